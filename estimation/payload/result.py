"""Payload by one method, free and as it should be used: one that can exist, with intervals that hold."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from ...common import Array, Brief, InputError, frozen_array
from ...model import InertialParameters, Pose, Robot
from ...model.inertia import PayloadSpread, payload_spread
from ..equations.equations import PAYLOAD, Equations
from ..fit.estimate import Estimate, Gains, error_model
from ..possible.constraints import Constraint
from ..possible.intervals import NO_INTERVALS, Intervals, profile_intervals
from ..possible.payload import CONFLICT, POSSIBLE, Active, Possible, solve_constrained, tested

_SIZE = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)"
_FORM = re.compile(rf"(box|cylinder):({_SIZE}(?:x{_SIZE})*)")


@dataclass(frozen=True, eq=False, repr=False)
class PayloadEstimate(Brief):
    """Payload estimated by one method: all ten parameters, or those that a short motion determines."""

    method: int  # 1 to 4
    estimate: Estimate  # of ``PAYLOAD``, about the origin of ``frame``
    frame: str
    without_robust: str = ""  # why there are no robust standard deviations although they were asked for
    from_scale: bool = False  # whether the mass is a scale's, not the torques'

    @cached_property
    def indices(self) -> tuple[int, ...]:
        """Indices of the determined parameters among the ten."""
        return tuple(PAYLOAD.index(name) for name in self.estimate.names)

    def unexplained(self, torque_rms: Array) -> Array:
        """Ratio of each joint's error to another torque (rms), shape (n,); nan without equations or torque."""
        fit = self.estimate.fit
        there = (np.array(fit.rows) > 0) & (torque_rms > 0.0)
        return np.asarray(fit.rms / np.where(there, torque_rms, np.nan))

    @property
    def ten(self) -> Array:
        """Ten parameters, nan where not determined, shape (10,)."""
        values = np.full(len(PAYLOAD), np.nan)
        values[list(self.indices)] = self.estimate.values
        return values

    @cached_property
    def body(self) -> InertialParameters:
        """Payload as a body; all ten must be determined."""
        return InertialParameters(self.estimate.values)

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.body.mass

    @cached_property
    def spread(self) -> PayloadSpread:
        """Standard deviations of mass, centre of mass and inertia there by the formula's covariance."""
        return payload_spread(self.ten, self.estimate.covariance, self.indices)

    @cached_property
    def robust_spread(self) -> PayloadSpread | None:
        """Standard deviations that hold for autocorrelated noise, where they were asked for."""
        robust = self.estimate.robust
        return payload_spread(self.ten, robust.covariance, self.indices) if robust else None


def moved(
    estimate: PayloadEstimate, change: Array | None = None, more: Array | None = None, factor: float | Array = 1.0
) -> PayloadEstimate:
    """Change the values, multiply sigmas by one ``factor`` or one each and add ``more`` covariance; of the ten."""
    indices, own = list(estimate.indices), estimate.estimate
    wider = 0.0 if more is None else more[np.ix_(indices, indices)]
    factors = np.outer(factor, factor)
    robust = own.robust and replace(own.robust, covariance=factors * own.robust.covariance + wider)
    values = own.values if change is None else own.values + change[indices]
    covariance = factors * own.covariance + wider
    return replace(estimate, estimate=replace(own, values=values, covariance=covariance, robust=robust))


@dataclass(frozen=True, eq=False, repr=False)
class ConstrainedPayload(Brief):
    """Payload nearest to one method's estimate among those that keep the constraints.

    Distance, p-value and intervals go by the covariance of ``error_model``, that of ``result.free``.
    """

    free: PayloadEstimate  # the method's own estimate
    result: Possible
    intervals: Intervals  # 95 %; nan where a constraint contradicts the data
    gains: Gains | None  # errors that are part of the covariance; None where gains are taken as exact
    tested: tuple[Active, ...]  # active constraints with the probability of what each costs

    @property
    def method(self) -> int:
        """Number of the method, 1 to 4."""
        return self.free.method

    @property
    def body(self) -> InertialParameters:
        """Payload as a body that can exist."""
        return self.result.body

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.body.mass

    @cached_property
    def principal_moments(self) -> Array:
        """Principal moments of inertia at the centre of mass, rising [kg m^2], shape (3,)."""
        return np.asarray(np.linalg.eigvalsh(self.body.inertia_com))

    @property
    def conflicts(self) -> tuple[Active, ...]:
        """Active constraints that contradict the data."""
        return tuple(constraint for constraint in self.tested if constraint.conflict)

    @property
    def conflict(self) -> bool:
        """True if a constraint or a weighed mass, or all of them together, contradict the data."""
        apart = any(weighing.conflict for weighing in self.result.weighings)
        return apart or bool(self.conflicts) or self.result.p_value < CONFLICT


