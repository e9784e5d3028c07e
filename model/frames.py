"""Frames of the chain, and those a user knows: the mount, the tool, the links of the file a robot was read from.

Vectors are triples of entries: numbers, CasADi's scalars, or arrays whose last axis counts states. So the same
formulas make the symbolic model, and evaluate it by NumPy for a robot that is tried once, where generated code does
not pay.

A data sheet and a URDF give an arm by where each axis lies at the zero pose and which way is positive. Its frames
then follow Khalil and Kleinfinger: z_j along axis j, x_j along the common normal of the axes j and j + 1.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import casadi as ca
import numpy as np

from ..common import Array, InputError, listed
from .inertia import INERTIAL, InertialParameters, Pose, check_metres, cos_sin
from .robot import SNAP_ANGLE, SNAP_LENGTH, Joint, Limits, Robot

Vector = tuple[Any, Any, Any]
ZERO: Vector = (0.0, 0.0, 0.0)  # zero vector, with which ``dot`` takes no operations


class FrameChange(NamedTuple):
    """Frame j in frame j-1."""

    c: Any  # cosine of the angle about z
    s: Any  # its sine
    alpha: tuple[float, float]  # cosine and sine of the angle about x
    origin: Vector  # of frame j in frame j-1 [m]

    @staticmethod
    def of(joint: Joint, q: Any, lib: Any = ca) -> "FrameChange":
        """Make the change before a joint at position ``q`` [rad or m], by CasADi or NumPy."""
        c, s = cos_sin(joint.theta)
        along = joint.r
        if joint.revolute:
            # The offset is taken out of the cosine, so that special offsets stay exact.
            cq, sq = lib.cos(q), lib.sin(q)
            c, s = cq * c - sq * s, sq * c + cq * s
        else:
            along = q + along
        ca_, sa = cos_sin(joint.alpha)
        return FrameChange(c, s, (ca_, sa), (joint.d, -sa * along, ca_ * along))

    def into(self, x: Vector) -> Vector:
        """Rotate a vector of frame j-1 into the axes of frame j."""
        ca_, sa = self.alpha
        across = ca_ * x[1] + sa * x[2]
        return self.c * x[0] + self.s * across, self.c * across - self.s * x[0], ca_ * x[2] - sa * x[1]

    def out_of(self, x: Vector) -> Vector:
        """Rotate a vector of frame j into the axes of frame j-1."""
        ca_, sa = self.alpha
        across = self.s * x[0] + self.c * x[1]
        return self.c * x[0] - self.s * x[1], ca_ * across - sa * x[2], sa * across + ca_ * x[2]


def add(a: Vector, b: Vector) -> Vector:
    """Sum of two vectors."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def dot(a: Vector, b: Vector) -> Any:
    """Scalar product of two vectors."""
    return 0.0 if b is ZERO else a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Cross product of two vectors."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def link_frames(robot: Robot, q: ca.SX) -> list[tuple[ca.SX, ca.SX]]:
    """Axes (3 x 3) and origins (3 x 1 [m]) of frames 0 to n in frame 0, as expressions of ``q``, n x 1."""
    frames = [(ca.SX.eye(3), ca.SX.zeros(3))]
    for joint, position in zip(robot.joints, ca.vertsplit(q), strict=True):
        change = FrameChange.of(joint, position)
        axes = ca.horzcat(*(ca.vertcat(*change.out_of((x, y, z))) for x, y, z in np.eye(3).tolist()))
        R, p = frames[-1]
        frames.append((R @ axes, p + R @ ca.vertcat(*change.origin)))
    return frames


def forward_kinematics(robot: Robot) -> ca.Function:
    """``forward_kinematics(q) -> (R, p)``: axes (3 x 3) and origin [m] of frame n in frame 0."""
    q = ca.SX.sym("q", robot.n)
    return ca.Function("forward_kinematics", [q], [*link_frames(robot, q)[-1]], ["q"], ["R", "p"])


def point_at(robot: Robot, point: Array, q: Array) -> tuple[Array, Array]:
    """Position of a point of frame n at positions q, N x n, in frame 0 [m], and its Jacobian; 3 x (n x) N."""
    position: Any = point[:, None] + np.zeros(len(q))
    moved: Any = np.zeros((3, *q.T.shape))
    for j in reversed(range(robot.n)):
        if robot.joints[j].revolute:
            moved[0][j], moved[1][j] = -position[1], position[0]
        else:
            moved[2][j] = 1.0
        change = FrameChange.of(robot.joints[j], q[:, j], np)
        moved, position = change.out_of(moved), add(change.out_of(position), change.origin)
    return np.array(position), np.array(moved)


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
        needed = "bodies need all ten parameters of every link"
        raise InputError(f"robot {robot.name!r}: no {listed(missing)}: {needed}")
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
    along_x = Pose.from_rpy((joint.d, 0.0, 0.0), (joint.alpha, 0.0, 0.0))
    return along_x, Pose.from_rpy((0.0, 0.0, r), (0.0, 0.0, theta))


