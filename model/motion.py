"""What moves and what was measured: read-only arrays, one row a sample."""

from dataclasses import dataclass

import numpy as np

from ..common.arrays import Array, frozen_array, rising


@dataclass(frozen=True)
class Motion:
    """A joint motion on a uniform or uneven time grid.

    Attributes:
        t: time [s], shape (N,), rising.
        q, qd, qdd: positions [rad or m], speeds [.../s], accelerations [.../s^2], each of shape (N, n).
    """

    t: Array
    q: Array
    qd: Array
    qdd: Array

    def __post_init__(self) -> None:
        """Lock the arrays and check their shapes."""
        size, n = len(self.t), np.shape(self.q)[-1]
        object.__setattr__(self, "t", frozen_array(self.t, (None,), "t"))
        if not rising(self.t):
            raise ValueError("t must rise from sample to sample")
        for name in ("q", "qd", "qdd"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), (size, n), name))

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.q.shape[1])

    @property
    def rate(self) -> float:
        """Mean sampling rate [Hz]."""
        return (len(self.t) - 1) / float(self.t[-1] - self.t[0])


@dataclass(frozen=True)
class Measurement:
    """A motion and the joint torques measured on it.

    Attributes:
        motion: the motion.
        torque: joint torques [N·m or N], shape (N, n).
        spring_before: of a difference of two recordings, the torque of a known spring in the one that was
            subtracted [N·m], shape (N,); None for one recording, and where there is no such spring.
    """

    motion: Motion
    torque: Array
    spring_before: Array | None = None

    def __post_init__(self) -> None:
        """Lock the torques and check their shape."""
        object.__setattr__(self, "torque", frozen_array(self.torque, self.motion.q.shape, "torque"))
        if self.spring_before is not None:
            before = frozen_array(self.spring_before, self.motion.t.shape, "spring_before")
            object.__setattr__(self, "spring_before", before)


@dataclass(frozen=True)
class Recording:
    """What a controller wrote: uneven time, positions, perhaps speeds, torques; not yet filtered.

    Attributes:
        t: time [s], shape (N,), rising.
        q: positions [rad or m], shape (N, n).
        torque: joint torques [N·m or N], shape (N, n).
        qd: speeds [.../s], shape (N, n), or None where the controller writes none.
        source: where it came from, for messages.
        notes: what a user should know about how it was read.
        fingerprint: of time, positions and torques or currents as they stand in a log, before drive gains: the same
            for the same recording in any file; empty where it was not read from a log.
    """

    t: Array
    q: Array
    torque: Array
    qd: Array | None = None
    source: str = "recording"
    notes: tuple[str, ...] = ()
    fingerprint: str = ""

    def __post_init__(self) -> None:
        """Lock the arrays and check their shapes."""
        size, n = len(self.t), np.shape(self.q)[-1]
        object.__setattr__(self, "t", frozen_array(self.t, (None,), "t"))
        for name in ("q", "torque") + (("qd",) if self.qd is not None else ()):
            object.__setattr__(self, name, frozen_array(getattr(self, name), (size, n), name))
