"""The paper's method, from Newton-Euler to a payload that can exist, without the package; then compared with it.

To be read from top to bottom beside W. Khalil, M. Gautier, P. Lemoine, "Identification of the payload inertial
parameters of industrial manipulators": numbers in brackets are its equations, matrices have its letters.
"""

from typing import NamedTuple

import casadi as ca
import cvxpy as cp
import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, firwin, sosfiltfilt, upfirdn
from scipy.special import stdtrit

Array = NDArray[np.float64]

# --- The robot RX90: modified DH (Khalil and Kleinfinger), gravity along -z of frame 0 ---
D3 = RL4 = 0.45
alpha = [0.0, -np.pi / 2, 0.0, np.pi / 2, -np.pi / 2, np.pi / 2]
d, r = [0.0, 0.0, D3, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, RL4, 0.0, 0.0]

# The standard parameters (5), (6): ten of each link, its rotor, its friction; the friction of the coupling last.
TEN = ["XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M"]
standard = [f"{kind}{j}" for j in range(1, 7) for kind in (*TEN, "IA", "FS", "FV")] + ["FVM6", "FSM6"]
link_6 = [standard.index(f"{kind}6") for kind in TEN]  # a payload is a part of link 6: it has the same columns


def newton_euler(q: ca.SX, qd: ca.SX, qdd: ca.SX, chi: ca.SX) -> ca.SX:
    """Compute the torques of the links by the recursive algorithm of Newton and Euler (1)."""
    z = ca.SX([0, 0, 1])
    w, dw, a = ca.SX.zeros(3), ca.SX.zeros(3), 9.81 * z  # a base that accelerates upward feels like gravity
    links = []
    for j in range(6):  # from base to tip: speeds and accelerations, and what they cost in force and moment
        sin_a, cos_a, sin, cos = np.sin(alpha[j]).round(15), np.cos(alpha[j]).round(15), ca.sin(q[j]), ca.cos(q[j])
        rows = [[cos, -sin, 0], [cos_a * sin, cos_a * cos, -sin_a], [sin_a * sin, sin_a * cos, cos_a]]
        R = ca.vertcat(*(ca.horzcat(*row) for row in rows))  # axes of frame j in frame j-1
        P = ca.DM([d[j], -sin_a * r[j], cos_a * r[j]])  # origin of frame j in frame j-1
        a = R.T @ (a + ca.cross(dw, P) + ca.cross(w, ca.cross(w, P)))
        dw = R.T @ dw + ca.cross(R.T @ w, qd[j] * z) + qdd[j] * z
        w = R.T @ w + qd[j] * z
        XX, XY, XZ, YY, YZ, ZZ, MX, MY, MZ, M = ca.vertsplit(chi[13 * j : 13 * j + 10])
        J = ca.vertcat(ca.horzcat(XX, XY, XZ), ca.horzcat(XY, YY, YZ), ca.horzcat(XZ, YZ, ZZ))
        MS = ca.vertcat(MX, MY, MZ)
        force = M * a + ca.cross(dw, MS) + ca.cross(w, ca.cross(w, MS))
        moment = J @ dw + ca.cross(w, J @ w) + ca.cross(MS, a)
        links.append((R, P, force, moment))
    torques, f, m = [], ca.SX.zeros(3), ca.SX.zeros(3)
    for R, P, force, moment in reversed(links):  # from tip to base: f and m are what a link hands to the one before
        f, m = f + force, m + moment
        torques.append(m[2])
        f, m = R @ f, R @ m + ca.cross(P, R @ f)
    return ca.SX(ca.vertcat(*reversed(torques)))


q, qd, qdd, chi = (ca.SX.sym(name, size) for name, size in (("q", 6), ("qd", 6), ("qdd", 6), ("chi", 80)))
IA, FS, FV = (chi[[13 * j + k for j in range(6)]] for k in (10, 11, 12))
torque = newton_euler(q, qd, qdd, chi) + IA * qdd + FS * ca.sign(qd) + FV * qd  # friction (2), rotors (3)
# Rotor 6 turns with joint 5 as well (8). The paper prints sign(qd6) in (10) and sign(qd5) in (11); the duality (9)
# and real recordings ask for the sign of the rotor's own speed on both joints.
FVM6, FSM6 = chi[78], chi[79]
torque[4] += IA[5] * qdd[5] + FVM6 * qd[5] + FSM6 * ca.sign(qd[4] + qd[5])  # (10)
torque[5] += IA[5] * qdd[4] + FVM6 * qd[4] + FSM6 * ca.sign(qd[4] + qd[5])  # (11)
# The torque is linear in chi (4), so that its derivative is the regressor Phi_s: no need of (7).
Phi_s = ca.Function("Phi_s", [q, qd, qdd], [ca.cse(ca.jacobian(torque, chi))])


