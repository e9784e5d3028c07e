"""Regressors of base and essential parameters (13)."""

from collections.abc import Sequence

import casadi as ca

from ..regressors import regressor
from ..robot import Robot
from .parameters import BaseParameters


def base_regressor(robot: Robot, base: BaseParameters) -> ca.Function:
    """``base_regressor(q, qd, qdd) -> Phi``, n x N_b, columns as ``base.columns`` (13)."""
    return regressor(robot, base.columns, "base_regressor")


def essential_regressor(robot: Robot, base: BaseParameters, names: Sequence[str]) -> ca.Function:
    """``essential_regressor(q, qd, qdd) -> Phi``, n x ``len(names)``: some columns of the base regressor.

    Raises:
        KeyError: for a name that is not in ``base.columns``.
    """
    for name in names:
        if name not in base.columns:
            raise KeyError(f"{name!r} is not a base parameter of robot {robot.name!r}")
    return regressor(robot, names, "essential_regressor")
