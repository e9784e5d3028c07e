"""A whole robot as a simulator holds it: links that can exist, drives, and how sure each number is."""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model import InertialParameters, Robot
from .origin import Origin

BODY_NUMBERS = ("mass", "x", "y", "z", "ixx", "ixy", "ixz", "iyy", "iyz", "izz")
"""A body as simulators hold it: mass [kg], centre of mass [m], inertia there [kg m^2], in the link's frame."""
DRIVE_NUMBERS = {"armature": "IA", "damping": "FV", "friction": "FS", "offset": "OFF"}
"""A drive as simulators hold it, and the parameter it is: kg m^2 or kg, N·m·s/rad or N·s/m, N·m or N, N·m or N."""
SIGNED = ("armature", "damping", "friction")
"""Numbers of a drive that are not negative."""
_NONE = Origin("prior", (), 0.0)


class Labelled(NamedTuple):
    """A number, who decides it, and how sure it is.

    ``sigma`` and ``interval`` (95 %) are the data's; None where they do not determine the number. ``bound``:
    whether it stands at the bound of what can exist, which data alone would pass.
    """

    value: float
    origin: Origin = _NONE
    sigma: float | None = None
    interval: tuple[float, float] | None = None
    bound: bool = False

    @property
    def mark(self) -> Literal["data", "rule", "prior"]:
        """Who decides it in one word; the part that data have in a prior's number is ``origin.share``."""
        if self.bound:
            return "rule"
        return "data" if self.origin.kind == "identified" else "prior"


class LinkNumbers(NamedTuple):
    """One link.

    ``body`` in the link's own frame; ``numbers``: its ``BODY_NUMBERS`` (mass alone if it has none);
    ``parameters``: its standard ones and its drive's, in the modified DH frame.
    """

    link: str
    body: InertialParameters
    numbers: dict[str, Labelled]
    parameters: dict[str, Labelled]

    @property
    def moments(self) -> Array:
        """Principal moments of inertia [kg m^2], shape (3,), rising."""
        return np.asarray(np.linalg.eigvalsh(self.body.inertia_com) if self.body.mass else np.zeros(3), dtype=float)

    @property
    def margin(self) -> float:
        """How far the moments are from breaking A + B >= C, over their sum; 0 for a body at the edge."""
        a, b, c = self.moments.tolist()
        return (a + b - c) / (a + b + c) if c > 0.0 else 0.0


@dataclass(frozen=True)
class WholeRobot:
    """A robot with a number for everything that a simulator asks for.

    Attributes:
        drives: of each joint, by the words of ``DRIVE_NUMBERS``; what is not known is not there.
        coupled: of the drive that turns with both joints of a coupling; empty without one.
        apart: as ``drives`` for who cannot couple joints: the diagonal of what ``drives`` and ``coupled`` say.
        groupings: the base parameters, in text; none where nothing was identified.
        source: where the numbers come from.
        prior: what decides where data do not.
    """

    robot: Robot
    links: tuple[LinkNumbers, ...]
    drives: tuple[dict[str, Labelled], ...]
    coupled: dict[str, Labelled]
    apart: tuple[dict[str, Labelled], ...]
    groupings: tuple[str, ...]
    source: str
    prior: str

    @property
    def mass(self) -> float:
        """Mass of the moving links together [kg]."""
        return sum(link.body.mass for link in self.links)

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints: of the robot's own file, else the maker's, else joint1 to jointn."""
        robot = self.robot
        if robot.links is not None:
            return robot.links.joints
        return robot.joint_names[0] if robot.joint_names else tuple(f"joint{j + 1}" for j in range(robot.n))

    @cached_property
    def link_names(self) -> tuple[str, ...]:
        """Name of the base, then of the links."""
        links = self.robot.links
        return ("base_link" if links is None else links.base, *(link.link for link in self.links))

    def negative(self) -> tuple[str, ...]:
        """Names of numbers that no drive can have, as a description may hold them: ``joint1 damping``."""
        drives = [*zip(self.joint_names, self.drives, strict=True), ("coupled drive", self.coupled)]
        return tuple(
            f"{name} {quantity}"
            for name, drive in drives
            for quantity in SIGNED
            if quantity in drive and drive[quantity].value < 0.0
        )

    def at_bound(self) -> tuple[str, ...]:
        """Numbers of drives at the bound of what can exist: ``joint3 armature``."""
        drives = [*zip(self.joint_names, self.drives, strict=True), ("coupled drive", self.coupled)]
        return tuple(
            f"{name} {quantity}"
            for name, drive in drives
            for quantity in SIGNED
            if quantity in drive and drive[quantity].bound
        )

    def heavier_than_the_arm(self) -> tuple[str, ...]:
        """Links that weigh more than the maker says the whole arm does, in words."""
        most = self.robot.mass
        return tuple(
            f"{link.link} would weigh {link.body.mass:.4g} kg, the whole arm weighs {most:g} kg"
            for link in self.links
            if most is not None and link.body.mass > most
        )