def regressors(q: Array, qd: Array, qdd: Array) -> Array:
    """Evaluate Phi_s at N samples: N x 6 x 80."""
    return np.asarray(Phi_s.map(len(q))(q.T, qd.T, qdd.T).full().reshape(6, len(q), 80).transpose(1, 0, 2))


# --- The base parameters (12): columns that no columns to their left can imitate ---
draw = np.random.default_rng(0)
W_s = regressors(*draw.uniform(-3.0, 3.0, (3, 72, 6))).reshape(-1, 80)
chosen: list[int] = []
basis = np.zeros((len(W_s), 0))
for k in range(80):
    rest = W_s[:, k]
    for _ in range(2):  # the second pass takes off what rounding left
        rest = rest - basis @ (basis.T @ rest)
    if np.linalg.norm(rest) > 1e-8 * np.linalg.norm(W_s, axis=0).max():
        chosen.append(k)
        basis = np.column_stack([basis, rest / np.linalg.norm(rest)])
base = [standard[k] for k in chosen]
assert len(base) == 54  # 40 inertial, 14 of friction
G = np.asarray(np.linalg.lstsq(W_s[:, chosen], W_s, rcond=None)[0], dtype=float)  # W_s = W G, so that chi = G chi_s
G_L = G[:, link_6]  # how a payload changes the base parameters: (25) to (28) for all of them
M_L = {"ZZ1": D3**2, "XX2": -(D3**2), "ZZ2": D3**2, "MX2": D3, "XX3": RL4**2, "ZZ3": RL4**2, "MY3": -RL4}
YY_L, MZ_L, XX_L = {"XX5": 1, "ZZ5": 1, "XX6": -1}, {"MY5": -1}, {"XX6": 1}
for column, relations in ((9, M_L), (3, YY_L), (8, MZ_L), (0, XX_L)):  # (25), (26) with (28), (27), (28)
    assert np.allclose(G_L[:, column], [relations.get(name, 0.0) for name in base])

# --- A recording without and one with payload: the robot and the payload of Table 2 on a motion of 20 s ---
table_2 = {
    **{"ZZ1": 12.6, "XX2": -7.77, "XZ2": -0.866, "ZZ2": 11.4, "MX2": 15.9, "XX3": 1.23, "ZZ3": 1.3, "MY3": -3.17},
    **{"IA3": 1.48, "MX4": -0.052, "IA4": 0.866, "IA5": 0.28, "YZ6": -0.02, "IA6": 0.104},
    **{"FV1": 29.3, "FV2": 27.3, "FV3": 7.09, "FV4": 6.0, "FV5": 4.73, "FV6": 1.2, "FVM6": 1.05},
    **{"FS1": 21.7, "FS2": 21.3, "FS3": 12.8, "FS4": 5.8, "FS5": 2.31, "FS6": 0.82, "FSM6": 0.7},
}
truth = np.array([0.161, 0, 0, 0.161, 0, 0.035, 0, 0, 1.003, 7.025])  # the calibrated payload, order as in TEN
RATE, DURATION = 250.0, 20.0
time = np.arange(0.0, DURATION, 1.0 / RATE)
t = ca.SX.sym("t")
waves = ca.vertcat(*(ca.sin(2 * np.pi * k * t / DURATION + k**2) for k in range(3, 13)))
swing = ca.DM(draw.uniform(-0.5, 0.5, (6, 10))) @ waves * ca.sin(np.pi * t / DURATION) ** 2  # at rest at both ends
path = ca.DM([0.0, -1.0, 1.0, 0.0, 0.2, 0.0]) + swing
speed = ca.jacobian(path, t)
motion = ca.Function("motion", [t], [path, speed, ca.jacobian(speed, t)]).map(len(time))
exact = [values.full().T for values in motion(time)]
position = exact[0].round(5)  # as an encoder shows it
Phi = regressors(*exact)
needed = Phi[:, :, chosen] @ [table_2.get(name, 0.0) for name in base]  # (13)
noise = draw.normal(size=(2, len(time), 6)) * [20.0, 20.0, 10.0, 5.0, 3.0, 3.0]
unloaded, loaded = needed + noise[0], needed + Phi[:, :, link_6] @ truth + noise[1]  # (22)

# --- The observation system (14), (15) ---
FACTOR = 10  # of the parallel decimation
low_pass = firwin(20 * FACTOR + 1, 0.8 / FACTOR)
BANDWIDTH = FACTOR * np.sum(low_pass**2)  # share of the decimated rows that are independent of each other


