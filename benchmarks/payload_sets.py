"""Motions that hold for every payload in bounds: violations, tightness, what safety costs.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/payload_sets.py [--arms ur10e,..] [--poses 1] [--share 0.5]
     [--lowered] [--jobs 2]

For each arm and pose: the motion near the pose with torque limits for every body up to a share of the rated payload
in a ball at the flange, against the one without payload. Bodies drawn and the extreme ones are checked on another
grid by the arm's own regressor. ``--lowered``: torque limits are 85 % of what the motion without payload needs
with its worst body, yet 20 % above what its slow rehearsal needs. Where no torque limit is active a run counts in
nothing but the violations.
"""

from functools import partial
from typing import NamedTuple

import numpy as np
from dynident.benchmarks.shared import each, options, show
from dynident.common.errors import InputError
from dynident.model import load_robot, robot_names, stand_in
from dynident.tests.trajectories.safe_runs import Seen, held_case, seen_of
from dynident.trajectories import solve_design

DURATION, ACTIVE = 4.0, 0.01  # s; of a limit: what is nearer is active


class Run(NamedTuple):
    """One arm in one pose: how near bodies come to limits, whether one is active, CPU of the searches."""

    seen: Seen
    active: bool
    sigma_ratio: float
    safe_cpu: float
    unsafe_cpu: float


def measured(share: float, lowered: bool, case: tuple[str, int]) -> Run | str:
    """One arm in one pose in which every payload can be held; or why there is none."""
    name, seed = case
    robot, draw = stand_in.rehearsed(load_robot(name)), np.random.default_rng(seed)
    try:
        held = held_case(robot, share, DURATION, draw)
        unsafe = solve_design(held.problem(None), seed=seed, starts=1)
        held = held.lowered(unsafe) if lowered else held
        safe = solve_design(held.problem(held.payloads), seed=seed, starts=1)
    except InputError as error:
        return str(error)
    if not safe.feasible:
        return f"{name}, pose {seed}: no motion keeps every limit"
    sigma = [held.goal.predicted(robot, design.plan, held.shape.joints).mass for design in (safe, unsafe)]
    room = min(check.room for check in safe.score.limits if check.name.startswith("torque"))
    return Run(seen_of(held, safe, draw), room < ACTIVE, sigma[0] / sigma[1], safe.cpu_s, unsafe.cpu_s)


def main() -> None:
    arguments = options(__doc__, arms=",".join(robot_names()), poses=1, share=0.5, lowered=False, jobs=2)
    cases = [(name, seed) for name in arguments.arms.split(",") for seed in range(arguments.poses)]
    done = each(partial(measured, arguments.share, arguments.lowered), cases, arguments.jobs)
    runs = [run for run in done if isinstance(run, Run)]
    for (name, seed), run in zip(cases, done, strict=True):
        print(run if isinstance(run, str) else f"{name}, pose {seed}: {run}")
    active = [run for run in runs if run.active]
    rows: list[list[object]] = [["bodies that break a limit", 0, sum(run.seen.violations for run in runs)]]
    rows += [
        [f"CPU of a search{words} [s]", "", f"{np.median([run[k] for run in runs]):.1f}"]
        for words, k in (("", 3), (", no payload", 4))
    ]
    if active:
        ratios, least = [run.sigma_ratio for run in active], 100 * min(run.seen.reached for run in active)
        rows += [
            ["worst body comes to at least", ">= 99 %", f"{least:.2f} %"],
            ["sigma of the mass, median (largest)", "<= 1.3", f"{np.median(ratios):.2f} ({max(ratios):.2f})"],
            ["a body outside the set breaks a limit", len(active), sum(run.seen.outside > 1.0 for run in active)],
        ]
    show(f"{len(runs)} runs at {arguments.share:g} of the rating, {len(active)} with an active torque limit", rows)


if __name__ == "__main__":
    main()
