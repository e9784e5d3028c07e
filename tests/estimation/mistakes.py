"""Mistakes that a recording may hold, each made from a good one."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
from dynident.benchmarks import invented
from dynident.common.arrays import Array
from dynident.model import InertialParameters, Motion, Recording, Robot
from dynident.trajectories import Simulator

Change = Callable[[Recording], Recording]


@cache
def good(name: str, kind: str = "cube") -> tuple[Motion, Recording, Recording, InertialParameters]:
    """A motion, good recordings without and with payload, and the payload."""
    body = invented.payload(name, kind, np.random.default_rng(4))
    motion = invented.motion(name, 3, points=9 if name == "ur10e" else 11)
    return motion, invented.recorded(name, motion, None, 5), invented.recorded(name, motion, body, 6), body


def on_torque(change: Callable[[Array], Array]) -> Change:
    return lambda r: replace(r, torque=change(np.array(r.torque)))


def on_position(change: Callable[[Array], Array]) -> Change:
    return lambda r: replace(r, q=change(np.array(r.q)))


def scaled(joint: int, factor: float) -> Change:
    def change(torque: Array) -> Array:
        torque[:, joint - 1] *= factor
        return torque

    return on_torque(change)


def read_at(times: Callable[[Array], Array]) -> Change:
    """The torque that belongs to another time."""

    def change(r: Recording) -> Recording:
        torque = np.column_stack([np.interp(times(r.t), r.t, channel) for channel in r.torque.T])
        return replace(r, torque=torque)

    return change


def reordered(*order: int) -> Change:
    places = [joint - 1 for joint in order]
    return lambda r: replace(r, q=r.q[:, places], torque=r.torque[:, places])


def counted_backwards(joint: int) -> Change:
    sign = np.ones(6)
    sign[joint - 1] = -1.0
    return lambda r: replace(r, q=r.q * sign, torque=r.torque * sign)


def with_noise(torque: Array, joint: int) -> Array:
    torque[:, joint - 1] = 0.05 * np.random.default_rng(8).standard_normal(len(torque))
    return torque


def without_gravity(name: str) -> Change:
    """Torques as a gravity-compensated controller shows them, by load."""
    motion, bare, _, body = good(name)
    robot = invented.robot(name)
    still = Motion(motion.t, motion.q, 0.0 * motion.qd, 0.0 * motion.qdd)
    with_g, without = (Simulator(arm) for arm in (robot, replace(robot, gravity=(0.0, 0.0, 0.0))))

    def change(r: Recording) -> Recording:
        load = None if r is bare else body
        return replace(
            r, torque=r.torque - (with_g.measure(still, load).torque - without.measure(still, load).torque)
        )

    return change


def late_half(name: str, body: InertialParameters | None) -> Change:
    """In the second half another load."""
    motion, *_ = good(name)
    second = invented.recorded(name, motion, body, 6)

    def change(r: Recording) -> Recording:
        late = (r.t > 0.5 * r.t[-1])[:, None]
        return replace(r, torque=np.where(late, second.torque, r.torque))

    return change


def slipped(body: InertialParameters) -> InertialParameters:
    return body.moved(np.eye(3), [0.08, 0.0, 0.0])


def static_poses(name: str) -> Change:
    """Held poses one after another, without the motion between them."""
    motion, *_ = good(name)
    moving = invented.simulator(name)

    def change(r: Recording) -> Recording:
        poses = motion.q[np.linspace(0, len(motion.t) - 1, 12).astype(int)]
        q = np.repeat(poses, len(motion.t) // 12, axis=0)
        t = motion.t[: len(q)]
        still = moving.measure(Motion(t, q, 0.0 * q, 0.0 * q)).torque
        return replace(r, t=t, q=q, torque=still + 0.1 * np.random.default_rng(3).standard_normal(q.shape))

    return change


def only_joint(name: str, joint: int) -> Change:
    motion, *_ = good(name)
    q, qd, qdd = (np.array(x) for x in (motion.q, motion.qd, motion.qdd))
    others = [j for j in range(6) if j != joint - 1]
    q[:, others], qd[:, others], qdd[:, others] = q[0, others], 0.0, 0.0
    single = Motion(motion.t, q, qd, qdd)
    return lambda r: invented.recorded(name, single, None, len(r.source))


def stuck(joint: int) -> Change:
    """The encoder holds its value for a fifth of the recording, then follows again."""

    def change(q: Array) -> Array:
        a, b = int(0.4 * len(q)), int(0.6 * len(q))
        q[a:b, joint - 1] = q[a, joint - 1]
        return q

    return on_position(change)


def stuck_to_the_end(joint: int) -> Change:
    def change(q: Array) -> Array:
        a = int(0.5 * len(q))
        q[a:, joint - 1] = q[a, joint - 1]
        return q

    return on_position(change)


def clipped(share: float) -> Change:
    def change(torque: Array) -> Array:
        most = share * np.abs(torque).max(axis=0)
        return np.clip(torque, -most, most)

    return on_torque(change)


def drifting(joint: int, size: float) -> Change:
    """An offset that grows from nothing to ``size`` of the joint's torque."""

    def change(torque: Array) -> Array:
        column = torque[:, joint - 1]
        torque[:, joint - 1] += size * np.sqrt(np.mean(column**2)) * np.linspace(0.0, 1.0, len(torque))
        return torque

    return on_torque(change)


def speeds(factor: float) -> Change:
    def change(r: Recording) -> Recording:
        return replace(r, qd=factor * np.gradient(r.q, r.t, axis=0))

    return change


def lengthened(robot: Robot, joint: int, name: str, factor: float) -> Robot:
    joints = list(robot.joints)
    old = joints[joint - 1]
    joints[joint - 1] = replace(old, **{name: factor * getattr(old, name)})
    return replace(robot, joints=tuple(joints))


def uncoupled(robot: Robot) -> Robot:
    return replace(robot, drives=replace(robot.drives, coupling=None))


def same(r: Recording) -> Recording:
    return r
