"""What a robot's TOML file holds, read and written: angles in degrees, everything else in SI units."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Annotated, ClassVar, Literal

from msgspec import Meta, field, structs

from ...common.schema import Real, Table, Triple, WrongKeyError, at
from ..drives import Coupling, Drives, Spring
from ..motion import Processing, usual_slow_speed
from ..regressors import standard_columns
from ..robot import Robot
from .joint_table import JointTable, Pair, PoseTable, degrees, length_names


class CouplingTable(Table, frozen=True):
    """Two coupled drives."""

    joints: tuple[int, int]
    coulomb: Literal["sum", "paper"] = "sum"


class SpringTable(Table, frozen=True):
    """A gravity spring, by its law or by a table of [angle in degrees, torque in N·m]."""

    advice: ClassVar[Mapping[str, str]] = {"table": "must be a list of [angle in degrees, torque in N·m]"}

    joint: int
    stiffness: Real = 0.0
    length: Real = 0.0
    arms: Pair = (0.0, 0.0)
    zero_deg: Real = 0.0
    table: tuple[Pair, ...] = ()

    @staticmethod
    def of(spring: Spring) -> "SpringTable":
        """Table of a spring."""
        rows = tuple((degrees(angle), torque) for angle, torque in spring.table)
        return SpringTable(spring.joint, spring.stiffness, spring.length, spring.arms, degrees(spring.zero), rows)

    def spring(self) -> Spring:
        """The spring."""
        rows = tuple((math.radians(angle), torque) for angle, torque in self.table)
        return Spring(self.joint, self.stiffness, self.length, self.arms, math.radians(self.zero_deg), rows)


class DrivesTable(Table, frozen=True):
    """What the model has of each drive; keys that are left out go by the side where torque is measured."""

    side: Literal["motor", "link"] = "motor"
    rotor_inertia: bool | None = None
    friction: bool | None = None
    offsets: bool | None = None
    coupling: CouplingTable | None = None
    spring: SpringTable | None = None

    @staticmethod
    def of(drives: Drives) -> "DrivesTable":
        """Table of the drives."""
        usual, coupling = _usual(drives.side), drives.coupling
        values = {name: getattr(drives, name) for name in ("rotor_inertia", "friction", "offsets")}
        return DrivesTable(
            side=drives.side,
            coupling=CouplingTable(joints=coupling.joints, coulomb=coupling.coulomb) if coupling else None,
            spring=SpringTable.of(drives.spring) if drives.spring else None,
            **{name: value for name, value in values.items() if value != getattr(usual, name)},
        )

    def drives(self) -> Drives:
        """The drives."""
        for key in ("rotor_inertia", "coupling"):
            if self.side == "link" and getattr(self, key):
                raise WrongKeyError(key, "sensors on the link side do not see it: leave it out")
        values = {name: getattr(self, name) for name in ("rotor_inertia", "friction", "offsets")}
        drives = replace(_usual(self.side), **{key: value for key, value in values.items() if value is not None})
        if self.coupling:
            with at("coupling"):
                drives = replace(drives, coupling=Coupling(self.coupling.joints, self.coupling.coulomb))
        if self.spring:
            with at("spring"):
                drives = replace(drives, spring=self.spring.spring())
        return drives


class ProcessingTable(Table, frozen=True):
    """How recordings are treated."""

    rate: Real | None = field(default=Processing.rate, name="rate_hz")
    cutoff: Real | None = field(default=Processing.cutoff, name="cutoff_hz")
    decimate: int = Processing.decimate
    equation_rate: Real | None = field(default=Processing.equation_rate, name="equations_hz")
    still_speed: Real = Processing.still_speed
    slow_fraction: Real | None = None
    slow_speed: Real | tuple[Real, ...] | None = None
    max_mismatch: Real = Processing.max_mismatch

    def processing(self, turning: Sequence[bool]) -> Processing:
        """The settings; where nothing is said of slow rows, the usual speed of joints that turn or slide."""
        slow = usual_slow_speed(turning) if self.slow_fraction is None else 0.0
        values = {**structs.asdict(self), "slow_fraction": self.slow_fraction or 0.0}
        return Processing(**values | {"slow_speed": slow if self.slow_speed is None else self.slow_speed})


class SourcesTable(Table, frozen=True):
    """Where numbers come from; "assumed: .." and how, where no source gives them."""

    position: str = ""
    speed: str = ""
    acceleration: str = ""
    torque: str = ""
    parameters: str = ""
    mass: str = ""
    rated_payload: str = ""
    flange: str = ""
    joint_names: str = ""


class RobotTable(Table, frozen=True, kw_only=True):
    """A robot."""

    advice: ClassVar[Mapping[str, str]] = {"joints": "give one [[joints]] table for each joint"}

    name: str
    title: str = ""
    payload_frame: str = ""
    source: str = ""
    gravity: Triple = Robot.gravity
    rated_payload_kg: Real | None = None
    mass_kg: Real | None = None
    joint_names: tuple[tuple[str, ...], ...] = ()
    sources: SourcesTable = SourcesTable()
    flange: PoseTable = PoseTable()
    flange_in_payload_frame: PoseTable | None = None
    base: PoseTable = PoseTable()
    lengths: dict[str, Real] = field(default_factory=dict)
    joints: Annotated[tuple[JointTable, ...], Meta(min_length=1)]
    drives: DrivesTable = DrivesTable()
    processing: ProcessingTable = ProcessingTable()
    parameters: dict[str, Real] = field(default_factory=dict)

    @staticmethod
    def of(robot: Robot, source: str) -> "RobotTable":
        """Table of a robot; ``source`` says where its numbers come from."""
        named = [(length_names(joint, number), joint) for number, joint in enumerate(robot.joints, start=1)]
        lengths = ((name, value) for (d, r), joint in named for name, value in ((d, joint.d), (r, joint.r)))
        return RobotTable(
            name=robot.name,
            title=robot.title,
            payload_frame=robot.payload_frame,
            source=source,
            gravity=robot.gravity,
            rated_payload_kg=robot.rated_payload if math.isfinite(robot.rated_payload) else None,
            mass_kg=robot.mass,
            joint_names=robot.joint_names,
            flange_in_payload_frame=PoseTable.of(robot.flange_pose) if robot.flange_pose else None,
            sources=SourcesTable(**robot.sources),
            flange=PoseTable.of(robot.flange),
            base=PoseTable.of(robot.base),
            lengths={name: value for name, value in lengths if value != 0.0},
            joints=tuple(JointTable.of(joint, number) for number, joint in enumerate(robot.joints, start=1)),
            drives=DrivesTable.of(robot.drives),
            processing=ProcessingTable(**asdict(robot.processing)),
            parameters=dict(robot.parameters),
        )

    def robot(self) -> Robot:
        """The robot.

        Raises:
            WrongKeyError: names the key.
        """
        joints = []
        for number, table in enumerate(self.joints, start=1):
            with at(f"joints[{number}]"):
                joints.append(table.joint(self.lengths))
        with at("drives"):
            drives = self.drives.drives()
        with at("processing"):
            processing = self.processing.processing([joint.revolute for joint in joints])
        with at("robot"):
            robot = Robot(
                self.name,
                tuple(joints),
                self.gravity,
                drives,
                self.payload_frame or f"frame {len(joints)} (modified DH)",
                self.flange.pose(),
                self.base.pose(),
                math.inf if self.rated_payload_kg is None else self.rated_payload_kg,
                self.mass_kg,
                self.flange_in_payload_frame.pose() if self.flange_in_payload_frame else None,
                self.joint_names,
                {name: text for name, text in structs.asdict(self.sources).items() if text},
                processing=processing,
                parameters=self.parameters,
                title=self.title,
            )
        known = standard_columns(robot.with_offsets(True))
        for key in robot.parameters:
            if key not in known:
                raise WrongKeyError(f"parameters.{key}", "not a standard parameter of this robot")
        return robot


def _usual(side: Literal["motor", "link"]) -> Drives:
    return Drives.on_link_side() if side == "link" else Drives()
