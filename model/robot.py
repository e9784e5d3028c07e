"""The robot: a serial chain in modified DH notation (Khalil-Kleinfinger), its drives and limits.

Frame j is reached from frame j-1 by a rotation ``alpha`` about x, a translation ``d`` along x, a rotation
``theta`` about z and a translation ``r`` along z; the joint turns about or slides along z of frame j.
"""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import partial
from itertools import chain
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

import numpy as np

from ..common import Array, Brief, InputError, listed
from .drives import Coupling, Drives, Spring
from .friction import Friction, term_names, terms_of
from .inertia import INERTIAL, InertialParameters, Pose
from .motion import Processing

SNAP_ANGLE = 1e-4  # angle [rad]: one closer than this to a multiple of 90 degrees is taken as that multiple
SNAP_LENGTH = 1e-6  # length [m]: a shorter one is taken as zero

SOURCED = {
    "position": "position limits",
    "speed": "speed limits",
    "acceleration": "acceleration limits",
    "torque": "torque limits",
    "parameters": "links and drives of the stand-in",
    "mass": "mass of the arm",
    "rated_payload": "rated payload",
    "flange": "flange",
    "joint_names": "names of the joints",
}
"""Parts of a description that have a source (where numbers stand, or "assumed: .." and how), as text."""
ASSUMED = "assumed"  # beginning of the source of a number that no source gives


@dataclass(frozen=True)
class Limits:
    """Limits of a joint: position [rad or m], speed [rad/s or m/s], acceleration, torque [N·m or N]."""

    position: tuple[float, float] = (-math.inf, math.inf)
    speed: float = math.inf
    acceleration: float = math.inf
    torque: float = math.inf

    def __post_init__(self) -> None:
        if not self.position[0] < self.position[1]:
            raise ValueError(f"position limits {self.position} leave no range")
        for name in ("speed", "acceleration", "torque"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} limit must be positive")


@dataclass(frozen=True)
class Joint:
    """Joint of a chain, and the frame change before it.

    Attributes:
        alpha: angle about x from z of frame j-1 to z of frame j [rad].
        d: distance along x [m].
        theta: zero offset of a revolute joint, constant angle of a prismatic one [rad].
        r: constant distance along z of a revolute joint, zero offset of a prismatic one [m].
        names: the geometric names of ``d`` and ``r`` ("D3", "RL4"), empty where the length has none.
    """

    kind: Literal["revolute", "prismatic"] = "revolute"
    alpha: float = 0.0
    d: float = 0.0
    theta: float = 0.0
    r: float = 0.0
    limits: Limits = Limits()
    names: tuple[str, str] = ("", "")

    def __post_init__(self) -> None:
        if self.kind not in ("revolute", "prismatic"):
            fault = f"joint kind {self.kind!r} is not 'revolute' or 'prismatic'"
            raise ValueError(f"{fault}; a body fixed to a link is part of it")
        if not all(math.isfinite(value) for value in (self.alpha, self.d, self.theta, self.r)):
            raise ValueError("alpha, d, theta and r must be finite")

    @property
    def revolute(self) -> bool:
        """True if the joint turns."""
        return self.kind == "revolute"


class Mesh(NamedTuple):
    """Look of a part of a link: a file, its frame in the link's, and factors along its axes."""

    file: str
    pose: Pose
    scale: tuple[float, float, float]


@dataclass(frozen=True)
class Links:
    """The links and joints of the file a robot was read from."""

    names: tuple[str, ...]  # of the links that the joints 1 to n move
    poses: tuple[Pose, ...]  # each link's frame in the modified DH frame of its joint
    joints: tuple[str, ...]  # names of the joints
    base: str  # name of the first link
    tip: str  # name of the flange's link
    meshes: tuple[tuple[Mesh, ...], ...] = ()  # of links 0 to n with what is fixed to them, in modified DH frames


