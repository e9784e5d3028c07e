"""The equations of recordings with payload: [W W_L] of (22), and W_L of (29)."""

from collections.abc import Sequence

from ...common.paged import empty, parts
from ...model import BaseParameters, Processing, Robot
from ...model.motion import Measurement
from ...model.regressors import payload_columns
from ..equations.names import PAYLOAD
from ..equations.observation import Observer
from ..equations.problem import ReducedProblem, merged
from ..equations.reduction import reduced_measurement
from ..equations.shared_torque import known_spring


def loaded_observer(robot: Robot, base: BaseParameters) -> Observer:
    """Observer of [W W_L], columns base, then ``PAYLOAD``."""
    names = (*base.columns, *PAYLOAD)
    return Observer(robot, (*base.columns, *payload_columns(robot)), names)


def difference_observer(robot: Robot) -> Observer:
    """Observer of W_L alone."""
    return Observer(robot, payload_columns(robot), PAYLOAD)


def loaded_problem(
    robot: Robot, base: BaseParameters, measurements: Sequence[Measurement], processing: Processing
) -> ReducedProblem:
    """Equations [W W_L] of (22)."""
    observer = loaded_observer(robot, base)
    return merged(reduced_measurement(observer, data, processing) for data in measurements)


def difference_problem(
    robot: Robot, pairs: Sequence[tuple[Measurement, Measurement]], processing: Processing
) -> ReducedProblem:
    """Equations W_L of (29) from (unloaded, loaded) measurements on one trajectory and time.

    W_L is taken on the loaded motion.
    """
    observer = difference_observer(robot)
    return merged(
        reduced_measurement(observer, torque_change(robot, unloaded, loaded), processing, unloaded.motion)
        for unloaded, loaded in pairs
    )


def torque_change(robot: Robot, unloaded: Measurement, loaded: Measurement) -> Measurement:
    """Y_T - Y_wL on the loaded motion.

    The observer moves the spring's torque into Y; in a difference it is there twice, and the first goes along.
    """
    torque = empty(loaded.torque.shape)
    for part in parts(len(torque)):
        torque[part] = loaded.torque[part] - unloaded.torque[part]
    torque.setflags(write=False)
    spring = known_spring(robot)
    if spring is None:
        return Measurement(loaded.motion, torque)
    return Measurement(loaded.motion, torque, spring.torque(unloaded.motion.q[:, spring.joint - 1]))
