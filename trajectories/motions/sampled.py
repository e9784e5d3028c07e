"""References between the samples of a trajectory that somebody else planned."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ...common.arrays import Array, frozen_array
from ...common.brief import Brief
from ...common.errors import InputError
from ...model import Motion, Robot
from .family import Plan
from .via_points import ViaPoints

_REST = 0.01  # of the largest speed: what still counts as rest at the ends
_ROUNDING = 1e-6  # of a step: what times written in decimals are longer
_OVER = 1.02  # of a limit: rounding and the curve between samples


@dataclass(frozen=True, eq=False, repr=False)
class SampledTrajectory(Plan, Brief):
    """A smooth curve through samples; it rests before the first and after the last.

    With speeds and accelerations a quintic between samples, with speeds alone a cubic, with neither the quintic
    spline that starts and ends at rest.

    Attributes:
        t: times [s], shape (N,), rising; counted from the first.
        q: positions [rad or m], shape (N, n).
        qd, qdd: speeds and accelerations there, shape (N, n), or None.
        source: name for messages.
    """

    t: Array
    q: Array
    qd: Array | None = None
    qdd: Array | None = None
    source: str = "trajectory"

    def __post_init__(self) -> None:
        """Lock the arrays; refuse a trajectory that does not rest at its ends."""
        object.__setattr__(self, "t", frozen_array(np.asarray(self.t) - self.t[0], (None,), "t"))
        shape = (len(self.t), np.shape(self.q)[-1])
        for name in ("q", "qd", "qdd"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, frozen_array(getattr(self, name), shape, name))
        if len(self.t) < 6:
            raise InputError(f"{self.source}: {len(self.t)} samples do not make a trajectory")
        qd = np.gradient(self.q, self.t, axis=0) if self.qd is None else self.qd
        for k, where in ((0, "start"), (-1, "end")):
            moving = np.abs(qd[k]) > _REST * np.abs(qd).max() + 1e-9
            if moving.any():
                raise InputError(
                    f"{self.source}: joint {int(np.argmax(moving)) + 1} moves at the {where}: a trajectory must "
                    "start and end at rest"
                )

    @property
    def duration(self) -> float:
        """Duration from rest to rest [s]."""
        return float(self.t[-1])

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Position, speed and acceleration at times [s], each (N, n)."""
        t = np.asarray(t)
        inside = np.clip(t, 0.0, self.duration)
        moves = ((t >= 0.0) & (t <= self.duration))[:, None]
        q, qd, qdd = (np.asarray(curve(inside)) for curve in self._curves)
        return q, qd * moves, qdd * moves

    def check_limits(self, robot: Robot) -> None:
        """Refuse a trajectory that the robot's joints may not run."""
        q, qd, qdd = self.at(self.t)
        for j, joint in enumerate(robot.joints):
            low, high = joint.limits.position
            middle, half = 0.5 * (low + high), 0.5 * (high - low)
            away = np.abs(q[:, j] - (middle if np.isfinite(middle) else 0.0))
            for quantity, values, most in (
                ("position", away, half),
                ("speed", np.abs(qd[:, j]), joint.limits.speed),
                ("acceleration", np.abs(qdd[:, j]), joint.limits.acceleration),
            ):
                k = int(np.argmax(values))
                if values[k] > _OVER * most:
                    raise InputError(
                        f"{self.source}: joint {j + 1} goes beyond its {quantity} limit at {self.t[k]:.3f} s "
                        f"({values[k] / most:.2f} times): make the trajectory smaller or slower"
                    )

    @cached_property
    def _curves(self) -> tuple[Any, Any, Any]:
        from scipy.interpolate import BPoly, CubicHermiteSpline, make_interp_spline

        if self.qd is None:
            rest = [(1, np.zeros(self.q.shape[1])), (2, np.zeros(self.q.shape[1]))]
            curve: Any = make_interp_spline(self.t, self.q, k=5, bc_type=(rest, rest))
        elif self.qdd is None:
            curve = CubicHermiteSpline(self.t, self.q, self.qd)
        else:
            curve = BPoly.from_derivatives(self.t, np.stack([self.q, self.qd, self.qdd], axis=1))
        speed = curve.derivative()
        return curve, speed, speed.derivative()


def joined(motion: Motion, rate: float) -> Motion:
    """Refine samples to no less than ``rate`` [Hz]: more on the quintics through those that lie farther apart."""
    parts = np.ceil(np.diff(motion.t) * rate * (1.0 - _ROUNDING)).astype(int)
    if (parts <= 1).all():
        return motion
    k = np.repeat(np.arange(len(parts)), parts)  # the sample before
    fraction = (np.arange(len(k)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[k]
    t, last = motion.t[k] + fraction * np.diff(motion.t)[k], (motion.q, motion.qd, motion.qdd)
    between = ViaPoints(motion.q, np.diff(motion.t), motion.qd, motion.qdd).at(t - motion.t[0])
    return Motion(np.append(t, motion.t[-1]), *(np.vstack([x, y[-1]]) for x, y in zip(between, last, strict=True)))
