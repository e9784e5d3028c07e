"""Goal of a motion: which parameters it is to teach, by which criterion, and what is known already.

A motion near a pose is to tell of a payload, together with constant torques and friction that change by the day.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from ...common import Array, ArrayLike, Brief, InputError, decomposed, without
from ...common.errors import listed
from ...model import InertialParameters, Robot, base_parameters, standard_columns
from ...model.base.rank import leftmost_independent
from ...model.drives import parameter_kind
from ...model.inertia import PayloadSpread, payload_spread
from ...model.regressors import payload_columns
from ...model.visibility import check_mass_visible, friction_columns, visibility_of
from ..motions.family import FreeStates, JointBounds, Plan, Samples
from ..motions.fourier import FourierShape, FreeSeries, NearShape
from ..motions.rests import FreeRests, StaticShape
from ..motions.via_points import FreeViaPoints, ViaPoints, ViaPointShape
from .criterion import CRITERIA, Kind, RegressorKernel, regressor_kernel

Shape = ViaPointShape | FourierShape | NearShape | StaticShape
"""Kinds of motion among which a design chooses: each is a small value that stands for a family."""
Family = FreeViaPoints | FreeSeries | FreeRests | FreeStates
"""Families of motions that depend smoothly on a vector x of a ``size``, its entries of the order of 1 within
``low`` and ``high``: ``random`` draws an x to start from, through clear poses if it can, ``sample`` evaluates
states on the grid of the optimisation, or on a finer one, ``pullback`` gives the gradient in x of a number by that
in the samples, ``plan`` makes the motion, ``eased`` one that is slower, where the duration is free, and smaller.
``reach``: lowest and highest positions, (n,), or (k, n) for k equal parts of the samples."""

RESIDUAL, MEMORY, INDEPENDENT = 0.004, 1.8, 10.0
"""Torque errors assumed of a recording: standard deviation over the torque limits, times what memory adds to it;
and samples a second that are then independent [Hz].

