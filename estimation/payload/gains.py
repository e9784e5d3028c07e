"""Errors of the drive gains, carried through a whole payload method."""

from dataclasses import replace

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ..fit.drive_gains import NOT_TOLD, GainErrors, scaled_torque
from ..fit.estimate import Estimate
from ..fit.least_squares import weighted
from .frame import in_payload_frame
from .problem import FixedWeights, PayloadProblem
from .robust import Method

_STEP = 1e-5
"""Relative change of a torque; every method but the second is linear in it, and that one nearly."""


def gain_covariance(problem: PayloadProblem, method: Method, estimate: Estimate, gains: GainErrors) -> Array:
    """Covariance of a method's result from errors of the drive gains, 10 x 10.

    Raises:
        InputError: as ``payload_gain_sensitivity``; if the gains are another number of joints'.
    """
    J = payload_gain_sensitivity(problem, method, estimate)
    return np.asarray(J @ gains.covariance(problem.robot.n) @ J.T)


def payload_gain_sensitivity(problem: PayloadProblem, method: Method, estimate: Estimate) -> Array:
    """Derivatives of a method's result by the relative error of each motor's torque, 10 x n.

    The torque changes in every recording at once, with and without payload, and in the robot's parameters if they
    were identified earlier: with the same drives, so with the same error. The joints' weights stay.

    Args:
        problem: the reduced recordings.
        method: the method.
        estimate: its result on the problem.

    Raises:
        InputError: if earlier parameters came without what they owe to each motor's torque.
    """
    bare = problem.unloaded
    weights = FixedWeights(weighted(bare).weights if bare is not None else None, estimate.weights)

    def solved(motor: int, step: float) -> Array:
        return in_payload_frame(problem.robot, method(_changed(problem, motor, step), weights)).values

    motors = range(problem.robot.n)
    return np.column_stack([(solved(j, _STEP) - solved(j, -_STEP)) / (2.0 * _STEP) for j in motors])


def _changed(problem: PayloadProblem, motor: int, step: float) -> PayloadProblem:
    """The problem with one motor's torque 1 + step times as large."""
    factor, known = 1.0 + step, problem.known
    if known is not None:
        if known.gain_sensitivity is None:
            raise InputError(NOT_TOLD)
        known = replace(known, values=known.values + step * known.gain_sensitivity[:, motor])
    bare, difference = problem.unloaded, problem.difference
    return replace(
        problem,
        loaded=scaled_torque(problem.loaded, motor, factor),
        unloaded=scaled_torque(bare, motor, factor) if bare is not None else None,
        difference=scaled_torque(difference, motor, factor) if difference is not None else None,
        known=known,
    )
