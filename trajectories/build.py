"""Builds a design problem from a robot, the shape of its motion, a goal and what stands in the way."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..common.arrays import Array
from ..common.errors import InputError
from ..model import BaseParameters, InertialParameters, Robot, base_parameters, standard_columns
from ..model.regressors import payload_columns
from .bounds import JointBounds
from .collision import Clearance, Scene
from .goal import Goal
from .limits import DurationLimit, Limit, StateLimit, TorqueLimit
from .observation import SPRING, regressor_kernel
from .problem import DesignProblem
from .shapes import Shape, ViaPointShape, family_of


@dataclass(frozen=True)
class Loads:
    """What the torque limits are computed from.

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
    goal: Goal | None = None,
    *,
    bounds: JointBounds | None = None,
    loads: Loads | None = None,
    duration: float | None = None,
    start: ArrayLike | None = None,
    scene: Scene | None = None,
) -> DesignProblem:
    """Build the problem; ``solve_design`` solves it.

    Args:
        robot: the robot.
        shape: of the motion; 14 via points if None.
        goal: what is to be learnt; the information about all base parameters if None.
        bounds: limits of the joints; the description's if None.
        loads: parameters for the torque limits; the description's if None. Unused without torque limits.
        duration: longest time that a motion through via points may take [s].
        start: where it begins [rad or m], shape (n,).
        scene: obstacles, and the bodies that must keep clear of them and of each other.

    Raises:
        InputError: if something is missing or does not fit; if the parameters cannot be told apart.

    Example:
        >>> from dynident.model import load_robot
        >>> from dynident.trajectories import Goal, ViaPointShape, build_design, solve_design
        >>> problem = build_design(load_robot("rx90"), ViaPointShape(14), Goal("cond"))
        >>> design = solve_design(problem, seed=1)
        >>> motion = design.motion(rate=250.0)
    """
    shape, goal = shape or ViaPointShape(), goal or Goal()
    bounds = bounds or JointBounds.of(robot)
    pose = _start(robot, bounds, start)
    family = family_of(robot, bounds, shape, duration, pose)
    names, noise = goal.names(robot), goal.joint_noise(robot)
    criterion = goal.measure(names)
    limits: list[Limit] = [
        StateLimit("position", bounds.low, bounds.high),
        StateLimit("speed", -bounds.speed, bounds.speed),
        StateLimit("acceleration", -bounds.acceleration, bounds.acceleration),
    ]
    base = base_parameters(robot) if np.isfinite(bounds.torque).any() else None
    columns = regressor_columns(robot, names, base)
    kernel = regressor_kernel(robot, columns)
    if base is not None:
        for load, chi in load_coefficients(robot, base, columns, loads).items():
            limits.append(TorqueLimit(kernel, chi, bounds.torque, load))
    if duration is not None and family.free_duration:
        limits.append(DurationLimit(duration))
    if scene is not None:
        limits.append(Clearance(robot, scene))
    count = len(names)
    known = goal.earlier.rows(names) if goal.earlier is not None else np.zeros((0, count))
    places = np.array([columns.index(name) for name in names])
    problem = DesignProblem(
        robot, bounds, family, goal, names, criterion, kernel, places, noise, tuple(limits), known
    )
    for nearest in problem.clearances(pose[None]) if pose is not None else ():
        if nearest.room < 0.0:
            raise InputError(f"choose another start pose: {nearest} m")
    problem.require_full_rank(family.random(np.random.default_rng(0)))
    return problem


def regressor_columns(robot: Robot, names: Sequence[str], base: BaseParameters | None) -> tuple[str, ...]:
    """What the regressor must have, in the robot's order, so that different goals share compiled code."""
    wanted = {*names, *(base.columns if base is not None else ())}
    columns = tuple(name for name in standard_columns(robot) if name in wanted)
    return (*columns, SPRING) if base is not None and robot.spring is not None else columns


def _start(robot: Robot, bounds: JointBounds, start: ArrayLike | None) -> Array | None:
    if start is None:
        return None
    pose = np.asarray(start, dtype=float)
    if pose.shape != (robot.n,) or not ((pose >= bounds.low) & (pose <= bounds.high)).all():
        raise InputError(f"the start pose needs {robot.n} positions within the limits, got {pose.tolist()}")
    return pose


def load_coefficients(
    robot: Robot, base: BaseParameters, columns: Sequence[str], loads: Loads | None
) -> dict[str, Array]:
    """Coefficients of the columns for each load."""
    known = robot.parameters if loads is None else loads.parameters
    if all(name in known for name in base.standard):
        values = base.value(known)
    elif all(name in known for name in base.columns):
        values = np.array([known[name] for name in base.columns])
    else:
        missing = [name for name in base.columns if name not in known]
        raise InputError(
            f"torque limits need the parameters of robot {robot.name!r}: {', '.join(missing[:6])} "
            "are missing; identify the robot first, or leave torque limits out"
        )
    cases = {"": values}
    if loads is not None and loads.heaviest is not None:
        change = base.effect_of(payload_columns(robot)) @ loads.heaviest.vector
        cases = {"without payload": values, "with the heaviest payload": values + change}
    spring = {SPRING: -1.0}
    return {
        load: np.array([(dict(zip(base.columns, chi, strict=True)) | spring).get(name, 0.0) for name in columns])
        for load, chi in cases.items()
    }