@dataclass(frozen=True, repr=False)
class Robot(Brief):
    """A serial robot.

    Attributes:
        name: short name, as on the command line.
        joints: joint 1 to n, base to tip.
        gravity: acceleration of gravity in frame 0 [m/s^2].
        drives: which drive parameters the model has.
        payload_frame: the frame in which a payload is given, as text.
        flange: where that frame stands in frame n.
        base: where the base, as the maker or a URDF counts it, stands in frame 0.
        flange_pose: where the maker's flange stands in the payload's frame, if that is another frame; None where
            they are one, or it is not known.
        joint_names: names of the joints in other software, base to tip, one tuple for each.
        rated_payload: largest payload by the data sheet [kg].
        mass: of the whole arm by the data sheet, its base with it [kg]; None where it is not known.
        sources: of ``SOURCED``, where the numbers come from; those that begin with ``ASSUMED`` come from nowhere.
        links: names and frames of the file the robot was read from, if it has its own.
        processing: how recordings of this robot are treated unless set otherwise.
        parameters: known standard parameters by name ("XX1", "M3", "FV2"), where the robot has them.
        title: full name.
        snapped: what was made exact when the robot was made ("alpha2: 1.5708 -> pi/2").

    >>> robot = load_robot("rx90")
    >>> robot.n, robot.chi().shape
    (6, (80,))
    """

    name: str
    joints: tuple[Joint, ...]
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    drives: Drives = Drives()
    payload_frame: str = "last link"
    flange: Pose = Pose()
    base: Pose = Pose()
    rated_payload: float = math.inf
    mass: float | None = None
    flange_pose: Pose | None = None
    joint_names: tuple[tuple[str, ...], ...] = ()
    sources: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}), hash=False)
    links: Links | None = None
    processing: Processing = Processing()
    parameters: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}), hash=False)
    title: str = ""
    snapped: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.joints:
            raise ValueError(f"robot {self.name!r} has no joints")
        if len(self.gravity) != 3 or not all(math.isfinite(value) for value in self.gravity):
            raise ValueError("gravity must be three finite numbers")
        if not self.rated_payload > 0.0:
            raise ValueError("rated payload must be positive")
        if self.mass is not None and not 0.0 < self.mass < math.inf:
            raise ValueError("mass must be positive")
        n = len(self.joints)
        if any(len(names) != n for names in self.joint_names):
            raise ValueError(f"joint_names: give {n} names, base to tip, in each list")
        slow = self.processing.slow_speed
        if isinstance(slow, tuple) and len(slow) != n:
            raise ValueError(f"slow_speed: give one number, or {n}")
        for name in (self.name, *(name for names in self.joint_names for name in names)):
            unseen = [f"character {k} is U+{ord(x):04X}" for k, x in enumerate(name, 1) if not x.isprintable()]
            if unseen or not name.strip():
                fault = f"its {', '.join(unseen)}, which is invisible" if unseen else "it is empty"
                raise ValueError(f"{name!r} is not a valid name: {fault}: delete it and type it again")
        for text in (self.title, self.payload_frame, *self.sources.values()):
            if re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]", text):  # XML and terminals do not show them
                raise ValueError(f"{text[:40]!r} has control characters: remove them")
        joints, gravity, notes = _snap(self.joints, self.gravity)
        own = {name: MappingProxyType(dict(getattr(self, name))) for name in ("parameters", "sources")}
        exact = {"joints": joints, "gravity": gravity, "snapped": (*self.snapped, *notes), **own}
        for name, value in exact.items():
            object.__setattr__(self, name, value)
        self.drives.check(n)

    def __reduce__(self) -> tuple[partial[Robot], tuple[()]]:
        """Pickle and copy by the fields: read-only mappings cannot be pickled."""
        own = {part.name: getattr(self, part.name) for part in fields(self)}
        plain = {name: dict(value) for name, value in own.items() if isinstance(value, MappingProxyType)}
        return partial(Robot, **own | plain), ()

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joints)

    @property
    def standard(self) -> tuple[str, ...]:
        """Names of the standard parameters, link by link in the order of (6), coupled friction last."""
        links = ((*(f"{kind}{j}" for kind in INERTIAL), *self.drives.names(j)) for j in range(1, self.n + 1))
        coupled = (f"{kind}{self.coupling.joints[1]}" for kind in ("FVM", "FSM")) if self.coupling else ()
        return (*chain.from_iterable(links), *coupled)

    def chi(
        self, parameters: Mapping[str, float] | None = None, payload: InertialParameters | None = None
    ) -> Array:
        """Order standard parameters as ``standard``, shape (N_s,): the description's, unless others are given.

        Args:
            payload: in its own frame, added to the last link's.

        Raises:
            InputError: if some are missing.
        """
        values = dict(self.parameters if parameters is None else parameters)
        if missing := [name for name in self.standard if name not in values]:
            fault = f"robot {self.name!r} cannot be simulated: its description lacks {listed(missing)}"
            raise InputError(f"{fault}; add a [parameters] table, or use with_stand_in")
        if payload is not None:
            for name, value in payload.moved(self.flange.R, self.flange.p).named(str(self.n)).items():
                values[name] += value
        return np.array([values[name] for name in self.standard])

    @property
    def fingerprint(self) -> str:
        """Short text that differs between robots of other geometry, gravity or drives."""
        chain = [(joint.kind, joint.alpha, joint.d, joint.theta, joint.r) for joint in self.joints]
        drives = replace(self.drives, friction=()), term_names(self.drives.friction)
        return hashlib.sha256(repr((chain, self.gravity, *drives)).encode()).hexdigest()[:16]

    @property
    def last_frame(self) -> str:
        """Name of frame n, in which the last link's parameters are given."""
        return self.payload_frame if self.flange.is_identity else f"frame {self.n} (modified DH)"

    @property
    def coupling(self) -> Coupling | None:
        """Coupling between two drives, if there is one."""
        return self.drives.coupling

    @property
    def spring(self) -> Spring | None:
        """Gravity spring, if there is one."""
        return self.drives.spring

    def assumed(self, *parts: str) -> dict[str, str]:
        """Rules by which numbers without a source were assumed: of ``parts``, or of all that is ``SOURCED``."""
        told = {name: self.sources.get(name, "") for name in parts or SOURCED}
        return {x: text.removeprefix(ASSUMED).lstrip(": ") for x, text in told.items() if text.startswith(ASSUMED)}

    def with_offsets(self, offsets: bool) -> Robot:
        """Copy the robot with or without a constant friction offset per joint; FA gives way to it."""
        friction = tuple(term for term in self.drives.friction if not offsets or term.kind != "FA")
        return replace(self, drives=replace(self.drives, offsets=offsets, friction=friction))

    def with_friction(self, terms: Sequence[Friction]) -> Robot:
        """Copy the robot with other terms of friction."""
        return replace(self, drives=replace(self.drives, friction=tuple(terms)))

    def of_parameters(self, names: Sequence[str]) -> Robot:
        """Copy the robot with the terms of friction that parameters of an earlier identification are of."""
        return self.with_friction(terms_of(names, self.drives.friction, self.n))

    def for_currents(self) -> Robot:
        """Copy the robot whose equations each hold one motor's torque, a spring's torque as a column."""
        coupling = self.coupling and replace(self.coupling, rows="motor")
        spring = self.spring and replace(self.spring, column=True)
        return replace(self, drives=replace(self.drives, coupling=coupling, spring=spring))

    def with_coulomb(self, form: Literal["sum", "paper"]) -> Robot:
        """Copy the robot with the coupled Coulomb friction as the sum (dual) or as the paper prints it."""
        if self.coupling is None:
            raise ValueError(f"robot {self.name!r} has no coupled drives")
        return replace(self, drives=replace(self.drives, coupling=replace(self.coupling, coulomb=form)))


