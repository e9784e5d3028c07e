"""Recordings of an arm with a hose or cable at its flange."""

from dataclasses import replace

import casadi as ca
import numpy as np
from dynident.benchmarks import invented
from dynident.common.arrays import Array
from dynident.model import Recording
from dynident.model.frames import forward_kinematics

ABOVE, BESIDE = np.array([0.0, 0.0, 2.0]), np.array([1.0, 0.0, 0.5])
"""The point that a hose is fastened to [m]."""
NOTHING = np.zeros(3)


def first(recording: Recording, seconds: float = 20.0) -> Recording:
    """The beginning of a recording."""
    own = recording.t < seconds
    speeds = None if recording.qd is None else recording.qd[own]
    return replace(recording, t=recording.t[own], q=recording.q[own], qd=speeds, torque=recording.torque[own])


def pulled(
    recording: Recording, stiffness: float, end: Array, constant: Array = NOTHING, name: str = "ur10e"
) -> Recording:
    """A recording with the force ``stiffness`` (end - p) + ``constant`` [N] at the flange p."""
    robot = invented.robot(name)
    q = ca.SX.sym("q", robot.n)
    R, origin = forward_kinematics(robot)(q)
    flange = robot.flange if robot.flange_pose is None else robot.flange @ robot.flange_pose
    p = origin + R @ ca.DM(flange.p)
    force = stiffness * (ca.DM(end) - p) + ca.DM(constant)
    torque = ca.Function("torque", [q], [ca.jacobian(p, q).T @ force])  # what the motors need not do
    return replace(recording, torque=recording.torque - np.array(torque.map(len(recording.t))(recording.q.T)).T)
