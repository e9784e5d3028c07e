"""Constrained estimates: time after the reduction.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/constrained.py [--repeat 200]

Simulated RX90 with the paper's payload and noise as behind Table 2, 18 motions: payload by method 3, and the robot
alone. Timed from an ``Estimate`` to the repaired result.
"""

from dynident.benchmarks.coverage import repeated_problem
from dynident.benchmarks.shared import median_ms, options, show
from dynident.estimation import payload_estimate, solve_constrained
from dynident.estimation.possible.prior import robot_prior, solve_constrained_prior
from dynident.estimation.possible.robot import solve_constrained_base


def main() -> None:
    """Print the figures beside what is asked."""
    repeat = options(__doc__, repeat=200).repeat
    problem, _ = repeated_problem("disc", 0.0, 18, 4)
    robot, base, free, known = problem.robot, problem.base, payload_estimate(problem, 3).estimate, problem.bare
    assert known is not None
    result = solve_constrained(free)
    ours = median_ms(lambda: solve_constrained(free), repeat)
    whole, prior = solve_constrained_base(robot, base, known), robot_prior(robot)
    took = median_ms(lambda: solve_constrained_base(robot, base, known), max(repeat // 5, 3))
    near = solve_constrained_prior(robot, base, known, prior)
    longer = median_ms(lambda: solve_constrained_prior(robot, base, known, prior), max(repeat // 20, 3))
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
