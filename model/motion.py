"""Motions and measurements, read-only arrays, one row a sample; and the settings of recordings' processing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..common import Array, Brief, freeze_fields

_SLOW = {True: 0.05, False: 0.02}  # rad/s where a joint turns, m/s where it slides
_OVERSAMPLING = 1.25  # largest grid rate over a recording's mean rate: samples in between are not measurements
_SLOWEST = 1e-12  # lowest rate [Hz] of which samples in a period can be counted


@dataclass(frozen=True, eq=False, repr=False)
class Motion(Brief):
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
        shape = len(self.t), np.shape(self.q)[-1]
        freeze_fields(self, t=(None,), q=shape, qd=shape, qdd=shape)
        if not (np.diff(self.t) > 0.0).all():
            raise ValueError("t must rise from sample to sample")

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.q.shape[1])

    @property
    def rate(self) -> float:
        """Mean sampling rate [Hz]."""
        return (len(self.t) - 1) / float(self.t[-1] - self.t[0])


@dataclass(frozen=True, eq=False, repr=False)
class Measurement(Brief):
    """A motion and the joint torques measured on it."""

    motion: Motion
    torque: Array  # joint torques [N·m or N], shape (N, n)
    # of a difference of two recordings, the torque of a known spring in the one that was subtracted [N·m], shape
    # (N,); None for one recording, and where there is no such spring
    spring_before: Array | None = None
    # of a difference of two recordings, what the robot itself needs more on the second path [N·m or N], shape (N,
    # n); None where that was not worked out
    path: Array | None = None

    def __post_init__(self) -> None:
        samples, joints = self.motion.t.shape, self.motion.q.shape
        freeze_fields(self, torque=joints, spring_before=samples, path=joints)

    def between(self, start: int, stop: int) -> Measurement:
        """Take the samples from ``start`` to before ``stop``."""
        part, motion = slice(start, stop), self.motion
        before, path = (None if array is None else array[part] for array in (self.spring_before, self.path))
        own = Motion(motion.t[part], motion.q[part], motion.qd[part], motion.qdd[part])
        return Measurement(own, self.torque[part], before, path)


@dataclass(frozen=True, eq=False, repr=False)
class Recording(Brief):
    """Recording of a controller: uneven time, positions, perhaps speeds, torques; not yet filtered.

    Attributes:
        t: time [s], shape (N,), rising.
        q: positions [rad or m], shape (N, n).
        torque: joint torques [N·m or N], shape (N, n).
        qd: speeds [.../s], shape (N, n), or None where the controller writes none.
        source: where it came from, for messages.
        notes: what a user should know about how it was read.
        fingerprint: of time, positions and torques or currents as they stand in a log, before drive gains: the same
            for the same recording in any file; empty where it was not read from a log.
        gains: torque per current with which currents were read [N·m/A or N/A], shape (n,); empty for torques.
        origin: what a log's time held where ``t`` is 0 [s], such as seconds since 1970.
        gain_sigma: standard deviation of the relative error of each joint's scale of torque, 0 where torques are
            exact as simulated ones can be; None where nothing is said of it.
        torque_unit: "named" where a column is called a torque, "given" where a user, a map or the file says the
            unit, "unknown" of columns such as ``effort``, which may hold currents or percent.

    >>> Recording(t=np.arange(3) / 100.0, q=np.zeros((3, 6)), torque=np.ones((3, 6))).rate
    100.0
    """

    t: Array
    q: Array
    torque: Array
    qd: Array | None = None
    source: str = "recording"
    notes: tuple[str, ...] = ()
    fingerprint: str = ""
    gains: tuple[float, ...] = ()
    origin: float = 0.0
    gain_sigma: float | None = None
    torque_unit: Literal["named", "given", "unknown"] = "named"

    def __post_init__(self) -> None:
        if not 0.0 <= (self.gain_sigma or 0.0) < 1.0:
            raise ValueError(f"gain_sigma is {self.gain_sigma}: give a fraction from 0 to below 1")
        shape = len(self.t), np.shape(self.q)[-1]
        freeze_fields(self, t=(None,), q=shape, torque=shape, qd=shape)

    @property
    def rate(self) -> float:
        """Mean sampling rate [Hz]."""
        return (len(self.t) - 1) / float(self.t[-1] - self.t[0])


def usual_slow_speed(turning: Sequence[bool]) -> float | tuple[float, ...]:
    """Speed below which a joint's friction is not known well: 0.05 rad/s, or 0.02 m/s where it slides.

    With slower rows 95 % intervals of Coulomb friction hold 47 % of the time, without them 94 % (own simulations).
    """
    return _SLOW[True] if all(turning) else tuple(_SLOW[turns] for turns in turning)


@dataclass(frozen=True)
class Processing:
    """Settings of signal processing, in the order in which they are applied.

    Attributes:
        rate: uniform rate to which a recording is resampled [Hz]; None keeps the recording's mean rate. A faster
            recording is resampled to a multiple of it, and Y and W decimated to it, so that no noise folds in.
        cutoff: cut-off of the zero-phase 4th-order Butterworth filter on positions and speeds [Hz]; None
            leaves them as they are.
        decimate: parallel decimation of Y and of every column of W, by this whole factor; of ``rate``, where that
            is given.
        equation_rate: rate to which Y and W are decimated [Hz], as near as whole factors come, instead of
            ``decimate``.
        still_speed: below it a joint stands still [rad/s or m/s]; rows of one that never moves faster are left
            out, and those of all while all stand still for over 0.3 s, and where they move for under 1 s.
        slow_fraction: rows of joint j are left out where its speed is below this fraction of its largest
            speed, because the sign of the speed is not known there.
        slow_speed: and where it is below this [rad/s or m/s], one number for all joints or one for each; the larger
            of both bounds counts.
        max_mismatch: method 3 refuses a pair whose positions differ by more than this after alignment, root mean
            square of the worst joint [rad or m].
    """

    rate: float | None = None
    cutoff: float | None = None
    decimate: int = 1
    equation_rate: float | None = None
    still_speed: float = 2e-3
    slow_fraction: float = 0.0
    slow_speed: float | tuple[float, ...] = 0.0
    max_mismatch: float = 0.01

    def __post_init__(self) -> None:
        for name in ("rate", "cutoff", "equation_rate"):
            value = getattr(self, name)
            if value is not None and not _SLOWEST <= value < float("inf"):
                fault = f"{name} must be above 0 Hz, got {value:g}"
                raise ValueError(f"{fault}: omit it to leave recordings as they are")
        if self.decimate < 1 or self.decimate != int(self.decimate):
            raise ValueError(f"decimate must be a whole number of at least 1, got {self.decimate}")
        if self.decimate > 1 and self.equation_rate is not None:
            raise ValueError("decimate and equation_rate say the same: give one of them")
        if not 0.0 <= self.slow_fraction < 1.0:
            raise ValueError(f"slow_fraction must be in [0, 1), got {self.slow_fraction}")
        slow = self.slow_speed if isinstance(self.slow_speed, tuple) else (self.slow_speed,)
        if not all(0.0 <= speed < float("inf") for speed in slow):
            raise ValueError(f"slow_speed must not be negative, got {self.slow_speed}")
        for name in ("still_speed", "max_mismatch"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must not be negative")

    def grid_rate(self, recorded: float) -> float:
        """Even rate [Hz] at which a recording of some mean rate is processed.

        The multiple of ``rate`` next to the recorded one, not above 1.25 times that: torque that is picked from a
        faster log folds all noise above half of ``rate`` into the equations.
        """
        if self.rate is None:
            return recorded
        return self.rate * max(1, min(round(recorded / self.rate), int(_OVERSAMPLING * recorded / self.rate)))

    def thinning(self, rate: float) -> int:
        """Whole factor of the parallel decimation of samples at an even rate [Hz]."""
        if self.equation_rate is not None:
            return max(1, round(rate / self.equation_rate))
        return self.decimate * max(1, round(rate / self.rate)) if self.rate is not None else self.decimate

    def equations_a_second(self, recorded: float) -> float:
        """Rate of each joint's equations [Hz] of a recording of some mean rate, slow rows counted."""
        rate = self.grid_rate(recorded)
        return rate / self.thinning(rate)
