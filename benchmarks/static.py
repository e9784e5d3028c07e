"""A payload weighed standing still: stiction, drift and coarse currents simulated on every shipped arm.

Eight poses, the best of 60 random sets, each reached from both sides. At rest friction holds the Coulomb level of
its approach: 10 % of the torque limit, by 5 % of itself another one each time, taken up over the first half
millirad of a move. Constant torques change from recording to recording as those of a real arm, all torques drift
by 2 % an hour, and are written in steps of a 1000th of the limit.
"""

import functools
from typing import NamedTuple

import numpy as np
from dynident.common.arrays import Array
from dynident.estimation.payload.constant_torques import OFFSET_SHARE
from dynident.model import InertialParameters, Motion, Recording, Robot, load_robot
from dynident.model.regressors import payload_columns, regressor_at
from dynident.model.stand_in import with_stand_in
from dynident.trajectories import Simulator
from dynident.trajectories.motions.via_points import ViaPoints, quickest, random_points

LEVEL, SCATTER, PRESLIDING = 0.1, 0.05, 5e-4
"""Coulomb friction over the torque limit, its scatter over itself, and the move [rad] that takes it up."""
DRIFT, QUANTUM, BETWEEN = 0.02, 1e-3, 90.0  # per hour; of the torque limit; s from one recording to the next
APART, HOLD, POSES = np.radians(3.0), 1.5, 8


class Arm(NamedTuple):
    """An arm, its payload and motion, exact torques [N·m] without and with it, friction's state from -1 to 1."""

    robot: Robot
    payload: InertialParameters
    motion: Motion
    torques: tuple[Array, Array]
    friction: Array
    move: Array  # number of the move that each sample belongs to
    predicted: float  # sigma of the mass [kg], of two recordings

    @property
    def limits(self) -> Array:
        """Torque limits [N·m]."""
        return np.array([joint.limits.torque for joint in self.robot.joints])

    def record(self, loaded: bool, begins: float, seed: list[int], scatter: float = SCATTER) -> Recording:
        """A recording that begins at some time [s]."""
        draw, n = np.random.default_rng(seed), self.robot.n
        levels = LEVEL * (1.0 + scatter * draw.standard_normal((self.move[-1] + 1, n)))
        change = scatter / SCATTER * OFFSET_SHARE * LEVEL / np.sqrt(2.0) * draw.standard_normal(n)
        torque = self.torques[loaded] + self.limits * (levels[self.move] * self.friction + change)
        t = begins + self.motion.t
        step = QUANTUM * self.limits if scatter else 1e-9
        torque = step * np.round(torque * (1.0 + DRIFT / 3600.0 * t[:, None]) / step)
        name = f"{'loaded' if loaded else 'unloaded'}-{begins:.0f}.csv"
        return Recording(t, self.motion.q, torque, None, name, gain_sigma=0.0)

    def recordings(
        self, order: str, seed: int, scatter: float = SCATTER
    ) -> tuple[list[Recording], list[Recording]]:
        """Recordings with and without payload, in an order such as ABBA, A without."""
        length = float(self.motion.t[-1]) + BETWEEN
        own = [self.record(x == "B", k * length, [seed, k], scatter) for k, x in enumerate(order)]
        return [x for x, y in zip(own, order, strict=True) if y == "B"], [
            x for x, y in zip(own, order, strict=True) if y == "A"
        ]


def predicted(robot: Robot, poses: Array) -> float:
    """Sigma of the mass [kg] by two recordings of poses, their approaches and constant torques as simulated."""
    zero, n = np.zeros(poses.shape), robot.n
    columns = [payload_columns(robot)[k] for k in (6, 7, 8, 9)]
    W, level = regressor_at(robot, columns, poses, zero, zero), [LEVEL * x.limits.torque for x in robot.joints]
    information = np.zeros((4, 4))
    for j in range(n):  # 2 K approaches, without and with payload; the wrist's constant torques are free
        noise, change = SCATTER * level[j], OFFSET_SHARE * level[j] if j < n - 3 else np.inf
        mean, K = W[j].mean(axis=1), W.shape[2]
        information += (W[j] @ W[j].T - K * np.outer(mean, mean)) / noise**2
        information += np.outer(mean, mean) / (noise**2 / K + change**2)
    return float(np.sqrt(np.linalg.inv(information)[3, 3]))


@functools.cache
def arm(name: str) -> Arm:
    """An arm with half of its rated payload, and the motion."""
    robot = with_stand_in(load_robot(name))
    sets = [random_points(robot, POSES, seed, 0.75) for seed in range(60)]
    poses = min(sets, key=lambda own: predicted(robot, own))
    points, durations = [poses[0] - APART], list[float]()
    speed, strong = (np.array([getattr(x.limits, y) for x in robot.joints]) for y in ("speed", "acceleration"))
    for pose in poses:
        for begin in (pose - APART, pose + APART):
            for point, least in ((begin, 1.0), (pose, 1.0), (pose, HOLD)):
                step = np.array([point - points[-1]])
                time = quickest(step, 0.5 * speed, 0.5 * strong)[0] if step.any() else 0.0
                points.append(point)
                durations.append(max(time, least))
    rate = robot.processing.rate or 250.0
    motion = ViaPoints(np.array(points), np.array(durations)).motion(rate)
    load = 0.5 * robot.rated_payload
    body = InertialParameters.from_com(load, [0.02, -0.01, 0.08], 0.002 * load * np.eye(3))
    rubs = {name: 0.0 if name[:2] in ("FS", "FL") else value for name, value in robot.parameters.items()}
    torques = [Simulator(robot).measure(motion, own, rubs).torque for own in (None, body)]
    state = np.zeros(motion.q.shape)
    for k, step in enumerate(np.diff(motion.q, axis=0) / PRESLIDING, 1):
        state[k] = np.clip(state[k - 1] + step, -1.0, 1.0)
    starts = np.diff((np.abs(motion.qd) > 1e-9).any(axis=1).astype(int), prepend=0) > 0
    return Arm(robot, body, motion, (torques[0], torques[1]), state, np.cumsum(starts), predicted(robot, poses))
