"""Reads back what ``dynident identify --json`` wrote: identify the robot once, weigh payloads ever after."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..model import InputError, Robot
from .estimate import Estimate, Fit


@dataclass(frozen=True)
class StoredRobot:
    """A robot's base parameters from a file.

    Attributes:
        robot: name of the robot.
        offsets: whether the model has an offset per joint.
        coulomb: form of the coupled Coulomb friction, None without coupling.
        estimate: values and covariance.
    """

    robot: str
    offsets: bool
    coulomb: str | None
    estimate: Estimate

    def applied_to(self, robot: Robot) -> Robot:
        """The robot with the model structure under which the parameters were identified.

        Raises:
            InputError: if the file is another robot's.
        """
        if robot.name != self.robot:
            raise InputError(f"the stored parameters are of robot {self.robot!r}, not {robot.name!r}")
        robot = robot.with_offsets(self.offsets)
        if self.coulomb is not None and robot.coupling is not None:
            robot = robot.with_coulomb("paper" if self.coulomb == "paper" else "sum")
        return robot


def read_stored_robot(path: str | Path) -> StoredRobot:
    """Read the JSON of ``dynident identify``.

    Raises:
        InputError: if the file is not such a JSON; the key at fault is named.
    """
    try:
        data: dict[str, Any] = json.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
        raise InputError(f"{path}: cannot be read as JSON ({error})") from None
    try:
        names = tuple(str(name) for name in data["columns"])
        values = np.array([entry["value"] for entry in data["base_parameters"]], dtype=float)
        quality = data["data"]
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
        )
        processing = data["processing"]
        return StoredRobot(data["robot"], bool(processing["offsets"]), processing["coulomb"], estimate)
    except KeyError as error:
        raise InputError(f"{path}: key {error} missing: give the --json of 'dynident identify'") from None
    except (TypeError, ValueError) as error:
        raise InputError(f"{path}: not the --json of 'dynident identify' ({error})") from None