Real residuals at 10 to 50 Hz over the limits: of a UR10e .26 to .38 %, of a TX40 .24 to .31 % (arm) and 1.1 to
2.4 % (wrist); jackknife over formula 1.9 and 1.7, geometric mean over the parameters.
"""
ASSUMED_RATIO = RESIDUAL * MEMORY
ASSUMED_NOISE = f"assumed to be {100 * ASSUMED_RATIO:.2g} % of the torque limits, as on real arms"
ASSUMED_STICTION = 0.05 * 0.1, "assumed, 5 % of a Coulomb friction of 10 % of the torque limits"
"""Scatter of the torque at rest from one approach to the next over the torque limits, and its source."""
_CHANGE, _WRIST = 0.033 / 0.05, 3
"""Change of a joint's constant torque between two recordings over that scatter, 3.3 % of Coulomb friction over 5 %;
of so many last joints it is free: as a weighing takes it."""
_PAIR = 2.0  # times the variance: payloads show in the difference of two recordings
_ALIKE = {"M": 0.01, "MX": 1e-3, "MY": 1e-3, "MZ": 1e-3}
"""Standard deviations that count alike: of the mass 10 g times the shape's ``mass_alike``, of the first moments 1
mm times the mass expected; of inertias ``_INERTIA``."""
_INERTIA = 0.02  # kg m^2
_SLOW = 0.03  # rad/s or m/s: rows of a slower joint are not used; the sign of its friction is not sure
_APART = 0.5 * np.pi  # rad: between two wrist poses
_GLANCES, _LOOKS = 2, 6  # random motions by which second poses are compared: all of them, and then the best few
_FEW = 5
_LOOKED = 200.0  # samples of each of them
_HELPS = 0.75  # of the uncertainty with one pose: above it a second pose is not worth leaving the range


@dataclass(frozen=True, eq=False, repr=False)
class Earlier(Brief):
    """Information of earlier recordings: R of a QR decomposition of their observation matrix.

    For "d" and "a" the rows of W are divided by the joints' torque noise, for condition numbers they are not.

    Attributes:
        columns: names of the columns, c.
        factor: k x c.
    """

    columns: tuple[str, ...]
    factor: Array


@dataclass(frozen=True, eq=False, repr=False)
class Goal(Brief):
    """Parameters to be learnt, and how their uncertainty is measured.

    Attributes:
        criterion: "d", "a", "cond" or "cond-scaled"; see criterion.py.
        columns: names of the parameters that will be estimated; None for all base parameters.
        payload_only: the last link's ten inertial parameters instead, the robot being known.
        interest: the parameters that count ("d" and "a"), the others being estimated besides; None for all.
        reference: values that standard deviations are relative to, by name; "a" needs them.
        noise: standard deviation of the torque noise of a recording per joint [N·m or N], shape (n,); None for
            ``assumed_noise``, inf for a joint whose torque is not used.
        rate: independent samples per second that will be recorded [Hz].
        noise_from: source of the noise, in words.
        data_length: how long will be recorded, the motion being repeated [s]; None for one motion as it is.
        offsets: whether ``columns`` may name constant torques of the joints, though the robot has none of its own.
        paired: whether torques are differences of two recordings, as those of a payload alone always are.
    """

    criterion: Kind = "d"
    columns: tuple[str, ...] | None = None
    payload_only: bool = False
    interest: tuple[str, ...] | None = None
    reference: Mapping[str, float] | None = None
    noise: ArrayLike | None = None
    rate: float = INDEPENDENT
    noise_from: str = "as given"
    data_length: float | None = None
    earlier: Earlier | None = None
    offsets: bool = False
    paired: bool = False

    def __post_init__(self) -> None:
        if self.criterion not in CRITERIA:
            raise InputError(f"criterion {self.criterion!r} is not one of {', '.join(CRITERIA)}")
        if self.payload_only and self.columns is not None:
            raise InputError("payload_only names the parameters itself: leave columns out")
        if self.interest is not None and self.criterion not in ("d", "a"):
            raise InputError("interest counts for d and a only: name the columns of a condition number instead")
        if self.criterion == "a" and not self.reference:
            raise InputError("criterion a needs reference values that standard deviations are relative to")
        if self.earlier is not None and self.data_length is None:
            raise InputError("with earlier recordings the data length to come must be given")

    def model(self, robot: Robot) -> Robot:
        """Robot with all columns that the goal may name."""
        return robot.with_offsets(True) if self.offsets else robot

    @property
    def single_rate(self) -> float:
        """Rate of independent samples that say as much without a second recording [Hz]."""
        return self.rate / _PAIR if self.paired or self.payload_only else self.rate

    def names(self, robot: Robot) -> tuple[str, ...]:
        """Names of the parameters.

        Raises:
            InputError: for a name that the robot does not have.
        """
        names = payload_columns(robot) if self.payload_only else self.columns or base_parameters(robot).columns
        known, interest = standard_columns(self.model(robot)), self.interest or ()
        wrong = [name for name in names if name not in known] + [name for name in interest if name not in names]
        if wrong or not names or len(set(names)) != len(names):
            fault = listed(wrong or ["none or the same twice"])
            raise InputError(f"cannot design for these parameters of robot {robot.name!r}: {fault}")
        return names


@dataclass(frozen=True, eq=False, repr=False)
class NearGoal(Brief):
    """Goal of a motion near a pose: a payload seen in noisy torques of the joints that the motion moves.

    They move all the time as a ``NearShape`` says, or stand still as a ``StaticShape`` does, where each approach to
    a pose is one sample.

    Attributes:
        noise: standard deviation of a torque sample of a recording per joint [N·m or N], shape (n,).
        rate: independent torque samples per second [Hz]; of a ``StaticShape`` one in the time that a pose is held.
        expected: about what the payload is; what is predicted depends on it.
        mass_sigma: of the scale on which the payload was weighed [kg]; None where it was not.
        noise_from: source of the noise, in words.
    """

    noise: Array
    rate: float
    expected: InertialParameters
    mass_sigma: float | None = None
    noise_from: str = "as given"

    def with_friction(self, robot: Robot, shape: Shape, family: Family) -> Goal:
        """Extend the goal to all that such motions tell apart: of the payload, and of friction.

        Raises:
            InputError: "mass not visible" where the mass is neither visible nor known.
        """
        if not isinstance(shape, NearShape | StaticShape):
            raise InputError("this goal is for motions near a pose: give a NearShape or a StaticShape")
        visibility = shape.visibility(robot)
        check_mass_visible(visibility, self.mass_sigma is not None, "near this pose")
        payload, moving = payload_columns(robot), [joint - 1 for joint in shape.joints]
        kernel, samples = _payload_kernel(robot), family.sample(family.random(np.random.default_rng(0)))
        W = kernel.matrix(samples).reshape(robot.n, len(samples.q), -1)[moving].reshape(-1, len(kernel.columns))
        indices = [*visibility.base.chosen, *range(len(payload), len(kernel.columns))]
        names = tuple(kernel.columns[indices[k]] for k in leftmost_independent(W[:, indices]))
        interest = tuple(name for name in names if name in payload)
        mass = self.expected.mass
        scales = {name: _ALIKE.get(parameter_kind(name), _INERTIA / mass) for name in interest}
        alike = {name: scale * (shape.mass_alike if name == payload[9] else mass) for name, scale in scales.items()}
        noise = np.where(np.isin(np.arange(robot.n), moving), self.noise, np.inf)
        known = {} if self.mass_sigma is None else {payload[9]: self.mass_sigma}
        if isinstance(shape, StaticShape):
            known |= {f"OFF{j + 1}": _CHANGE * self.noise[j] for j in range(max(robot.n - _WRIST, 1))}
        rows = [[float(name == own) / sigma for name in names] for own, sigma in known.items() if own in names]
        return Goal(
            "a",
            names,
            interest=interest,
            reference=alike,
            noise=noise,
            rate=self.rate,
            noise_from=self.noise_from,
            data_length=shape.duration,
            earlier=Earlier(names, np.array(rows)) if rows else None,
            offsets=True,
            paired=True,
        )

    def predicted(
        self, robot: Robot, plan: Plan, joints: Sequence[int], sample_rate: float | None = None
    ) -> PayloadSpread:
        """Standard deviations by (17)-(19) of a payload's numbers; constant torques and friction unknown too.

        Torques of the ``joints`` with these numbers count. The motion is looked at at ``sample_rate`` [Hz], twice
        the rate of independent samples if None; of one through points every approach to a pose that it holds is a
        sample, and the arm's constant torques change little.
        """
        if held := isinstance(plan, ViaPoints):
            samples, rate = Samples.at_rest(plan.held), self.rate
        else:
            motion = plan.motion(sample_rate or 2.0 * self.rate)
            samples, rate = Samples.of(motion), motion.rate
        kernel, rows = _payload_kernel(robot), []
        W = kernel.matrix(samples).reshape(robot.n, len(samples.q), -1)
        for joint in joints:
            own = W[joint - 1][held | (np.abs(samples.qd[:, joint - 1]) >= _SLOW)]
            if held and joint <= max(robot.n - _WRIST, 1):
                own = np.vstack([own, np.sqrt(_PAIR) / _CHANGE * (np.array(kernel.columns) == f"OFF{joint}")])
            scale = np.sqrt(self.rate / _PAIR / rate) / self.noise[joint - 1]
            rows.append(scale * without(own[:, :10], own[:, 10:]))
        A = np.vstack(rows)
        visibility = visibility_of(A, joints)
        indices, T, b = visibility.resolved(self.mass_sigma is not None)
        known, W = np.array(visibility.base.chosen) == 9, A[:, list(visibility.base.chosen)]
        if self.mass_sigma is not None and known.any():
            W = np.vstack([W, known[None] / self.mass_sigma])  # the scale is one more equation
        C = decomposed(W).covariance
        total = T @ C @ T.T + (0.0 if self.mass_sigma is None else np.outer(b, b) * self.mass_sigma**2)
        return payload_spread(self.expected.vector, total, indices)


def assumed_noise(robot: Robot, ratio: float = ASSUMED_RATIO) -> Array:
    """Torque errors where none are told [N·m or N], a ratio of the limits, shape (n,); inf without limits."""
    return ratio * np.array([joint.limits.torque for joint in robot.joints])


def second_pose(
    robot: Robot, shape: NearShape, goal: NearGoal, bounds: JointBounds | None = None, seed: int = 0
) -> Array | None:
    """Find a second pose, wrist joints turned by 90 degrees, that tells clearly more on a few random motions.

    None where no such pose does.
    """
    bounds, n = bounds or JointBounds.of(robot), robot.n
    wrist = [j for j in range(max(n - 3, 0), n) if j + 1 in shape.joints and robot.joints[j].revolute]
    pose, candidates = shape.poses[0], []
    for steps in product((-1.0, 0.0, 1.0), repeat=len(wrist)):
        candidate = pose.copy()
        candidate[wrist] += _APART * np.array(steps)
        if any(steps) and ((candidate > bounds.low) & (candidate < bounds.high)).all():
            candidates.append(candidate)

    def least(poses: Sequence[Array], looks: int) -> float:
        """Uncertainty of the mass in 10 g or of its centre in mm, after the best of a few random motions."""
        try:
            family = replace(shape, poses=np.array(poses)).family(robot, bounds)
        except InputError:
            return np.inf  # there is no time for them
        draw, rate, seen = np.random.default_rng(seed), min(_LOOKED / shape.duration, 2.0 * goal.rate), []
        for _ in range(looks):
            spread = goal.predicted(robot, family.plan(family.random(draw)), shape.joints, rate)
            numbers = spread.mass / _ALIKE["M"], *(spread.com / _ALIKE["MX"])
            seen.append(max((x for x in numbers if np.isfinite(x)), default=np.inf))
        return min(seen)

    glances = [least([pose, candidate], _GLANCES) for candidate in candidates]
    few = np.argsort(glances, kind="stable")[:_FEW]
    best, k = min(((least([pose, candidates[k]], _LOOKS), int(k)) for k in few), default=(np.inf, 0))
    return candidates[k] if best < _HELPS * least([pose], _LOOKS) else None


def _payload_kernel(robot: Robot) -> RegressorKernel:
    return regressor_kernel(robot.with_offsets(True), (*payload_columns(robot), *friction_columns(robot)))
