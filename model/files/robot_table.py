"""Tables of a robot's TOML file, read and written: angles in degrees, everything else in SI units."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Annotated, Any, ClassVar, Literal

from msgspec import Meta, field, structs

from ...common.schema import Real, Table, Triple, WrongKeyError, at, unknown
from ..drives import Coupling, Drives, Spring
from ..friction import PAPER, friction_terms, term_names
from ..motion import Processing, usual_slow_speed
from ..pose import Pose
from ..regressors import standard_columns
from ..robot import SOURCED, Joint, Limits, Robot

_TREES = "trees are not supported: give the joints of one chain, base to tip"
_UNITS = {"revolute": "deg", "prismatic": "m"}
_LIMITS = {"position": "position_{}", "speed": "speed_{}_s", "acceleration": "acceleration_{}_s2"}
Pair = tuple[Real, Real]
"""Pair of numbers."""


class PoseTable(Table, frozen=True):
    """Table of a frame in another one."""

    xyz: Triple = (0.0, 0.0, 0.0)
    rpy_deg: Triple = (0.0, 0.0, 0.0)

    @staticmethod
    def of(pose: Pose) -> "PoseTable":
        """Make the table of a frame."""
        roll, pitch, yaw = map(degrees, pose.rpy)
        return PoseTable(xyz=pose.origin, rpy_deg=(roll, pitch, yaw))

    def pose(self) -> Pose:
        """Make the frame."""
        return Pose.from_rpy(self.xyz, [math.radians(angle) for angle in self.rpy_deg])


class JointTable(Table, frozen=True):
    """Table of a joint; ``d`` and ``r`` are lengths or names of lengths, units of limits go by the kind."""

    advice: ClassVar[Mapping[str, str]] = {
        "parent": _TREES,
        "antecedent": _TREES,
        "kind": "must be 'revolute' or 'prismatic' (a body fixed to a link is part of it)",
    }

    kind: Literal["revolute", "prismatic"] = "revolute"
    alpha_deg: Real = 0.0
    d: Real | str = 0.0
    theta_deg: Real = 0.0
    r: Real | str = 0.0
    position_deg: Pair | None = None
    position_m: Pair | None = None
    speed_deg_s: Real | None = None
    speed_m_s: Real | None = None
    acceleration_deg_s2: Real | None = None
    acceleration_m_s2: Real | None = None
    torque: Real | None = None

    @staticmethod
    def of(joint: Joint, number: int) -> "JointTable":
        """Make the table of a joint; limits that are infinite are left out."""
        shown = degrees if joint.revolute else float
        values: dict[str, Any] = {}
        for name, key in _LIMITS.items():
            value = getattr(joint.limits, name)
            if all(map(math.isfinite, value if name == "position" else [value])):
                shorter = [shown(end) for end in value] if name == "position" else shown(value)
                values[key.format(_UNITS[joint.kind])] = shorter
        names = length_names(joint, number)
        return JointTable(
            kind=joint.kind,
            alpha_deg=degrees(joint.alpha),
            d=names[0] if joint.d else 0.0,
            theta_deg=degrees(joint.theta),
            r=names[1] if joint.r else 0.0,
            torque=joint.limits.torque if math.isfinite(joint.limits.torque) else None,
            **values,
        )

    def joint(self, lengths: Mapping[str, float]) -> Joint:
        """Make the joint."""
        unit, other_unit = ("deg", "m") if self.kind == "revolute" else ("m", "deg")
        scale = math.pi / 180.0 if unit == "deg" else 1.0
        limits: dict[str, Any] = {} if self.torque is None else {"torque": self.torque}
        for name, key in _LIMITS.items():
            if getattr(self, key.format(other_unit)) is not None:
                raise WrongKeyError(key.format(other_unit), f"a {self.kind} joint takes {key.format(unit)}")
            value = getattr(self, key.format(unit))
            if value is not None:
                limits[name] = tuple(end * scale for end in value) if name == "position" else value * scale
        (d, d_name), (r, r_name) = self._length("d", lengths), self._length("r", lengths)
        alpha, theta = math.radians(self.alpha_deg), math.radians(self.theta_deg)
        return Joint(self.kind, alpha, d, theta, r, Limits(**limits), (d_name, r_name))

    def _length(self, key: str, lengths: Mapping[str, float]) -> tuple[float, str]:
        value = getattr(self, key)
        if not isinstance(value, str):
            return value, ""
        if value not in lengths:
            raise WrongKeyError(key, f"no length {value!r} in [lengths]")
        return lengths[value], value


def length_names(joint: Joint, number: int) -> tuple[str, str]:
    """Names of the lengths d and r of a joint (from 1)."""
    return joint.names[0] or f"D{number}", joint.names[1] or f"R{number}"


def degrees(angle: float) -> float:
    """Write an angle in as few digits as give it back to 1e-14 rad."""
    degrees = math.degrees(angle)
    short = (round(degrees, digits) + 0.0 for digits in range(14))
    return next(
        (value for value in short if abs(math.radians(value) - angle) <= 1e-14 * max(1.0, abs(angle))), degrees
    )


class CouplingTable(Table, frozen=True):
    """Table of two coupled drives."""

    joints: tuple[int, int]
    coulomb: Literal["sum", "paper"] = "sum"


class SpringTable(Table, frozen=True):
    """Table of a gravity spring, by its law or by a table of [angle in degrees, torque in N·m]."""

    advice: ClassVar[Mapping[str, str]] = {"table": "must be a list of [angle in degrees, torque in N·m]"}

    joint: int
    stiffness: Real = 0.0
    length: Real = 0.0
    arms: Pair = (0.0, 0.0)
    zero_deg: Real = 0.0
    table: tuple[Pair, ...] = ()

    @staticmethod
    def of(spring: Spring) -> "SpringTable":
        """Make the table of a spring."""
        rows = tuple((degrees(angle), torque) for angle, torque in spring.table)
        return SpringTable(spring.joint, spring.stiffness, spring.length, spring.arms, degrees(spring.zero), rows)

    def spring(self) -> Spring:
        """Make the spring."""
        rows = tuple((math.radians(angle), torque) for angle, torque in self.table)
        return Spring(self.joint, self.stiffness, self.length, self.arms, math.radians(self.zero_deg), rows)


class DrivesTable(Table, frozen=True):
    """Table of drives' parameters; keys that are left out go by the side where torque is measured."""

    side: Literal["motor", "link"] = "motor"
    rotor_inertia: bool | None = None
    friction: bool | tuple[str, ...] | None = None
    offsets: bool | None = None
    coupling: CouplingTable | None = None
    spring: SpringTable | None = None

    @staticmethod
    def of(drives: Drives) -> "DrivesTable":
        """Make the table of the drives."""
        usual, coupling = _usual(drives.side), drives.coupling
        values = {name: getattr(drives, name) for name in ("rotor_inertia", "friction", "offsets")}
        if drives.friction not in ((), PAPER):
            values["friction"] = term_names(drives.friction)
        return DrivesTable(
            side=drives.side,
            coupling=CouplingTable(joints=coupling.joints, coulomb=coupling.coulomb) if coupling else None,
            spring=SpringTable.of(drives.spring) if drives.spring else None,
            **{
                name: bool(value) if value in ((), PAPER) else value
                for name, value in values.items()
                if value != getattr(usual, name)
            },
        )

    def drives(self) -> Drives:
        """Make the drives."""
        for key in ("rotor_inertia", "coupling"):
            if self.side == "link" and getattr(self, key):
                raise WrongKeyError(key, "sensors on the link side do not see it: leave it out")
        values = {name: getattr(self, name) for name in ("rotor_inertia", "friction", "offsets")}
        if isinstance(self.friction, bool):
            values["friction"] = PAPER if self.friction else ()
        elif self.friction is not None:
            with at("friction"):
                values["friction"] = friction_terms(self.friction)
        drives = replace(_usual(self.side), **{key: value for key, value in values.items() if value is not None})
        if self.coupling:
            with at("coupling"):
                drives = replace(drives, coupling=Coupling(self.coupling.joints, self.coupling.coulomb))
        if self.spring:
            with at("spring"):
                drives = replace(drives, spring=self.spring.spring())
        return drives


