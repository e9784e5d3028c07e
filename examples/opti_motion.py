"""A motion of one's own by CasADi's Opti: the most information on a payload, within speed and torque limits."""

from typing import Any

import casadi as ca
import numpy as np
from dynident import load_robot
from dynident.model import inverse_dynamics, payload_regressor, with_stand_in

robot = with_stand_in(load_robot("ur5e"))  # its links, friction and torque limits are assumed
N, harmonics, duration = 40, 3, 6.0
speed, torque = (np.array([getattr(joint.limits, name) for joint in robot.joints]) for name in ("speed", "torque"))

# Sums of 1 - cos and sin terms that start and end at one pose; rows for q, qd and qdd at N times.
t, w = np.linspace(0.0, duration, N), 2.0 * np.pi / duration * np.arange(1, harmonics + 1)[:, None]
q_rows = np.vstack([1.0 - np.cos(w * t), np.sin(w * t)])
qd_rows = np.vstack([w * np.sin(w * t), w * np.cos(w * t)])
qdd_rows = np.vstack([w**2 * np.cos(w * t), -(w**2) * np.sin(w * t)])

opti = ca.Opti()
amplitude = opti.variable(robot.n, 2 * harmonics)
start = ca.DM([0.0, -1.2, 1.5, 0.0, 1.0, 0.0])
q = ca.repmat(start, 1, N) + amplitude @ q_rows
qd, qdd = amplitude @ qd_rows, amplitude @ qdd_rows
opti.subject_to(opti.bounded(-1.0, amplitude @ q_rows, 1.0))
opti.subject_to(opti.bounded(-ca.repmat(speed, 1, N), qd, ca.repmat(speed, 1, N)))
needed = inverse_dynamics(robot, smooth=0.05).map(N)(q, qd, qdd, ca.repmat(ca.DM(robot.chi()), 1, N))
opti.subject_to(opti.bounded(-0.8, needed / ca.repmat(torque, 1, N), 0.8))

# log det of Phi' Phi, of columns in kg, kg 0.1 m and kg 0.01 m^2.
units = np.diag([0.01] * 6 + [0.1] * 3 + [1.0])
phi = payload_regressor(robot).map(N)(q, qd, qdd)
information = ca.MX.zeros(10, 10)
for k in range(N):
    own = phi[:, 10 * k : 10 * k + 10] @ units
    information += own.T @ own
M = ca.SX.sym("M", 10, 10)
log_det = ca.Function("log_det", [M], [2.0 * ca.sum1(ca.log(ca.diag(ca.chol(M))))])
opti.minimize(-log_det(information + 1e-9 * np.eye(10)))
opti.set_initial(amplitude, np.random.default_rng(0).uniform(-0.1, 0.1, amplitude.shape))
quiet: dict[str, Any] = {"print_level": 0, "sb": "yes", "max_iter": 60, "hessian_approximation": "limited-memory"}
opti.solver("ipopt", {"print_time": 0}, quiet)
before = opti.debug.value(log_det(information + 1e-9 * np.eye(10)), opti.initial())
opti.solve_limited()
after = opti.debug.value(log_det(information + 1e-9 * np.eye(10)))
largest = np.abs(opti.debug.value(needed) / torque[:, None]).max()
print(f"log det of the payload's information: {before:.1f} at the start, {after:.1f} found")
print(f"largest torque: {100.0 * largest:.0f} % of its limit")
