"""What a motion near a pose is to tell: a payload, beside constant torques and friction that change by the day."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import decomposed, without
from ...model import InertialParameters, Robot
from ...model.base.rank import leftmost_independent
from ...model.drives import parameter_kind
from ...model.inertia import PayloadSpread, payload_spread
from ...model.regressors import payload_columns
from ...model.visibility import PayloadVisibility, friction_columns, visibility_of
from ..motions.bounds import JointBounds
from ..motions.near import NearShape
from ..motions.samples import Family, Plan, Samples, Shape
from .goal import Earlier, Goal
from .information import RegressorKernel, regressor_kernel

_SHARES = {"M": 0.01, "MX": 1e-3, "MY": 1e-3, "MZ": 1e-3}
"""Standard deviations that count alike: of the mass 10 g, of the first moments 1 mm times the mass expected; of
inertias ``_INERTIA``."""
_INERTIA = 0.02  # kg m^2
_SLOW = 0.03  # rad/s or m/s: rows of a slower joint are not used; the sign of its friction is not sure
_APART = 0.5 * np.pi  # rad: between two wrist poses
_GLANCES, _LOOKS = 2, 6  # random motions by which second poses are compared: all of them, and then the best few
_FEW = 5
_LOOKED = 200.0  # samples of each of them
_HELPS = 0.75  # of the uncertainty with one pose: above it a second pose is not worth leaving the range


@dataclass(frozen=True, eq=False)
class NearGoal:
    """A payload seen through noisy torques of the joints that a ``NearShape`` moves.

    Attributes:
        noise: standard deviation of a torque sample per joint [N·m or N], shape (n,).
        rate: independent torque samples per second [Hz].
        expected: about what the payload is; what is predicted depends on it.
        mass_sigma: of the scale on which the payload was weighed [kg]; None where it was not.
    """

    noise: Array
    rate: float
    expected: InertialParameters
    mass_sigma: float | None = None

    def beside_friction(self, robot: Robot, shape: Shape, family: Family) -> Goal:
        """The goal with the names of all that such motions tell apart: of the payload, and of friction beside it.

        Raises:
            InputError: "mass not visible" where the mass is neither visible nor known.
        """
        if not isinstance(shape, NearShape):
            raise InputError("this goal is for motions near a pose: give a NearShape")
        visibility = shape.visibility(robot)
        check_mass_visible(visibility, self.mass_sigma is not None, "near this pose")
        payload, moving = payload_columns(robot), [joint - 1 for joint in shape.joints]
        kernel, samples = _payload_kernel(robot), family.sample(family.random(np.random.default_rng(0)))
        W = kernel.matrix(samples).reshape(robot.n, len(samples.q), -1)[moving].reshape(-1, len(kernel.columns))
        indices = [*visibility.chosen, *range(len(payload), len(kernel.columns))]
        names = tuple(kernel.columns[indices[k]] for k in leftmost_independent(W[:, indices]))
        interest = tuple(name for name in names if name in payload)
        noise, earlier = np.full(robot.n, np.inf), None
        noise[moving] = self.noise[moving]
        if self.mass_sigma is not None and payload[9] in names:
            earlier = Earlier(names, np.array([[float(name == payload[9]) / self.mass_sigma for name in names]]))
        return Goal(
            "a",
            names,
            interest=interest,
            reference={name: self._alike(name) for name in interest},
            noise=noise,
            rate=self.rate,
            data_length=shape.duration,
            earlier=earlier,
            offsets=True,
        )

    def _alike(self, name: str) -> float:
        """Standard deviation of a parameter that counts as much as those of the others."""
        kind, mass = parameter_kind(name), self.expected.mass
        return _SHARES["M"] if kind == "M" else _SHARES.get(kind, _INERTIA / mass) * mass

    def predicted(
        self, robot: Robot, plan: Plan, joints: Sequence[int], sample_rate: float | None = None
    ) -> PayloadSpread:
        """Standard deviations by (17)-(19) of a payload's numbers; constant torques and friction unknown too.

        Args:
            joints: numbers of the joints whose torques count.
            sample_rate: at which the motion is looked at [Hz]; None for twice the rate of independent samples.
        """
        motion = plan.motion(sample_rate or 2.0 * self.rate)
        count, rows = len(motion.t), []
        samples = Samples(np.ones(count), motion.q, motion.qd, motion.qdd)
        W = _payload_kernel(robot).matrix(samples).reshape(robot.n, count, -1)
        for joint in joints:
            own = W[joint - 1][np.abs(motion.qd[:, joint - 1]) >= _SLOW]
            share = np.sqrt(self.rate / motion.rate) / self.noise[joint - 1]
            rows.append(share * without(own[:, :10], own[:, 10:]))
        A = np.vstack(rows)
        visibility = visibility_of(A, joints)
        places, T, b = visibility.resolved(self.mass_sigma is not None)
        C = _covariance(A[:, list(visibility.chosen)], visibility.chosen, self.mass_sigma)
        total = T @ C @ T.T + (0.0 if self.mass_sigma is None else np.outer(b, b) * self.mass_sigma**2)
        return payload_spread(self.expected.vector, total, places)


def check_mass_visible(visibility: PayloadVisibility, mass_known: bool, when: str) -> None:
    """Refuse joints whose torques do not hold the mass, unless it is known."""
    if visibility.mass_visible or mass_known:
        return
    joints = ", ".join(map(str, visibility.joints))
    sums = visibility.combination("M")
    why = f"they show it only in {sums}" if sums else "they do not contain it"
    raise InputError(
        f"mass not visible {when}: the torques of joint {joints} alone leave it undetermined ({why}); let another "
        "joint move, or weigh the payload and give --mass KG+-KG"
    )


def second_pose(
    robot: Robot, shape: NearShape, goal: NearGoal, bounds: JointBounds | None = None, seed: int = 0
) -> Array | None:
    """A second pose that would tell clearly more, the moving wrist joints turned by 90 degrees; None without one.

    Judged on a few random motions each, before any design.
    """
    bounds, n = bounds or JointBounds.of(robot), robot.n
    wrist = [j for j in range(max(n - 3, 0), n) if j + 1 in shape.joints and robot.joints[j].revolute]
    pose, candidates = shape.poses[0], []
    for pattern in np.ndindex(*(3,) * len(wrist)):
        candidate = pose.copy()
        candidate[wrist] += _APART * (np.array(pattern) - 1.0)
        if any(step != 1 for step in pattern) and ((candidate > bounds.low) & (candidate < bounds.high)).all():
            candidates.append(candidate)

    def least(poses: Sequence[Array], looks: int) -> float:
        return _least_uncertainty(robot, replace(shape, poses=np.array(poses)), goal, bounds, seed, looks)

    glances = [least([pose, candidate], _GLANCES) for candidate in candidates]
    few = np.argsort(glances, kind="stable")[:_FEW]
    best, k = min(((least([pose, candidates[k]], _LOOKS), int(k)) for k in few), default=(np.inf, 0))
    return candidates[k] if best < _HELPS * least([pose], _LOOKS) else None


def _least_uncertainty(
    robot: Robot, shape: NearShape, goal: NearGoal, bounds: JointBounds, seed: int, looks: int
) -> float:
    """Uncertainty after the best of a few random motions; infinite if there is no time for them."""
    try:
        family = shape.family(robot, bounds)
    except InputError:
        return np.inf
    draw = np.random.default_rng(seed)
    plans = (family.plan(family.random(draw)) for _ in range(looks))
    rate = min(_LOOKED / shape.duration, 2.0 * goal.rate)
    return min(_uncertainty(goal.predicted(robot, plan, shape.joints, rate)) for plan in plans)


def _uncertainty(spread: PayloadSpread) -> float:
    """Uncertainty of mass in units of 10 g or of the centre of mass in mm, the larger; infinite ones left out."""
    numbers = [spread.mass / _SHARES["M"], *(spread.com / _SHARES["MX"])]
    return max((x for x in numbers if np.isfinite(x)), default=np.inf)


def _payload_kernel(robot: Robot) -> RegressorKernel:
    """The payload's ten columns, then constant torques and Coulomb friction."""
    return regressor_kernel(robot.with_offsets(True), (*payload_columns(robot), *friction_columns(robot)))


def _covariance(W: Array, chosen: tuple[int, ...], mass_sigma: float | None) -> Array:
    """Covariance of least squares, with the scale as one more equation where the mass is among the parameters."""
    if mass_sigma is not None and 9 in chosen:
        W = np.vstack([W, (np.array(chosen) == 9)[None] / mass_sigma])
    return decomposed(W).covariance
