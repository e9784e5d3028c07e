"""Robots from and to files: a TOML file of tables, a URDF, or a name of robot_descriptions; payloads from TOML.

In TOML angles are in degrees, everything else in SI units.
"""

import math
import re
from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import asdict
from difflib import get_close_matches
from functools import cache
from itertools import product
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, cast

import numpy as np
from msgspec import Meta, defstruct, field, structs

from ...common.errors import InputError
from ...common.schema import Real, Table, Triple, WrongKeyError, at, convert, naming, read_toml, toml_text, unknown
from ..drives import Coupling, Drives, Spring
from ..friction import PAPER, friction_terms, term_names
from ..inertia import INERTIAL, InertialParameters, Pose, check_metres
from ..motion import Processing, usual_slow_speed
from ..regressors import standard_columns
from ..robot import SOURCED, Joint, Limits, Robot

_ROBOTS = Path(__file__).parents[1] / "robots"
_TREES = "trees are not supported: give the joints of one chain, base to tip"
_LIMITS = {"position": "position_{}", "speed": "speed_{}_s", "acceleration": "acceleration_{}_s2"}
_UNITS = {"revolute": "deg", "prismatic": "m"}
_SAME = "name", "title", "payload_frame", "gravity", "joint_names", "parameters"  # keys that a Robot has as well
Pair = tuple[Real, Real]  # pair of numbers


@cache
def robot_names() -> tuple[str, ...]:
    """Names of the shipped robots."""
    return tuple(sorted(path.stem for path in _ROBOTS.glob("*.toml")))


def load_robot(name: str | Path, base: str | None = None, tip: str | None = None) -> Robot:
    """Load a shipped robot by name, or a robot from a TOML or URDF file by path.

    Args:
        name: a shipped robot's name, the path of a file (a URDF or xacro file is known by its ending), or a name of
            robot_descriptions, whose file must be in its cache.
        base: URDF only: first link of the chain, where there are several.
        tip: URDF only: the flange's link, where there are several.

    Raises:
        InputError: if there is no such robot or file, or if the file cannot be used; the key is named.

    >>> load_robot("ur10e").n
    6
    """
    text, is_file = str(name), Path(name).is_file()
    is_description = not is_file and re.fullmatch(r"\w+_description", text)
    if is_description or (is_file and Path(name).suffix.lower() in (".urdf", ".xacro")):
        from . import urdf  # commands of other robots need none of it

        return urdf.load_urdf(urdf.described(text) if is_description else name, base, tip)
    if base is not None or tip is not None:
        raise InputError(f"chain chooses links of a URDF file, {text!r} is not one: omit it")
    # Capitals, blanks and hyphens do not count: "UR 10e", "Kr6-R900".
    plain = re.sub(r"[\s_-]", "", text.lower())
    for shipped in robot_names():
        if shipped.replace("_", "") == plain:
            return _read_shipped(_ROBOTS / f"{shipped}.toml")
    if is_file:
        return _read(name)
    if Path(text).is_dir():
        raise InputError(f"no robot {text!r}: it is a folder; give the path of a TOML or URDF file")
    if Path(text).suffix or "/" in text or "\\" in text:
        raise InputError(f"no such file: {text!r}; 'dynident robot list' shows the shipped robots")
    text, names = text.lower(), robot_names()
    begins = [shipped for shipped in names if shipped.startswith(text)]
    near = begins or get_close_matches(text, names, 3, 0.6)
    # A maker ("kuka"), or another name of the arm.
    near = near or [shipped for shipped in names if text in re.split(r"\W+", load_robot(shipped).title.lower())]
    hint = f"did you mean {' or '.join(map(repr, near))}? " if near else ""
    among = f"give one of {', '.join(names)}, or the path of a TOML or URDF file"
    raise InputError(f"no robot {str(name)!r}: {hint}{among}")


def robot_toml(robot: Robot, source: str = "") -> str:
    """Write a robot's description as the text of a TOML file, as ``load_robot`` reads it.

    Args:
        robot: the robot; frames of a URDF it came from are not kept.
        source: where its numbers come from.
    """
    joints, lengths, friction = list[JointTable](), dict[str, float](), robot.drives.friction
    for number, joint in enumerate(robot.joints, start=1):
        limits: dict[str, Any] = {}  # those that are infinite are left out
        for name, key in _LIMITS.items():
            ends = joint.limits.position if name == "position" else (getattr(joint.limits, name),)
            if all(map(math.isfinite, ends)):
                shown = tuple(map(degrees if joint.revolute else float, ends))
                limits[key.format(_UNITS[joint.kind])] = shown if len(ends) > 1 else shown[0]
        if math.isfinite(joint.limits.torque):
            limits["torque"] = joint.limits.torque
        named = (joint.names[0] or f"D{number}", joint.d), (joint.names[1] or f"R{number}", joint.r)
        lengths |= {name: length for name, length in named if length}
        d, r = (name if length else 0.0 for name, length in named)
        joints.append(JointTable(degrees(joint.alpha), joint.kind, d, degrees(joint.theta), r, **limits))
    drives, coupling, spring, table = robot.drives, robot.coupling, robot.spring, None
    if spring:
        rows = tuple((degrees(angle), torque) for angle, torque in spring.table)
        table = SpringTable(spring.joint, spring.stiffness, spring.length, spring.arms, degrees(spring.zero), rows)
    terms = bool(friction) if friction in ((), PAPER) else term_names(friction)
    coupled = CouplingTable(coupling.joints, coupling.coulomb) if coupling else None
    same: dict[str, Any] = {key: getattr(robot, key) for key in _SAME}
    whole = RobotTable(
        **same,
        source=source,
        rated_payload_kg=None if math.isinf(robot.rated_payload) else robot.rated_payload,
        mass_kg=robot.mass,
        flange_in_payload_frame=PoseTable.of(robot.flange_pose) if robot.flange_pose else None,
        sources={name: robot.sources[name] for name in SOURCED if name in robot.sources},
        flange=PoseTable.of(robot.flange),
        base=PoseTable.of(robot.base),
        lengths=lengths,
        joints=tuple(joints),
        drives=DrivesTable(drives.side, drives.rotor_inertia, terms, drives.offsets, coupled, table),
        processing=ProcessingTable(**asdict(robot.processing)),
    )
    return f"# {robot.title or robot.name}. Lengths in m, angles in degrees.\n{toml_text(whole)}"


