"""Options of the robot: its description, how it is mounted, the payload's frame, its controller on the network."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

from .... import model
from ....common.errors import InputError
from ... import live
from ..progress import note
from ..values import chain, mount, port_number, positive_number, tool_frame
from .reading import Options, option

_INSTALLED = "installation"


@dataclass(frozen=True)
class ArmOptions(Options):
    """A robot by its name or file, for commands in which gravity does not count."""

    robot: str = option(
        reads="robot",
        required=True,
        metavar="NAME|FILE",
        help="a shipped robot ('dynident robot list'), TOML or URDF",
    )
    chain: tuple[str | None, str | None] | None = option(
        group=_INSTALLED,
        type=chain,
        metavar="BASE:TIP",
        help="URDF: first link and flange of the arm, either may be left out (default: the root, the only end)",
    )

    def load(self) -> model.Robot:
        """The robot, with a note for each angle that was taken as a right one."""
        robot = model.load_robot(self.robot, *(self.chain or (None, None)))
        for angle in robot.snapped:
            note(f"{self.robot}: {angle}")
        return robot


@dataclass(frozen=True)
class RobotOptions(ArmOptions):
    """A robot and how it is mounted."""

    mount: tuple[str, tuple[float, float, float]] | None = option(
        group=_INSTALLED,
        type=mount,
        metavar="HOW",
        help="floor, wall (x of the base points down), ceiling, roll,pitch,yaw of the base in degrees, or "
        "gravity=X,Y,Z in its frame [m/s^2]",
    )

    def load(self) -> model.Robot:
        """The robot as it is mounted."""
        robot = super().load()
        if self.mount is None:
            return robot
        kind, values = self.mount
        return model.with_gravity(robot, values) if kind == "gravity" else model.mounted(robot, values)


@dataclass(frozen=True)
class RehearsedRobotOptions(RobotOptions):
    """A robot to plan or simulate with, which may need a stand-in."""

    arm_mass: float | None = option(
        group=_INSTALLED,
        type=positive_number,
        metavar="KG",
        help="of the whole arm, for a stand-in where its file tells neither mass nor bodies of links",
    )

    def load(self) -> model.Robot:
        """The robot with the mass that was given."""
        robot = super().load()
        if self.arm_mass is None:
            return robot
        if not model.stand_in.missing_inertial(robot):
            raise InputError(f"--arm-mass has no effect: {robot.name} has a body for each link: leave it out")
        return replace(robot, mass=self.arm_mass, sources={**robot.sources, "mass": "given with --arm-mass"})


@dataclass(frozen=True)
class FramedRobotOptions(RobotOptions):
    """A robot, and the frame in which a payload is taken or given."""

    tool_frame: model.Pose | None = option(
        type=tool_frame,
        metavar="X,Y,Z,R,P,Y",
        help="frame of the payload in the flange: metres, then roll, pitch, yaw in degrees (default: the flange)",
    )

    def load(self) -> model.Robot:
        """The robot as it is mounted, with the payload's frame that is asked for."""
        robot, tool = super().load(), self.tool_frame
        if tool is None:
            return robot
        lengths = ", ".join(f"{value:g}" for value in tool.origin)
        angles = ", ".join(f"{math.degrees(angle) + 0.0:g}" for angle in tool.rpy)
        return model.with_tool(robot, tool, f"tool frame ({lengths} m; rpy {angles} deg) in: {robot.payload_frame}")


@dataclass(frozen=True)
class HostOptions(Options):
    """The controller that is listened to."""

    GROUP: ClassVar[str] = "controller"

    host: str | None = option(metavar="H", help="name or address of the controller")
    port: int | None = option(type=port_number, metavar="N", help="its port of RTDE (default: 30004)")

    def client(self) -> live.Client:
        """A connection to it."""
        return live.Client(self.host or "", self.port or live.PORT)
