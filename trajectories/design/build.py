"""Builds a design problem from a robot, the shape of its motion, a goal and what stands in the way."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from msgspec.structs import replace
from numpy.typing import ArrayLike

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import InertialParameters, Robot, base_parameters, standard_columns
from ...model.base.parameters import BaseParameters
from ...model.regressors import payload_columns
from ..motions.bounds import JointBounds
from ..motions.samples import Family, Shape
from ..motions.via_points import ViaPointShape
from .collision import clearance
from .goal import Goal
from .information import SPRING, RegressorKernel, regressor_kernel
from .limits import Limit, duration_limit, state_limit, torque_limit
from .near_goal import NearGoal
from .payloads import PayloadSet, RobotTorque, payload_limit
from .problem import DesignProblem
from .scene import Capsule, Scene

_WRIST = 3  # links before the flange that the ball of the payloads may overlap


@dataclass(frozen=True)
class Loads:
    """Parameters that torque limits are computed from.

    Attributes:
        parameters: standard or base parameters of the robot by name.
        heaviest: the heaviest payload expected, in the last link's frame; the limits then hold without and
            with it. A set: they hold for each of its bodies, and without any.
        covariance: of ``parameters`` in their order; None where they are taken as exact. It counts for a set, by
            two standard deviations of the robot's own torque.
        margin: share of the torque limits that stays free.
    """

    parameters: Mapping[str, float]
    heaviest: InertialParameters | PayloadSet | None = None
    covariance: Array | None = None
    margin: float = 0.0

    def __post_init__(self) -> None:
        """Refuse a margin that leaves nothing.

        Raises:
            InputError: unless it is at least 0 and below 1.
        """
        if not 0.0 <= self.margin < 1.0:
            raise InputError(f"a torque margin of {self.margin:g}: give a share of the limits from 0 to below 1")


def build_design(
    robot: Robot,
    shape: Shape | None = None,
    goal: Goal | NearGoal | None = None,
    *,
    bounds: JointBounds | None = None,
    loads: Loads | None = None,
    duration: float | None = None,
    start: ArrayLike | None = None,
    scene: Scene | None = None,
) -> DesignProblem:
    """Build the problem; ``solve_design`` solves it.

    Args:
        shape: of the motion; 14 via points if None.
        goal: what is to be learnt; the information about all base parameters if None.
        bounds: limits of the joints; the description's if None.
        loads: parameters for the torque limits; the description's if None. Unused without torque limits.
        duration: longest time that a motion through via points may take [s].
        start: where it begins [rad or m], shape (n,).
        scene: obstacles, and the bodies that must keep clear of them and of each other.

    Raises:
        InputError: if something is missing or does not fit; if the parameters cannot be told apart.
    """
    shape, goal, bounds = shape or ViaPointShape(), goal or Goal(), bounds or JointBounds.of(robot)
    pose = _start(robot, bounds, start)
    family = shape.family(robot, bounds, duration, pose)
    if isinstance(goal, NearGoal):
        goal = goal.beside_friction(robot, shape, family)
    model, base = goal.model(robot), base_parameters(robot) if np.isfinite(bounds.torque).any() else None
    payloads = _set_of(loads)
    names = (*goal.names(robot), *(payload_columns(robot) if payloads is not None else ()))
    around = _with_payload(scene, payloads, robot.n)
    kernel = regressor_kernel(model, _regressor_columns(model, names, base))
    limits = (
        *_joint_limits(family, bounds),
        *(_torque_limits(robot, base, kernel, bounds, loads) if base is not None else ()),
        *((duration_limit(duration),) if duration is not None and family.free_duration else ()),
        *((clearance(robot, around),) if around is not None else ()),
    )
    problem = DesignProblem(model, bounds, family, goal, kernel, limits, payloads, around)
    _check_start(problem, pose)
    problem.require_full_rank(family.random(np.random.default_rng(0)))
    return problem


def _start(robot: Robot, bounds: JointBounds, start: ArrayLike | None) -> Array | None:
    if start is None:
        return None
    pose = np.asarray(start, dtype=float)
    if pose.shape != (robot.n,) or not ((pose >= bounds.low) & (pose <= bounds.high)).all():
        raise InputError(f"the start pose needs {robot.n} positions within the limits, got {pose.tolist()}")
    return pose


def _check_start(problem: DesignProblem, pose: Array | None) -> None:
    """Refuse a start pose that touches something."""
    for nearest in problem.clearances(pose[None]) if pose is not None else ():
        if nearest.room < 0.0:
            raise InputError(f"choose another start pose: {nearest} m")


def _joint_limits(family: Family, bounds: JointBounds) -> Iterator[Limit]:
    yield state_limit("position", *family.reach)
    yield state_limit("speed", -bounds.speed, bounds.speed)
    yield state_limit("acceleration", -bounds.acceleration, bounds.acceleration)


def _regressor_columns(robot: Robot, names: Sequence[str], base: BaseParameters | None) -> tuple[str, ...]:
    """What the regressor must have, in the robot's order, so that different goals share compiled code."""
    needed = {*names, *(base.columns if base is not None else ())}
    columns = tuple(name for name in standard_columns(robot) if name in needed)
    return (*columns, SPRING) if base is not None and robot.spring is not None else columns


