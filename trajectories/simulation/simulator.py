"""Simulated recordings: a robot with known parameters moves, and its controller writes down what it sees."""

from collections.abc import Mapping, Sequence
from functools import lru_cache

import numpy as np

from ...common import Array, ArrayLike, InputError
from ...model import InertialParameters, Motion, Recording, Robot, inverse_dynamics, standard_columns
from ...model.kernel.kernel import Kernel
from ...model.motion import Measurement

RX90_NOISE = (24.0, 30.0, 10.8, 5.1, 6.6, 2.3)
"""White torque noise per joint at 250 Hz [N·m] that leaves residuals like those behind the paper's Table 2."""


@lru_cache(maxsize=16)
def _torque_code(robot: Robot) -> Kernel:
    """Generate the code of the torques, once: fleets and trials simulate one robot many times."""
    return Kernel(inverse_dynamics(robot))


class Simulator:
    """Simulates recordings by the inverse dynamics of one robot with known parameters."""

    def __init__(self, robot: Robot) -> None:
        """Generate the code.

        Raises:
            InputError: if the robot's description lacks standard parameters.
        """
        parameter_vector(robot, robot.parameters)  # refuses a robot that lacks some
        self.robot = robot
        self._kernel = _torque_code(robot)

    def measure(
        self,
        motion: Motion,
        payload: InertialParameters | None = None,
        parameters: Mapping[str, float] | None = None,
    ) -> Measurement:
        """Compute exact joint torques [N·m or N] on a motion; ``parameters``: of a twin, else the robot's own."""
        chi = parameter_vector(self.robot, parameters or self.robot.parameters, payload)
        torque = np.zeros(motion.q.shape)
        torque[:, self._kernel.rows] = self._kernel(motion.q, motion.qd, motion.qdd, chi).T
        return Measurement(motion, torque)

    def record(
        self,
        motion: Motion,
        payload: InertialParameters | None = None,
        noise: ArrayLike | None = None,
        seed: int | Sequence[int] = 0,
        source: str = "simulated",
        parameters: Mapping[str, float] | None = None,
    ) -> Recording:
        """Record positions and torques on a motion, torques with white noise and to an exact scale.

        Args:
            motion: what the robot does, exactly.
            payload: fixed to the last link, given in the robot's payload frame.
            noise: standard deviation of the torque noise per joint [N·m or N]; None for none.
            seed: of the noise.
            source: name of the recording.
            parameters: of a twin of the robot; the robot's own by default.
        """
        torque = np.array(self.measure(motion, payload, parameters).torque)
        if noise is not None:
            torque += np.asarray(noise) * np.random.default_rng(seed).standard_normal(torque.shape)
        return Recording(motion.t, motion.q, torque, None, source, gain_sigma=0.0)


def parameter_vector(
    robot: Robot, parameters: Mapping[str, float], payload: InertialParameters | None = None
) -> Array:
    """Order standard parameters as ``standard_columns``, a payload in its own frame added to the last link's.

    Raises:
        InputError: if some are missing.
    """
    values, columns = dict(parameters), standard_columns(robot)
    missing = [name for name in columns if name not in values]
    if missing:
        raise InputError(
            f"robot {robot.name!r} cannot be simulated: its description lacks {', '.join(missing[:6])}"
            f"{' and more' if len(missing) > 6 else ''}; add a [parameters] table"
        )
    if payload is not None:
        moved = payload.moved(robot.flange.R, robot.flange.p)
        for name, value in moved.named(str(robot.n)).items():
            values[name] += value
    return np.array([values[name] for name in columns])