def constrain_payload(
    free: PayloadEstimate, constraints: Sequence[Constraint] = POSSIBLE, gains: Gains | None = None
) -> ConstrainedPayload:
    """Find the nearest payload that keeps the constraints, with intervals; all ten must be determined.

    That the body can exist is always demanded; ``gains``: taken as exact by default.

    Raises:
        InputError: if the covariance does not determine every parameter, or what the result owes to the drive gains
            is not known.
        SolverError: for anything but a clean solve, as when no body holds all constraints.
    """
    result = solve_constrained(error_model(free.estimate, gains), constraints)
    tests = tested(result)
    contradicted = result.p_value < CONFLICT or any(test.conflict for test in tests)
    intervals = NO_INTERVALS if contradicted else profile_intervals(result)
    return ConstrainedPayload(free, result, intervals, gains, tests)


@dataclass(frozen=True)
class StandIn:
    """Nominal inertia where none was measured: that of an evenly filled body. Assumed, and called so."""

    kind: str  # "box" or "cylinder"
    sizes: tuple[float, ...]  # along x, y, z; of a cylinder diameter and length along z [m]

    def __post_init__(self) -> None:
        """Refuse sizes that no body has."""
        known = (self.kind, len(self.sizes)) in (("box", 3), ("cylinder", 2))
        if not (known and all(0.0 < size < np.inf for size in self.sizes)):
            raise InputError(
                f"an assumed inertia of {self.kind} {self.sizes}: give box:AxBxC (along x, y, z) or cylinder:DxL "
                "(diameter, and length along z), in mm"
            )

    @staticmethod
    def parse(text: str) -> "StandIn":
        """Parse "box:60x60x350" or "cylinder:80x200", in mm."""
        match = _FORM.fullmatch(text.strip().lower())
        if match is None:
            raise InputError(f"--inertia {text!r}: write box:60x60x350 or cylinder:80x200, in mm")
        return StandIn(match[1], tuple(1e-3 * float(size) for size in match[2].split("x")))

    @property
    def description(self) -> str:
        """Describe it with its sizes in mm."""
        sizes = " x ".join(f"{1e3 * size:g}" for size in self.sizes)
        along = "along x, y, z" if self.kind == "box" else "(diameter, length along z)"
        return f"evenly filled {self.kind} of {sizes} mm {along} about the centre of mass"

    def body(self, mass: float, com: Array) -> InertialParameters:
        """Give the payload this inertia, its mass spread evenly."""
        # A box's moment is m/12 of the squares of both other sides, a cylinder's across m/12 (3 r^2 + h^2).
        if self.kind == "box":
            a, b, c = np.square(self.sizes)
            moments = np.array([b + c, a + c, a + b])
        else:
            d, h = np.square(self.sizes)
            moments = np.array([0.75 * d + h, 0.75 * d + h, 1.5 * d])
        return InertialParameters.from_com(mass, com, np.diag(mass / 12.0 * moments))


def in_payload_frame(robot: Robot, equations: Equations) -> Equations:
    """Transform equations whose payload stands in frame n to the ten parameters about ``robot.payload_frame``."""
    if robot.flange.is_identity:
        return equations
    indices, M = [equations.columns.index(name) for name in PAYLOAD], np.eye(len(equations.columns))
    M[np.ix_(indices, indices)] = frame_change(robot.flange)
    return equations.transformed(M, equations.columns)


@lru_cache(maxsize=64)
def frame_change(pose: Pose) -> Array:
    """Matrix that changes the frame of a body's ten parameters, 10 x 10; ``pose``: of theirs in the one wanted."""
    columns = [InertialParameters(unit).moved(pose.R, pose.p).vector for unit in np.eye(10)]
    return frozen_array(np.column_stack(columns), (10, 10), "change of frame")