def _torque_limits(
    robot: Robot, base: BaseParameters, kernel: RegressorKernel, bounds: JointBounds, loads: Loads | None
) -> Iterator[Limit]:
    """Torque limits for each load."""
    loads = loads or Loads(robot.parameters)
    values = _base_values(robot, base, loads.parameters)
    torque = (1.0 - loads.margin) * bounds.torque
    if isinstance(loads.heaviest, PayloadSet):
        own = RobotTorque(_by_column(kernel, base, values), _root(kernel, base, loads))
        yield payload_limit(kernel, own, torque, loads.heaviest, payload_columns(robot))
        return
    cases = {"": values}
    if isinstance(loads.heaviest, InertialParameters):
        change = base.effect_of(payload_columns(robot)) @ loads.heaviest.vector
        cases = {"without payload": values, "with the heaviest payload": values + change}
    for load, chi in cases.items():
        yield torque_limit(kernel, _by_column(kernel, base, chi), torque, load)


def _set_of(loads: Loads | None) -> PayloadSet | None:
    """Payloads for each of which torque limits hold."""
    return loads.heaviest if loads is not None and isinstance(loads.heaviest, PayloadSet) else None


def _with_payload(scene: Scene | None, payloads: PayloadSet | None, n: int) -> Scene | None:
    """The scene with the ball that holds the payloads: clear of all surfaces, and of bodies below the wrist."""
    if scene is None or payloads is None:
        return scene
    x, y, z = (float(c) for c in payloads.centre)
    ball = Capsule("payload within bounds", n, payloads.radius, (x, y, z))
    pairs = tuple((ball.name, body.name) for body in scene.bodies if body.link <= n - _WRIST)
    return replace(scene, bodies=(*scene.bodies, ball), pairs=(*scene.pairs, *pairs))


def _by_column(kernel: RegressorKernel, base: BaseParameters, chi: Array) -> Array:
    """Coefficients of the kernel's columns, the known spring's among them."""
    by_name = dict(zip(base.columns, chi, strict=True)) | {SPRING: -1.0}
    return np.array([by_name.get(name, 0.0) for name in kernel.columns])


def _root(kernel: RegressorKernel, base: BaseParameters, loads: Loads) -> Array:
    """Root of the covariance of ``_by_column``, c x r; r = 0 without one.

    Raises:
        InputError: if the covariance is not that of the base parameters.
    """
    root = np.zeros((len(kernel.columns), 0))
    if loads.covariance is None:
        return root
    names = list(loads.parameters)
    if not set(base.columns) <= set(names) or np.shape(loads.covariance) != (len(names),) * 2:
        raise InputError(
            "a covariance of the torques' parameters must be that of all base parameters, in their order"
        )
    values, V = np.linalg.eigh(loads.covariance)
    root = np.zeros((len(kernel.columns), len(names)))
    for name in base.columns:
        root[kernel.columns.index(name)] = (V * np.sqrt(np.maximum(values, 0.0)))[names.index(name)]
    return root


def _base_values(robot: Robot, base: BaseParameters, known: Mapping[str, float]) -> Array:
    """Base parameters from standard or base parameters by name."""
    if all(name in known for name in base.standard):
        return base.value(known)
    missing = [name for name in base.columns if name not in known]
    if missing:
        raise InputError(
            f"torque limits need the parameters of robot {robot.name!r}: {', '.join(missing[:6])} "
            "are missing; identify the robot first, or leave torque limits out"
        )
    return np.array([known[name] for name in base.columns])
