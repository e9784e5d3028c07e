"""Options of what a motion keeps: limits of the joints, parameters for torques, obstacles."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from ... import estimation, model, trajectories
from ..values import gains_list, number
from .reading import Options, each_joint, in_si, option


def _acceleration_limit(text: str) -> Any:
    """Times the speed limit per second, "3x" (a float); or a number per joint (a tuple)."""
    if text.lower().endswith("x"):
        try:
            factor = float(text[:-1])
        except ValueError:
            factor = -1.0
        if not 0.0 < factor < 1e6:
            raise argparse.ArgumentTypeError(f"{text!r} is not a factor such as 3x")
        return factor
    return gains_list(text)


def _torque_list(text: str) -> tuple[float, ...] | str:
    """The word "none"; or a number per joint."""
    return text if text == "none" else gains_list(text)


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
    scene: str | None = option(
        reads="scene", metavar="TOML", help="floor, walls, and bodies that keep clear of each other"
    )

    def known(self, robot: model.Robot) -> tuple[model.Robot, Mapping[str, float]]:
        """The robot with the parameters of ``--robot-parameters``, and these by name; a stand-in without."""
        if not self.robot_parameters:
            return model.stand_in.rehearsed(robot), {}
        robot = model.assumed_limits.with_assumed_limits(robot)
        stored = estimation.files.read_stored_robot(self.robot_parameters)
        values = dict(zip(stored.estimate.names, stored.estimate.values.tolist(), strict=True))
        return stored.applied_to(robot), values

    def bounds(self, robot: model.Robot) -> trajectories.JointBounds:
        """Limits of the joints."""
        given: list[float] | None = None
        if isinstance(self.acceleration, float):
            given = [self.acceleration * joint.limits.speed for joint in robot.joints]
        elif self.acceleration is not None:
            given = in_si(each_joint(self.acceleration, robot, "--acceleration"), robot).tolist()
        torque = (math.inf,) * robot.n if isinstance(self.torque_limits, str) else self.torque_limits
        torque = torque and each_joint(torque, robot, "--torque-limits")
        return trajectories.JointBounds.of(robot, override=self.speed_override, acceleration=given, torque=torque)

    def read_scene(self) -> trajectories.Scene | None:
        """What the motion keeps clear of."""
        return trajectories.read_scene(self.scene) if self.scene else None
