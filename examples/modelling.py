"""A robot's dynamics as CasADi functions: base parameters, matrices, a use of one's own, and C for a controller."""

from tempfile import TemporaryDirectory
from typing import Any

import casadi as ca
import numpy as np
from dynident import base_parameters, load_robot
from dynident.model import (
    closed_form_base_parameters,
    forward_dynamics,
    generate_code,
    gravity,
    inverse_dynamics,
    mass_matrix,
)

robot = load_robot("rx90")

# Which parameters have an effect of their own, and what each groups: by rank and by rules.
rules = closed_form_base_parameters(robot)
print(f"{robot.name}: {len(robot.standard)} standard, {len(rules.columns)} base parameters")
rank = base_parameters(robot)
print("the same by rank:", rules.columns == rank.columns and np.allclose(rules.grouping, rank.grouping))
for line in rules.groupings(symbolic=True)[:4]:
    print("  ", line)

# The dynamics with the description's own parameters.
chi = robot.chi()
q, qd, qdd = np.full(6, 0.3), np.full(6, 0.5), np.full(6, 1.0)
torque = np.array(inverse_dynamics(robot)(q, qd, qdd, chi)).ravel()
acceleration = np.array(forward_dynamics(robot)(q, qd, torque, chi)).ravel()
print("torque [N·m]:", torque.round(2))
print("back to the accelerations:", np.abs(acceleration - qdd).max() < 1e-9)
print("eigenvalues of the mass matrix:", np.linalg.eigvalsh(np.array(mass_matrix(robot)(q, chi))).round(2))

# They are symbolic functions: here the pose of joints 2 and 3 in which the shoulder carries most.
angles = ca.SX.sym("angles", 2)
pose = ca.vertcat(0.0, angles, np.zeros(3))
weight = gravity(robot)(pose, chi)[1]
quiet: dict[str, Any] = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": 0}
solver = ca.nlpsol("heaviest", "ipopt", {"x": angles, "f": -(weight**2)}, quiet)
solution = solver(x0=[0.1, 1.0])
worst = np.degrees(np.array(solution["x"])).ravel().round(1)
print(f"heaviest pose: {worst} deg, {abs(float(solution['f'])) ** 0.5:.1f} N·m on joint 2")

with TemporaryDirectory() as folder:
    for path in generate_code(robot, "base_regressor", folder):
        print(f"{path.name}: {len(path.read_text(encoding='utf-8').splitlines())} lines of C")
