"""A payload weighed standing still in designed poses: stiction, drift and coarse currents simulated on every arm.

Friction at rest is the Coulomb level of the approach, another one each time, taken up in half a millirad.
Run: OPENBLAS_NUM_THREADS=1 python benchmarks/static.py [--arms ur10e,..] [--seeds 40] [--jobs 1]
"""

import functools
from typing import NamedTuple

import numpy as np
from dynident import estimation
from dynident.benchmarks.shared import each, held, options, rms, show
from dynident.common.arrays import Array
from dynident.estimation.payload.short_motion import OFFSET_SHARE
from dynident.model import InertialParameters, Motion, Recording, Robot, load_robot, robot_names, stand_in
from dynident.tests.trajectories.safe_runs import RestCase, rest_case
from dynident.trajectories import Simulator, solve_design
from dynident.trajectories.design.limits import excess
from dynident.trajectories.motions.via_points import ViaPoints

LEVEL, SCATTER, PRESLIDING = 0.1, 0.05, 5e-4
"""Coulomb friction over the torque limit, its scatter over itself, and the move [rad] that takes it up."""
DRIFT, QUANTUM, BETWEEN = 0.02, 1e-3, 90.0  # per hour; of the torque limit; s from one recording to the next
POSES, SETS = 8, 60  # of a motion; random ones, of which the best counts


class Arm(NamedTuple):
    """An arm, its payload and motion, exact torques [N·m] without and with it, friction's state from -1 to 1."""

    robot: Robot
    payload: InertialParameters
    motion: Motion
    torques: tuple[Array, Array]
    friction: Array
    move: Array  # number of the move that each sample belongs to
    sigma: float  # of the mass by two recordings as the plan predicts it [kg]

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
            torque = step * np.round(torque / step + draw.standard_normal(torque.shape))  # noise of a step besides
            made.append(Recording(t, self.motion.q, torque, None, kind, gain_sigma=0.0))
        return tuple([own for own in made if own.source == kind] for kind in "BA")


@functools.cache
def arm(name: str, starts: int | None = None, both_sides: bool = True) -> Arm:
    """An arm with half of its rated payload, on the motion that ``near --static`` plans; or from below only."""
    robot = stand_in.rehearsed(load_robot(name))
    case = rest_case(robot, POSES)
    plan = solve_design(case.problem, seed=0, starts=starts).plan
    assert isinstance(plan, ViaPoints)
    sigma = case.goal.predicted(robot, plan, case.shape.joints).mass
    if not both_sides:
        points = plan.points.copy()
        points[4::6] = points[1:-1:6]
        plan = ViaPoints(points, plan.durations)
    motion, load = plan.motion(robot.processing.rate or 250.0), case.goal.expected.mass
    body = InertialParameters.from_com(load, [0.02, -0.01, 0.08], 0.002 * load * np.eye(3))
    rubs = {name: 0.0 if name[:2] in ("FS", "FL") else value for name, value in robot.parameters.items()}
    bare, loaded = (Simulator(robot).measure(motion, own, rubs).torque for own in (None, body))
    state = np.zeros(motion.q.shape)
    for k, step in enumerate(np.diff(motion.q, axis=0) / PRESLIDING, 1):
        state[k] = np.clip(state[k - 1] + step, -1.0, 1.0)
    begins = np.diff((np.abs(motion.qd) > 1e-9).any(axis=1).astype(int), prepend=0) > 0
    return Arm(robot, body, motion, (bare, loaded), state, np.cumsum(begins), sigma)


def best_of_random(case: RestCase) -> float:
    """Sigma of the mass [kg] by the best of sets of random poses in which the arm can stand."""
    draw, kept, limits = np.random.default_rng(0), list[Array](), case.problem.of_kind("torque", "clearance")
    while len(kept) < POSES * SETS:
        poses = case.bounds.middle + 0.8 * case.bounds.half * draw.uniform(-1.0, 1.0, (POSES, case.robot.n))
        state = case.problem.at_rest(poses)
        fine = [excess(limit, limit.values(state)).max(axis=1) <= 0.0 for limit in limits]
        kept += list(poses[np.all(fine, axis=0)])
    return float(min(case.sigma(own)[3] for own in np.array(kept[: POSES * SETS]).reshape(SETS, POSES, -1)))


def weighed(own: Arm, order: str, seed: int, scatter: float = SCATTER) -> Array:
    """Error of the mass, its sigma as told and the ends of its interval less the truth, in % of the mass."""
    loaded, unloaded = own.recordings(order, seed, scatter)
    result, mass = estimation.weigh_at_rest(own.robot, loaded, unloaded), own.payload.mass
    sigma = result.working.model.sigma[result.working.model.names.index("M_L")]
    return 100.0 / mass * np.array([result.mass.value - mass, sigma, *(result.mass.interval95 - mass)])


def seen(name: str, seeds: int) -> list[list[str]]:
    """Rows of the table, for two recordings and for four."""
    own, rows = arm(name), list[list[str]]()
    random = best_of_random(rest_case(own.robot, POSES))
    biases = [weighed(own, order, 0, scatter=0.0)[0] for order in ("AB", "ABBA")]
    for order, bias, least in zip(("AB", "ABBA"), biases, ("", f"<= {abs(biases[0]) / 5.0:.3f}"), strict=True):
        runs = np.array([weighed(own, order, seed) for seed in range(seeds)])
        error, sigma = rms(runs[:, 0]), 100.0 * own.sigma / own.payload.mass * np.sqrt(2.0 / len(order))
        numbers = [f"{x:.2f}" for x in (error / sigma, error, sigma, np.median(runs[:, 1]), own.sigma / random)]
        hits = f"{100.0 * held(runs[:, 2:], np.zeros(1)).mean():.0f}"
        rows.append([f"{name} {order}", "<= 1.3", *numbers, "92 to 99", hits, least, f"{bias:+.3f}"])
    return rows


def main() -> None:
    arguments = options(__doc__, arms=tuple(robot_names()), seeds=40, jobs=1)
    rows = each(functools.partial(seen, seeds=arguments.seeds), list(arguments.arms), arguments.jobs)
    more = ("rms", "predicted", "told", "of random", "intervals, asked", "hold", "bias by drift, asked", "seen")
    title = f"Mass at rest, {arguments.seeds} seeds, % of half the rated payload: rms over the predicted sigma"
    show(title, [row for both in rows for row in both], *more)


if __name__ == "__main__":
    main()
