"""A joint controller: position and speed loops in cascade, with feed-forward."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import casadi as ca
import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import InertialParameters, Motion, Robot, mass_matrix
from ..motions.samples import Plan
from .simulator import Simulator, parameter_vector

_POSES = 200
_TIMES = 2000  # of each reference, at which a payload's torque is looked at


@dataclass(frozen=True)
class Controller:
    """Gains of a joint's loops; torques are these times the joint's mean inertia.

    motor torque = J (kv (v - qd) + ki z) + feed-forward, with v = qd_r + kp (q_r - q) and z' = v - qd.

    The feed-forward is the model's torque on the reference motion: the bare robot's, without dry friction, for a
    controller knows neither the payload nor how stiff the gears are today. Without an integral nothing takes up
    what the payload adds: the arm sags until the position error holds it, by its torque / (J kp kv). The loops
    see the exact positions and speeds: a step of the encoder of 1e-5 rad changes the torque by far less than the
    recorded noise.

    Attributes:
        position: kp [1/s].
        speed: kv [1/s].
        integral: ki [1/s^2].
        feed_forward: share of the model's torque that is fed forward.
        compensates: whether that is the torque of the whole motion, or only what holds the reference pose at rest.
    """

    position: float = 100.0
    speed: float = 450.0
    integral: float = 30000.0
    feed_forward: float = 1.0
    compensates: Literal["motion", "gravity"] = "motion"

    def __post_init__(self) -> None:
        """Refuse gains that cannot hold a robot."""
        if not (self.position > 0.0 and self.speed > 0.0 and self.integral >= 0.0):
            raise ValueError("position and speed gains must be positive, the integral gain not negative")
        if self.compensates not in ("motion", "gravity"):
            raise ValueError(f"compensates must be 'motion' or 'gravity', got {self.compensates!r}")

    def sagging(
        self, robot: Robot, payload: InertialParameters, references: Sequence[Plan], sag: float
    ) -> "Controller":
        """Position and speed gains changed alike until a payload pulls the arm off its path by as much as told.

        Args:
            payload: given in the robot's payload frame.
            references: the motions on which that shall be so.
            sag: of the joint that gives way most, root mean square over all of them [rad or m].

        Raises:
            InputError: if the loops have an integral, which takes every sag up.
        """
        if self.integral > 0.0:
            raise InputError("a controller with integral action does not sag: choose one without")
        if not sag > 0.0:
            raise InputError(f"a sag of {sag:g} rad: give a positive one")
        simulator, pulls = Simulator(robot), []
        for reference in references:
            t = np.linspace(0.0, reference.duration, _TIMES)
            motion = Motion(t, *reference.at(t))
            pulls.append(simulator.measure(motion, payload).torque - simulator.measure(motion).torque)
        pull = np.sqrt(np.mean(np.concatenate(pulls) ** 2, axis=0)) / mean_inertia(robot)
        share = np.sqrt(float(pull.max()) / sag / (self.position * self.speed))
        return replace(self, position=share * self.position, speed=share * self.speed)


CONTROLLERS = {
    "integral": Controller(),
    "proportional": Controller(integral=0.0),
    "gravity": Controller(integral=0.0, compensates="gravity"),
}
"""Loops as most industrial arms have them; without integral action; and those that know of gravity alone."""


def speed_error(q: ca.SX, qd: ca.SX, reference: ca.SX, kp: ca.SX) -> ca.SX:
    """v - qd, n x 1 [rad/s or m/s]; ``reference`` holds q_r, qd_r and the feed-forward."""
    q_r, qd_r, _ = ca.vertsplit(reference, q.numel())
    return qd_r + kp * (q_r - q) - qd


def motor_torque(error: ca.SX, z: ca.SX, reference: ca.SX, J: ca.SX, kv: ca.SX, ki: ca.SX) -> ca.SX:
    """Motor torque, n x 1 [N·m or N], of the speed error, its integral and ``reference`` as above."""
    return J * (kv * error + ki * z) + ca.vertsplit(reference, z.numel())[2]


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
