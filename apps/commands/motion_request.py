"""From options to a design problem, for commands that design a motion or judge one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ... import model, trajectories
from ...common.arrays import Array
from ...common.errors import InputError
from .options import GoalOptions, LimitOptions
from .options.limits import Known

if TYPE_CHECKING:
    Payload = model.InertialParameters | trajectories.PayloadSet
_ZERO = 1e-9  # SI units: what standard parameters leave where they cancel


class Request(NamedTuple):
    """What was asked for.

    Attributes:
        problem: to be solved, or to judge a motion by.
        reference: values of parameters that standard deviations are relative to.
        labels: how to call a parameter ("ZZ1R"), by its name.
    """

    problem: trajectories.DesignProblem
    reference: Mapping[str, float]
    labels: Mapping[str, str]


class Asked(NamedTuple):
    """What is asked of the motion itself.

    Attributes:
        shape: of the motion; None where it is given.
        length: how long it will take [s], where that is known.
        longest: how long it may take [s].
        start: where it begins [rad or m], shape (n,).
    """

    shape: trajectories.Shape | None = None
    length: float | None = None
    longest: float | None = None
    start: Array | None = None


def build_request(robot: model.Robot, motion: Asked, goal: GoalOptions, limits: LimitOptions) -> Request:
    """Read all files and build the problem.

    Raises:
        InputError: for whatever does not fit; one line.
    """
    known = limits.known(robot)
    robot, bounds = known.robot, limits.bounds(known.robot)
    payload = limits.payload(robot, bounds)
    reference = _payload_reference(robot, payload) if goal.payload_only else _reference(robot, known.values)
    problem = trajectories.build_design(
        robot,
        motion.shape,
        goal.goal(robot, bounds, reference, motion.length),
        bounds=bounds,
        loads=_loads(known, payload, bounds, goal.payload_only, limits.torque_margin),
        duration=motion.longest,
        start=motion.start,
        scene=limits.read_scene(),
    )
    base = model.base_parameters(robot)
    labels = {} if goal.payload_only else dict(zip(base.columns, base.names, strict=True))
    return Request(problem, reference, labels)


def _payload_reference(robot: model.Robot, payload: Payload | None) -> dict[str, float]:
    """Values of the heaviest payload's parameters, that standard deviations are relative to; none of a set."""
    values = payload.named(str(robot.n)) if isinstance(payload, model.InertialParameters) else {}
    return {name: value for name, value in values.items() if abs(value) > _ZERO}


def _reference(robot: model.Robot, known: Mapping[str, float]) -> dict[str, float]:
    """Values of the robot's parameters, as far as they are known, that standard deviations are relative to."""
    base, values = model.base_parameters(robot), dict(known)
    if not known and all(name in robot.parameters for name in base.standard):
        values = dict(zip(base.columns, base.value(robot.parameters).tolist(), strict=True))
    return {name: value for name, value in values.items() if abs(value) > _ZERO}


def _loads(
    known: Known,
    payload: Payload | None,
    bounds: trajectories.JointBounds,
    payload_only: bool,
    margin: float | None,
) -> trajectories.Loads | None:
    if not np.isfinite(bounds.torque).any():
        if payload is not None and not payload_only:
            raise InputError("--heaviest-payload counts in torque limits: give --torque-limits")
        return None
    return known.loads(payload, margin) if known.values or payload or margin else None
