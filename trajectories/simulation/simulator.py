"""Simulated recordings of a robot with known parameters, and disturbances of them: every level a parameter.

The robot moves, its controller writes down what it sees; every draw is by a seed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ...common import Array, Brief
from ...common.recursion import filtered
from ...model import InertialParameters, Motion, Recording, Robot, inverse_dynamics
from ...model.dynamics import dry_friction_names
from ...model.kernel.kernel import Kernel
from ...model.motion import Measurement
from ...model.stand_in import completed

RX90_NOISE = (24.0, 30.0, 10.8, 5.1, 6.6, 2.3)
"""White torque noise per joint at 250 Hz [N·m] that leaves residuals like those behind the paper's Table 2."""


@lru_cache(maxsize=16)
def _torque_code(robot: Robot) -> Kernel:
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

    def measure(
        self,
        motion: Motion,
        payload: InertialParameters | None = None,
        parameters: Mapping[str, float] | None = None,
    ) -> Measurement:
        """Compute exact joint torques [N·m or N] on a motion; ``parameters``: of a twin, else the robot's own."""
        chi, kernel = self.robot.chi(parameters, payload), _torque_code(self.robot)
        torque = np.zeros(motion.q.shape)
        torque[:, kernel.rows] = kernel(motion.q, motion.qd, motion.qdd, chi).T
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


_AFTER_DECIMATION = 0.28  # of white noise at 250 Hz, through the filter of a decimation by 10
_ROBOT, _RUN, _RECORDING = 0, 1, 2  # what a random stream belongs to


@dataclass(frozen=True, eq=False, repr=False)
class Disturbances(Brief):
    """Levels of all that stands between a robot's model and its recordings.

    Ripple and the level of dry friction act on the moving robot; the rest on what its controller writes down.
    Torques in N·m or N, one number per joint.

    Attributes:
        white: standard deviation of the torque's noise, independent from sample to sample.
        slow: standard deviation of a torque noise with exponential memory.
        slow_memory: its correlation time [s].
        ripple: amplitude of a torque that is periodic in the joint's position, for each of ``waves`` alike.
        waves: periods per turn [1 per 2 pi rad or 2 pi m].
        friction: standard deviation of the level of dry friction, relative to its mean.
        friction_memory: correlation time of the level [s].
        encoder: step of the recorded positions [rad or m].
        gain_error: standard deviation of the joints' drive gains, relative.
    """

    white: tuple[float, ...]
    slow: tuple[float, ...]
    ripple: tuple[float, ...]
    slow_memory: float = 0.8
    waves: tuple[int, ...] = (8, 36)
    friction: float = 0.0
    friction_memory: float = 2.0
    encoder: float = 0.0
    gain_error: float = 0.0

    def __post_init__(self) -> None:
        if not len(self.white) == len(self.slow) == len(self.ripple):
            raise ValueError("white, slow and ripple need one number per joint")
        single = (self.friction, self.encoder, self.gain_error)
        if not all(0.0 <= level < np.inf for level in (*self.white, *self.slow, *self.ripple, *single)):
            raise ValueError("a level must not be negative")
        if not (self.slow_memory > 0.0 and self.friction_memory > 0.0 and all(wave > 0 for wave in self.waves)):
            raise ValueError("memories and waves must be positive")


def no_disturbances(n: int) -> Disturbances:
    """Make levels of zero: recordings exactly as the robot moves."""
    return Disturbances((0.0,) * n, (0.0,) * n, (0.0,) * n)


RX90_DISTURBANCES = Disturbances(
    white=(16.9, 29.7, 9.4, 4.66, 6.07, 2.74),
    slow=(0.0,) * 6,
    ripple=(1.7, 2.7, 0.95, 0.46, 0.54, 0.24),
    friction=0.12,
    encoder=1e-5,
)
"""Make levels as noisy as the paper's robot: (17)-(19) come out like Table 2's.

Its printed deviations need a relative residual of 7 to 8 % in all and of 20 to 25 % on joints 5 and 6: residuals of
4 to 5 % would give deviations that are too small, both cannot be had. How the residual is shared out between white
noise, ripple and friction is not published; it is assumed here, as are the encoder's step and the ripple's waves.
"""

