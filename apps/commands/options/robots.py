"""Options of the robot: its description, how it is mounted, the payload's frame, its controller on the network."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated

from cyclopts import Parameter

from .... import model
from ....common.errors import InputError
from ... import live
from ..entry import CONTROLLER, SETTING, Options
from ..progress import note
from ..values import Frame, Kilograms, Port, RobotFile, chain, mount, word

_Chain = Annotated[tuple[str | None, str | None], word(chain, "BASE:TIP")]
_Mount = Annotated[tuple[str, tuple[float, float, float]], word(mount, "HOW")]


class ArmOptions(Options):
    """A robot by its name or file, for commands in which gravity does not count."""

    robot: RobotFile
    """A shipped robot ('dynident robot list'), TOML, URDF or xacro, or a name of robot_descriptions."""
    chain: Annotated[_Chain | None, SETTING] = None
    """URDF: first link and flange of the arm, either may be left out (default: the root, the only end)."""

    def load(self) -> model.Robot:
        """The robot, with a note for each angle that was taken as a right one."""
        robot = model.load_robot(self.robot, *(self.chain or (None, None)))
        for angle in robot.snapped:
            note(f"{self.robot}: {angle}")
        return robot


class RobotOptions(ArmOptions):
    """A robot and how it is mounted."""

    mount: _Mount | None = None
    """Floor, wall (x of the base points down), ceiling, roll,pitch,yaw of the base in degrees, or gravity=X,Y,Z in
    its frame [m/s^2]."""

    def load(self) -> model.Robot:
        """The robot as it is mounted."""
        robot = super().load()
        if self.mount is None:
            return robot
        kind, values = self.mount
        return model.with_gravity(robot, values) if kind == "gravity" else model.mounted(robot, values)


class RehearsedRobotOptions(RobotOptions):
    """A robot to plan or simulate with, which may need a stand-in."""

    arm_mass: Kilograms | None = None
    """Mass of the whole arm, for a stand-in where its file tells neither mass nor bodies of links."""

    def load(self) -> model.Robot:
        """The robot with the mass that was given."""
        robot = super().load()
        if self.arm_mass is None:
            return robot
        if not model.stand_in.missing_inertial(robot):
            raise InputError(f"--arm-mass has no effect: {robot.name} has a body for each link: leave it out")
        return replace(robot, mass=self.arm_mass, sources={**robot.sources, "mass": "given with --arm-mass"})


class FramedRobotOptions(RobotOptions):
    """A robot, and the frame in which a payload is taken or given."""

    tool_frame: Frame | None = None
    """Frame of the payload in the flange: metres, then roll, pitch, yaw in degrees (default: the flange)."""

    def load(self) -> model.Robot:
        """The robot as it is mounted, with the payload's frame that is asked for."""
        robot, tool = super().load(), self.tool_frame
        if tool is None:
            return robot
        lengths = ", ".join(f"{value:g}" for value in tool.origin)
        angles = ", ".join(f"{math.degrees(angle) + 0.0:g}" for angle in tool.rpy)
        return model.with_tool(robot, tool, f"tool frame ({lengths} m; rpy {angles} deg) in: {robot.payload_frame}")


class HostOptions(Options, group=CONTROLLER):
    """The controller that is listened to."""

    host: Annotated[str | None, Parameter(metavar="H")] = None
    """Name or address of the controller."""
    port: Port | None = None
    """Its port of RTDE (default: 30004)."""

    def client(self) -> live.Client:
        """A connection to it."""
        return live.Client(self.host or "", self.port or live.PORT)
