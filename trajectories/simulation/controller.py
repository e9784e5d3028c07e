"""A joint controller: position and speed loops in cascade, with feed-forward."""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from ...common.arrays import Array
from ...model import Robot, mass_matrix
from .simulator import parameter_vector

_POSES = 200


@dataclass(frozen=True)
class Controller:
    """Gains of a joint's loops; torques are these times the joint's mean inertia.

    motor torque = J (kv (v - qd) + ki z) + feed-forward, with v = qd_r + kp (q_r - q) and z' = v - qd.

    The feed-forward is the model's torque on the reference motion: the bare robot's, without dry friction, for a
    controller knows neither the payload nor how stiff the gears are today. The loops see the exact positions and
    speeds: a step of the encoder of 1e-5 rad changes the torque by far less than the recorded noise.

    Attributes:
        position: kp [1/s].
        speed: kv [1/s].
        integral: ki [1/s^2].
        feed_forward: share of the model's torque that is fed forward.
    """

    position: float = 100.0
    speed: float = 450.0
    integral: float = 30000.0
    feed_forward: float = 1.0

    def __post_init__(self) -> None:
        """Refuse gains that cannot hold a robot."""
        if not (self.position > 0.0 and self.speed > 0.0 and self.integral >= 0.0):
            raise ValueError("position and speed gains must be positive, the integral gain not negative")


def speed_error(q: ca.SX, qd: ca.SX, wanted: ca.SX, kp: ca.SX) -> ca.SX:
    """v - qd, n x 1 [rad/s or m/s]; ``wanted`` holds q_r, qd_r and the feed-forward."""
    q_r, qd_r, _ = ca.vertsplit(wanted, q.numel())
    return qd_r + kp * (q_r - q) - qd


def motor_torque(error: ca.SX, z: ca.SX, wanted: ca.SX, J: ca.SX, kv: ca.SX, ki: ca.SX) -> ca.SX:
    """Motor torque, n x 1 [N·m or N], of the speed error, its integral and ``wanted`` as above."""
    return J * (kv * error + ki * z) + ca.vertsplit(wanted, z.numel())[2]


def mean_inertia(robot: Robot) -> Array:
    """Mean diagonal of the inertia matrix over the joints' ranges [kg m^2 or kg], shape (n,)."""
    A, chi = mass_matrix(robot), parameter_vector(robot, robot.parameters)
    diagonals = [np.diag(np.array(A(q, chi))) for q in random_positions(robot, _POSES)]
    return np.asarray(np.mean(diagonals, axis=0))


def random_positions(robot: Robot, count: int) -> Array:
    """Positions spread over the joints' ranges (one turn or metre where there is no limit), always the same."""
    ranges = np.array([joint.limits.position for joint in robot.joints])
    bound = np.array([np.pi if joint.revolute else 0.5 for joint in robot.joints])
    ranges = np.clip(ranges, -bound[:, None], bound[:, None])
    return np.asarray(np.random.default_rng(0).uniform(ranges[:, 0], ranges[:, 1], (count, robot.n)))
