"""A number's passport: the reduced equations it comes from, whose they are, and how it was made from them."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal

from ...common.errors import InputError
from ...common.schema import Document
from ...estimation.diagnosis.evidence import Sampled
from ...estimation.equations.equations import Equations
from ...estimation.fit.drive_gains import Gains
from ...estimation.fit.essential import StopRule
from ...estimation.payload.problem import PayloadProblem
from ...estimation.payload.stand_in import StandIn
from ...estimation.possible.constraints import Constraint
from ...model import BaseParameters, Processing, Robot

Kind = Literal["identify", "payload", "weigh"]


class Log(Document, frozen=True):
    """A log that was read.

    ``role``: "without payload", "with payload" or "held out"; ``name``: of the file; ``sha256``: of its bytes.
    """

    role: str
    name: str
    sha256: str


@dataclass(frozen=True)
class Recipe:
    """How a number is made from logs.

    Attributes:
        kind: the command that makes it.
        drive_gains: torque per current [N·m/A or N/A], if currents were read.
        gains: how sure they are; None where they are taken as exact.
        log_map: how logs were read, in words.
        essential: when elimination ends; None for the default.
        methods: of ``payload``; None for all.
        free_friction, friction_change, scale_sigma: as ``payload`` takes them.
        moving: joints that move, of ``weigh``, where they were told.
        parameters: SHA-256 of the file of a robot that was known, empty without one.
    """

    kind: Kind
    processing: Processing
    drive_gains: tuple[float, ...] | None = None
    gains: Gains | None = None
    log_map: str = ""
    essential: StopRule | None = None
    methods: tuple[int, ...] | None = None
    free_friction: bool = False
    friction_change: float = 0.0
    scale_sigma: float = 0.0
    constraints: tuple[Constraint, ...] = ()
    stand_in: StandIn | None = None
    moving: tuple[int, ...] | None = None
    parameters: str = ""

    @property
    def fingerprint(self) -> str:
        """Short text that differs between recipes."""
        return hashlib.sha256(repr(self).encode()).hexdigest()[:16]

    def differing(self, other: "Recipe") -> tuple[str, ...]:
        """In what two recipes differ."""
        names = self.__dataclass_fields__
        return tuple(name for name in names if repr(getattr(self, name)) != repr(getattr(other, name)))


@dataclass(frozen=True, kw_only=True)
class Passport:
    """What a number's file holds, whatever it is of.

    Attributes:
        logs: that were read.
        versions: of the packages that made it.
        about: what else is known: the arm's own name, day, temperature, told payload.
    """

    robot: Robot
    base: BaseParameters
    recipe: Recipe
    logs: tuple[Log, ...]
    versions: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    about: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        """Refuse one of no log."""
        if not self.logs:
            raise ValueError("a passport names the logs that it comes from")

    @property
    def robot_fingerprint(self) -> str:
        """Short text that differs between robots of other names, geometry, drives or flanges."""
        robot = self.robot
        words = repr((robot.name, robot.fingerprint, robot.flange, robot.payload_frame))
        return hashlib.sha256(words.encode()).hexdigest()[:16]

    @property
    def name(self) -> str:
        """The logs in words."""
        return ", ".join(dict.fromkeys(log.name for log in self.logs))

    def check_alike(self, other: "Passport") -> None:
        """Refuse a passport of another robot or recipe, or one that holds a log of this one."""
        if self.robot_fingerprint != other.robot_fingerprint:
            raise InputError(
                f"{other.name} is of robot {other.robot.name!r} ({other.robot_fingerprint}), {self.name} of "
                f"{self.robot.name!r} ({self.robot_fingerprint}): passports of different robots do not merge"
            )
        arms = self.about.get("arm"), other.about.get("arm")
        if arms[0] != arms[1]:
            raise InputError(f"{self.name} is of arm {arms[0]!r}, {other.name} of {arms[1]!r}: they do not merge")
        if self.recipe.fingerprint != other.recipe.fingerprint:
            raise InputError(
                f"{self.name} and {other.name} were made by different recipes "
                f"({', '.join(self.recipe.differing(other.recipe))}): reduce both with the same options"
            )
        twice = self._fitted & other._fitted
        if twice and self.recipe.kind == "identify":
            name = next(log.name for log in other.logs if log.sha256 in twice)
            raise InputError(f"{name} is in both passports: a recording counts once")

    @property
    def _fitted(self) -> set[str]:
        """Checksums of the logs that were fitted."""
        return {log.sha256 for log in self.logs if log.role != "held out"}


@dataclass(frozen=True, kw_only=True)
class RobotPassport(Passport):
    """The equations of a robot without payload.

    Attributes:
        equations: in its base parameters, with their blocks of time.
    """

    equations: Equations
    sampled: Sampled = Sampled()


@dataclass(frozen=True, kw_only=True)
class PayloadPassport(Passport):
    """The equations of a robot with and without payload.

    Attributes:
        problem: the equations, without the recordings.
        others: other ways to the same payload, of a short motion.
    """

    problem: PayloadProblem
    others: tuple[PayloadProblem, ...] = ()
    sampled: Sampled = Sampled()
