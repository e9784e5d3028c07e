"""Simulated recordings: a robot with known parameters moves, and its controller writes down what it sees."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ...common import Array, Brief
from ...model import InertialParameters, Motion, Recording, Robot, inverse_dynamics
from ...model.kernel.kernel import Kernel
from ...model.motion import Measurement
from ...model.stand_in import completed

RX90_NOISE = (24.0, 30.0, 10.8, 5.1, 6.6, 2.3)
"""White torque noise per joint at 250 Hz [N·m] that leaves residuals like those behind the paper's Table 2."""


@lru_cache(maxsize=16)
def _torque_code(robot: Robot) -> Kernel:
    """Generate the code of the torques, once: fleets and trials simulate one robot many times."""
    return Kernel(inverse_dynamics(robot))


@dataclass(frozen=True, repr=False)
class Simulator(Brief):
    """Simulates recordings by the inverse dynamics of one robot with known parameters.

    Attributes:
        robot: by its description; what that lacks is completed ``with_stand_in``, and a warning says by what.

    >>> motion = random_via_points(robot, count=8, seed=0).motion(rate=100.0)
    >>> Simulator(robot).record(motion, body).torque.shape == motion.q.shape
    True
    """

    robot: Robot

    def __post_init__(self) -> None:
        """Complete the robot.

        Raises:
            InputError: if the robot's description lacks standard parameters that nothing stands in for.
        """
        object.__setattr__(self, "robot", completed(self.robot, limits=False, frames=4))

    @property
    def _kernel(self) -> Kernel:
        return _torque_code(self.robot)

    def measure(
        self,
        motion: Motion,
        payload: InertialParameters | None = None,
        parameters: Mapping[str, float] | None = None,
    ) -> Measurement:
        """Compute exact joint torques [N·m or N] on a motion; ``parameters``: of a twin, else the robot's own."""
        chi = self.robot.chi(parameters, payload)
        torque = np.zeros(motion.q.shape)
        torque[:, self._kernel.rows] = self._kernel(motion.q, motion.qd, motion.qdd, chi).T
        return Measurement(motion, torque)

    def record(
        self,
        motion: Motion,
        payload: InertialParameters | None = None,
        noise: Array | Sequence[float] | None = None,
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
