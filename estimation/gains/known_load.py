"""The known parameters of the payload, which fix the scale of all gains."""

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
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


class Mountings(NamedTuple):
    """Mountings of the known weight: loaded recordings of one number share a centre of mass."""

    groups: dict[
        int, tuple[int, ...]
    ]  # number -> indices of its loaded recordings, in the order in which they come
    paired: bool  # whether each loaded recording has one without payload of its own

    @staticmethod
    def of(numbers: Sequence[int], loaded: int, unloaded: int) -> "Mountings":
        """Number this many recordings with and without payload; all in one mounting by default."""
        if numbers and len(numbers) != loaded:
            raise InputError(
                f"{len(numbers)} numbers of mountings for {loaded} loaded recording{'s' * (loaded != 1)}: give "
                "one number for each of them, in their order, such as 1,2,2 (--mounting)"
            )
        numbers = tuple(numbers) or (1,) * loaded
        groups = {name: tuple(k for k, number in enumerate(numbers) if number == name) for name in numbers}
        return Mountings(groups, loaded == unloaded or len(groups) < 2)

    def loads(self, load: KnownLoad | Sequence[KnownLoad]) -> tuple[KnownLoad, ...]:
        """Assign the known parameters of the payload to each mounting: the same in all, or one for each."""
        many = len(self.groups)
        if not isinstance(load, KnownLoad):
            if len(load) != many:
                raise InputError(f"{len(load)} known payloads for {many} mountings: give one, or one for each")
            return tuple(load)
        if many > 1 and load.com is not None:
            raise InputError(
                "one centre of mass cannot hold in several mountings: leave com and inertia_com out, or give one "
                "mounting"
            )
        return (load,) * many