def check_robot(robot: object) -> None:
    """Refuse what is no robot, such as its name."""
    if not isinstance(robot, Robot):
        raise InputError(f"a robot is needed, not {robot!r:.60}: give load_robot(name or path)")


def snapped(value: float, angle: bool) -> float:
    """Take an angle [rad] near a multiple of 90 degrees as that multiple, a tiny length [m] as zero."""
    special = round(value / (math.pi / 2)) * (math.pi / 2) if angle else 0.0
    return special if abs(value - special) < (SNAP_ANGLE if angle else SNAP_LENGTH) else value


def _snap(
    joints: Sequence[Joint], gravity: Sequence[float]
) -> tuple[tuple[Joint, ...], tuple[float, ...], list[str]]:
    """Make special joints and gravity exact, and note what was changed."""
    exact, size = list[Joint](), math.hypot(*gravity)
    down = tuple(value if abs(value) >= SNAP_ANGLE * size else 0.0 for value in gravity)
    pairs = [(f"gravity along {x}", old, new, size) for x, old, new in zip("xyz", gravity, down, strict=True)]
    for number, joint in enumerate(joints, start=1):
        changes: dict[str, Any] = {}
        for name in ("alpha", "theta", "d", "r"):
            changes[name] = snapped(getattr(joint, name), angle=name in ("alpha", "theta"))
            pairs.append((f"{name}{number}", getattr(joint, name), changes[name], 1.0))
        exact.append(replace(joint, **changes))
    notes = [f"{x}: {old:.9g} taken as {new:.9g}" for x, old, new, size in pairs if abs(old - new) > 1e-12 * size]
    return tuple(exact), down, notes
