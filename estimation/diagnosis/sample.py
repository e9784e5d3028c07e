"""Thin samples of recordings: some hundred instants on which many models are tried."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from ...common.arrays import Array
from ...model import Processing, Recording
from ...model.motion import Measurement
from ..signals.filtering import lowpass
from ..signals.measurements import measurement
from ..signals.rows import Mask, used_rows

_SAMPLES = 200
_STUCK = 0.5  # s
_CUTOFF = 0.4  # of the sample's own rate


@dataclass(frozen=True)
class Sample:
    """Some hundred instants of a recording.

    Attributes:
        source: name of the recording.
        t: time [s], shape (N,).
        q, qd, qdd: filtered motion [rad or m], shapes (N, n).
        torque: low-passed torque [N·m or N], shape (N, n).
        keep: which rows are used, N x n.
        stuck: where a joint's position is the very same number for over half a second, N x n.
        all_t: time of every sample of the recording [s].
        all_torque: low-passed torque at those, to read it at another time.
    """

    source: str
    t: Array
    q: Array
    qd: Array
    qdd: Array
    torque: Array
    keep: Mask
    stuck: Mask
    all_t: Array
    all_torque: Array

    @staticmethod
    def of(
        recording: Recording, processing: Processing, filtered: Measurement | None = None, count: int = _SAMPLES
    ) -> "Sample":
        """Take some 200 instants, evenly over the moving part; ``filtered`` is their measurement if it is there."""
        data = filtered or measurement(recording, processing)
        motion, step = data.motion, 1.0 / data.motion.rate
        keep = used_rows(motion, processing)
        moving = np.flatnonzero(keep.any(axis=1))
        thin = max(1, len(moving) // count)
        cutoff = _CUTOFF / (thin * step) if thin > 1 else None
        torque = lowpass(data.torque, step, cutoff, recording.source)
        at = moving[thin // 2 :: thin]
        return Sample(
            recording.source, motion.t[at], motion.q[at], motion.qd[at], motion.qdd[at], torque[at], keep[at],
            _stuck(recording, motion.t[at]), motion.t, torque,
        )  # fmt: skip

    @staticmethod
    def joined(samples: Sequence["Sample"]) -> "Sample":
        """Samples of several recordings as one."""
        arrays = {
            field.name: np.concatenate([getattr(sample, field.name) for sample in samples])
            for field in fields(Sample)
            if field.name != "source"
        }
        return Sample(", ".join(sample.source for sample in samples), **arrays)

    def later(self, delay: "float | Array") -> "Sample":
        """This motion with the torque that was written ``delay`` [s] later."""
        times = self.t + delay
        torque = np.column_stack([np.interp(times, self.all_t, channel) for channel in self.all_torque.T])
        return replace(self, torque=torque)

    def part(self, start: int, stop: int, step: int = 1) -> "Sample":
        """Only some of the instants."""
        own = slice(start, stop, step)
        return replace(
            self, t=self.t[own], q=self.q[own], qd=self.qd[own], qdd=self.qdd[own], torque=self.torque[own],
            keep=self.keep[own], stuck=self.stuck[own],
        )  # fmt: skip


def _stuck(recording: Recording, t: Array) -> Mask:
    """Instants of ``t`` within long stretches of one position, N x n."""
    result = np.zeros((len(t), recording.q.shape[1]), dtype=bool)
    for j, q in enumerate(recording.q.T):
        edges = np.flatnonzero(np.diff(q) != 0.0) + 1
        starts, stops = np.append(0, edges), np.append(edges - 1, len(q) - 1)
        long = recording.t[stops] - recording.t[starts] > _STUCK
        for start, stop in zip(recording.t[starts[long]], recording.t[stops[long]], strict=True):
            result[:, j] |= (t >= start) & (t <= stop)
    return result
