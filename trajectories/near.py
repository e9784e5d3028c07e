"""Designs a short motion near a pose that tells a payload, and what it will tell."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..common.arrays import Array
from ..common.errors import InputError
from ..model import InertialParameters, Robot, base_parameters
from ..model.base import leftmost_independent
from ..model.names import parameter_kind
from ..model.payload_spread import PayloadSpread
from ..model.regressors import payload_columns
from ..model.visibility import PayloadVisibility, checked_joints, friction_columns, payload_visibility
from .bounds import JointBounds
from .build import Loads, load_coefficients, regressor_columns
from .collision import Clearance, Scene
from .design import Design, solve_design
from .goal import Goal
from .limits import Limit, StateLimit, TorqueLimit
from .near_motion import FreeNearMotion, NearMotion, RangeLimit
from .near_prediction import predicted_spread
from .observation import regressor_kernel
from .problem import DesignProblem
from .search import Step
from .via_points import shortest_durations

_PERIOD = 7.5
"""s: about how long a series lasts before it is repeated."""
_HARMONICS = 8
SHARES = {"M": 0.01, "MX": 1e-3, "MY": 1e-3, "MZ": 1e-3}
"""Standard deviations that count alike: of the mass 10 g, of the first moments 1 mm times the mass expected; of
inertias ``_INERTIA``."""
_INERTIA = 0.02  # kg m^2
_TRANSFER_SPEED = 0.5  # of the limits


@dataclass(frozen=True, eq=False)
class NearRequest:
    """A motion about a pose.

    Attributes:
        robot: the robot, n joints.
        pose: where it stands [rad or m], shape (n,).
        joints: numbers of the joints that move.
        ranges: how far each goes to either side [rad or m], shape (k,).
        duration: of the motion [s].
        noise: standard deviation of a torque sample per joint [N·m or N], shape (n,).
        rate: independent torque samples per second [Hz].
        expected: about what the payload is; what is predicted depends on it.
        mass_sigma: of the scale on which the payload was weighed [kg]; None where it was not.
        second: another pose at which the motion is done again [rad or m], shape (n,).
        bounds: limits of the joints; the description's if None.
        scene: what must keep clear.
        parameters: of the robot by name, for its torque limits; the description's if None. Without either the
            torque limits are not kept, and ``torque_limited`` says so.
    """

    robot: Robot
    pose: Array
    joints: tuple[int, ...]
    ranges: Array
    duration: float
    noise: Array
    rate: float
    expected: InertialParameters
    mass_sigma: float | None = None
    second: Array | None = None
    bounds: JointBounds | None = None
    scene: Scene | None = None
    parameters: Mapping[str, float] | None = None

    def __post_init__(self) -> None:
        """Refuse what cannot be moved."""
        moving, limits = checked_joints(self.robot, self.joints), self.limits
        if len(self.ranges) != len(moving) or not (self.ranges > 0.0).all() or not np.isfinite(self.ranges).all():
            raise InputError(f"the range must be one positive number, or one for each of {len(moving)} joints")
        if not 0.0 < self.duration < np.inf:
            raise InputError(f"a duration of {self.duration:g} s: give a positive one")
        for pose in self.poses:
            if pose.shape != (self.robot.n,) or not ((pose > limits.low) & (pose < limits.high)).all():
                raise InputError(
                    f"the pose {_degrees(self.robot, pose)} must be {self.robot.n} positions within the limits of "
                    f"{self.robot.name}"
                )

    @property
    def limits(self) -> JointBounds:
        """What the joints may do."""
        return self.bounds or JointBounds.of(self.robot)

    @property
    def poses(self) -> Array:
        """One pose, or two, poses x n."""
        return np.array([self.pose] if self.second is None else [self.pose, self.second], dtype=float)

    @cached_property
    def loads(self) -> Loads | None:
        """What the torques are computed from; None where the limits or the robot's parameters are not known."""
        known = self.robot.parameters if self.parameters is None else self.parameters
        if not known or not np.isfinite(self.limits.torque).any():
            return None
        return Loads(known, self.expected)

    @property
    def torque_limited(self) -> bool:
        """Whether the motion keeps torque limits."""
        return self.loads is not None

    @property
    def visibility(self) -> PayloadVisibility:
        """What torques near the poses will show, before any motion."""
        return payload_visibility(self.robot, list(self.poses), self.joints, self.ranges.tolist())


@dataclass(frozen=True, eq=False)
class NearDesign:
    """The motion that was found, and what it will tell.

    Attributes:
        request: what was asked.
        visibility: what can be seen at all.
        design: of the series; its score tells the limits.
        motion: with its repeats and transfers.
        spread: predicted standard deviations, of white noise.
    """

    request: NearRequest
    visibility: PayloadVisibility
    design: Design
    motion: NearMotion
    spread: PayloadSpread


def check_mass_visible(visibility: PayloadVisibility, mass_known: bool, when: str) -> None:
    """Refuse joints whose torques do not hold the mass, unless it is known.

    Raises:
        InputError: "mass not visible".
    """
    if visibility.mass_visible or mass_known:
        return
    joints = ", ".join(map(str, visibility.joints))
    sums = visibility.combination("M")
    why = f"they show it only in {sums}" if sums else "they do not contain it"
    raise InputError(
        f"mass not visible {when}: the torques of joint {joints} alone leave it undetermined ({why}); let another "
        "joint move, or weigh the payload and give --mass and --mass-sigma"
    )


