"""Exciting motions by design, beside a random one: what each would teach, and how near it comes to the limits."""

import numpy as np
from dynident import load_robot, random_via_points
from dynident.trajectories import FourierShape, Goal, Score, ViaPointShape, build_design, score_motion, solve_design

robot = load_robot("rx90")


def told(title: str, score: Score) -> None:
    """One line about a motion; sigma for 1 N·m of torque noise and 100 independent samples a second."""
    learnt = score.learnt
    worst = max(learnt.sigma.values())
    print(
        f"{title}: {score.duration:.1f} s, condition number {learnt.condition_number:.1f} "
        f"({learnt.condition_number_scaled:.2f} scaled), largest sigma {worst:.3f}, limits kept: {score.feasible}"
    )


# Smallest condition number of 14 via points, as controllers run them.
problem = build_design(robot, ViaPointShape(count=14), Goal("cond"))
design = solve_design(problem, seed=1, starts=1)
told("designed via points", design.score)
told("random via points", score_motion(problem, random_via_points(robot, count=14, seed=1).motion(rate=250.0)))

# Most information in ten seconds; add torque limits where the drives are weak.
series = build_design(robot, FourierShape(harmonics=5, duration=10.0), Goal("d"))
fast = solve_design(series, seed=1, starts=1)
told("designed Fourier series", fast.score)
for limit in fast.score.limits:
    print("  ", limit)

motion = design.motion(rate=250.0)
table = np.column_stack([motion.t, motion.q, motion.qd, motion.qdd])
print(f"to be run: {len(table)} rows of t, q, qd, qdd")
