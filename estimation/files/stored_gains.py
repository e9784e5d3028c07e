"""Gains that were identified before, as ``dynident gains --json`` wrote them."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...common.arrays import Array, frozen_array
from ...common.errors import InputError
from ...model import Robot
from ..fit.gain_recordings import GainRecordings


@dataclass(frozen=True)
class StoredGains:
    """Drive gains and the covariance of their relative errors.

    Attributes:
        robot: name of the robot they belong to.
        values: gains [N·m/A or N/A], shape (n,).
        relative_covariance: of ln K, n x n.
        mass: of the payload they were identified with [kg].
        recordings: from which they were identified; empty in files of older versions.
    """

    robot: str
    values: Array
    relative_covariance: Array
    mass: float = float("nan")
    recordings: GainRecordings = GainRecordings()

    def __post_init__(self) -> None:
        """Lock the arrays; refuse what is no gain or no covariance."""
        n = np.size(self.values)
        object.__setattr__(self, "values", frozen_array(self.values, (n,), "gains"))
        object.__setattr__(
            self, "relative_covariance", frozen_array(self.relative_covariance, (n, n), "covariance")
        )
        C = self.relative_covariance
        if (self.values == 0.0).any():
            raise ValueError("a gain is zero")
        if not np.allclose(C, C.T, atol=1e-12) or np.linalg.eigvalsh(C)[0] < -1e-9 * max(np.trace(C), 1e-300):
            raise ValueError("relative_covariance is no covariance")

    @property
    def relative_sigma(self) -> Array:
        """Relative standard deviations, shape (n,)."""
        return np.sqrt(np.maximum(np.diag(self.relative_covariance), 0.0))

    def check(self, robot: Robot, path: str | Path) -> None:
        """Refuse gains of another robot.

        Raises:
            InputError: names both.
        """
        if self.robot != robot.name or len(self.values) != robot.n:
            raise InputError(
                f"{path}: gains of {self.robot!r} with {len(self.values)} joints do not belong to {robot.name!r} "
                f"with {robot.n}: identify gains for it"
            )


def read_stored_gains(path: str | Path) -> StoredGains:
    """Read the ``--json`` of ``dynident gains``.

    Raises:
        InputError: if the file holds no gains.
    """
    try:
        data = json.loads(Path(path).read_text(encoding="utf-8"))
        gains = data["drive_gains"]
        return StoredGains(
            str(data["robot"]),
            np.array(gains["values"]),
            np.array(gains["relative_covariance"]),
            _mass(data.get("load", {})),
            GainRecordings.read(data.get("recordings", {})),
        )
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"{path}: not the --json of 'dynident gains' ({error})") from None


def _mass(load: Any) -> float:
    """Of the known payload, absent from files of older versions."""
    known = load.get("known", {}) if isinstance(load, dict) else None
    if not isinstance(known, dict):
        raise ValueError("load: must hold 'known', names with values")
    return float(known.get("M_L", "nan"))
