"""Drive gains of a robot and a payload that can exist: the same least squares over possible bodies, as cones.

The equations are homogeneous: torques and gains may be scaled together. The gain that is known best is therefore
fixed while the linearised problem, a cone program, is solved; the load's known mass sets the scale at the end.
"""

import numpy as np
from scipy.linalg import block_diag

from ...common import Array, InputError
from ...model import INERTIAL
from ...model.drives import SPRING, parameter_kind
from ..equations.equations import PAYLOAD, Equations, triangular
from ..possible.cone import ConeProgram, SolverError, solve_cone
from ..possible.robot import POWERS, drive_rules, link_indices, typical_length
from .problem import CurrentFit, GainProblem, linearised

_MOST = 50  # linearisations
_ENOUGH = 1e-5  # relative change of a gain
_WAYS = ((1e5, np.inf), (1e5, 1e3), (1e5, 1e2), (1e3, 1e2), (1e2, 1e2), (1e2, 30.0))
"""Bounds on the scaled unknowns, entry and radius: what no current shows has no least value, and may run away."""
_LENGTH = 0.1  # m: size of a payload, for scaling only


def possible_gains(problem: GainProblem, equations: Equations, start: CurrentFit, anchor: int) -> CurrentFit:
    """Find gains, base parameters and payload of bodies that can exist, drives that do not push.

    ``equations``: all of the problem's or those without a block; ``start``: gains to begin with, whose covariance
    is kept; ``anchor``: index of the gain that stays while solving.
    """
    to_x, to_bodies, rules = _variables(problem, start.x)
    k, x, others = start.k, start.x, len(start.k) - 1
    c, m = to_x.shape
    # The unknowns are z, then the other gains over their present values.
    A = block_diag(rules, np.eye(others))
    bodies = np.pad(to_bodies, ((0, 0), (0, 0), (0, others)))
    for _ in range(_MOST):
        J, errors = linearised(equations.factors, problem.weights, k, x, range(c))
        by_ratio = np.delete(J[:, c:] * k, anchor, axis=1)
        right = errors + J[:, :c] @ x + by_ratio.sum(axis=1)
        # Below the triangle of the unknowns stands what none of them explains.
        R = triangular(np.column_stack([J[:, :c] @ to_x, by_ratio, right]))[: m + others]
        try:
            solution = solve_cone(ConeProgram(R[:, :-1], R[:, -1], A, np.zeros(len(A)), bodies), _WAYS)
        except SolverError as error:
            raise InputError(f"gains of bodies that can exist were not found ({error.explanation})") from None
        ratio, load = np.insert(solution.z[m:], anchor, 1.0), float(solution.z[m - 1])
        if load <= 0.0 or (ratio <= 0.0).any():
            raise InputError("no gain explains the currents: check units, signs, order of joints and the payload")
        x = to_x @ solution.z[:m] / load
        ratio *= load
        k = k * ratio
        if np.abs(ratio - 1.0).max() < _ENOUGH:
            return start._replace(k=k, x=x)
    raise InputError(
        "the gains of bodies that can exist do not settle: check units, signs and order of the currents"
    )


def _variables(problem: GainProblem, x: Array) -> tuple[Array, Array, Array]:
    """Map the cone program's z to the base parameters and the payload's ten, c x m, and to bodies, p x 10 x m.

    z are standard parameters of the robot, the unknown ones of the payload, and the factor of its known ones,
    scaled; last the rows A z that must not be negative.
    """
    base, loads, length = problem.posed[0].base, problem.loads, typical_length(problem.robot)
    spring = np.array([parameter_kind(name) == SPRING for name in base.standard])
    names = [name for name in base.standard if parameter_kind(name) != SPRING]
    unknown = [(k, name) for k, load in enumerate(loads) for name in load.free]
    s, m = len(names), len(names) + len(unknown) + 1
    # One mass and one length for all links, one size for friction.
    own = [(parameter_kind(name), abs(value)) for name, value in zip(base.columns, x, strict=False)]
    masses = [value / length ** POWERS[kind] for kind, value in own if kind in INERTIAL]
    frictions = [value for kind, value in own if kind not in POWERS and kind != SPRING]
    mass, friction = float(np.median(masses)) or 1.0, max(float(np.median(frictions or [1.0])), 1e-6)
    kinds = [parameter_kind(name) for name in names]
    scale = np.ones(m)
    scale[:s] = [mass * length ** POWERS[kind] if kind in POWERS else friction for kind in kinds]
    scale[s:-1] = [loads[k].mass * _LENGTH ** POWERS[name.removesuffix("_L")] for k, name in unknown]
    payloads = np.zeros((len(loads), len(PAYLOAD), m))
    for column, (k, name) in enumerate(unknown, s):
        payloads[k, PAYLOAD.index(name), column] = 1.0
    payloads[:, :, -1] = [load.ten for load in loads]
    robot = np.zeros((len(base.columns), m))
    robot[:, :s] = base.grouping[:, ~spring]
    robot[:, -1] = base.grouping[:, spring].sum(axis=1)  # a spring's torque: its parameter is 1
    rules = block_diag(drive_rules(problem.robot, names, scale[:s])[0], np.zeros((0, len(unknown))), np.eye(1))
    # A body whose ten are all known needs no cone: it was checked when it was read.
    open_ones = [body for body, load in zip(payloads, loads, strict=True) if load.free]
    bodies = np.array([*np.eye(s, m)[link_indices(problem.robot, names)], *open_ones])
    return np.vstack([robot, *payloads]) * scale, bodies * scale, rules
