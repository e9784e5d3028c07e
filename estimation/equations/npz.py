"""Equations in an NPZ file, as ``Equations.save`` writes them."""

import zipfile
from pathlib import Path

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from .shared_torque import SharedTorque

SHARED = "shared"
"""How the names of shared torques begin."""
_Fields = tuple[tuple[str, ...], tuple[Array, ...], tuple[int, ...], tuple[float, ...], tuple[SharedTorque, ...]]


def fields_of(path: str | Path) -> _Fields:
    """Columns, factors, rows, effective rows and shared torques that a file holds.

    Raises:
        InputError: if the file holds something else.
    """
    try:
        with np.load(path, allow_pickle=False) as data:
            return (
                tuple(str(name) for name in data["columns"]),
                tuple(data[f"factor{j}"] for j in range(len(data["rows"]))),
                tuple(int(count) for count in data["rows"]),
                tuple(float(count) for count in data["effective_rows"]),
                tuple(
                    SharedTorque(*_joint_and_motor(name), data[name])
                    for name in sorted(data.files)
                    if name.startswith(SHARED)
                ),
            )
    except (OSError, KeyError, ValueError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: not a saved reduced problem ({error})") from None


def _joint_and_motor(name: str) -> tuple[int, int]:
    joint, motor = name.removeprefix(SHARED).split("_")
    return int(joint), int(motor)
