"""Options of what a motion keeps: limits of the joints, parameters for torques, obstacles."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

from .... import model, trajectories
from ....common.arrays import Array
from ....common.errors import InputError
from ... import results
from ..progress import note
from ..values import fraction, gains_list, number
from .reading import Options, each_joint, in_si, option

_BOX = "box:"


def _acceleration_limit(text: str) -> Any:
    """Times the speed limit per second, "3x" (a float); or a number per joint (a tuple)."""
    if text.lower().endswith("x"):
        try:
            factor = number(text[:-1])
        except argparse.ArgumentTypeError:
            factor = -1.0
        if not 0.0 < factor < 1e6:
            raise argparse.ArgumentTypeError(f"{text!r} is not a factor such as 3x")
        return factor
    return gains_list(text)


def _torque_list(text: str) -> tuple[float, ...] | str:
    """The word "none"; or a number per joint."""
    return text if text == "none" else gains_list(text)


def _region(text: str) -> tuple[tuple[float, ...], bool]:
    """Radius or three half axes [m], and whether they are half edges of a box."""
    box = text.startswith(_BOX)
    half = gains_list(text.removeprefix(_BOX))
    if len(half) not in (1, 3) or not all(0.0 < x < np.inf for x in half):
        raise argparse.ArgumentTypeError(f"{text!r}: give R, A,B,C or box:A,B,C, each above 0 m")
    return half, box


class Known(NamedTuple):
    """What is known of a robot.

    Attributes:
        robot: with its parameters, or a stand-in's.
        values: identified parameters by name; none of a stand-in.
        covariance: of ``values`` in their order.
    """

    robot: model.Robot
    values: Mapping[str, float]
    covariance: Array | None

    def loads(
        self, payload: model.InertialParameters | trajectories.PayloadSet | None, margin: float | None
    ) -> trajectories.Loads:
        """Parameters that torque limits are computed from."""
        return trajectories.Loads(self.values or self.robot.parameters, payload, self.covariance, margin or 0.0)


@dataclass(frozen=True)
class LimitOptions(Options):
    """Limits of the joints, the robot's parameters for its torques, and the scene."""

    GROUP: ClassVar[str] = "limits"
    ABOUT: ClassVar[str] = "positions and speeds stand in the robot's file"

    speed_override: float = option(type=number, default=1.0, metavar="SHARE", help="of the speed (default: 1)")
    acceleration: float | tuple[float, ...] | None = option(
        type=_acceleration_limit,
        metavar="A|A1,A2,..",
        help="[deg/s² or m/s²], or 3x: three times the speed limit per second",
    )
    torque_limits: str | tuple[float, ...] | None = option(
        type=_torque_list, metavar="T|T1,T2,..", help="[N·m or N], or none: not even those of the robot's file"
    )
    robot_parameters: str | None = option(
        reads="robot's parameters", metavar="JSON", help="of identify: for torques and relative sigma"
    )
    heaviest_payload: str | None = option(
        reads="heaviest payload",
        metavar="KG[@X,Y,Z]|TOML",
        help="torque limits hold without it and with it",
    )
    within: tuple[tuple[float, ...], bool] | None = option(
        type=_region,
        metavar="R|A,B,C|box:A,B,C",
        help="torque limits hold for every payload up to --heaviest-payload in a ball, ellipsoid or box there [m]",
    )
    torque_margin: float | None = option(
        type=fraction, metavar="SHARE", help="of the torque limits that stays free, such as 10%%"
    )
    scene: str | None = option(
        reads="scene", metavar="TOML", help="floor, walls, and bodies that keep clear of each other"
    )

    def known(self, robot: model.Robot) -> Known:
        """What is known of the robot: ``--robot-parameters``, or a stand-in."""
        if not self.robot_parameters:
            return Known(model.stand_in.rehearsed(robot), {}, None)
        robot = model.stand_in.with_assumed_limits(robot)
        stored = results.read_stored_robot(self.robot_parameters)
        values = dict(zip(stored.estimate.names, stored.estimate.values.tolist(), strict=True))
        return Known(stored.applied_to(robot), values, np.asarray(stored.estimate.covariance))

    def payload(
        self, robot: model.Robot, bounds: trajectories.JointBounds
    ) -> model.InertialParameters | trajectories.PayloadSet | None:
        """The heaviest payload, or every payload within bounds, in the last link's frame.

        Raises:
            InputError: if options contradict each other, or torque limits are missing that a set needs.
        """
        if self.torque_margin is not None and not np.isfinite(bounds.torque).any():
            raise InputError("--torque-margin has no effect without torque limits: give --torque-limits")
        if self.heaviest_payload is None:
            self.refuse("within", "needs --heaviest-payload KG[@X,Y,Z]: the largest mass there")
            return None
        missing = np.flatnonzero(~np.isfinite(bounds.torque)) + 1
        if self.within is not None and len(missing):
            joints = ", ".join(map(str, missing))
            raise InputError(
                f"--within needs a torque limit of every joint, {joints} without: give --torque-limits"
            )
        return _payload_bounds(robot, self.heaviest_payload, self.within)

    def bounds(self, robot: model.Robot) -> trajectories.JointBounds:
        """Limits of the joints."""
        acceleration: list[float] | None = None
        if isinstance(self.acceleration, float):
            acceleration = [self.acceleration * joint.limits.speed for joint in robot.joints]
        elif self.acceleration is not None:
            acceleration = in_si(each_joint(self.acceleration, robot, "--acceleration"), robot).tolist()
        torque = (math.inf,) * robot.n if isinstance(self.torque_limits, str) else self.torque_limits
        torque = torque and each_joint(torque, robot, "--torque-limits")
        return trajectories.JointBounds.of(
            robot, override=self.speed_override, acceleration=acceleration, torque=torque
        )

    def whole(self, problem: trajectories.DesignProblem) -> trajectories.DesignProblem:
        """The problem with the whole of the torque limits, the share that a design leaves free included."""
        return problem.with_torque_share(1.0 / (1.0 - (self.torque_margin or 0.0)))

    def read_scene(self) -> trajectories.Scene | None:
        """What the motion keeps clear of."""
        return trajectories.read_scene(self.scene) if self.scene else None


