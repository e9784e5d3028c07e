"""Reads back what ``dynident identify --json`` wrote: identify the robot once, weigh payloads ever after."""

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...common.errors import InputError
from ...model import Robot
from ..fit.drive_gains import GainErrors
from ..fit.estimate import Estimate, Fit
from ..fit.gain_recordings import GainRecordings
from ..fit.robust import RobustCovariance


class StoredPrior(NamedTuple):
    """The prior gauge: ``parameters``, all standard ones by name; ``source`` of the prior; ``chi2_rise``."""

    parameters: dict[str, float]
    source: str
    chi2_rise: float


@dataclass(frozen=True)
class StoredRobot:
    """A robot's base parameters from a file, and what they belong to.

    Attributes:
        robot: name of the robot.
        fingerprint: of its description with the drives that were identified.
        offsets: whether the model has an offset per joint.
        coulomb: form of the coupled Coulomb friction, None without coupling.
        drive_gains: torque per current [N·m/A] with which currents were read; None for torques.
        estimate: values and covariance.
        gains: uncertainty of the drive gains that was told then; None where they were taken as exact. Part of
            ``estimate`` as ``gain_covariance`` too.
        nearest_prior: standard parameters of the robot nearest to a prior, where such were stored.
    """

    robot: str
    fingerprint: str
    offsets: bool
    coulomb: str | None
    drive_gains: tuple[float, ...] | None
    estimate: Estimate
    gains: GainErrors | None = None
    nearest_prior: StoredPrior | None = None

    def applied_to(self, robot: Robot) -> Robot:
        """The robot with the model structure under which the parameters were identified.

        Raises:
            InputError: if the file is another robot's, or the robot's description has changed.
        """
        if robot.name != self.robot:
            raise InputError(f"the stored parameters are of robot {self.robot!r}, not {robot.name!r}")
        robot = robot.with_offsets(self.offsets)
        if self.coulomb is not None and robot.coupling is not None:
            robot = robot.with_coulomb("paper" if self.coulomb == "paper" else "sum")
        if robot.fingerprint != self.fingerprint:
            raise InputError(
                f"the stored parameters are of a {robot.name} with other geometry, gravity or drives than this "
                "description: identify the robot again"
            )
        return robot

    def check_gains(self, drive_gains: tuple[float, ...] | None) -> None:
        """Refuse other drive gains than those the parameters were identified with.

        Raises:
            InputError: names both.
        """
        if drive_gains != self.drive_gains:
            raise InputError(
                f"the stored parameters were identified with {_gains(self.drive_gains)}, recordings are now read "
                f"with {_gains(drive_gains)}: use the same"
            )


def _robust(data: dict[str, Any]) -> RobustCovariance | None:
    """Robust covariance, absent from files of version 0.1.0 and where the recordings did not allow one."""
    covariance = data.get("covariance_robust")
    if covariance is None:
        return None
    told = data["robust"]
    C = np.array(covariance, dtype=float)
    if not (np.diag(C) >= 0.0).all():
        raise ValueError("covariance_robust: variances must not be negative")
    return RobustCovariance(C, int(told["blocks"]), int(told["degrees_of_freedom"]), float(told["block_length_s"]))


def _gain_errors(data: dict[str, Any]) -> GainErrors | None:
    """Uncertainty of the drive gains, absent from files of older versions and where gains were taken as exact."""
    told = data.get("gain_sigma")
    if told is None:
        return None
    recordings, mass = GainRecordings.read(told.get("recordings", {})), told.get("mass")
    return GainErrors(
        told["per_joint"],
        float(told["common"]),
        told.get("identified", ()),
        recordings,
        float(mass) if mass is not None else None,
    )


def _nearest_prior(data: dict[str, Any]) -> StoredPrior | None:
    """Standard parameters, absent where 'identify' ran without --constrained prior."""
    constrained = data.get("constrained")
    if constrained is None or constrained["gauge"] != "prior":
        return None
    values = {str(entry["name"]): float(entry["value"]) for entry in constrained["parameters"]}
    if not all(map(math.isfinite, values.values())):
        raise ValueError("constrained parameters must be finite numbers")
    return StoredPrior(values, str(constrained["prior"]["source"]), float(constrained["chi2_rise"]))


def _gains(gains: tuple[float, ...] | None) -> str:
    return f"drive gains {','.join(f'{gain:g}' for gain in gains)}" if gains else "torques, no drive gains"


def read_stored_robot(path: str | Path) -> StoredRobot:
    """Read the JSON of ``dynident identify``.

    Raises:
        InputError: if the file is not such a JSON; the key at fault is named.
    """
    try:
        data: dict[str, Any] = json.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (OSError, UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise InputError(f"{path}: cannot be read as JSON ({error})") from None
    try:
        names = tuple(str(name) for name in data["columns"])
        values = np.array([entry["value"] for entry in data["base_parameters"]], dtype=float)
        quality = data["data"]
        sensitivity = data.get("gain_sensitivity")  # absent from files of version 0.1.0
        errors = _gain_errors(data)
        estimate = Estimate(
            names=names,
            values=values,
            covariance=np.array(data["covariance"], dtype=float),
            degrees_of_freedom=float(quality["degrees_of_freedom"]),
            fit=Fit(
                np.array(quality["error_norms"], dtype=float),
                np.array(quality["torque_norms"], dtype=float),
                tuple(quality["rows_per_joint"]),
            ),
            weights=np.array(quality["weights"], dtype=float),
            robust=_robust(data),
            gain_sensitivity=np.array(sensitivity, dtype=float) if sensitivity is not None else None,
            gain_covariance=errors.covariance(len(quality["rows_per_joint"])) if errors is not None else None,
        )
        processing = data["processing"]
        gains = processing["drive_gains"]
        return StoredRobot(
            robot=str(data["robot"]),
            fingerprint=str(data["robot_fingerprint"]),
            offsets=bool(processing["offsets"]),
            coulomb=processing["coulomb"],
            drive_gains=tuple(float(gain) for gain in gains) if gains else None,
            estimate=estimate,
            gains=errors,
            nearest_prior=_nearest_prior(data),
        )
    except KeyError as error:
        raise InputError(f"{path}: key {error} missing: give the --json of 'dynident identify'") from None
    except (TypeError, ValueError) as error:
        raise InputError(f"{path}: not the --json of 'dynident identify' ({error})") from None
