"""The known parameters of the payload, which fix the scale of all gains."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from ...common import Array, InputError
from ...common.schema import Real, WrongKeyError
from ...model.files.payload_file import BodyTable
from ..equations.equations import PAYLOAD


class KnownLoad(BodyTable, frozen=True, kw_only=True, dict=True):
    """Known ones of the payload's ten parameters, in the robot's payload frame; also the keys of its TOML file.

    ``com`` [m] holds three numbers, ``inertia_com`` [kg m^2] XX XY XZ YY YZ ZZ at the centre of mass.
    """

    mass: Real  # kg
    mass_sigma: Real = 0.0  # its standard deviation [kg]; the others are known per mass, so that it is one of scale

    def __post_init__(self) -> None:
        """Refuse a load without mass, and an inertia without its centre of mass or of no body."""
        if not 0.0 < self.mass < np.inf:
            raise InputError(f"known mass {self.mass:g} kg: give the payload's mass in kg, more than zero")
        if not 0.0 <= self.mass_sigma < self.mass:
            raise InputError(
                f"standard deviation {self.mass_sigma:g} kg of a mass of {self.mass:g} kg: give one of at least 0 "
                "and below the mass"
            )
        super().__post_init__()
        if self.inertia_com is not None and self.com is None:
            raise WrongKeyError(
                "com", "missing: give the centre of mass [m], three numbers, where inertia_com is given"
            )
        if self.inertia_com is not None and not self.body().physically_consistent:
            raise WrongKeyError("inertia_com", "no body has this inertia at its centre of mass: correct it")

    @property
    def known(self) -> tuple[str, ...]:
        """Names of ``PAYLOAD`` that are known; ``M_L`` always is."""
        if self.inertia_com is not None:
            return PAYLOAD
        return PAYLOAD[-1:] if self.com is None else PAYLOAD[6:]

    @property
    def free(self) -> tuple[str, ...]:
        """Names of ``PAYLOAD`` that are not known."""
        return tuple(name for name in PAYLOAD if name not in self.known)

    @cached_property
    def ten(self) -> Array:
        """Known ones of the ten at their index, zero for the others, shape (10,)."""
        return np.where([name in self.known for name in PAYLOAD], self.body().vector, 0.0)


def payload_columns(mountings: int) -> tuple[tuple[str, ...], ...]:
    """Names of the payload's ten parameters in each mounting: ``PAYLOAD``, then XX_L2 .. M_L2, and so on."""
    return tuple(tuple(f"{name}{k if k > 1 else ''}" for name in PAYLOAD) for k in range(1, mountings + 1))


def known_values(loads: Sequence[KnownLoad]) -> dict[str, float]:
    """Collect the known parameters of the payload in each mounting, by the names of ``payload_columns``."""
    return {
        column: float(value)
        for columns, load in zip(payload_columns(len(loads)), loads, strict=True)
        for column, name, value in zip(columns, PAYLOAD, load.ten, strict=True)
        if name in load.known
    }


def known_mass(mass: float, sigma: float = 0.0) -> KnownLoad:
    """Make a payload of which only the mass [kg] is known, with its standard deviation [kg]."""
    return KnownLoad(mass=mass, mass_sigma=sigma)


def mountings(
    numbers: Sequence[int], load: KnownLoad | Sequence[KnownLoad], loaded: int
) -> tuple[dict[int, tuple[int, ...]], tuple[KnownLoad, ...]]:
    """Group the loaded recordings, this many, by the number of their mounting: one number, one centre of mass.

    Args:
        numbers: one for each of them; all in one mounting by default.
        load: the known parameters of the payload, the same in all mountings or those of each.

    Returns:
        The indices of each number's recordings, in the order in which they come, and the load of each.
    """
    if numbers and len(numbers) != loaded:
        raise InputError(
            f"{len(numbers)} numbers of mountings for {loaded} loaded recording{'s' * (loaded != 1)}: give "
            "one number for each of them, in their order, such as 1,2,2 (--mounting)"
        )
    numbers = tuple(numbers) or (1,) * loaded
    groups = {name: tuple(k for k, number in enumerate(numbers) if number == name) for name in numbers}
    if not isinstance(load, KnownLoad):
        if len(load) != len(groups):
            raise InputError(f"{len(load)} known payloads for {len(groups)} mountings: give one, or one for each")
        return groups, tuple(load)
    if len(groups) > 1 and load.com is not None:
        raise InputError(
            "one centre of mass cannot hold in several mountings: leave com and inertia_com out, or give one "
            "mounting"
        )
    return groups, (load,) * len(groups)
