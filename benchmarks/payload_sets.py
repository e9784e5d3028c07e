"""Motions that hold for every payload in bounds: violations, tightness, what safety costs.

    python benchmarks/payload_sets.py [--arms ur10e,..] [--poses 1] [--share 0.5] [--lowered]

For each arm and pose: the motion near the pose with torque limits for every body up to a share of the rated payload
in a ball at the flange, against the one without payload. Bodies drawn and the extreme ones are checked on another
grid by the arm's own regressor. ``--lowered``: torque limits are 85 % of what the motion without payload needs
with its worst body, yet 20 % above what its slow rehearsal needs. Where no torque limit is active a run counts in
nothing but the violations.
"""

import argparse
import time
from typing import NamedTuple

import numpy as np
from dynident.common.errors import InputError
from dynident.model import Robot, load_robot, robot_names, stand_in
from dynident.tests.trajectories.safe_runs import BODIES, Seen, held_case, seen_of
from dynident.trajectories import solve_design

DURATION = 4.0
ACTIVE = 0.01  # of a limit: what is nearer is active


class Run(NamedTuple):
    """What was seen of one arm in one pose."""

    seen: Seen
    active: bool
    sigma_ratio: float
    cpu: tuple[float, float]


def main() -> None:
    """Print asked and seen."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--arms", default=",".join(robot_names()))
    parser.add_argument("--poses", type=int, default=1)
    parser.add_argument("--share", type=float, default=0.5, help="of the rated payload")
    parser.add_argument("--lowered", action="store_true", help="torque limits until one is active")
    arguments, runs = parser.parse_args(), []
    begun = time.process_time()
    for name in arguments.arms.split(","):
        robot = stand_in.rehearsed(load_robot(name))
        for seed in range(arguments.poses):
            try:
                run = measured(robot, arguments.share, seed, arguments.lowered)
            except InputError as error:
                print(error, flush=True)
                continue
            runs.append(run)
            print(
                f"{name:12} {run.seen.violations} violations, reaches {100 * run.seen.reached:.2f} % of a limit, "
                f"{'active' if run.active else 'not active'}, sigma of the mass {run.sigma_ratio:.2f} times, "
                f"outside {100 * run.seen.outside:.0f} %, CPU {run.cpu[0]:.1f} s (unsafe {run.cpu[1]:.1f} s)",
                flush=True,
            )
    if runs:
        summary(runs, arguments.share)
    print(f"all: {time.process_time() - begun:.0f} s CPU")


def measured(robot: Robot, share: float, seed: int, lowered: bool) -> Run:
    """One arm in one pose in which every payload can be held.

    Raises:
        InputError: if there is no such pose, or no motion keeps the limits.
    """
    draw = np.random.default_rng(seed)
    case = held_case(robot, share, DURATION, draw)
    unsafe = solve_design(case.problem(None), seed=seed, starts=1)
    case = case.lowered(unsafe) if lowered else case
    safe = solve_design(case.problem(case.payloads), seed=seed, starts=1)
    if not safe.feasible:
        raise InputError(f"{robot.name}, pose {seed}: no motion keeps every limit")
    sigma = [case.goal.predicted(robot, design.plan, case.shape.joints).mass for design in (safe, unsafe)]
    room = min(check.room for check in safe.score.limits if check.name.startswith("torque"))
    return Run(seen_of(case, safe, draw), room < ACTIVE, sigma[0] / sigma[1], (safe.cpu_s, unsafe.cpu_s))


def summary(runs: list[Run], share: float) -> None:
    """Print asked and seen of all runs."""
    active = [run for run in runs if run.active]
    print(f"\n{len(runs)} runs at {share:g} of the rating, {len(active)} with an active torque limit")
    violations = sum(run.seen.violations for run in runs)
    print(f"violations: asked 0, seen {violations} of {BODIES} bodies and the worst, each")
    if active:
        print(f"tight: asked >= 99 %, seen {100 * min(run.seen.reached for run in active):.2f} % at least")
        ratios = [run.sigma_ratio for run in active]
        print(f"sigma of the mass: median asked <= 1.3, seen {np.median(ratios):.2f}, at most {max(ratios):.2f}")
    count = sum(run.seen.outside > 1.0 for run in active)
    print(f"body outside the set that breaks a limit: found in {count} of {len(active)}")
    safe, unsafe = (np.median([run.cpu[k] for run in runs]) for k in (0, 1))
    print(f"CPU of a search: {safe:.1f} s, {unsafe:.1f} s without payloads")


if __name__ == "__main__":
    main()