class PoseTable(Table, frozen=True):
    """Table of a frame in another one."""

    xyz: Triple = (0.0, 0.0, 0.0)
    rpy_deg: Triple = (0.0, 0.0, 0.0)

    @staticmethod
    def of(pose: Pose) -> "PoseTable":
        """Make the table of a frame."""
        roll, pitch, yaw = (degrees(angle) + 0.0 for angle in pose.rpy)
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

    alpha_deg: Real | None = None  # written where it is zero, too
    kind: Literal["revolute", "prismatic"] = "revolute"
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

    def joint(self, lengths: Mapping[str, float]) -> Joint:
        """Make the joint."""
        scale = math.pi / 180.0 if self.kind == "revolute" else 1.0
        limits: dict[str, Any] = {} if self.torque is None else {"torque": self.torque}
        for (name, key), (kind, unit) in product(_LIMITS.items(), _UNITS.items()):
            if (value := getattr(self, key.format(unit))) is None:
                continue
            if kind != self.kind:
                raise WrongKeyError(key.format(unit), f"a {self.kind} joint takes {key.format(_UNITS[self.kind])}")
            limits[name] = tuple(end * scale for end in value) if name == "position" else value * scale
        sizes: dict[str, Any] = {"d": self.d, "r": self.r}
        names = {key: value for key, value in sizes.items() if isinstance(value, str)}
        for key, name in names.items():
            if name not in lengths:
                raise WrongKeyError(key, f"no length {name!r} in [lengths]")
            sizes[key] = lengths[name]
        alpha, theta = math.radians(self.alpha_deg or 0.0), math.radians(self.theta_deg)
        named = names.get("d", ""), names.get("r", "")
        return Joint(self.kind, alpha=alpha, theta=theta, **sizes, limits=Limits(**limits), names=named)


def degrees(angle: float) -> float:
    """Write an angle in as few digits as give it back to 1e-14 rad."""
    exact, near = math.degrees(angle), 1e-14 * max(1.0, abs(angle))
    short = (round(exact, digits) + 0.0 for digits in range(14))
    return next((value for value in short if abs(math.radians(value) - angle) <= near), exact)


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


class DrivesTable(Table, frozen=True):
    """Table of drives' parameters; keys that are left out go by the side where torque is measured."""

    side: Literal["motor", "link"] = "motor"
    rotor_inertia: bool | None = None
    friction: bool | tuple[str, ...] | None = None
    offsets: bool | None = None
    coupling: CouplingTable | None = None
    spring: SpringTable | None = None


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


