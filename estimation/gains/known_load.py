"""What is known of the payload that fixes the scale of all gains."""

import math
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...common.arrays import Array, frozen_array
from ...common.errors import InputError
from ...model import InertialParameters
from ..equations.names import PAYLOAD

_KEYS = ("mass", "mass_sigma", "com", "inertia_com")


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


def read_known_load(path: str | Path) -> KnownLoad:
    """Read a payload from TOML: ``mass``, and where known ``mass_sigma``, ``com``, ``inertia_com``.

    ``com`` [m] holds three numbers, ``inertia_com`` [kg m^2] XX XY XZ YY YZ ZZ at the centre of mass, all in the
    robot's payload frame.

    Raises:
        InputError: names the file and the key.
    """
    try:
        data = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"{path}: not valid TOML: {error}") from None
    unknown = sorted(set(data) - set(_KEYS))
    if unknown:
        raise InputError(f"{path}: key {unknown[0]!r}: unknown; known here: {', '.join(_KEYS)}")
    if "mass" not in data or ("inertia_com" in data and "com" not in data):
        raise InputError(f"{path}: needs mass [kg], and com [m] where inertia_com is given")
    mass, sigma = (_numbers(path, data, key, 1)[0] if key in data else 0.0 for key in ("mass", "mass_sigma"))
    if "com" not in data:
        return known_mass(mass, sigma)
    com = _numbers(path, data, "com", 3)
    inertia = np.zeros((3, 3))
    if "inertia_com" in data:
        inertia[np.triu_indices(3)] = _numbers(path, data, "inertia_com", 6)
        inertia += np.triu(inertia, 1).T
    body = InertialParameters.from_com(mass, com, inertia)
    if "inertia_com" not in data:
        return KnownLoad(PAYLOAD[6:], body.vector[6:], sigma)
    if not body.physically_consistent:
        raise InputError(f"{path}: key 'inertia_com': no body has this inertia at its centre of mass: correct it")
    return KnownLoad(PAYLOAD, body.vector, sigma)


def _numbers(path: str | Path, data: dict[str, Any], key: str, count: int) -> list[float]:
    values = data[key] if isinstance(data[key], list) else [data[key]]
    good = [v for v in values if isinstance(v, int | float) and not isinstance(v, bool) and math.isfinite(v)]
    if len(values) != count or len(good) != count:
        raise InputError(f"{path}: key {key!r}: must be {count} finite number{'s' * (count > 1)}")
    return [float(value) for value in good]
