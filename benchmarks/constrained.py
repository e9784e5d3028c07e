"""Constrained estimates: time after the reduction, and that of CVXPY on all rows.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/constrained.py [--repeat 200]

Simulated RX90 with the paper's payload and noise as behind Table 2: 63,000 equations [W_L Y] of method 3, and the
robot alone. Timed from an ``Estimate`` to the repaired result.
"""

import cvxpy
import numpy as np
from dynident.apps.commands.demo import PAYLOAD as PAPER_PAYLOAD
from dynident.benchmarks.shared import median_ms, options, show
from dynident.common.arrays import Array
from dynident.estimation import PAYLOAD, Estimate, solve_constrained
from dynident.estimation.equations.observer import Observer
from dynident.estimation.equations.reduction import reduced_measurement
from dynident.estimation.fit.least_squares import weighted
from dynident.estimation.possible.constraints import PSEUDO_INERTIA
from dynident.estimation.possible.prior import robot_prior, solve_constrained_prior
from dynident.estimation.possible.robot import solve_constrained_base
from dynident.model import Motion, Processing, base_parameters, load_robot, payload_regressor
from dynident.model.kernel.kernel import Kernel
from dynident.model.motion import Measurement
from dynident.model.regressors import payload_columns
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points

SAMPLES = 10_500


def measured() -> tuple[Simulator, Measurement, Measurement]:
    """The difference of the torques with and without payload, and the torques without; joined trajectories."""
    simulator = Simulator(load_robot("rx90"))
    draw = np.random.default_rng(0)
    motion = random_via_points(simulator.robot, 60, 0).motion(250.0)
    assert len(motion.t) >= SAMPLES
    motion = Motion(*(values[:SAMPLES] for values in (motion.t, motion.q, motion.qd, motion.qdd)))
    noise = np.array(RX90_NOISE) * draw.standard_normal((2, SAMPLES, 6)) / np.sqrt(10.0)
    bare = simulator.measure(motion).torque + noise[0]
    loaded = simulator.measure(motion, PAPER_PAYLOAD).torque + noise[1]
    return simulator, Measurement(motion, loaded - bare), Measurement(motion, bare)


def all_rows(simulator: Simulator, data: Measurement) -> tuple[Array, Array]:
    """W_L (63,000 x 10) and Y, row after row."""
    kernel = Kernel(payload_regressor(simulator.robot))
    W = np.zeros((simulator.robot.n, SAMPLES, 10))
    W[kernel.rows, :, kernel.columns] = kernel(data.motion.q, data.motion.qd, data.motion.qdd)
    return W.reshape(-1, 10), np.asarray(data.torque.T.ravel())


def naive(W: Array, Y: Array, estimate: Estimate) -> Array:
    """A first attempt in CVXPY: weighted squares of all rows, pseudo-inertia positive semidefinite."""
    weight = np.repeat(estimate.weights, SAMPLES)
    x = cvxpy.Variable(10)
    J = sum(x[k] * PSEUDO_INERTIA[k] for k in range(10))
    squares = cvxpy.sum_squares(cvxpy.multiply(weight, W @ x - Y))
    cvxpy.Problem(cvxpy.Minimize(squares), [J >> 0]).solve(solver="CLARABEL")
    return np.asarray(x.value)


def main() -> None:
    """Print the figures beside what is asked."""
    repeat = options(__doc__, repeat=200).repeat
    simulator, difference, bare = measured()
    robot, base = simulator.robot, base_parameters(simulator.robot)

    estimate = weighted(
        reduced_measurement(Observer(robot, payload_columns(robot), PAYLOAD), difference, Processing())
    )
    result = solve_constrained(estimate)
    ours = median_ms(lambda: solve_constrained(estimate), repeat)
    W, Y = all_rows(simulator, difference)
    theirs = median_ms(lambda: naive(W, Y, estimate), 3)
    apart = np.abs((naive(W, Y, estimate) - result.values) / estimate.sigma).max()

    estimate_base = weighted(reduced_measurement(Observer(robot, base.columns), bare, Processing()))
    whole, prior = solve_constrained_base(robot, base, estimate_base), robot_prior(robot)
    took = median_ms(lambda: solve_constrained_base(robot, base, estimate_base), max(repeat // 5, 3))
    near = solve_constrained_prior(robot, base, estimate_base, prior)
    longer = median_ms(lambda: solve_constrained_prior(robot, base, estimate_base, prior), max(repeat // 20, 3))
    rows = [
        ["payload, chi2 rise", "", f"{result.chi2_rise:.3g}"],
        ["payload, after the reduction [ms]", "<= 1", f"{ours:.2f}"],
        [f"CVXPY on all {len(Y)} rows, times as long", ">= 20", f"{theirs / ours:.0f}"],
        ["largest difference [sigma] (squares are less accurate than the norm)", "", f"{apart:.1e}"],
        [f"robot, {len(base.columns)} base parameters, chi2 rise", "", f"{whole.chi2_rise:.3g}"],
        ["robot, after the reduction [ms]", "<= 20", f"{took:.1f}"],
        ["nearest to a prior, base gauge included [ms]", "", f"{longer:.0f}"],
        ["nearest to a prior, chi2 above the robot's", "", f"{near.chi2_rise - near.nearest.chi2_rise:.6f}"],
    ]
    show(f"Constrained estimates: payload {result.status}, robot {whole.status}", rows)


if __name__ == "__main__":
    main()