def _read(path: str | Path) -> Robot:
    table = read_toml(path, RobotTable)
    with naming(path):
        for name in table.sources:
            if name not in SOURCED:
                raise WrongKeyError(f"sources.{name}", unknown(SOURCED, name))
        joints = []
        for number, joint in enumerate(table.joints, start=1):
            with at(f"joints[{number}]"):
                joints.append(joint.joint(table.lengths))
        with at("drives"):
            own, spring = table.drives, table.drives.spring
            for key in ("rotor_inertia", "coupling"):
                if own.side == "link" and getattr(own, key):
                    raise WrongKeyError(key, "sensors on the link side do not see it: remove it")
            values: dict[str, Any] = {"rotor_inertia": own.rotor_inertia, "offsets": own.offsets}
            names = ("FS", "FV") * own.friction if isinstance(own.friction, bool) else own.friction
            with at("friction"):
                values["friction"] = names if names is None else friction_terms(names)
            with at("coupling"):
                values["coupling"] = own.coupling and Coupling(own.coupling.joints, own.coupling.coulomb)
            with at("spring"):
                if spring:
                    rows = tuple((math.radians(angle), torque) for angle, torque in spring.table)
                    zero = math.radians(spring.zero_deg)
                    law = spring.stiffness, spring.length, spring.arms
                    values["spring"] = Spring(spring.joint, *law, zero, rows)
            # Sensors behind the gears see no rotor and no friction, and have an offset of their own.
            behind: dict[str, Any] = {"rotor_inertia": False, "friction": (), "offsets": True}
            given = {key: value for key, value in values.items() if value is not None}
            drives = Drives(side=own.side, **behind | given if own.side == "link" else given)
        with at("processing"):
            values, fraction = structs.asdict(table.processing), table.processing.slow_fraction
            if values["slow_speed"] is None:  # where nothing is said of slow rows, the usual speed counts
                speed = usual_slow_speed([joint.revolute for joint in joints])
                values["slow_speed"] = speed if fraction is None else 0.0
            processing = Processing(**values | {"slow_fraction": fraction or 0.0})
        same: dict[str, Any] = {key: getattr(table, key) for key in _SAME}
        with at("robot"):
            robot = Robot(
                **same | {"payload_frame": table.payload_frame or f"frame {len(joints)} (modified DH)"},
                joints=tuple(joints),
                drives=drives,
                flange=table.flange.pose(),
                base=table.base.pose(),
                rated_payload=math.inf if table.rated_payload_kg is None else table.rated_payload_kg,
                mass=table.mass_kg,
                flange_pose=table.flange_in_payload_frame.pose() if table.flange_in_payload_frame else None,
                sources={name: text for name, text in table.sources.items() if text},
                processing=processing,
            )
        known = {*standard_columns(robot), *standard_columns(robot.with_offsets(True))}
        for key in robot.parameters:
            if key not in known:
                raise WrongKeyError(f"parameters.{key}", "not a standard parameter of this robot")
        return robot


_read_shipped = cache(_read)  # once a process: a search over all of them asks again and again

_Bounded = Annotated[float, Meta(ge=-1e6, le=1e6)]
Three = tuple[_Bounded, _Bounded, _Bounded]
Six = tuple[_Bounded, _Bounded, _Bounded, _Bounded, _Bounded, _Bounded]

_TEN = [(kind, _Bounded, 0.0) for kind in INERTIAL]
TenTable = cast(type[Table], defstruct("TenTable", _TEN, bases=(Table,), frozen=True))
"""Table of Khalil's ten about the frame's origin."""
_WIDEST = 3.0  # m: radius of gyration that no payload has
_NARROWEST = 1e-3  # m of a mass of 1 kg; a ball of gold has 0.02


class BodyTable(Table, frozen=True):
    """Table of a body: centre of mass, and the entries Ixx, Ixy, Ixz, Iyy, Iyz, Izz of its inertia about it."""

    mass: _Bounded = 0.0
    com: Three | None = None
    inertia_com: Six | None = None

    def __post_init__(self) -> None:
        check_metres(self.com or (0.0,), "com")
        xx, _, _, yy, _, zz = self.inertia_com or (0.0,) * 6
        radius = math.sqrt(max(xx + yy + zz, 0.0) / 2.0 / self.mass) if self.mass > 0.0 else 0.0
        fault = f"with this inertia_com a mass of {self.mass:g} kg "
        if radius >= _WIDEST:
            fault += f"would spread over {radius:.3g} m"
            raise ValueError(f"{fault}: give inertia_com in kg m^2 (1 kg mm^2 is 1e-6, 1 g mm^2 is 1e-9)")
        if 0.0 < radius < self.mass ** (1.0 / 3.0) * _NARROWEST:
            fault += f"would fit within {1e3 * radius:.2g} mm, denser than any metal"
            raise ValueError(f"{fault}: give mass in kg (1 g is 0.001) and inertia_com in kg m^2")

    def body(self) -> InertialParameters:
        """Make the body; what is missing is zero."""
        return InertialParameters.from_com(self.mass, self.com or (0.0,) * 3, self.inertia_com or (0.0,) * 6)


def read_payload(path: str | Path) -> InertialParameters:
    """Read a payload, in the robot's payload frame.

    The file, or its table [payload], holds either Khalil's ten about the frame's origin (``XX`` to ``M``; what is
    missing is zero), or ``mass`` [kg], ``com`` [m] (three numbers) and ``inertia_com`` [kg m^2] about the centre of
    mass (Ixx, Ixy, Ixz, Iyy, Iyz, Izz, entries of the matrix).

    Raises:
        InputError: if the file cannot be used, or no body has such parameters.
    """
    data = read_toml(path, dict[str, Any])
    with naming(path), at("payload") if "payload" in data else nullcontext():
        own = convert(data.get("payload", data), dict[str, Any])
        if own and not set(INERTIAL) & set(own):
            body = convert(own, BodyTable).body()
        else:
            body = InertialParameters(np.array(structs.astuple(convert(own, TenTable))))
            if body.mass > 0.0:
                check_metres(body.com, "first moments over the mass")
    if not body.physically_consistent:
        fault = f"smallest eigenvalue of the pseudo-inertia {body.min_pseudo_inertia_eigenvalue:.3g}"
        advice = "check the signs, and about which point the inertia is"
        raise InputError(f"{path}: no body has such parameters ({fault}): {advice}")
    return body
