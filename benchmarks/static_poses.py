"""Weighing at rest: sigma of the mass by designed poses, and by the best of sets of random ones, over all arms.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/static_poses.py [--arms ur10e,..] [--poses 8] [--sets 60] [--jobs 1]

All joints move, over their whole range, with half of the rated payload; stiction as `near --static` assumes it, a
constant torque of each joint unknown. Random poses keep position limits (80 % of the range), torque limits at rest
and clear of everything, as designed ones do. In % of the mass; ``bare``: the random sets' were no constant torque
unknown.
"""

from functools import partial
from typing import NamedTuple

import numpy as np
from dynident.benchmarks.shared import each, options, show
from dynident.common.arrays import Array
from dynident.model import load_robot, robot_names, stand_in
from dynident.tests.trajectories.safe_runs import RestCase, rest_case
from dynident.trajectories import solve_design
from dynident.trajectories.design.limits import excess


class Run(NamedTuple):
    """Sigma of the mass by both [% of it], of the centre by design [mm], and the motion [s]."""

    random: float
    bare: float
    designed: float
    com: float
    duration: float
    cpu: float


def held_poses(case: RestCase, count: int, draw: np.random.Generator) -> Array:
    """Random poses in which the arm can stand."""
    kept: list[Array] = []
    limits = case.problem.of_kind("torque", "clearance")
    while len(kept) < count:
        poses = case.bounds.middle + 0.8 * case.bounds.half * draw.uniform(-1.0, 1.0, (count, case.robot.n))
        state = case.problem.at_rest(poses)
        kept += list(
            poses[np.all([excess(limit, limit.values(state)).max(axis=1) <= 0.0 for limit in limits], axis=0)]
        )
    return np.array(kept[:count])


def measured(poses: int, sets: int, name: str) -> Run:
    """One arm."""
    robot = stand_in.rehearsed(load_robot(name))
    case, draw = rest_case(robot, poses), np.random.default_rng(0)
    share = 100.0 / case.goal.expected.mass
    drawn = held_poses(case, poses * sets, draw).reshape(sets, poses, -1)
    random, bare = (min(case.sigma(one, free)[3] for one in drawn) for free in (True, False))
    design = solve_design(case.problem, seed=0)
    spread = case.goal.predicted(robot, design.plan, case.shape.joints)
    assert design.feasible
    return Run(
        share * random, share * bare, share * spread.mass, 1e3 * max(spread.com), design.plan.duration, design.cpu_s
    )


def main() -> None:
    arguments = options(__doc__, arms=",".join(robot_names()), poses=8, sets=60, jobs=1)
    names = arguments.arms.split(",")
    runs = each(partial(measured, arguments.poses, arguments.sets), names, arguments.jobs)
    rows = [
        (name, f"{run.random:.2f}", f"{run.bare:.2f}", f"{run.designed:.2f}", f"{run.designed / run.random:.2f}",
         f"{run.designed / run.bare:.2f}", f"{run.com:.1f}", f"{run.duration:.0f}", f"{run.cpu:.1f}")
        for name, run in zip(names, runs, strict=True)
    ]  # fmt: skip
    show("", rows, "bare", "designed", "of random", "of bare", "com mm", "motion s", "CPU s", asked=False)
    for kind in ("random", "bare"):
        ratios = [run.designed / getattr(run, kind) for run in runs]
        mean = float(np.exp(np.mean(np.log(ratios))))
        print(f"designed over {kind}: geometric mean {mean:.2f} (asked .8), most {max(ratios):.2f}")


if __name__ == "__main__":
    main()