def _payload_bounds(
    robot: model.Robot, text: str, within: tuple[tuple[float, ...], bool] | None
) -> model.InertialParameters | trajectories.PayloadSet:
    """The payload of ``--heaviest-payload``, or with ``--within`` the set, in the last link's frame.

    Raises:
        InputError: for what is no payload, or a file with ``--within``.
    """
    flange = robot.flange
    if Path(text).suffix.lower() == ".toml":
        if within is not None:
            raise InputError(f"--within bounds payloads that are not known, {text} is one: give KG[@X,Y,Z]")
        return model.read_payload(text).moved(flange.R, flange.p)
    mass, _, place = text.partition("@")
    try:
        kilograms = number(mass)
        centre = list(gains_list(place)) if place else [0.0, 0.0, 0.0]
    except argparse.ArgumentTypeError:
        kilograms, centre = np.nan, [0.0]
    if not (0.0 < kilograms < 1e6) or len(centre) != 3 or not np.isfinite(centre).all():
        raise InputError(f"--heaviest-payload {text!r}: give kg, kg@x,y,z (m), or a TOML file")
    if within is not None:
        half, box = within
        sides = half if len(half) == 3 else half * 3
        return trajectories.PayloadSet.within(kilograms, sides, centre, box).seen_from(flange)
    if not place:
        note(
            f"--heaviest-payload {text} is taken as a point at the origin of the payload's frame: give kg@x,y,z "
            "or a TOML file to put it where it hangs, or --within for every payload about it"
        )
    return model.InertialParameters.from_com(kilograms, centre, np.zeros((3, 3))).moved(flange.R, flange.p)
