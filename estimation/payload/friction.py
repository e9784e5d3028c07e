"""Friction under load that is not quite the robot's own: it changes by the day, by temperature and with the load.

Left as it was, what it changed by goes into the payload; wholly free, it takes most of what a motion tells of the
mass. So it may change as far as friction of real arms does.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ...model.drives import parameter_kind
from ..equations.equations import Equations
from ..fit.estimate import Estimate
from ..fit.linear_problem import SoftPrior

_OFFSETS = 0.012
"""Standard deviation of a constant torque's change, as a share of the arm's largest Coulomb friction: 0.2 N·m on a
UR10e."""
_CHANGE = " under load"
"""Behind the name of a friction: how much more it is with payload."""
_NONE = 1e-9
"""Share of the arm's largest friction below which a joint has none."""


def friction_sigmas(robot: Estimate, share: float) -> dict[str, float]:
    """Which frictions may change, and how far (1 sigma); those that there are none of cannot.

    Args:
        robot: its own parameters, friction among them.
        share: standard deviation over friction; 0 for none at all.
    """
    kinds = {name: parameter_kind(name) for name in robot.names}
    largest = max((abs(robot[name]) for name, kind in kinds.items() if kind == "FS"), default=0.0)
    sigmas = {name: share * abs(robot[name]) for name, kind in kinds.items() if kind in ("FS", "FV", "FSM", "FVM")}
    if share > 0.0:
        sigmas |= {name: _OFFSETS * largest for name, kind in kinds.items() if kind == "OFF"}
    return {name: sigma for name, sigma in sigmas.items() if sigma > _NONE * largest}


def friction_changes(robot: Estimate, inflation: Sequence[float], share: float) -> dict[str, SoftPrior]:
    """How frictions are held near the robot's own; arguments as of ``friction_sigmas``.

    Args:
        inflation: of each joint's errors, by their memory.
    """
    sigmas = friction_sigmas(robot, share)
    joints = {name: int(name.removeprefix(parameter_kind(name))) - 1 for name in sigmas}
    return {name: SoftPrior(sigma, inflation[joints[name]]) for name, sigma in sigmas.items()}


def with_changes(equations: Equations, roles: Mapping[str, SoftPrior]) -> tuple[Equations, dict[str, SoftPrior]]:
    """Equations under load with one more column for each friction that may change, and how these are held."""
    names = [f"{name}{_CHANGE}" for name in roles]
    own, c = equations.columns, len(equations.columns)
    M = np.eye(c)[:, [*range(c), *map(own.index, roles)]]
    return equations.transformed(M, (*own, *names)), dict(zip(names, roles.values(), strict=True))
