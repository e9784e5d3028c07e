"""What a motion is to teach: which parameters, by which criterion, beside what is known already."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Robot, base_parameters, standard_columns
from ...model.regressors import payload_columns
from .criterion import ORDERS, Criterion, Kind


@dataclass(frozen=True)
class Earlier:
    """Information from earlier recordings: R of a QR decomposition of their observation matrix.

    For "d" and "a" the rows of W are divided by the joints' torque noise, for condition numbers they are not.

    Attributes:
        columns: names of the columns, c.
        factor: k x c.
    """

    columns: tuple[str, ...]
    factor: Array

    def rows(self, columns: Sequence[str]) -> Array:
        """The factor in the order of ``columns``.

        Raises:
            InputError: if the factor lacks a column or has another one.
        """
        unmatched = set(self.columns) ^ set(columns)
        if unmatched or np.shape(self.factor)[-1] != len(self.columns):
            raise InputError(
                "the earlier recordings' factor does not fit the design's columns: "
                f"{', '.join(sorted(unmatched)[:6])} stand on one side only; select the same columns"
            )
        return np.asarray(self.factor)[:, [self.columns.index(name) for name in columns]]


@dataclass(frozen=True)
class Goal:
    """What is to be learnt.

    Attributes:
        criterion: "d", "a", "cond" or "cond-scaled"; see criterion.py.
        columns: names of the parameters that will be estimated; None for all base parameters.
        payload_only: the last link's ten inertial parameters instead, the robot being known.
        interest: the parameters that count ("d" and "a"), the others being estimated beside them; None for all.
        reference: values that standard deviations are relative to, by name; "a" needs them.
        noise: standard deviation of the torque noise per joint [N·m or N], shape (n,); None for 1 everywhere, inf
            for a joint whose torque is not used.
        rate: independent samples per second that will be recorded [Hz].
        data_length: how long will be recorded, the motion being repeated [s]; None for one motion as it is.
        offsets: whether ``columns`` may name constant torques of the joints, though the robot has none of its own.
    """

    criterion: Kind = "d"
    columns: tuple[str, ...] | None = None
    payload_only: bool = False
    interest: tuple[str, ...] | None = None
    reference: Mapping[str, float] | None = None
    noise: ArrayLike | None = None
    rate: float = 100.0
    data_length: float | None = None
    earlier: Earlier | None = None
    offsets: bool = False

    def __post_init__(self) -> None:
        """Refuse what contradicts itself."""
        if self.criterion not in ORDERS:
            raise InputError(f"criterion {self.criterion!r} is not one of {', '.join(ORDERS)}")
        if self.payload_only and self.columns is not None:
            raise InputError("payload_only names the parameters itself: leave columns out")
        if self.interest is not None and self.criterion not in ("d", "a"):
            raise InputError("interest counts for d and a only: name the columns of a condition number instead")
        if self.criterion == "a" and not self.reference:
            raise InputError("criterion a needs reference values that standard deviations are relative to")
        if self.earlier is not None and self.data_length is None:
            raise InputError("with earlier recordings the data length to come must be given")

    def model(self, robot: Robot) -> Robot:
        """The robot with all columns that the goal may name."""
        return robot.with_offsets(True) if self.offsets else robot

    def names(self, robot: Robot) -> tuple[str, ...]:
        """Names of the parameters.

        Raises:
            InputError: for a name that the robot does not have.
        """
        names = payload_columns(robot) if self.payload_only else self.columns or base_parameters(robot).columns
        known, interest = standard_columns(self.model(robot)), self.interest or ()
        wrong = [name for name in names if name not in known] + [name for name in interest if name not in names]
        if not wrong and (not names or len(set(names)) != len(names)):
            wrong = ["none or the same twice"]
        if wrong:
            raise InputError(f"cannot design for these parameters of robot {robot.name!r}: {', '.join(wrong[:6])}")
        return names

    def measure(self, names: Sequence[str]) -> Criterion:
        """The criterion in the order of ``names``.

        Raises:
            InputError: if a reference value is missing or zero.
        """
        interest = None if self.interest is None else [list(names).index(name) for name in self.interest]
        reference = None
        if self.criterion == "a" and self.reference is not None:
            values = self.reference
            missing = [name for name in self.interest or names if not values.get(name, 0.0)]
            if missing:
                raise InputError(
                    f"criterion a needs a reference value other than zero for {', '.join(missing[:6])}"
                )
            reference = np.array([values.get(name, 0.0) or 1.0 for name in names])
        return Criterion(self.criterion, reference, interest)

    def joint_noise(self, robot: Robot) -> Array:
        """Standard deviation of the torque noise, shape (n,).

        Raises:
            InputError: if it does not fit the robot.
        """
        noise = np.ones(robot.n) if self.noise is None else np.asarray(self.noise, dtype=float)
        if noise.shape != (robot.n,) or not (noise > 0.0).all() or not np.isfinite(noise).any():
            raise InputError(f"torque noise: robot {robot.name!r} needs {robot.n} positive numbers")
        return noise
