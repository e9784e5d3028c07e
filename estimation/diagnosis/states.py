"""Recordings subsampled to some 10 states a second, cheap enough to try many hypotheses on, and readings of
them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...model import Processing, Recording
from ...model.motion import Measurement
from ..payload.problem import Source
from ..signals.filtering import lowpass, measurement
from ..signals.rows import Mask, used_rows

BLOCKS = 20
"""Blocks of time that are left out in turn."""
STRETCH = 3.0
"""s: the shortest stretch of time that is judged; shorter ones of good recordings stand out by chance."""
FEW = 200
"""States of a recording that are enough to compare readings of it."""
_RATE = 10.0  # Hz
_MOST = 600  # states of a recording
_LONGEST = 180.0  # s: of a longer recording the middle is used
_FEWEST = 60  # states altogether
_COARSER = 5  # times fewer states decide first
_STEP = 0.01  # s: to either side, over which a torque's slope is taken
_STUCK = 0.5  # s
_CUTOFF = 0.4  # of the states' own rate
_PER_STATE = ("t", "q", "qd", "qdd", "torque", "slope", "keep", "stuck", "loaded", "block", "stretch", "recording")
Index = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class States:
    """Subsampled states of one or more recordings: N states of n joints.

    Attributes:
        source: names of the recordings.
        t: time in its recording [s], shape (N,).
        q, qd, qdd: filtered motion [rad or m], N x n.
        torque: low-passed torque [N·m or N], N x n.
        slope: derivative of the torque [N·m/s or N/s], N x n.
        keep: rows that are used, N x n.
        stuck: where a position is the very same number for over half a second, N x n.
        loaded: 1 with payload, else 0, shape (N,).
        block: number of the block of time, shape (N,).
        stretch: number of the stretch of 3 s, shape (N,).
        recording: number of the recording, shape (N,).
        signals: time [s] and torque of each recording's every sample, to read the torque at another time.
        gains: of the drives, with which currents were read; empty for torques.
    """

    source: str
    t: Array
    q: Array
    qd: Array
    qdd: Array
    torque: Array
    slope: Array
    keep: Mask
    stuck: Mask
    loaded: Array
    block: Index
    stretch: Index
    recording: Index
    signals: tuple[tuple[Array, Array], ...]
    gains: tuple[float, ...] = ()

    @staticmethod
    def of(
        recording: Recording,
        processing: Processing,
        count: int = FEW,
        data: Measurement | None = None,
        loaded: float = 0.0,
    ) -> "States":
        """Subsample one recording evenly over its moving part.

        Args:
            recording: to take states of.
            processing: how it is filtered.
            count: about so many states.
            data: its measurement, where it is filtered already.
            loaded: 1 with payload.
        """
        data = data or measurement(recording, processing)
        motion, step = data.motion, 1.0 / data.motion.rate
        keep = used_rows(motion, processing)
        moving = np.flatnonzero(keep.any(axis=1))
        thin = max(1, len(moving) // count)
        torque = lowpass(data.torque, step, _CUTOFF / (thin * step) if thin > 1 else None, recording.source)
        at = moving[thin // 2 :: thin]
        t, zeros = motion.t[at], np.zeros(len(at), dtype=np.intp)
        states = States(
            recording.source, t, motion.q[at], motion.qd[at], motion.qdd[at], torque[at], torque[at], keep[at],
            _stuck(recording, t), np.full(len(at), loaded), zeros, ((t - t[:1].sum()) / STRETCH).astype(np.intp),
            zeros, ((motion.t, torque),), tuple(recording.gains),
        )  # fmt: skip
        return replace(states, slope=(states.later(_STEP).torque - states.later(-_STEP).torque) / (2.0 * _STEP))

    @staticmethod
    def joined(parts: Sequence["States"]) -> "States":
        """Join the states of several recordings, in blocks of time over all of them."""
        names = ", ".join(part.source for part in parts)
        arrays: dict[str, Any] = {
            name: np.concatenate([getattr(part, name) for part in parts]) for name in _PER_STATE
        }
        counts = [int(part.stretch.max(initial=-1)) + 1 for part in parts]
        first = np.repeat(np.cumsum([0, *counts[:-1]]), [len(part.t) for part in parts])
        total, number = len(arrays["t"]), np.repeat(np.arange(len(parts)), [len(part.t) for part in parts])
        arrays |= {"block": np.arange(total) * BLOCKS // max(total, 1), "stretch": arrays["stretch"] + first}
        signals = tuple(signal for part in parts for signal in part.signals)
        return replace(parts[0], source=names, signals=signals, **(arrays | {"recording": number}))

    @property
    def passed(self) -> Array:
        """Time that has passed, from 0 to 1 over each recording, shape (N,)."""
        first, last = np.array([t[[0, -1]] for t, _ in self.signals])[self.recording].T
        return np.asarray((self.t - first) / (last - first))

    def later(self, delay: "float | Array") -> "States":
        """Read the torque that was written ``delay`` [s] later, a number or one for each state."""
        times, torque = self.t + delay, np.array(self.torque)
        for number, (t, signal) in enumerate(self.signals):
            own = self.recording == number
            torque[own] = np.column_stack([np.interp(times[own], t, channel) for channel in signal.T])
        return replace(self, torque=torque)

    def taken(self, index: Any) -> "States":
        """Take some of the states: a slice, a mask or numbers."""
        return replace(self, **{name: getattr(self, name)[index] for name in _PER_STATE})

    def mixed(self, other: "States", mask: Mask) -> "States":
        """Take some of the states in another reading."""
        if mask.all():
            return other
        names = ("q", "qd", "qdd", "torque", "keep")
        arrays: dict[str, Any] = {
            name: np.where(mask[:, None], getattr(other, name), getattr(self, name)) for name in names
        }
        return replace(self, **arrays)

    def coarser(self) -> "States":
        """Every fifth state; all of them where few would be left."""
        return self.taken(slice(None, None, _COARSER if len(self.t) >= 3 * _COARSER * _FEWEST else 1))


def states_of(source: Source) -> States | None:
    """Some 10 states a second of all recordings, without payload first; None where there is too little motion."""
    parts = []
    for recordings, loaded in ((source.unloaded, 0.0), (source.loaded, 1.0)):
        for recording in map(_middle, recordings):
            count = min(_MOST, int(_RATE * float(recording.t[-1] - recording.t[0])) + 1)
            parts.append(States.of(recording, source.processing, count, loaded=loaded))
    return States.joined(parts) if sum(len(part.t) for part in parts) >= _FEWEST else None


def _middle(recording: Recording) -> Recording:
    t = recording.t
    ends = 0.5 * (t[0] + t[-1]) + 0.5 * _LONGEST * np.array([-1.0, 1.0])
    first, last = np.searchsorted(t, ends)
    if last - first >= len(t) - 1:
        return recording
    own = slice(int(first), int(last))
    qd = recording.qd[own] if recording.qd is not None else None
    return replace(recording, t=t[own], q=recording.q[own], torque=recording.torque[own], qd=qd)


def _stuck(recording: Recording, t: Array) -> Mask:
    result = np.zeros((len(t), recording.q.shape[1]), dtype=bool)
    for j, q in enumerate(recording.q.T):
        edges = np.flatnonzero(np.diff(q) != 0.0) + 1
        starts, stops = recording.t[np.append(0, edges)], recording.t[np.append(edges - 1, len(q) - 1)]
        for start, stop in zip(starts, stops, strict=True):
            if stop - start > _STUCK:
                result[:, j] |= (t >= start) & (t <= stop)
    return result


@dataclass(frozen=True, order=True)
class Reading:
    """How joint j of the robot is read: q_j = sign_j q_log[order_j] + quarters_j 90 degrees.

    Attributes:
        order: for each joint the column of the log, counted from 0.
        sign: +1 or -1: the log's sense of rotation, torque included.
        quarters: quarter turns to add, 0 to 3.
        torque: +1 or -1: sign of the torque alone.
    """

    order: tuple[int, ...]
    sign: tuple[int, ...]
    quarters: tuple[int, ...]
    torque: tuple[int, ...]

    @staticmethod
    def as_recorded(n: int) -> "Reading":
        """Every column as it stands."""
        return Reading(tuple(range(n)), (1,) * n, (0,) * n, (1,) * n)

    def swapped(self, i: int, j: int) -> "Reading":
        """The columns of two joints exchanged."""
        order = list(self.order)
        order[i], order[j] = order[j], order[i]
        return replace(self, order=tuple(order))

    def turned(self, *joints: int) -> "Reading":
        """Some joints counted the other way."""
        return replace(self, sign=_flipped(self.sign, joints))

    def pushed(self, j: int) -> "Reading":
        """The torque of one joint alone with the other sign."""
        return replace(self, torque=_flipped(self.torque, (j,)))

    def moved(self, j: int, quarters: int) -> "Reading":
        """The zero of one joint moved."""
        there = (self.quarters[j] + quarters) % 4
        return replace(self, quarters=(*self.quarters[:j], there, *self.quarters[j + 1 :]))

    def positions(self, q: Array) -> Array:
        """Joint positions [rad or m] from a log's, N x n."""
        return np.asarray(q[:, list(self.order)] * np.array(self.sign) + np.array(self.quarters) * (pi / 2))

    def of(self, states: States) -> States:
        """Read the states of a log."""
        order, sign = list(self.order), np.array(self.sign)
        return replace(
            states,
            q=self.positions(states.q),
            qd=states.qd[:, order] * sign,
            qdd=states.qdd[:, order] * sign,
            torque=states.torque[:, order] * (sign * np.array(self.torque)),
            slope=states.slope[:, order] * (sign * np.array(self.torque)),
            keep=states.keep[:, order],
        )

    @property
    def changes(self) -> int:
        """Number of joints and columns that are not taken as they stand."""
        moved = sum(column != j for j, column in enumerate(self.order))
        signs = sum(sign < 0 for sign in (*self.sign, *self.torque))
        return moved + signs + sum(quarter != 0 for quarter in self.quarters)

    def described(self) -> str:
        """Describe the reading, joints counted from 1; "as recorded" if nothing is changed."""
        parts = []
        for j in range(len(self.order)):
            changes = []
            if self.order[j] != j:
                changes.append(f"from column {self.order[j] + 1}")
            if self.sign[j] < 0:
                changes.append("turned round (position and torque)")
            if self.quarters[j]:
                changes.append(f"zero moved by {(90, 180, -90)[self.quarters[j] - 1]} degrees")
            if self.torque[j] < 0:
                changes.append("torque turned round")
            if changes:
                parts.append(f"joint {j + 1} {', '.join(changes)}")
        return "; ".join(parts) or "as recorded"


def _flipped(signs: tuple[int, ...], joints: Sequence[int]) -> tuple[int, ...]:
    return tuple(-sign if j in joints else sign for j, sign in enumerate(signs))