RX90_SLOW_NOISE = replace(
    RX90_DISTURBANCES, white=(0.0,) * 6, slow=tuple(_AFTER_DECIMATION * x for x in RX90_DISTURBANCES.white)
)
"""Make the paper's levels with noise that remembers 0.8 s instead of white noise.

What decimation by 10 leaves of white noise at 250 Hz it leaves of this noise whole: residuals are as large, but say
far less about the robot.
"""


def remembered_disturbances(noise: Array, rate: float) -> Disturbances:
    """Make levels as a design assumes them: ``noise`` [N·m or N], (n,), that remembers half of 1/``rate`` [s]."""
    none = (0.0,) * len(noise)
    return Disturbances(none, tuple(noise.tolist()), none, slow_memory=0.5 / rate, encoder=1e-5)


def relative_disturbances(torque: Array, share: float) -> Disturbances:
    """Make levels of the joints' rms torque, (n,): the fraction ``share`` white, half of it ripple and friction."""
    joints = tuple(float(x) for x in share * torque)
    half = tuple(0.5 * x for x in joints)
    return Disturbances(joints, (0.0,) * len(joints), half, friction=0.5 * share, encoder=1e-5)


def draw_robot_errors(disturbances: Disturbances, seed: int) -> tuple[Array, Array]:
    """Draw the ripple's phases [rad], n x waves, and the drives' gains, (n,), alike in all recordings."""
    draw, n = np.random.default_rng([seed, _ROBOT]), len(disturbances.white)
    phases = draw.uniform(-np.pi, np.pi, (n, len(disturbances.waves)))
    return phases, 1.0 + disturbances.gain_error * draw.standard_normal(n)


def draw_friction(robot: Robot, disturbances: Disturbances, count: int, rate: float, seed: Sequence[int]) -> Array:
    """Draw dry friction of one run, one row a sample [N·m or N], columns as ``dry_friction_names``."""
    names = dry_friction_names(robot)
    mean = np.array([robot.parameters[name] for name in names])
    draw = np.random.default_rng([*seed, _RUN])
    change = _exponential(draw, (count, len(names)), disturbances.friction_memory * rate)
    return np.asarray(mean * np.maximum(1.0 + disturbances.friction * change, 0.0))


def record(
    exact: Measurement, disturbances: Disturbances, gains: Array, seed: Sequence[int], source: str = "simulated"
) -> Recording:
    """Record a motion and its motor torques as the controller writes them down.

    ``gains``: of the drives, measured over true torque, shape (n,).
    """
    motion, torque = exact.motion, exact.torque
    draw = np.random.default_rng([*seed, _RECORDING])
    noise = np.array(disturbances.white) * draw.standard_normal(torque.shape)
    slow = _exponential(draw, torque.shape, disturbances.slow_memory * motion.rate)
    noise += np.array(disturbances.slow) * slow
    step = disturbances.encoder
    q = step * np.round(motion.q / step) if step > 0.0 else motion.q
    return Recording(motion.t, q, gains * torque + noise, None, source, gain_sigma=disturbances.gain_error)


def _exponential(draw: np.random.Generator, shape: tuple[int, ...], memory: float) -> Array:
    """Draw noise of unit variance whose correlation falls by e in ``memory`` samples, column by column."""
    # A first-order autoregression, its first sample of the same variance as all others.
    decay = float(np.exp(-1.0 / memory))
    fresh = draw.standard_normal(shape)
    fresh[1:] *= np.sqrt(1.0 - decay**2)
    return filtered([(1.0, 0.0, 0.0, -decay, 0.0)], fresh, np.zeros(shape[1]))
