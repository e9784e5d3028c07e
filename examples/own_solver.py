"""A solver and a constraint of one's own: robust regression by hand, links with a known mass, and the payload."""

import cvxpy
import dynident as di
import numpy as np
from dynident.estimation import build_constrained_base

robot, body = di.load_robot("rx90"), di.InertialParameters.from_com(7.0, [0.0, 0.0, 0.14], [0.02, 0.02, 0.03])
arm, motion = di.Simulator(robot), di.random_via_points(robot, count=14, seed=2).motion(rate=250.0)
unloaded, loaded = ([arm.record(motion, load, di.RX90_NOISE, seed=[2, k])] for k, load in enumerate((None, body)))

W, Y, joint, t = di.equations(robot, unloaded)
base, weight = di.base_parameters(robot), np.ones(len(Y))
for _ in range(10):  # Huber's weights, and one over each joint's scatter
    chi = np.linalg.lstsq(weight[:, None] * W, weight * Y, rcond=None)[0]
    error = (Y - W @ chi) / np.array([np.std((Y - W @ chi)[joint == j]) for j in range(1, 7)])[joint - 1]
    weight = np.sqrt(np.minimum(1.0, 1.5 / np.abs(error))) * error / (Y - W @ chi)
own = di.Estimate.from_values(base.columns, chi, np.linalg.inv((weight[:, None] * W).T @ (weight[:, None] * W)))

problem, parameter, inertias = build_constrained_base(robot, base, own)
heavy = [parameter["M3"] == 15.0, cvxpy.trace(inertias[5]) <= 0.5]
problem = cvxpy.Problem(problem.objective, [*problem.constraints, *heavy])
problem.solve(solver=cvxpy.CLARABEL)
print(
    f"links that exist, the third of 15 kg: chi2 rises by {problem.value**2:.1f}, M2 {parameter['M2'].value:.1f} kg"
)
print(di.identify_payload(robot, loaded, known=own))
