"""A payload's numbers by name, each with its 95 % interval and whether to use it."""

from typing import NamedTuple

from ...model import InertialParameters


class Quantity(NamedTuple):
    """A number with its 95 % interval, nan where it is not determined.

    Attributes:
        low, high: bounds of its 95 % interval.
        unit: of all three.
        use: whether it may be used.
    """

    value: float
    low: float
    high: float
    unit: str
    use: bool

    def __float__(self) -> float:
        """The number alone."""
        return self.value

    def __str__(self) -> str:
        """Number, interval and unit."""
        return f"{self.value:.6g} {self.unit} (95 % from {self.low:.6g} to {self.high:.6g})"


class CentreOfMass(NamedTuple):
    """The centre of mass [m] along the axes of the payload's frame."""

    x: Quantity
    y: Quantity
    z: Quantity


class Inertia(NamedTuple):
    """Entries of the inertia matrix at the centre of mass [kg m^2], axes of the payload's frame."""

    xx: Quantity
    yy: Quantity
    zz: Quantity
    xy: Quantity
    xz: Quantity
    yz: Quantity


class NamedPayload(NamedTuple):
    """A payload with its intervals by name.

    Attributes:
        mass: [kg].
        com: centre of mass [m].
        inertia: at the centre of mass [kg m^2].
        frame: they are given in, in words.
        body: as a body; None where not all ten parameters are determined.
    """

    mass: Quantity
    com: CentreOfMass
    inertia: Inertia
    frame: str
    body: InertialParameters | None
