"""Reads a payload from TOML."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...common.errors import InputError
from ..inertia import InertialParameters
from ..robot import INERTIAL

_BY_COM = {"mass": 1, "com": 3, "inertia_com": 6}
_LARGEST = 1e6


def read_payload(path: str | Path) -> InertialParameters:
    """Read a payload, in the robot's payload frame.

    The file, or its table [payload], holds either Khalil's ten about the frame's origin (``XX`` to ``M``; what is
    missing is zero), or ``mass`` [kg], ``com`` [m] (three numbers) and ``inertia_com`` [kg m^2] about the centre of
    mass (Ixx, Ixy, Ixz, Iyy, Iyz, Izz, entries of the matrix).

    Raises:
        InputError: if the file cannot be used, or no body has such parameters.
    """
    try:
        data = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as text ({error})") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not valid TOML: {error}") from None
    table = data.get("payload", data)
    if not isinstance(table, dict):
        raise InputError(f"{path}: key 'payload': must be a table")
    body = _body(str(path), table)
    if not body.physically_consistent:
        raise InputError(
            f"{path}: no body has such parameters (smallest eigenvalue of the pseudo-inertia "
            f"{body.min_pseudo_inertia_eigenvalue:.3g}): check the signs, and about which point the inertia is"
        )
    return body


def _body(path: str, table: Mapping[str, Any]) -> InertialParameters:
    known: Mapping[str, int] = _BY_COM if set(_BY_COM) & set(table) else dict.fromkeys(INERTIAL, 1)
    for key in table:
        if key not in known:
            raise InputError(f"{path}: key {key!r}: unknown; known here: {', '.join(known)}")
    values = {key: _numbers(path, table, key, count) for key, count in known.items()}
    if known is not _BY_COM:
        return InertialParameters(np.concatenate([values[kind] for kind in INERTIAL]))
    inertia = np.zeros((3, 3))
    inertia[np.triu_indices(3)] = values["inertia_com"]
    return InertialParameters.from_com(values["mass"][0], values["com"], np.triu(inertia, 1).T + inertia)


def _numbers(path: str, table: Mapping[str, Any], key: str, count: int) -> list[float]:
    given = table.get(key, 0.0 if count == 1 else [0.0] * count)
    numbers = given if isinstance(given, list) else [given]
    good = all(not isinstance(x, bool) and isinstance(x, int | float) and abs(x) < _LARGEST for x in numbers)
    if not good or len(numbers) != count or isinstance(given, list) != (count > 1):
        raise InputError(f"{path}: key {key!r}: must be {'a number' if count == 1 else f'{count} numbers'}")
    return [float(x) for x in numbers]