class ProcessingTable(Table, frozen=True):
    """Table of the settings of recordings' processing."""

    rate: Real | None = field(default=Processing.rate, name="rate_hz")
    cutoff: Real | None = field(default=Processing.cutoff, name="cutoff_hz")
    decimate: int = Processing.decimate
    equation_rate: Real | None = field(default=Processing.equation_rate, name="equations_hz")
    still_speed: Real = Processing.still_speed
    slow_fraction: Real | None = None
    slow_speed: Real | tuple[Real, ...] | None = None
    max_mismatch: Real = Processing.max_mismatch

    def processing(self, turning: Sequence[bool]) -> Processing:
        """Make the settings; where nothing is said of slow rows, the usual speed of joints that turn or slide."""
        slow = usual_slow_speed(turning) if self.slow_fraction is None else 0.0
        values = {**structs.asdict(self), "slow_fraction": self.slow_fraction or 0.0}
        return Processing(**values | {"slow_speed": slow if self.slow_speed is None else self.slow_speed})


class RobotTable(Table, frozen=True, kw_only=True):
    """Table of a robot."""

    advice: ClassVar[Mapping[str, str]] = {"joints": "give one [[joints]] table for each joint"}

    name: str
    title: str = ""
    payload_frame: str = ""
    source: str = ""
    gravity: Triple = Robot.gravity
    rated_payload_kg: Real | None = None
    mass_kg: Real | None = None
    joint_names: tuple[tuple[str, ...], ...] = ()
    sources: dict[str, str] = field(default_factory=dict)
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
        """Make the table of a robot; ``source`` says where its numbers come from."""
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
            sources={name: robot.sources[name] for name in SOURCED if name in robot.sources},
            flange=PoseTable.of(robot.flange),
            base=PoseTable.of(robot.base),
            lengths={name: value for name, value in lengths if value != 0.0},
            joints=tuple(JointTable.of(joint, number) for number, joint in enumerate(robot.joints, start=1)),
            drives=DrivesTable.of(robot.drives),
            processing=ProcessingTable(**asdict(robot.processing)),
            parameters=dict(robot.parameters),
        )

    def robot(self) -> Robot:
        """Make the robot.

        Raises:
            WrongKeyError: names the key.
        """
        for name in self.sources:
            if name not in SOURCED:
                raise WrongKeyError(f"sources.{name}", unknown(SOURCED, name))
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
                {name: text for name, text in self.sources.items() if text},
                processing=processing,
                parameters=self.parameters,
                title=self.title,
            )
        known = {*standard_columns(robot), *standard_columns(robot.with_offsets(True))}
        for key in robot.parameters:
            if key not in known:
                raise WrongKeyError(f"parameters.{key}", "not a standard parameter of this robot")
        return robot


def _usual(side: Literal["motor", "link"]) -> Drives:
    return Drives.on_link_side() if side == "link" else Drives()
