"""The inverse dynamic model (1) by the recursive Newton-Euler algorithm, its parts, and the direct model.

Gamma = A(q) qdd + C(q, qd) qd + Q(q) + drive torque. Everywhere q, qd, qdd are n x 1 (rad or m, per second,
per second squared), chi holds the standard parameters in the order of ``standard_columns`` and torques are in
N·m or N. Every function is made of scalar operations, differentiable, and can be called on SX, MX or numbers.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import casadi as ca

from .base import BaseParameters
from .drives import DriveState, drive_terms, parameter_kind, smooth_sign
from .regressors import load_expression, standard_columns, term_matrix
from .robot import Robot

_STEPS = 5
SMOOTHING = 0.01  # width w of tanh(qd / w), which stands for the sign of a speed in dry friction [rad/s or m/s]
_STABLE = 2.0  # largest rate times step; Runge-Kutta's limit on the real axis is 2.78


def inverse_dynamics(robot: Robot, smooth: float = 0.0) -> ca.Function:
    """``inverse_dynamics(q, qd, qdd, chi) -> Gamma`` (1), n x 1.

    Gamma is what the motors must give: the torque of a spring is already taken off.

    Args:
        smooth: width w of tanh(qd / w), which stands for the sign in dry friction [rad/s or m/s]; 0 for the sign.
    """
    q, qd, qdd, chi = _symbols(robot)
    columns = standard_columns(robot)
    load = load_expression(robot, DriveState(q, qd, qdd, None), columns, chi)
    sign = smooth_sign(smooth) if smooth > 0.0 else ca.sign
    terms = drive_terms(robot.drives, DriveState(q, qd, qdd, load), sign)
    torque = load + term_matrix([terms.get(name, {}) for name in columns], robot.n) @ chi
    return _function("inverse_dynamics", {"q": q, "qd": qd, "qdd": qdd, "chi": chi}, Gamma=torque)


def inverse_dynamics_slopes(robot: Robot, smooth: float = SMOOTHING) -> ca.Function:
    """``inverse_dynamics_slopes(q, qd, qdd, chi) -> by_q, by_qd, by_qdd``, each n x n: the torques' Jacobians.

    ``smooth``: as of ``inverse_dynamics``; with 0 dry friction has no slope.
    """
    q, qd, qdd, chi = _symbols(robot)
    torque = inverse_dynamics(robot, smooth)(q, qd, qdd, chi)
    slopes = {f"by_{name}": ca.jacobian(torque, x) for name, x in (("q", q), ("qd", qd), ("qdd", qdd))}
    return _function("inverse_dynamics_slopes", {"q": q, "qd": qd, "qdd": qdd, "chi": chi}, **slopes)


def inverse_dynamics_base(robot: Robot, base: BaseParameters, smooth: float = 0.0) -> ca.Function:
    """``inverse_dynamics_base(q, qd, qdd, chi) -> Gamma`` with chi the base parameters, N_b x 1.

    The same algorithm with the eliminated parameters at zero: base parameters in the place of the standard
    ones they are named after give the same torques, by the fewest operations.
    """
    (q, qd, qdd, _), chi = _symbols(robot), ca.SX.sym("chi", len(base.columns))
    value = dict(zip(base.columns, ca.vertsplit(chi), strict=True))
    standard = ca.vertcat(*(value.get(name, ca.SX(0)) for name in base.standard))
    torque = inverse_dynamics(robot, smooth)(q, qd, qdd, standard)
    return _function("inverse_dynamics_base", {"q": q, "qd": qd, "qdd": qdd, "chi": chi}, Gamma=torque)


def mass_matrix(robot: Robot) -> ca.Function:
    """``mass_matrix(q, chi) -> A``, n x n, symmetric: the inertia matrix, rotors included."""
    q, _, _, chi = _symbols(robot)
    return _function("mass_matrix", {"q": q, "chi": chi}, A=_mass_matrix(inverse_dynamics(robot), q, chi))


def coriolis(robot: Robot) -> ca.Function:
    """``coriolis(q, qd, chi) -> c``, n x 1: Coriolis and centrifugal torques C(q, qd) qd."""
    q, qd, _, chi = _symbols(robot)
    bare = replace(robot, gravity=(0.0, 0.0, 0.0), drives=replace(robot.drives, spring=None))
    torque = load_expression(bare, DriveState(q, qd, ca.SX.zeros(robot.n), None), standard_columns(robot), chi)
    return _function("coriolis", {"q": q, "qd": qd, "chi": chi}, c=torque)


def coriolis_matrix(robot: Robot) -> ca.Function:
    """``coriolis_matrix(q, qd, chi) -> C``, n x n, by Christoffel symbols: dA/dt - 2 C is skew-symmetric."""
    q, qd, _, chi = _symbols(robot)
    # c is quadratic in qd with the (symmetric) Christoffel symbols as coefficients.
    matrix = 0.5 * ca.jacobian(coriolis(robot)(q, qd, chi), qd)
    return _function("coriolis_matrix", {"q": q, "qd": qd, "chi": chi}, C=matrix)


def gravity(robot: Robot) -> ca.Function:
    """``gravity(q, chi) -> Q``, n x 1: torques that hold the links against gravity, without the spring."""
    q, _, _, chi = _symbols(robot)
    still, bare = ca.SX.zeros(robot.n), replace(robot, drives=replace(robot.drives, spring=None))
    torque = load_expression(bare, DriveState(q, still, still, None), standard_columns(robot), chi)
    return _function("gravity", {"q": q, "chi": chi}, Q=torque)


def forward_dynamics(robot: Robot) -> ca.Function:
    """``forward_dynamics(q, qd, Gamma, chi) -> qdd``: the inverse of ``inverse_dynamics``, drives included.

    qdd = A^-1 (Gamma - ID(q, qd, 0, chi)) by L D L'. A must be regular, which it is for links that can exist.
    """
    return _forward("forward_dynamics", robot, inverse_dynamics(robot))


def forward_dynamics_base(robot: Robot, base: BaseParameters, smooth: float = 0.0) -> ca.Function:
    """``forward_dynamics_base(q, qd, Gamma, chi) -> qdd`` with chi the base parameters, N_b x 1.

    Motion is as determined by the base parameters as torque is: A and the rest are the same in them.
    """
    return _forward("forward_dynamics_base", robot, inverse_dynamics_base(robot, base, smooth))


def _forward(name: str, robot: Robot, inverse: ca.Function) -> ca.Function:
    (q, qd, torque, chi), result = inverse.sx_in(), ca.SX.zeros(robot.n)
    D, LT, order = ca.ldl(_mass_matrix(inverse, q, chi))
    # Friction that grows with load grows with acceleration: each further step leaves FL of the error.
    for _ in range(1 + _STEPS if robot.drives.loaded else 1):
        result += ca.ldl_solve(torque - inverse(q, qd, result, chi), D, LT, order)
    return _function(name, {"q": q, "qd": qd, "Gamma": torque, "chi": chi}, qdd=result)


def dry_friction_names(robot: Robot) -> tuple[str, ...]:
    """Parameters of friction that jumps with the speed's sign; none without friction."""
    rubs = (name for name in robot.standard if name.startswith("F"))
    return tuple(name for name in rubs if parameter_kind(name) not in ("FV", "FVM"))


