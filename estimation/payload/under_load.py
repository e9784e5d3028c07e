"""Priors on what may be another one under load: the path, friction, the scale of the torques.

An arm that sags does not run the motion it ran without payload. The difference of the torques then holds
Phi(q_L) chi - Phi(q_U) chi of the robot itself, about 100 N·m/rad at the second joint, and repeats with the motion:
no block of time shows it. It is taken off by parameters fitted to the recording without payload, and a quarter of
what it changes is part of the uncertainty: alignment takes part of a sag for a delay.

Friction changes by the day, by temperature and with the load. Left as it was, what it changed by goes into the
payload; wholly free, it takes most of what a motion tells of the mass. So it may change as far as friction of real
arms does.

A scale of the loaded torques wrong by 1 % (drives warm up, sensors drift) moves the mass by several percent, for
the arm weighs more than its payload. Where it is asked for, it is one more unknown near 1, as far as it is said to
be sure.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ...common.arrays import Array
from ...common.linear import decomposed
from ...model.drives import joint_of, parameter_kind
from ...model.friction import is_friction
from ..equations.equations import PAYLOAD, Equations
from ..equations.observer import PATH
from ..fit.estimate import Estimate
from ..fit.linear_problem import Known, LinearProblem, SoftPrior

_UNSURE = 0.25  # fraction of the path's correction that may be wrong (1 sigma)
_SMALL = 1e-3  # smallest singular value over the largest, columns scaled, that recordings without payload show
_OFFSETS = 0.012
"""Standard deviation of a constant torque's change, as a fraction of the arm's largest Coulomb friction: 0.2 N·m on
a UR10e."""
_NONE = 1e-9  # fraction of the arm's largest friction below which a joint has none
_SCALE = "scale under load"


def robot_of(unloaded: Equations) -> Array:
    """Estimate the robot's parameters, (c,), by a recording without payload, as far as shown, friction zero.

    Joints weigh by their torques: weights by residuals would fall for a joint that is explained by chance.
    """
    rms = unloaded.torque_norms / np.sqrt(np.maximum(unloaded.rows, 1))
    factor = unloaded.stacked(np.divide(1.0, rms, out=np.zeros_like(rms), where=rms > 0.0))
    values = decomposed(factor[:, :-1], tolerance=_SMALL).solution(factor[:, -1])
    return np.where([is_friction(name) for name in unloaded.columns], 0.0, values)


def known_path(columns: Sequence[str], joints: int) -> tuple[Known, ...]:
    """Prior of the torque of paths that differ: nothing of it is left, but for a quarter."""
    if PATH not in columns:
        return ()
    zero, derivatives = np.zeros((1, 1)), np.zeros((1, joints))
    return (Known((PATH,), zero[0], zero, zero + _UNSURE**2, gain_sensitivity=lambda: derivatives),)


def friction_changes(robot: Estimate, inflation: Sequence[float], ratio: float) -> dict[str, SoftPrior]:
    """Priors that keep frictions near the robot's own, by the memory of errors; what a joint lacks cannot change.

    Coulomb and viscous friction change with the day and the oil's temperature. What grows with load changes by the
    payload's torque, and is known; free as well, it would take weight along. Without a ``ratio`` none changes.
    """
    kinds = {name: parameter_kind(name) for name in robot.names}
    largest = max((abs(robot[name]) for name, kind in kinds.items() if kind == "FS"), default=0.0)
    rubs = [name for name, kind in kinds.items() if kind in ("FS", "FV", "FSM", "FVM")]
    sigmas = {name: ratio * abs(robot[name]) for name in rubs}
    if ratio > 0.0:
        sigmas |= {name: _OFFSETS * largest for name, kind in kinds.items() if kind == "OFF"}
    there = {name: sigma for name, sigma in sigmas.items() if sigma > _NONE * largest}
    return {name: SoftPrior(sigma, inflation[joint_of(name)]) for name, sigma in there.items()}


def with_scale(loaded: Equations, robot: Known, role: SoftPrior) -> tuple[Equations, dict[str, SoftPrior]]:
    """Add one column for the scale under load, and its prior.

    It scales the torque of robot and payload, without friction; the payload's own is therefore found first.
    ``role`` is the prior of its difference from 1.
    """

    def scaled_by(scaled: Mapping[str, float]) -> Equations:
        column = [scaled.get(name, 0.0) for name in loaded.columns]
        return loaded.transformed(np.column_stack([np.eye(len(column)), column]), (*loaded.columns, _SCALE))

    every = zip(robot.names, robot.values.tolist(), strict=True)
    rigid = {name: value for name, value in every if not is_friction(name)}
    near = {_SCALE: role}
    values = LinearProblem(scaled_by(rigid), (*PAYLOAD, _SCALE), (robot,), near).solved().values
    payload = values[:-1] / (1.0 + values[-1])
    return scaled_by(rigid | dict(zip(PAYLOAD, payload.tolist(), strict=True))), near
