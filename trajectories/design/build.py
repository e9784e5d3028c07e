"""Builds a design problem from a robot, the shape of its motion, a goal and what stands in the way."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
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
from .problem import DesignProblem
from .scene import Scene


@dataclass(frozen=True)
class Loads:
    """Parameters that torque limits are computed from.

    Attributes:
        parameters: standard or base parameters of the robot by name.
        heaviest: the heaviest payload expected, in the last link's frame; the limits then hold without and
            with it.
    """

    parameters: Mapping[str, float]
    heaviest: InertialParameters | None = None


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
    kernel = regressor_kernel(model, _regressor_columns(model, goal.names(robot), base))
    limits = (
        *_joint_limits(family, bounds),
        *(_torque_limits(robot, base, kernel, bounds, loads) if base is not None else ()),
        *((duration_limit(duration),) if duration is not None and family.free_duration else ()),
        *((clearance(robot, scene),) if scene is not None else ()),
    )
    problem = DesignProblem(model, bounds, family, goal, kernel, limits)
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
    values = _base_values(robot, base, robot.parameters if loads is None else loads.parameters)
    cases = {"": values}
    if loads is not None and loads.heaviest is not None:
        change = base.effect_of(payload_columns(robot)) @ loads.heaviest.vector
        cases = {"without payload": values, "with the heaviest payload": values + change}
    for load, chi in cases.items():
        by_name = dict(zip(base.columns, chi, strict=True)) | {SPRING: -1.0}
        coefficients = np.array([by_name.get(name, 0.0) for name in kernel.columns])
        yield torque_limit(kernel, coefficients, bounds.torque, load)


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
