"""What is known of the payload that fixes the scale of all gains."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...common.arrays import Array, frozen_array
from ...common.errors import InputError
from ...common.schema import Real, WrongKeyError, naming, read_toml
from ...model.files import BodyTable
from ..equations.equations import PAYLOAD


@dataclass(frozen=True)
class KnownLoad:
    """The known ones of the payload's ten parameters.

    Attributes:
        known: names of ``PAYLOAD`` that are known; ``M_L`` always is.
        values: their values, SI units, shape (k,).
        mass_sigma: standard deviation of the mass [kg]; the others are known per mass, so that it is one of scale.
    """

    known: tuple[str, ...]
    values: Array
    mass_sigma: float = 0.0

    def __post_init__(self) -> None:
        """Refuse a load without mass."""
        object.__setattr__(self, "values", frozen_array(self.values, (len(self.known),), "known load"))
        if "M_L" not in self.known or not set(self.known) <= set(PAYLOAD):
            raise ValueError(f"known parameters must be of {', '.join(PAYLOAD)}, with M_L among them")
        if not 0.0 < self.mass < math.inf:
            raise InputError(f"known mass {self.mass:g} kg: give the payload's mass in kg, more than zero")
        if not 0.0 <= self.mass_sigma < self.mass:
            raise InputError(
                f"standard deviation {self.mass_sigma:g} kg of a mass of {self.mass:g} kg: give one of at least 0 "
                "and below the mass"
            )

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return float(self.values[self.known.index("M_L")])

    @property
    def free(self) -> tuple[str, ...]:
        """Names of ``PAYLOAD`` that are not known."""
        return tuple(name for name in PAYLOAD if name not in self.known)

    @property
    def ten(self) -> Array:
        """The known ones in their place among the ten, zero for the others, shape (10,)."""
        ten = np.zeros(10)
        ten[[PAYLOAD.index(name) for name in self.known]] = self.values
        return ten


def known_mass(mass: float, sigma: float = 0.0) -> KnownLoad:
    """A payload of which only the mass [kg] is known, with its standard deviation [kg]."""
    return KnownLoad(("M_L",), np.array([mass]), sigma)


class LoadTable(BodyTable, frozen=True, kw_only=True):
    """A known load: its mass [kg], how sure that is, and what else is known."""

    mass: Real
    mass_sigma: Real = 0.0


def read_known_load(path: str | Path) -> KnownLoad:
    """Read a payload from TOML: ``mass``, and where known ``mass_sigma``, ``com``, ``inertia_com``.

    ``com`` [m] holds three numbers, ``inertia_com`` [kg m^2] XX XY XZ YY YZ ZZ at the centre of mass, all in the
    robot's payload frame.

    Raises:
        InputError: names the file and the key.
    """
    table = read_toml(path, LoadTable)
    with naming(path):
        load, body = known_mass(table.mass, table.mass_sigma), table.body()
        if table.com is None and table.inertia_com is not None:
            raise WrongKeyError(
                "com", "missing: give the centre of mass [m], three numbers, where inertia_com is given"
            )
        if table.com is None:
            return load
        if table.inertia_com is None:
            return KnownLoad(PAYLOAD[6:], body.vector[6:], table.mass_sigma)
        if not body.physically_consistent:
            raise WrongKeyError("inertia_com", "no body has this inertia at its centre of mass: correct it")
        return KnownLoad(PAYLOAD, body.vector, table.mass_sigma)
