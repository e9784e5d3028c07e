"""Recordings subsampled to some 10 states a second, cheap enough to try many hypotheses on."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...common import Array, Indices, Mask
from ...model import Processing, Recording
from ..payload.long_motion import Source
from ..signals.filtering import lowpass, measurement
from ..signals.rows import used_rows

BLOCKS = 20  # number of blocks of time that are left out in turn
STRETCH = 3.0  # shortest stretch of time that is judged [s]; shorter ones of good recordings stand out by chance
FEW = 200  # number of states of a recording that are enough to compare readings of it
_RATE = 10.0  # Hz
_MOST = 600  # states of a recording
_LONGEST = 180.0  # s: of a longer recording the middle is used
_FEWEST = 60  # states altogether
_COARSER = 5  # times fewer states decide first
_STEP = 0.01  # s: to either side, over which a torque's slope is taken
_STUCK = 0.5  # s
_AWAY, _BACK = 0.4, 0.2
"""Distance of states, over that of any two, at which a motion has gone elsewhere, and at which it is back."""
_PLACES = 5  # of a block: half a second
_OVERLAP = 0.7  # of a recording: the longest passage of a motion that repeats itself
_CUTOFF = 0.4  # of the states' own rate
_PER_STATE = ("t", "q", "qd", "qdd", "torque", "slope", "keep", "stuck", "loaded", "block", "stretch", "recording")


@dataclass(frozen=True, eq=False)
class States:
    """Subsampled states of one or more recordings: N states of n joints."""

    source: str  # names of the recordings
    t: Array  # time in its recording [s], shape (N,)
    q: Array  # filtered motion [rad or m], N x n
    qd: Array
    qdd: Array
    torque: Array  # low-passed [N·m or N], N x n
    slope: Array  # its derivative [N·m/s or N/s], N x n
    keep: Mask  # rows that are used, n to a state, N x n
    stuck: Mask  # where a position is the very same number for over half a second, N x n
    loaded: Array  # 1 with payload, else 0, shape (N,)
    block: Indices  # number of the block of time, (N,)
    stretch: Indices  # of the stretch of 3 s
    recording: Indices
    signals: tuple[tuple[Array, Array], ...]  # time [s] and torque of each recording's every sample
    gains: tuple[float, ...] = ()  # of the drives, with which currents were read; empty for torques

    @staticmethod
    def of(recording: Recording, processing: Processing, count: int = FEW, loaded: float = 0.0) -> "States":
        """Subsample one recording evenly over its moving part, to about ``count`` states; 1 with payload."""
        data = measurement(recording, processing)
        motion, step = data.motion, 1.0 / data.motion.rate
        keep = used_rows(motion, processing) & (np.ptp(recording.torque, axis=0) > 0.0)  # no dead channel
        moving = np.flatnonzero(keep.any(axis=1))
        thin = max(1, len(moving) // count)
        torque = lowpass(data.torque, step, _CUTOFF / (thin * step) if thin > 1 else None, recording.source)
        at = moving[thin // 2 :: thin]
        stuck = []
        for q in recording.q.T:
            edges = np.flatnonzero(np.diff(q)) + 1
            starts, stops = recording.t[np.append(0, edges)], recording.t[np.append(edges - 1, len(q) - 1)]
            place = np.maximum(np.searchsorted(starts, motion.t[at], "right") - 1, 0)
            stuck.append((stops - starts > _STUCK)[place] & (motion.t[at] <= stops[place]))
        t, zeros = motion.t[at], np.zeros(len(at), dtype=np.intp)
        states = States(
            recording.source, t, motion.q[at], motion.qd[at], motion.qdd[at], torque[at], torque[at], keep[at],
            np.column_stack(stuck), np.full(len(at), loaded), zeros, ((t - t[:1].sum()) / STRETCH).astype(np.intp),
            zeros, ((motion.t, torque),), tuple(recording.gains),
        )  # fmt: skip
        return replace(states, slope=(states.later(_STEP).torque - states.later(-_STEP).torque) / (2.0 * _STEP))

    @staticmethod
    def joined(parts: Sequence["States"]) -> "States":
        """Join the states of several recordings, in blocks of time over all of them."""
        arrays: dict[str, Any] = {
            name: np.concatenate([getattr(part, name) for part in parts]) for name in _PER_STATE
        }
        lengths = [len(part.t) for part in parts]
        counts = np.cumsum([0, *(int(part.stretch.max(initial=-1)) + 1 for part in parts)])
        arrays["stretch"] = arrays["stretch"] + np.repeat(counts[:-1], lengths)
        arrays["recording"] = np.repeat(np.arange(len(parts)), lengths)
        signals = tuple(signal for part in parts for signal in part.signals)
        joined = replace(parts[0], source=", ".join(part.source for part in parts), signals=signals, **arrays)
        _, place, sizes = np.unique(_places(joined.q, joined.recording), return_inverse=True, return_counts=True)
        blocks = BLOCKS if len(sizes) == len(place) else int(np.clip(len(sizes) // _PLACES, 2, BLOCKS))
        return replace(joined, block=(np.cumsum(sizes) - sizes)[place] * blocks // max(sum(lengths), 1))

    @property
    def passed(self) -> Array:
        """Fraction of the time that has passed, from 0 to 1 over each recording, shape (N,)."""
        first, last = np.array([t[[0, -1]] for t, _ in self.signals])[self.recording].T
        return np.asarray((self.t - first) / (last - first))

    def later(self, delay: "float | Array") -> "States":
        """Read the torque that was written ``delay`` [s] later, a number or one for each state."""
        times, torque = self.t + delay, np.array(self.torque)
        for number, (t, signal) in enumerate(self.signals):
            own = self.recording == number
            after = np.clip(np.searchsorted(t, times[own]), 1, len(t) - 1)
            fraction = np.clip((times[own] - t[after - 1]) / (t[after] - t[after - 1]), 0.0, 1.0)[:, None]
            torque[own] = (1.0 - fraction) * signal[after - 1] + fraction * signal[after]
        return replace(self, torque=torque)

    def taken(self, index: Any) -> "States":
        """Take some of the states: a slice, a mask or numbers."""
        return replace(self, **{name: getattr(self, name)[index] for name in _PER_STATE})

    def mixed(self, other: "States", mask: Mask) -> "States":
        """Take some of the states in another reading."""
        names, own = ("q", "qd", "qdd", "torque", "keep"), mask[:, None]
        arrays: dict[str, Any] = {name: np.where(own, getattr(other, name), getattr(self, name)) for name in names}
        return replace(self, **arrays)

    def coarser(self) -> "States":
        """Take up to every fifth state, as long as three times the fewest are left."""
        return self.taken(slice(None, None, max(1, min(_COARSER, len(self.t) // (3 * _FEWEST)))))


def states_of(source: Source | None, fewest: int = _FEWEST) -> States | None:
    """Some 10 states a second of all recordings, without payload first; None where there are too few."""
    if source is None:
        return None
    parts, recordings = [], [(recording, 0.0) for recording in source.unloaded]
    for recording, loaded in [*recordings, *((recording, 1.0) for recording in source.loaded)]:
        t, qd = recording.t, recording.qd
        middle = 0.5 * (t[0] + t[-1]) + 0.5 * _LONGEST * np.array([-1.0, 1.0])
        own = slice(*map(int, np.searchsorted(t, middle)))
        if len(t[own]) < len(t) - 1:
            speeds = None if qd is None else qd[own]
            recording = replace(recording, t=t[own], q=recording.q[own], torque=recording.torque[own], qd=speeds)
        count = min(_MOST, int(_RATE * float(recording.t[-1] - recording.t[0])) + 1)
        parts.append(States.of(recording, source.processing, count, loaded))
    return States.joined(parts) if sum(len(part.t) for part in parts) >= fewest else None


def _places(q: Array, recording: Indices) -> Indices:
    """Number each state by the first one at its place of a motion that repeats, by itself in any other motion.

    What a model leaves, such as ripple, repeats with the motion: passages of one path count as one.
    """
    place = np.arange(len(q))
    for k in np.unique(recording):
        own = np.flatnonzero(recording == k)
        x, size = q[own], np.sqrt(2.0 * q[own].var(axis=0).sum()) or 1.0
        apart = np.array([_rms(x[m:] - x[:-m]) / size for m in range(1, int(_OVERLAP * len(x)))])
        gone = int(np.argmax(apart > _AWAY)) if (apart > _AWAY).any() else len(apart)
        back = gone + np.flatnonzero(apart[gone:] < _BACK)
        if not len(back):
            continue
        passage = int(back[np.argmin(apart[back[back < back[0] + gone + 1]])]) + 1
        earlier = [_rms(x[:passage] - q[j : j + passage]) / size for j in range(own[0] - passage + 1)]
        if min(earlier, default=1.0) < _BACK:  # passages of an earlier recording
            place[own[:passage]] = place[np.argmin(earlier) :][:passage]
        for i in own[passage:]:
            place[i] = place[i - passage]
    return place


def _rms(distance: Array) -> float:
    return float(np.sqrt(np.mean(np.sum(distance**2, axis=1))))