def decimated(signals: Array) -> Array:
    """Filter samples x 6 .. without delay, keep every tenth, and put the joints first, as (15) does."""
    filtered = upfirdn(low_pass, signals, down=FACTOR, axis=0)  # beyond the ends of the recording all is zero
    return np.asarray(filtered[10 : 10 + len(signals) // FACTOR].swapaxes(0, 1))


q_t = sosfiltfilt(butter(4, 20.0, fs=RATE, output="sos"), position, axis=0)  # zero-phase Butterworth, 20 Hz
qd_t = np.gradient(q_t, 1.0 / RATE, axis=0)
columns = decimated(regressors(q_t, qd_t, np.gradient(qd_t, 1.0 / RATE, axis=0)))  # 6 x samples x 80
W, W_L = columns[:, :, chosen], columns[:, :, link_6]
Y, Y_T = decimated(unloaded), decimated(loaded)


# --- Weighted least squares (16) to (21) ---
class Estimate(NamedTuple):
    """Holds parameters, their covariance (19), the weights of the joints and the degrees of freedom."""

    values: Array
    covariance: Array
    weights: Array
    freedom: float


def weighted_least_squares(W: Array, Y: Array) -> Estimate:
    """Solve Y = W chi + rho, the equations of joint i weighted by one over the standard deviation of its errors."""
    c = W.shape[2]
    ordinary = np.linalg.lstsq(W.reshape(-1, c), Y.ravel(), rcond=None)[0]  # (16)
    weights = 1.0 / np.sqrt(np.mean((Y - W @ ordinary) ** 2, axis=1))
    system = weights[:, None, None] * np.block([W, Y[:, :, None]])
    triangle = np.asarray(np.linalg.qr(system.reshape(-1, c + 1), mode="r"))
    R, z, rest = triangle[:c, :c], triangle[:c, c], triangle[c, c]
    # (18), but decimated rows are not independent: r counts those that are, which are BANDWIDTH of them.
    freedom = BANDWIDTH * Y.size - c
    inverse = np.linalg.inv(R)
    return Estimate(inverse @ z, rest**2 / freedom * inverse @ inverse.T, weights, freedom)  # (17), (19)


# --- The four methods ---
robot = weighted_least_squares(W, Y)

# Method 1, (22), (23): the robot is known. Its errors are part of the payload's: P = W_L^+ W carries them over.
alone = weighted_least_squares(W_L, Y_T - W @ robot.values)
left, right = ((alone.weights[:, None, None] * A).reshape(-1, A.shape[2]) for A in (W_L, W))
P = np.linalg.lstsq(left, right, rcond=None)[0]
method_1 = alone._replace(covariance=alone.covariance + P @ robot.covariance @ P.T)

# Method 2, (24) to (28): the change of the inertial base parameters, weighted by its covariance.
with_payload = weighted_least_squares(W, Y_T)
inertial = [k for k, name in enumerate(base) if name.rstrip("0123456789") in TEN]
change = (with_payload.values - robot.values)[inertial]  # (24)
weight = np.linalg.inv((with_payload.covariance + robot.covariance)[np.ix_(inertial, inertial)])
C_2 = np.linalg.inv(G_L[inertial].T @ weight @ G_L[inertial])
method_2 = Estimate(C_2 @ G_L[inertial].T @ weight @ change, C_2, with_payload.weights, with_payload.freedom)

# Method 3, (29): the difference of the torques on one trajectory.
method_3 = weighted_least_squares(W_L, Y_T - Y)

# Method 4, (30): robot and payload together.
together = weighted_least_squares(np.block([[W, 0 * W_L], [W, W_L]]), np.block([Y, Y_T]))
method_4 = together._replace(values=together.values[54:], covariance=together.covariance[54:, 54:])
methods = {"known robot": method_1, "change": method_2, "difference": method_3, "together": method_4}


# --- The payload that can exist: its pseudo-inertia has no negative eigenvalue ---
def pseudo_inertia(ten: Array) -> Array:
    """Build [[S, MS], [MS', M]], 4 x 4, with S = tr(J)/2 1 - J, the integral of p p' dm: linear in the ten."""
    XX, XY, XZ, YY, YZ, ZZ, MX, MY, MZ, M = ten
    J = np.array([[XX, XY, XZ], [XY, YY, YZ], [XZ, YZ, ZZ]])
    MS = np.array([[MX], [MY], [MZ]])
    return np.block([[np.trace(J) / 2 * np.eye(3) - J, MS], [MS.T, M]])


# Minimise (x - x_LS)' C^-1 (x - x_LS) over such bodies: with x = x_LS + root u it is the square of u's length.
root, u = np.linalg.cholesky(method_4.covariance), cp.Variable(10)
units = np.diag([10.0, 10.0, 10.0, 1.0])  # decimetres, so that all entries have one size
start, *steps = (units @ pseudo_inertia(ten) @ units for ten in (method_4.values, *root.T))
can_exist = start + sum(u[k] * steps[k] for k in range(10)) >> 0
chi2 = cp.Problem(cp.Minimize(cp.norm(u)), [can_exist]).solve(solver=cp.CLARABEL) ** 2
payload = method_4.values + root @ u.value
# 95 % of the mass: where chi2 has risen by t^2, nearly 1.96^2; 1.2 times as much holds at the edge of the cone too.
near = cp.norm(u) <= np.sqrt(chi2 + 1.2 * stdtrit(method_4.freedom, 0.975) ** 2)
ends = [cp.Problem(way(root[9] @ u), [can_exist, near]) for way in (cp.Minimize, cp.Maximize)]
mass = method_4.values[9] + [end.solve(solver=cp.CLARABEL) for end in ends]


# --- Only here the package enters: each step must come out the same ---
def equal(own: Array, theirs: Array, unit: Array | float = 1.0, tolerance: float = 1e-9) -> bool:
    """Tell whether two results agree, in units such as standard deviations."""
    return bool((np.abs(own - theirs) <= tolerance * unit).all())


def compare() -> None:
    """Assert that exact steps agree to 1e-9 and searched ones to a hundredth of a standard deviation."""
    from dynident.estimation import Settings, payload_estimate, payload_problem, weighted
    from dynident.estimation.payload.methods import constrain_payload
    from dynident.model import Processing, Recording, base_parameters, load_robot, regressor

    rx90 = load_robot("rx90")
    Phi_theirs = regressor(rx90, standard).map(len(time))(*(values.T for values in exact)).full()
    assert equal(Phi, Phi_theirs.reshape(6, len(time), 80).transpose(1, 0, 2))
    assert base_parameters(rx90).columns == tuple(base)
    assert equal(G, base_parameters(rx90).grouping)
    bare, heavy = (Recording(time, position, torques) for torques in (unloaded, loaded))
    settings = Processing(cutoff=20.0, decimate=FACTOR, still_speed=0.0)
    problem = payload_problem(rx90, [heavy], [bare], settings=Settings(settings, robust=False))
    for A, R in zip(np.block([W, W_L, Y_T[:, :, None]]), problem.loaded.factors, strict=True):
        assert equal(A.T @ A, R.T @ R, np.sum(A**2))  # the package keeps R of [W W_L Y] of each joint alone
    assert problem.unloaded is not None
    theirs = [weighted(problem.unloaded), *(payload_estimate(problem, number).estimate for number in (1, 2, 3, 4))]
    for own, their in zip((robot, *methods.values()), theirs, strict=True):
        tolerance = 1e-2 if own is method_3 else 1e-9  # the package aligns the two recordings in time before (29)
        assert equal(own.values, their.values, their.sigma, tolerance)
        assert equal(own.covariance, their.covariance, np.outer(their.sigma, their.sigma), tolerance)
    constrained, sigma = constrain_payload(payload_estimate(problem, 4)), theirs[4].sigma
    assert equal(payload, constrained.result.values, sigma, 1e-2)
    assert equal(mass, constrained.intervals.parameters[9], sigma[9], 1e-2)


compare()
print("             M [kg]   centre of mass [mm]  inertia about it [kg m2]  lowest eigenvalue")
rows = {"truth": truth} | {name: own.values for name, own in methods.items()} | {"can exist": payload}
for title, ten in rows.items():
    com, lowest = ten[6:9] / ten[9], np.linalg.eigvalsh(pseudo_inertia(ten))[0]
    inertia = ten[[0, 3, 5]] - ten[9] * (com @ com - com**2)
    print(f"{title:11}{ten[9]:8.3f}", *(f"{1e3 * x:6.1f}" for x in com), *(f"{x:8.4f}" for x in (*inertia, lowest)))
relative = 100 * np.sqrt(np.diag(method_4.covariance)) / np.abs(method_4.values)  # (20), (21)
print(f"relative standard deviations of MZ and M, together: {relative[8]:.1f} and {relative[9]:.1f} %")
print(f"95 % of the mass: {mass[0]:.3f} to {mass[1]:.3f} kg; chi2 of the payload that can exist: {chi2:.2f}")