def frames_at(robot: Robot, q: Sequence[float]) -> tuple[Pose, ...]:
    """Poses of frames 0 to n and of the payload's frame, all in the base, at the positions ``q`` [rad or m]."""
    frames = [robot.base.inverse()]
    for joint, position in zip(robot.joints, q, strict=True):
        along_x, along_z = step(joint, position)
        frames.append(frames[-1] @ along_x @ along_z)
    return (*frames, frames[-1] @ robot.flange)


@dataclass(frozen=True)
class JointAxis:
    """A joint's axis at the zero pose, in the base's frame.

    Attributes:
        direction: along the positive sense (right-hand rule), of any length but zero.
        point: a point on the axis [m].
    """

    kind: Literal["revolute", "prismatic"]
    direction: tuple[float, float, float]
    point: tuple[float, float, float]
    limits: Limits = Limits()

    def __post_init__(self) -> None:
        if not all(math.isfinite(value) for value in (*self.direction, *self.point)):
            raise ValueError("direction and point of an axis must be finite")
        if math.hypot(*self.direction) < 1e-9:
            raise ValueError("an axis needs a direction")


def modified_dh(axes: Sequence[JointAxis], flange: Pose) -> Robot:
    """Robot of a chain's axes, gravity along -z of its base, with every freedom used for plain numbers.

    Frame 0 is the base wherever the first axis allows it, frame n the flange wherever the last one does; axes
    within 1e-4 rad of parallel, or 1e-6 m of meeting, are taken as such.

    Args:
        axes: of the joints 1 to n at the zero pose, in the base.
        flange: the flange at the zero pose, in the base.
    """
    lines = list[tuple[Array, Array]]()  # each axis as its direction, of length 1, and a point on it
    for axis in axes:
        direction = np.array(axis.direction) / np.linalg.norm(axis.direction)
        special = np.where(np.abs(direction) < SNAP_ANGLE, 0.0, direction)
        lines.append((special / np.linalg.norm(special), np.array(axis.point, dtype=float)))
    # Frame 0 is the base, if its x axis meets the first joint's at a right angle.
    x, z, origin = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]), np.zeros(3)
    first, foot = lines[0][0], _foot(origin, *lines[0])
    if abs(first @ x) >= SNAP_ANGLE or np.linalg.norm(foot[1:]) >= SNAP_LENGTH:
        x, z, origin = _perpendicular(first, x), first, foot
    base, joints = _pose(x, z, origin).inverse(), list[Joint]()
    for j, (axis, (direction, point)) in enumerate(zip(axes, lines, strict=True)):
        # x of the frame before meets this axis at a right angle, so this is where.
        foot = _foot(origin, direction, point)
        new_x, new_origin = x, foot
        if j + 1 == len(axes):  # the flange where its z axis lies on the last joint's, as near as can be elsewhere
            wish, new_origin = flange.R[:, 0], _foot(flange.p, direction, foot)
            if np.linalg.norm(np.cross(wish, direction)) > SNAP_ANGLE:
                new_x = _perpendicular(direction, wish)
        else:  # along the common normal of this axis and the next one
            ahead, there = lines[j + 1]
            normal, between = np.cross(direction, ahead), there - point
            size = float(np.linalg.norm(normal))
            if size < SNAP_ANGLE:
                normal = between - (between @ direction) * direction
                size = apart = float(np.linalg.norm(normal))
            else:  # the nearest point to the next axis
                new_origin = point + np.cross(between, ahead) @ normal / size**2 * direction
                apart = float(between @ normal) / size
            if size >= SNAP_LENGTH:  # else the axes are one
                normal = normal / size
                # Of both directions the one near the x before; if neither is near it, towards the next axis.
                side = float(normal @ x)
                if abs(side) < 1e-9:
                    side = apart if abs(apart) > SNAP_LENGTH else float(np.cross(x, normal) @ direction)
                new_x = normal if side > 0.0 else -normal
        alpha, d = _angle(z, direction, x), _along(foot - origin, x)
        theta, r = _angle(x, new_x, direction), _along(new_origin - foot, direction)
        joints.append(Joint(axis.kind, alpha, d, theta, r, axis.limits))
        x, z, origin = new_x, direction, new_origin
    robot = Robot("robot", tuple(joints), flange=_pose(x, z, origin).inverse() @ flange, base=base)
    return with_gravity(robot, (0.0, 0.0, -9.81))


def _foot(origin: Array, direction: Array, point: Array) -> Array:
    return np.asarray(point + ((origin - point) @ direction) * direction)


def _perpendicular(direction: Array, wish: Array) -> Array:
    """Unit vector at a right angle to ``direction``, near ``wish`` where that is possible."""
    across = wish - (wish @ direction) * direction
    if np.linalg.norm(across) < SNAP_ANGLE:
        across = np.eye(3)[int(np.argmin(np.abs(direction)))]
        across = across - (across @ direction) * direction
    return np.asarray(across / np.linalg.norm(across))


def _pose(x: Array, z: Array, origin: Array) -> Pose:
    return Pose.of(np.column_stack([x, np.cross(z, x), z]), origin)


def _angle(before: Array, after: Array, axis: Array) -> float:
    return math.atan2(float(np.cross(before, after) @ axis), float(before @ after))


def _along(step: Array, direction: Array) -> float:
    return round(float(step @ direction), 12) + 0.0
