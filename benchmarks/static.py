"""A payload weighed standing still: stiction, drift and coarse currents simulated on every shipped arm.

Friction at rest is the Coulomb level of the approach, another one each time, taken up in half a millirad.
"""

import functools
from typing import NamedTuple

import numpy as np
from dynident import estimation
from dynident.benchmarks.shared import each, held, options, rms, show
from dynident.common.arrays import Array
from dynident.estimation.payload.constant_torques import OFFSET_SHARE
from dynident.model import InertialParameters, Motion, Recording, Robot, load_robot, robot_names
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
    sigma: float  # of the mass by two recordings as predicted [kg]

    def recordings(self, order: str, seed: int, scatter: float = SCATTER) -> tuple[list[Recording], ...]:
        """Recordings with and without payload, in an order such as ABBA, A without; scales hold half-way."""
        length, limits = float(self.motion.t[-1]) + BETWEEN, [joint.limits.torque for joint in self.robot.joints]
        made, step, n = [], np.array(limits) * (QUANTUM if scatter else 1e-9), len(limits)
        for k, kind in enumerate(order):
            draw, t = np.random.default_rng([seed, k]), k * length + self.motion.t
            levels = LEVEL * (1.0 + scatter * draw.standard_normal((self.move[-1] + 1, n)))
            change = scatter / SCATTER * OFFSET_SHARE * LEVEL / np.sqrt(2.0) * draw.standard_normal(n)
            torque = self.torques[kind == "B"] + np.array(limits) * (levels[self.move] * self.friction + change)
            torque *= 1.0 + DRIFT / 3600.0 * (t[:, None] - 0.5 * (len(order) * length - BETWEEN))
            made.append(Recording(t, self.motion.q, step * np.round(torque / step), None, kind, gain_sigma=0.0))
        return tuple([own for own in made if own.source == kind] for kind in "BA")


def predicted(robot: Robot, poses: Array) -> float:
    """Sigma of the mass [kg] by two recordings of poses, their approaches and constant torques as simulated."""
    zero, columns = np.zeros(poses.shape), payload_columns(robot)[6:]
    W, information = regressor_at(robot, columns, poses, zero, zero), np.zeros((4, 4))
    for j, joint in enumerate(robot.joints):  # 2 K approaches; the wrist's constant torques are free
        level = LEVEL * joint.limits.torque
        noise, change = SCATTER * level, OFFSET_SHARE * level if j < robot.n - 3 else np.inf
        mean, K = W[j].mean(axis=1), W.shape[2]
        information += (W[j] @ W[j].T - K * np.outer(mean, mean)) / noise**2
        information += np.outer(mean, mean) / (noise**2 / K + change**2)
    return float(np.sqrt(np.linalg.inv(information)[3, 3]))


@functools.cache
def arm(name: str, sides: tuple[float, ...] = (-1.0, 1.0)) -> Arm:
    """An arm with half of its rated payload, and the motion that reaches poses from these sides."""
    robot = with_stand_in(load_robot(name))
    sets = [random_points(robot, POSES, seed, 0.75) for seed in range(60)]
    poses = min(sets, key=lambda own: predicted(robot, own))
    points, durations = [poses[0] - APART], list[float]()
    speed, strong = 0.5 * np.array([(x.limits.speed, x.limits.acceleration) for x in robot.joints]).T
    for pose in poses:
        for side in sides:
            for point, least in ((pose + side * APART, 1.0), (pose, 1.0), (pose, HOLD)):
                step = np.array([point - points[-1]])
                durations.append(max(quickest(step, speed, strong)[0] if step.any() else 0.0, least))
                points.append(point)
    motion = ViaPoints(np.array(points), np.array(durations)).motion(robot.processing.rate or 250.0)
    load, com = 0.5 * robot.rated_payload, [0.02, -0.01, 0.08]
    body = InertialParameters.from_com(load, com, 0.002 * load * np.eye(3))
    rubs = {name: 0.0 if name[:2] in ("FS", "FL") else value for name, value in robot.parameters.items()}
    bare, loaded = (Simulator(robot).measure(motion, own, rubs).torque for own in (None, body))
    state = np.zeros(motion.q.shape)
    for k, step in enumerate(np.diff(motion.q, axis=0) / PRESLIDING, 1):
        state[k] = np.clip(state[k - 1] + step, -1.0, 1.0)
    starts = np.diff((np.abs(motion.qd) > 1e-9).any(axis=1).astype(int), prepend=0) > 0
    return Arm(robot, body, motion, (bare, loaded), state, np.cumsum(starts), predicted(robot, poses))


def weighed(name: str, order: str, seed: int, scatter: float = SCATTER) -> Array:
    """Error of the mass, its sigma as told and the ends of its interval less the truth, in % of the mass."""
    own = arm(name)
    loaded, unloaded = own.recordings(order, seed, scatter)
    result, mass = estimation.weigh_at_rest(own.robot, loaded, unloaded), own.payload.mass
    sigma = result.working.model.sigma[result.working.model.names.index("M_L")]
    return 100.0 / mass * np.array([result.mass.value - mass, sigma, *(result.mass.interval95 - mass)])


def seen(name: str, seeds: int) -> list[list[str]]:
    """Rows of the table, for two recordings and for four."""
    rows, biases = [], [weighed(name, order, 0, scatter=0.0)[0] for order in ("AB", "ABBA")]
    for order, bias, least in zip(("AB", "ABBA"), biases, ("", f"<= {abs(biases[0]) / 5.0:.3f}"), strict=True):
        runs = np.array([weighed(name, order, seed) for seed in range(seeds)])
        error, sigma = rms(runs[:, 0]), 100.0 * arm(name).sigma / arm(name).payload.mass * np.sqrt(2.0 / len(order))
        numbers = [f"{x:.2f}" for x in (error / sigma, error, sigma, np.median(runs[:, 1]))]
        hits = f"{100.0 * held(runs[:, 2:], np.zeros(1)).mean():.0f}"
        rows.append([f"{name} {order}", "<= 1.3", *numbers, "92 to 99", hits, least, f"{bias:+.3f}"])
    return rows


def main() -> None:
    arguments = options(__doc__, arms=tuple(robot_names()), seeds=40, jobs=1)
    rows = each(functools.partial(seen, seeds=arguments.seeds), list(arguments.arms), arguments.jobs)
    more = ("rms", "predicted", "told", "intervals, asked", "hold", "bias by drift, asked", "seen")
    title = f"Mass at rest, {arguments.seeds} seeds, % of half the rated payload: rms over the predicted sigma"
    show(title, [row for both in rows for row in both], *more)


if __name__ == "__main__":
    main()
