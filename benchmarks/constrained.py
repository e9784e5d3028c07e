"""Constrained estimates: time after the reduction.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/constrained.py [--repeat 200]

Simulated RX90 with the paper's payload and noise as behind Table 2, 18 motions: payload by method 3, and the robot
alone. Timed from an ``Estimate`` to the repaired result.
"""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from dynident.benchmarks.coverage import repeated_problem
from dynident.benchmarks.shared import options, show
from dynident.estimation import payload_estimate, solve_constrained
from dynident.estimation.possible.prior import robot_prior, solve_constrained_prior
from dynident.estimation.possible.robot import solve_constrained_base


def timed(solve: Callable[[], Any], repeat: int) -> tuple[Any, float]:
    """Its result, and the median processor time [ms] after this one call."""
    result, times = solve(), []
    for _ in range(repeat):
        begun = time.process_time()
        solve()
        times.append(time.process_time() - begun)
    return result, 1e3 * float(np.median(times))


def main() -> None:
    repeat = options(__doc__, repeat=200).repeat
    problem, _ = repeated_problem("disc", 0.0, 18, 4)
    robot, base, free, known = problem.robot, problem.base, payload_estimate(problem, 3).estimate, problem.bare
    assert known is not None
    prior = robot_prior(robot)
    result, ours = timed(lambda: solve_constrained(free), repeat)
    whole, took = timed(lambda: solve_constrained_base(robot, base, known), max(repeat // 5, 3))
    near, longer = timed(lambda: solve_constrained_prior(robot, base, known, prior), max(repeat // 20, 3))
    rows = [
        ["payload, chi2 rise", "", f"{result.chi2_rise:.3g}"],
        ["payload, after the reduction [ms]", "<= 1", f"{ours:.2f}"],
        [f"robot, {len(base.columns)} base parameters, chi2 rise", "", f"{whole.chi2_rise:.3g}"],
        ["robot, after the reduction [ms]", "<= 20", f"{took:.1f}"],
        ["nearest to a prior, base gauge included [ms]", "", f"{longer:.0f}"],
        ["nearest to a prior, chi2 above the robot's", "", f"{near.chi2_rise - near.nearest.chi2_rise:.6f}"],
    ]
    show(f"Constrained estimates: payload {result.status}, robot {whole.status}", rows)


if __name__ == "__main__":
    main()
