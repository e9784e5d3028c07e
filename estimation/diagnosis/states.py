"""Recordings thinned to some 10 states a second: cheap enough to ask many questions of them."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...model import Recording
from ..payload.problem import Source
from .sample import Sample

BLOCKS = 20
"""Blocks of time, that are left out in turn."""
STRETCH = 3.0
"""s: the shortest stretch of time that is looked at alone; shorter ones of good recordings stand out too."""
_RATE = 10.0  # Hz
_MOST = 600  # states of a recording
_LONGEST = 180.0  # s: of a longer recording the middle is looked at
_FEWEST = 60  # states altogether
_ROUGHLY = 5  # times fewer states decide first
_STEP = 0.01  # s: to either side, over which a torque's slope is taken

Places = NDArray[np.intp]


class States(NamedTuple):
    """Thinned states of all recordings, N.

    ``sample``: the states; ``loaded`` (N,): 1 with payload; ``block`` (N,): of time; ``stretch`` (N,): of 3 s;
    ``slope``: of the torques [N·m/s or N/s], N x n.
    """

    sample: Sample
    loaded: Array
    block: Places
    stretch: Places
    slope: Array

    def thinned(self) -> "States":
        """Every so many-th state; all of them where few would be left."""
        count = len(self.block)
        step = _ROUGHLY if count >= 3 * _ROUGHLY * _FEWEST else 1
        return States(
            self.sample.part(0, count, step),
            self.loaded[::step],
            self.block[::step],
            self.stretch[::step],
            self.slope[::step],
        )


def states_of(source: Source) -> States | None:
    """Some 10 states a second of all recordings, without payload first; None where there is too little motion."""
    samples: list[Sample] = []
    loaded: list[Array] = []
    for recordings, with_payload in ((source.unloaded, 0.0), (source.loaded, 1.0)):
        for recording in recordings:
            part = _middle(recording)
            samples.append(Sample.of(part, source.processing, count=_count(part)))
            loaded.append(np.full(len(samples[-1].t), with_payload))
    total = sum(len(sample.t) for sample in samples)
    if total < _FEWEST:
        return None
    return States(
        Sample.joined(samples),
        np.concatenate(loaded),
        np.arange(total) * BLOCKS // total,
        _stretches([sample.t for sample in samples]),
        np.concatenate([_slope(sample) for sample in samples]),
    )


def _stretches(times: Sequence[Array]) -> Places:
    """Numbers of the stretches of 3 s, recording after recording."""
    numbers, first = [], 0
    for t in times:
        numbers.append(first + ((t - t[:1].sum()) / STRETCH).astype(np.intp))
        first = int(numbers[-1].max(initial=first - 1)) + 1
    return np.concatenate(numbers)


def _slope(sample: Sample) -> Array:
    later, earlier = (sample.later(step).torque for step in (_STEP, -_STEP))
    return np.asarray((later - earlier) / (2.0 * _STEP))


def _middle(recording: Recording) -> Recording:
    """The middle of a recording that has far more than the states that are looked at."""
    t = recording.t
    first, last = np.searchsorted(t, 0.5 * (t[0] + t[-1]) + 0.5 * _LONGEST * np.array([-1.0, 1.0]))
    if last - first >= len(t) - 1:
        return recording
    part = slice(int(first), int(last))
    qd = recording.qd[part] if recording.qd is not None else None
    return replace(recording, t=t[part], q=recording.q[part], torque=recording.torque[part], qd=qd)


def _count(recording: Recording) -> int:
    return min(_MOST, int(_RATE * float(recording.t[-1] - recording.t[0])) + 1)