def smooth_dry_friction(robot: Robot, width: float) -> ca.Function:
    """``smooth_dry_friction(qd, level) -> Gamma``, n x 1: the largest dry friction, where load counts at its limit.

    ``level``: the parameters ``dry_friction_names`` [N·m or N]; ``width``: of ``smooth_sign``.
    """
    names = dry_friction_names(robot)
    qd, level, none = ca.SX.sym("qd", robot.n), ca.SX.sym("level", len(names)), ca.SX.zeros(robot.n)
    limits = [joint.limits.torque if math.isfinite(joint.limits.torque) else 0.0 for joint in robot.joints]
    terms = drive_terms(robot.drives, DriveState(none, qd, none, ca.SX(limits)), smooth_sign(width))
    torque = term_matrix([terms[name] for name in names], robot.n) @ level
    return _function("smooth_dry_friction", {"qd": qd, "level": level}, Gamma=torque)


def runge_kutta(
    slope: Callable[[ca.SX, ca.SX], ca.SX], x: ca.SX, h: ca.SX, inputs: tuple[ca.SX, ca.SX, ca.SX]
) -> ca.SX:
    """Step a state ``x`` by ``h`` [s] by the classical fourth-order method.

    ``slope``: time derivative, by state and input; ``inputs``: at the start, middle and end of the step.
    """
    start, middle, end = inputs
    k1 = slope(x, start)
    k2 = slope(x + 0.5 * h * k1, middle)
    k3 = slope(x + 0.5 * h * k2, middle)
    k4 = slope(x + h * k3, end)
    return x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


def stable_steps(fastest: float, interval: float) -> int:
    """Number of steps in ``interval`` [s] that integrates a rate [1/s] stably."""
    return math.ceil(fastest * interval / _STABLE)


def _symbols(robot: Robot) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
    q, qd, qdd = (ca.SX.sym(symbol, robot.n) for symbol in ("q", "qd", "qdd"))
    return q, qd, qdd, ca.SX.sym("chi", len(standard_columns(robot)))


def _function(name: str, inputs: Mapping[str, ca.SX], **outputs: ca.SX) -> ca.Function:
    return ca.Function(name, [*inputs.values()], [*map(ca.cse, outputs.values())], [*inputs], [*outputs])


def _mass_matrix(inverse: ca.Function, q: ca.SX, chi: ca.SX) -> ca.SX:
    qdd = ca.SX.sym("qdd", q.numel())
    torque = inverse(q, ca.SX.zeros(q.numel()), qdd, chi)
    # The lower half needs fewer operations than the upper one.
    return ca.tril2symm(ca.tril(ca.jacobian(torque, qdd)))
