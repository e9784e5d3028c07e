"""From options to a design problem, for commands that design a motion or judge one."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .. import model, trajectories
from ..common.arrays import Array
from ..common.errors import InputError
from .options import GoalOptions, LimitOptions
from .progress import note

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

    shape: trajectories.motions.Shape | None = None
    length: float | None = None
    longest: float | None = None
    start: Array | None = None


def build_request(robot: model.Robot, motion: Asked, goal: GoalOptions, limits: LimitOptions) -> Request:
    """Read all files and build the problem.

    Args:
        robot: the robot.
        motion: what is asked of it.
        goal, limits: options.

    Raises:
        InputError: for whatever does not fit; one line.
    """
    robot, known = limits.known(robot)
    payload = _payload(limits.heaviest_payload) if limits.heaviest_payload else None
    bounds = limits.bounds(robot)
    reference = _payload_reference(robot, payload) if goal.payload_only else _reference(robot, known)
    problem = trajectories.build_design(
        robot,
        motion.shape,
        goal.goal(robot, bounds, reference, motion.length),
        bounds=bounds,
        loads=_loads(robot, known, payload, bounds, goal.payload_only),
        duration=motion.longest,
        start=motion.start,
        scene=limits.read_scene(),
    )
    base = model.base_parameters(robot)
    labels = {} if goal.payload_only else dict(zip(base.columns, base.names, strict=True))
    return Request(problem, reference, labels)


def _payload_reference(robot: model.Robot, payload: model.InertialParameters | None) -> dict[str, float]:
    """Values of the heaviest payload's parameters, that standard deviations are relative to."""
    values = payload.named(str(robot.n)) if payload is not None else {}
    return {name: value for name, value in values.items() if abs(value) > _ZERO}


def _reference(robot: model.Robot, known: Mapping[str, float]) -> dict[str, float]:
    """Values of the robot's parameters, as far as they are known, that standard deviations are relative to."""
    base, values = model.base_parameters(robot), dict(known)
    if not known and all(name in robot.parameters for name in base.standard):
        values = dict(zip(base.columns, base.value(robot.parameters).tolist(), strict=True))
    return {name: value for name, value in values.items() if abs(value) > _ZERO}


def _loads(
    robot: model.Robot,
    known: Mapping[str, float],
    payload: model.InertialParameters | None,
    bounds: trajectories.JointBounds,
    payload_only: bool,
) -> trajectories.Loads | None:
    if not np.isfinite(bounds.torque).any():
        if payload is not None and not payload_only:
            raise InputError("--heaviest-payload counts in torque limits: give --torque-limits")
        return None
    return trajectories.Loads(known or robot.parameters, payload) if known or payload else None


def _payload(text: str) -> model.InertialParameters:
    """A TOML file, or a point mass "7.0" or "7.0@0,0,0.2" [kg, m]."""
    if Path(text).suffix.lower() == ".toml":
        return model.read_payload(text)
    mass, _, place = text.partition("@")
    try:
        kilograms = float(mass)
        com = [float(x) for x in place.split(",")] if place else [0.0, 0.0, 0.0]
    except ValueError:
        kilograms, com = np.nan, [0.0]
    if not (0.0 < kilograms < 1e6) or len(com) != 3 or not np.isfinite(com).all():
        raise InputError(f"--heaviest-payload {text!r}: give kg, kg@x,y,z (m), or a TOML file")
    if not place:
        note(
            f"--heaviest-payload {text} is taken as a point at the origin of the last link's frame: give kg@x,y,z "
            "or a TOML file to put it where it hangs"
        )
    return model.InertialParameters.from_com(kilograms, com, np.zeros((3, 3)))
