"""From the command line of ``dynident design`` to a design problem."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .. import estimation, model, trajectories
from ..common.arrays import Array
from ..common.errors import InputError
from .arguments import chosen_robot
from .design_shape import asked_shape, known_length

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


def build_request(arguments: argparse.Namespace) -> Request:
    """Read all files and build the problem.

    Raises:
        InputError: for whatever does not fit; one line.
    """
    robot = chosen_robot(arguments)
    known: Mapping[str, float] = {}
    if arguments.robot_parameters:
        stored = estimation.files.read_stored_robot(arguments.robot_parameters)
        robot = stored.applied_to(robot)
        known = dict(zip(stored.estimate.names, stored.estimate.values.tolist(), strict=True))
    payload = _payload(arguments.heaviest_payload, robot) if arguments.heaviest_payload else None
    bounds = asked_bounds(arguments, robot)
    reference = _reference(robot, known, payload if arguments.payload_only else None, arguments.payload_only)
    problem = trajectories.build_design(
        robot,
        asked_shape(arguments),
        _goal(arguments, robot, bounds, reference),
        bounds=bounds,
        loads=_loads(robot, known, payload, bounds, arguments.payload_only),
        duration=arguments.max_duration,
        start=_start(arguments.start, robot) if arguments.start else None,
        scene=trajectories.read_scene(arguments.scene) if arguments.scene else None,
    )
    base = model.base_parameters(robot)
    labels = {} if arguments.payload_only else dict(zip(base.columns, base.names, strict=True))
    return Request(problem, reference, labels)


def in_si(values: Sequence[float], robot: model.Robot) -> Array:
    """Degrees of turning joints in radians; metres of sliding ones as they are."""
    if len(values) != robot.n:
        raise InputError(f"{len(values)} numbers for the {robot.n} joints of robot {robot.name!r}: give one each")
    return np.array([np.radians(x) if joint.revolute else x for x, joint in zip(values, robot.joints, strict=True)])


def _start(values: Sequence[float], robot: model.Robot) -> Array:
    """The pose where the motion begins, checked in the units it was given in."""
    pose = in_si(values, robot)
    for j, (joint, given, position) in enumerate(zip(robot.joints, values, pose, strict=True), 1):
        low, high = joint.limits.position
        if not low <= position <= high:
            unit = "deg" if joint.revolute else "m"
            shown = [math.degrees(limit) if joint.revolute else limit for limit in (low, high)]
            raise InputError(
                f"--start: joint {j} at {given:g} {unit} is outside {shown[0]:g} to {shown[1]:g} {unit}"
            )
    return pose


def asked_bounds(arguments: argparse.Namespace, robot: model.Robot) -> trajectories.JointBounds:
    """Limits of the joints."""
    given: list[float] | None = None
    if isinstance(arguments.acceleration, float):
        given = [arguments.acceleration * joint.limits.speed for joint in robot.joints]
    elif arguments.acceleration is not None:
        given = in_si(arguments.acceleration, robot).tolist()
    torque = (math.inf,) * robot.n if arguments.torque_limits == "none" else arguments.torque_limits
    return trajectories.JointBounds.of(robot, override=arguments.speed_override, acceleration=given, torque=torque)


def _goal(
    arguments: argparse.Namespace,
    robot: model.Robot,
    bounds: trajectories.JointBounds,
    reference: Mapping[str, float],
) -> trajectories.Goal:

    noise, earlier = asked_noise(arguments, bounds), None
    length = arguments.data_length
    if arguments.data_from:
        earlier, length = _earlier(arguments, robot, noise), length or known_length(arguments)
    return trajectories.Goal(
        arguments.criterion,
        columns=arguments.columns,
        payload_only=arguments.payload_only,
        interest=arguments.parameters,
        reference=reference if arguments.criterion == "a" else None,
        noise=noise,
        rate=arguments.independent_rate,
        data_length=length,
        earlier=earlier,
    )


def asked_noise(arguments: argparse.Namespace, bounds: trajectories.JointBounds) -> Array | None:
    """Torque noise as asked for, else that of the earlier recordings."""
    if isinstance(arguments.torque_noise, float):
        if not np.isfinite(bounds.torque).all():
            raise InputError("--torque-noise as a percentage needs a torque limit of every joint: --torque-limits")
        return np.asarray(arguments.torque_noise * bounds.torque)
    if arguments.torque_noise is not None:
        return np.array(arguments.torque_noise)
    found = estimation.files.recorded_noise(arguments.data_from[0]) if arguments.data_from else None
    if found is None:
        print("dynident: note: no --torque-noise: 1 N·m (or N) in every joint is assumed", file=sys.stderr)
    return found


def _earlier(arguments: argparse.Namespace, robot: model.Robot, noise: Array | None) -> trajectories.Earlier:

    weighted = arguments.criterion in ("d", "a")
    if weighted and noise is None:
        raise InputError(f"{arguments.data_from[0]}: carries no weights: give --torque-noise")
    found = [estimation.files.read_information(path, noise if weighted else None) for path in arguments.data_from]
    if arguments.payload_only:
        found = [one.of_payload(model.regressors.payload_columns(robot)) for one in found]
    columns = found[0].columns
    for path, other in zip(arguments.data_from, found, strict=True):
        if set(other.columns) != set(columns):
            raise InputError(f"{path}: has other columns than {arguments.data_from[0]}: give files of one model")
    rows = [one.factor[:, [one.columns.index(name) for name in columns]] for one in found]
    return trajectories.Earlier(columns, np.vstack(rows))


def _reference(
    robot: model.Robot, known: Mapping[str, float], payload: model.InertialParameters | None, payload_only: bool
) -> dict[str, float]:
    """Values that standard deviations are relative to, as far as they are known."""
    base, values = model.base_parameters(robot), dict(known)
    if payload_only:
        values = payload.named(str(robot.n)) if payload is not None else {}
    elif not known and all(name in robot.parameters for name in base.standard):
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
    if not (known or payload):
        return None
    return trajectories.Loads(known or robot.parameters, payload)


def _payload(text: str, robot: model.Robot) -> model.InertialParameters:
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
        print(
            f"dynident: note: --heaviest-payload {text} is taken as a point at the origin of "
            "the last link's frame: give kg@x,y,z or a TOML file to put it where it hangs",
            file=sys.stderr,
        )
    return model.InertialParameters.from_com(kilograms, com, np.zeros((3, 3)))
