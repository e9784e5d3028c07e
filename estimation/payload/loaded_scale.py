"""Loaded torques on a scale that is not quite that of the unloaded ones: drives warm up, sensors drift.

A scale wrong by 1 % moves the mass by several percent, for the arm weighs more than its payload. Where it is asked
for, the scale is one more unknown near 1, as far as it is said to be sure.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model.drives import FRICTION, parameter_kind
from ..equations.equations import PAYLOAD, Equations
from ..fit.linear_problem import Known, LinearProblem, SoftPrior

_SCALE = "scale under load"


class LoadedScale(NamedTuple):
    """How the scale is held, and the torque it scales: parameters of robot and payload, without friction."""

    held: SoftPrior
    names: tuple[str, ...]
    values: Array


def loaded_scale(loaded: Equations, robot: Known, role: SoftPrior) -> LoadedScale:
    """The scale of the loaded torques; the payload's own torque is scaled as well, so it is found first.

    Args:
        loaded: equations with payload, in frame n.
        role: how the scale's difference from 1 is held near zero.
    """
    places = [k for k, name in enumerate(robot.names) if parameter_kind(name) not in FRICTION]
    rigid = LoadedScale(role, tuple(robot.names[k] for k in places), robot.values[places])
    wide, near = with_scale(loaded, {}, rigid)
    values = LinearProblem(wide, (*PAYLOAD, _SCALE), (robot,), near).solved().values
    payload = values[: len(PAYLOAD)] / (1.0 + values[-1])
    return LoadedScale(role, (*rigid.names, *PAYLOAD), np.concatenate([rigid.values, payload]))


def with_scale(
    loaded: Equations, roles: Mapping[str, SoftPrior], scale: LoadedScale | None
) -> tuple[Equations, dict[str, SoftPrior]]:
    """Equations with payload with one more column for the scale, and how their columns are held."""
    if scale is None:
        return loaded, dict(roles)
    c, values = len(loaded.columns), np.zeros((len(loaded.columns), 1))
    values[[loaded.columns.index(name) for name in scale.names], 0] = scale.values
    wide = loaded.transformed(np.hstack([np.eye(c), values]), (*loaded.columns, _SCALE))
    return wide, {**roles, _SCALE: scale.held}