def design_near(
    request: NearRequest,
    *,
    seed: int = 0,
    starts: int = 1,
    progress: Callable[[Step], None] = lambda step: None,
) -> NearDesign:
    """Find a motion near a pose that tells the payload well.

    Args:
        request: what is asked.
        seed: of the random starts; the same seed gives the same motion.
        starts: number of random starts.
        progress: called after each stage.

    Raises:
        InputError: "mass not visible" where it is neither visible nor known; if the duration leaves no time.
    """
    visibility = request.visibility
    check_mass_visible(visibility, request.mass_sigma is not None, "near this pose")
    problem = near_problem(request, visibility)
    design = solve_design(problem, seed=seed, starts=starts, progress=progress)
    assert isinstance(design.plan, NearMotion)
    spread = spread_of(request, design.plan)
    return NearDesign(request, visibility, design, design.plan, spread)


def near_problem(request: NearRequest, visibility: PayloadVisibility) -> DesignProblem:
    """The design problem of a request."""
    robot, moving = request.robot.with_offsets(True), [joint - 1 for joint in request.joints]
    bounds, family = request.limits, near_family(request)
    loads = request.loads
    base = base_parameters(request.robot) if loads is not None else None
    wanted = (*payload_columns(robot), *friction_columns(robot))
    kernel = regressor_kernel(robot, regressor_columns(robot, wanted, base))
    limits: list[Limit] = [
        RangeLimit(family),
        StateLimit("speed", -bounds.speed, bounds.speed),
        StateLimit("acceleration", -bounds.acceleration, bounds.acceleration),
    ]
    if base is not None:
        cases = load_coefficients(request.robot, base, kernel.columns, loads)
        limits += [TorqueLimit(kernel, chi, bounds.torque, load) for load, chi in cases.items()]
    if request.scene is not None:
        limits.append(Clearance(request.robot, request.scene))
    samples = family.sample(family.random(np.random.default_rng(0)))
    W = kernel.matrix(samples).reshape(robot.n, len(samples.q), -1)[moving].reshape(-1, len(kernel.columns))
    seen = [kernel.columns.index(name) for name in [wanted[k] for k in visibility.chosen] + list(wanted[10:])]
    places = np.array([seen[k] for k in leftmost_independent(W[:, seen])])
    names = tuple(kernel.columns[k] for k in places)
    own = [k for k, name in enumerate(names) if name in wanted[:10]]
    mass = request.expected.mass
    reference = {
        names[k]: SHARES.get(kind, _INERTIA / mass) * (1.0 if kind == "M" else mass)
        for k in own
        for kind in [parameter_kind(names[k])]
    }
    goal = Goal(
        "a",
        names,
        interest=tuple(names[k] for k in own),
        reference=reference,
        rate=request.rate,
        data_length=request.duration,
    )
    scale = np.zeros((0, len(names)))
    if request.mass_sigma is not None and wanted[9] in names:
        scale = np.array([[float(name == wanted[9]) / request.mass_sigma for name in names]])
    noise = np.full(robot.n, np.inf)
    noise[moving] = request.noise[moving]
    return DesignProblem(
        robot, bounds, family, goal, names, goal.measure(names), kernel, places, noise, tuple(limits), scale
    )


def spread_of(request: NearRequest, motion: NearMotion) -> PayloadSpread:
    """What a motion will tell."""
    return predicted_spread(
        request.robot,
        motion.motion(2.0 * request.rate),
        request.joints,
        request.noise,
        request.rate,
        request.expected,
        request.mass_sigma,
    )


def near_family(request: NearRequest) -> FreeNearMotion:
    """The motions among which to choose.

    Raises:
        InputError: if the duration leaves no time beside the way between two poses.
    """
    bounds, poses = request.limits, request.poses
    moving = [joint - 1 for joint in request.joints]
    transfer = 0.0
    if len(poses) > 1:
        # Ten milliseconds more than the shortest, so that rounding breaks no limit.
        transfer = float(shortest_durations(bounds.on(request.robot), poses, _TRANSFER_SPEED)[0]) + 0.01
    stay = request.duration / len(poses) - transfer
    if stay < 1.0:
        raise InputError(
            f"{request.duration:g} s leave {stay:.1f} s at each pose beside the way between them: give a longer "
            "--duration"
        )
    repeats = max(1, round(stay / _PERIOD))
    return FreeNearMotion(
        bounds,
        poses,
        moving,
        np.asarray(request.ranges, dtype=float),
        harmonics=_HARMONICS,
        period=stay / repeats,
        repeats=repeats,
        transfer=transfer,
    )


def _degrees(robot: Robot, pose: Sequence[float]) -> str:
    if len(pose) != robot.n:
        return f"of {len(pose)} numbers"
    told = (np.degrees(x) if joint.revolute else x for x, joint in zip(pose, robot.joints, strict=True))
    return ", ".join(f"{x:g}" for x in told)
