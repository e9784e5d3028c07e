"""A constraint of one's own, in CVXPY: a tool that is symmetric about the axis of the flange, and not long."""

import cvxpy
import numpy as np
from dynident import InertialParameters, Simulator, load_robot, payload_problem, random_via_points
from dynident.estimation import PAYLOAD, Settings, build_constrained, payload_estimate, solve_constrained
from dynident.trajectories import RX90_NOISE

robot = load_robot("rx90")
body = InertialParameters.from_com(7.025, [0.0, 0.0, 0.143], [[0.018, 0, 0], [0, 0.018, 0], [0, 0, 0.035]])
simulator = Simulator(robot)
motion = random_via_points(robot, count=14, seed=2).motion(rate=250.0)
unloaded = [simulator.record(motion, None, RX90_NOISE, seed=[2, 0])]
loaded = [simulator.record(motion, body, RX90_NOISE, seed=[2, 1])]
free = payload_estimate(payload_problem(robot, loaded, unloaded, settings=Settings(robust=False)), 4).estimate

# The same problem as solve_constrained's, not solved yet: the parameters and the pseudo-inertia are expressions.
built, ten, pseudo_inertia = build_constrained(free)
x = {name: ten[k] for k, name in enumerate(PAYLOAD)}
symmetric = [x["XX_L"] == x["YY_L"], *(x[f"{name}_L"] == 0 for name in ("XY", "XZ", "YZ", "MX", "MY"))]
reach = [x["MZ_L"] <= 0.25 * x["M_L"]]  # the centre of mass is at most 250 mm from the flange
problem = cvxpy.Problem(built.objective, [*built.constraints, *symmetric, *reach])
problem.solve(solver=cvxpy.CLARABEL)

plain = solve_constrained(free)
print(" " * 9, "  ".join(f"{name:>7s}" for name in PAYLOAD))
rows = {"truth": body.vector, "free": free.values, "exists": plain.values, "symmetric": ten.value}
for title, values in rows.items():
    print(f"{title:9s}", "  ".join(f"{value:7.4f}" for value in values))
print(f"chi2 rises by {plain.chi2_rise:.2f} for a body that exists, by {problem.value**2:.2f} for a symmetric one")
print("smallest eigenvalue of the pseudo-inertia:", f"{np.linalg.eigvalsh(pseudo_inertia.value)[0]:.1e}")
