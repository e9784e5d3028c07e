"""Torques on a motion, for every load that a design reckons with."""

from ..common.arrays import Array
from ..model import Motion, standard_columns
from .limits import State, TorqueLimit
from .problem import DesignProblem
from .samples import Samples
from .score import time_weights
from .simulation import Simulator


def load_torques(problem: DesignProblem, motion: Motion) -> dict[str, Array]:
    """Torques of each load [N·m or N], (N, n), by what the load is called.

    Those of the torque limits; without any, those of the parameters in the robot's description; nothing if
    it holds none.
    """
    samples = Samples(time_weights(motion.t), motion.q, motion.qd, motion.qdd)
    limits = [limit for limit in problem.limits if isinstance(limit, TorqueLimit)]
    if limits:
        state = State(samples, problem.kernel.entries(samples, 0.0))
        return {limit.name: limit.values(state) * limit.unit for limit in limits}
    if all(name in problem.robot.parameters for name in standard_columns(problem.robot)):
        return {"torque": Simulator(problem.robot).measure(motion).torque}
    return {}
