"""Frames a user knows: the links of the file a robot was read from, and how the arm is mounted."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..common.errors import InputError, listed
from .inertia import INERTIAL, InertialParameters
from .pose import Pose, check_metres
from .robot import Joint, Robot

MOUNTS = {"floor": (0.0, 0.0, 0.0), "wall": (0.0, 90.0, 0.0), "ceiling": (180.0, 0.0, 0.0)}
"""Roll, pitch, yaw [deg] of the base in the world (z up); on the wall the base's x axis points down."""


def mounted(robot: Robot, rpy: tuple[float, float, float]) -> Robot:
    """Turn the robot's base in the world: gravity in frame 0 follows.

    Args:
        robot: its base frame stands at ``robot.base`` in frame 0.
        rpy: roll, pitch, yaw [rad] of the base in the world, whose z axis points up.
    """
    down = np.array([0.0, 0.0, -math.hypot(*robot.gravity)])
    return with_gravity(robot, tuple((Pose.from_rpy((0.0, 0.0, 0.0), rpy).R.T @ down).tolist()))


def with_gravity(robot: Robot, gravity: tuple[float, ...]) -> Robot:
    """Give the robot another acceleration of gravity [m/s^2], in the base's frame."""
    x, y, z = (float(value) + 0.0 for value in robot.base.R @ np.array(gravity))
    return replace(robot, gravity=(x, y, z))


def with_tool(robot: Robot, tool: Pose, name: str) -> Robot:
    """Give payloads of the robot in a tool's frame.

    Args:
        robot: payloads are given in its flange so far.
        tool: the tool's frame in the flange.
        name: text that names the new frame.

    Raises:
        InputError: for a tool that no arm carries, mostly one in mm.
    """
    check_metres(tool.origin, "origin of the tool's frame")
    maker = None if robot.flange_pose is None else tool.inverse() @ robot.flange_pose
    return replace(robot, flange=robot.flange @ tool, payload_frame=name, flange_pose=maker)


def bodies_in_link_frames(robot: Robot, parameters: Mapping[str, float]) -> dict[str, InertialParameters]:
    """Bodies of the moving links by name, base to tip, in the frames of the robot's file; else in modified DH."""
    missing = [f"{kind}{j}" for j in range(1, robot.n + 1) for kind in INERTIAL if f"{kind}{j}" not in parameters]
    if missing:
        raise InputError(
            f"robot {robot.name!r}: no {listed(missing)}: bodies need all ten parameters of every link"
        )
    bodies = {}
    for j in range(robot.n):
        body = InertialParameters(np.array([parameters[f"{kind}{j + 1}"] for kind in INERTIAL]))
        name = f"link{j + 1}"
        if robot.links is not None:
            there = robot.links.poses[j].inverse()
            name, body = robot.links.names[j], body.moved(there.R, there.p)
        bodies[name] = body
    return bodies


def step(joint: Joint, q: float) -> tuple[Pose, Pose]:
    """Poses of both halves of the way from frame j-1 to frame j at position ``q``: along x, then along z."""
    theta, r = (joint.theta + q, joint.r) if joint.revolute else (joint.theta, joint.r + q)
    return (
        Pose.from_rpy((joint.d, 0.0, 0.0), (joint.alpha, 0.0, 0.0)),
        Pose.from_rpy((0.0, 0.0, r), (0.0, 0.0, theta)),
    )


def frames_at(robot: Robot, q: Sequence[float]) -> tuple[Pose, ...]:
    """Poses of frames 0 to n and of the payload's frame, all in the base, at the positions ``q`` [rad or m]."""
    frames = [robot.base.inverse()]
    for joint, position in zip(robot.joints, q, strict=True):
        along_x, along_z = step(joint, position)
        frames.append(frames[-1] @ along_x @ along_z)
    return (*frames, frames[-1] @ robot.flange)
