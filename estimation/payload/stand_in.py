"""A usable inertia where none was measured: that of a simple body of the payload's mass. Assumed, and called so."""

import re
from dataclasses import dataclass

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import InertialParameters

_FORM = re.compile(r"(box|cylinder):([0-9.]+(?:x[0-9.]+)*)")


@dataclass(frozen=True)
class StandIn:
    """An evenly filled body about the centre of mass.

    Attributes:
        kind: "box" or "cylinder".
        sizes: of a box along x, y, z [m]; diameter, and length along z, of a cylinder [m].
    """

    kind: str
    sizes: tuple[float, ...]

    def __post_init__(self) -> None:
        """Refuse sizes that no body has."""
        count = {"box": 3, "cylinder": 2}.get(self.kind, 0)
        if len(self.sizes) != count or not all(0.0 < size < np.inf for size in self.sizes):
            raise InputError(
                f"an assumed inertia of {self.kind} {self.sizes}: give box:AxBxC (along x, y, z) or cylinder:DxL "
                "(diameter, and length along z), in mm"
            )

    @staticmethod
    def parse(text: str) -> "StandIn":
        """From "box:60x60x350" or "cylinder:80x200", in mm.

        Raises:
            InputError: for anything else.
        """
        match = _FORM.fullmatch(text.strip().lower())
        try:
            sizes = tuple(1e-3 * float(size) for size in match[2].split("x")) if match else ()
        except ValueError:
            sizes = ()
        if match is None or not sizes:
            raise InputError(f"--inertia {text!r}: write box:60x60x350 or cylinder:80x200, in mm")
        return StandIn(match[1], sizes)

    @property
    def description(self) -> str:
        """In words, with its sizes in mm."""
        sizes = " x ".join(f"{1e3 * size:g}" for size in self.sizes)
        along = "along x, y, z" if self.kind == "box" else "(diameter, length along z)"
        return f"evenly filled {self.kind} of {sizes} mm {along} about the centre of mass"

    def inertia(self, mass: float) -> Array:
        """Inertia at the centre of mass of that mass [kg m^2], 3 x 3."""
        if self.kind == "box":
            squares = np.square(self.sizes)
            return np.diag(mass / 12.0 * (squares.sum() - squares))
        diameter, length = self.sizes
        across = mass * (3.0 * (diameter / 2.0) ** 2 + length**2) / 12.0
        return np.diag([across, across, mass * diameter**2 / 8.0])

    def body(self, mass: float, com: Array) -> InertialParameters:
        """The payload with this inertia."""
        return InertialParameters.from_com(mass, com, self.inertia(mass))
