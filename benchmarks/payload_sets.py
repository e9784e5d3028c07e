"""Motions that hold for every payload in bounds: violations, tightness, what safety costs.

    python benchmarks/payload_sets.py [--arms ur10e,..] [--poses 1] [--share 0.5] [--lowered]

For each arm and pose: the motion near the pose with torque limits for every body up to a share of the rated payload
in a ball at the flange, against the one without payload. Bodies drawn and the extreme ones are checked on another
grid by the arm's own regressor. ``--lowered``: torque limits are 85 % of what the motion without payload needs
with its worst body, yet 15 % above what holds it at rest. Where no torque limit is active a run counts in nothing
but the violations.
"""

import argparse
import time
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from dynident.common.errors import InputError
from dynident.model import InertialParameters, Robot, load_robot, robot_names, stand_in
from dynident.tests.trajectories.bodies import drawn_bodies, drawn_shares, worst_shares
from dynident.trajectories import (
    DesignProblem,
    JointBounds,
    Loads,
    NearGoal,
    NearShape,
    PayloadSet,
    build_design,
    solve_design,
)
from dynident.trajectories.design import check_held, holding_torques

BODIES, RATE, DURATION = 10_000, 100.0, 4.0
RADIUS, REACH = 0.15, 0.1  # m: of the ball, and of its centre before the flange
ACTIVE = 0.01  # of a limit: what is nearer is active


class Run(NamedTuple):
    """What was seen of one arm in one pose."""

    violations: int
    reached: float
    active: bool
    sigma_ratio: float
    outside: bool
    cpu: tuple[float, float]


def main() -> None:
    """Print asked and seen."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--arms", default=",".join(robot_names()))
    parser.add_argument("--poses", type=int, default=1)
    parser.add_argument("--share", type=float, default=0.5, help="of the rated payload")
    parser.add_argument("--lowered", action="store_true", help="torque limits until one is active")
    asked, runs = parser.parse_args(), []
    begun = time.process_time()
    for name in asked.arms.split(","):
        robot = stand_in.rehearsed(load_robot(name))
        for seed in range(asked.poses):
            run = measured(robot, asked.share, seed, asked.lowered)
            runs.append(run)
            print(
                f"{name:12} {run.violations} violations, reaches {100 * run.reached:.2f} % of a limit, "
                f"{'active' if run.active else 'not active'}, sigma of the mass {run.sigma_ratio:.2f} times, "
                f"outside found: {run.outside}, CPU {run.cpu[0]:.1f} s (unsafe {run.cpu[1]:.1f} s)",
                flush=True,
            )
    active = [run for run in runs if run.active]
    print(f"\n{len(runs)} runs at {asked.share:g} of the rating, {len(active)} with an active torque limit")
    print(f"violations: asked 0, seen {sum(run.violations for run in runs)} of {BODIES} bodies and the worst, each")
    if active:
        print(f"tight: asked >= 99 %, seen {100 * min(run.reached for run in active):.2f} % at least where active")
        ratios = [run.sigma_ratio for run in active]
        print(f"sigma of the mass: median asked <= 1.3, seen {np.median(ratios):.2f}, at most {max(ratios):.2f}")
    print(
        f"body outside the set that breaks a limit: found in {sum(run.outside for run in active)} of {len(active)}"
    )
    safe, unsafe = (np.median([run.cpu[k] for run in runs]) for k in (0, 1))
    print(
        f"CPU of a search: {safe:.1f} s, {unsafe:.1f} s without payloads; all {time.process_time() - begun:.0f} s"
    )


def measured(robot: Robot, share: float, seed: int, lowered: bool) -> Run:
    """One arm in one pose in which every payload can be held."""
    draw = np.random.default_rng(seed)
    rated = robot.rated_payload if np.isfinite(robot.rated_payload) else 5.0
    payloads = PayloadSet.within(share * rated, RADIUS, (0.0, 0.0, REACH))
    in_link = payloads.seen_from(robot.flange)
    problem, shape, goal = held_problem(robot, in_link, draw)
    free = build_design(robot, shape, goal, bounds=problem.bounds, loads=Loads(robot.parameters))
    unsafe = solve_design(free, seed=seed, starts=1)
    if lowered:
        needed = worst_shares(robot, unsafe.motion(RATE), in_link, np.ones(robot.n))
        least = np.maximum(0.85 * needed, 1.15 * holding_torques(problem, shape.poses))
        bounds = replace(problem.bounds, torque=np.minimum(problem.bounds.torque, least))
        problem = build_design(robot, shape, goal, bounds=bounds, loads=Loads(robot.parameters, in_link))
    safe = solve_design(problem, seed=seed, starts=1)
    sigma = [goal.predicted(robot, design.plan, shape.joints).mass for design in (safe, unsafe)]
    motion, limits = safe.motion(RATE), problem.bounds.torque
    drawn = drawn_shares(robot, motion, drawn_bodies(in_link, BODIES, draw), limits)
    most = float(worst_shares(robot, motion, in_link, limits).max())
    wider = PayloadSet(1.1 * in_link.mass, in_link.centre, 1.1 * in_link.axes)
    room = min(check.room for check in safe.score.limits if check.name.startswith("torque"))
    outside = bool(worst_shares(robot, motion, wider, limits).max() > 1.0)
    violations = int((drawn > 1.0).any(axis=0).sum()) + int(most > 1.0)
    return Run(violations, most, room < ACTIVE, sigma[0] / sigma[1], outside, (safe.cpu_s, unsafe.cpu_s))


def held_problem(
    robot: Robot, payloads: PayloadSet, draw: np.random.Generator
) -> tuple[DesignProblem, NearShape, NearGoal]:
    """About the first random pose that shows the mass and holds every payload at rest."""
    bounds = JointBounds.of(robot)
    expected = InertialParameters.from_com(payloads.mass, [0.0, 0.0, REACH], 0.003 * payloads.mass * np.eye(3))
    goal = NearGoal(0.007 * bounds.torque, 10.0, expected)
    joints = tuple(range(2, robot.n + 1))
    for _ in range(200):
        pose = bounds.middle + 0.6 * bounds.half * draw.uniform(-1.0, 1.0, robot.n)
        shape = NearShape(pose[None], joints, np.full(len(joints), np.radians(25.0)), DURATION)
        if not shape.visibility(robot).mass_visible:
            continue
        try:
            problem = build_design(robot, shape, goal, bounds=bounds, loads=Loads(robot.parameters, payloads))
            check_held(problem, shape.poses)
        except InputError:
            continue
        return problem, shape, goal
    raise InputError(f"{robot.name}: no pose in 200 holds every payload")


if __name__ == "__main__":
    main()
