"""Gains of a robot and a payload that can exist: the same least squares over possible bodies, solved as cones.

The equations are homogeneous: torques and gains may be scaled together. The gain that is known best is therefore
held while the linearised problem, a cone program, is solved; the load's known mass sets the scale at the end.
"""

from collections.abc import Sequence

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import INERTIAL
from ...model.drives import SPRING, parameter_kind
from ..equations.equations import PAYLOAD, Equations, triangular
from ..possible.cone import ConeProgram, SolverError, solve_in_turn
from ..possible.robot import POWERS, RobotRules, link_places, typical_length
from .current_side import CurrentFit
from .known_load import KnownLoad
from .problem import GainProblem

_MOST = 50  # linearisations
_ENOUGH = 1e-5  # relative change of a gain
_WAYS = ((None, None), (None, 1e3), (None, 1e2), (1e3, 1e2), (1e2, 1e2), (1e2, 30.0))
"""Largest entry, and radius of the scaled unknowns: what no current shows has no least value, and may run away."""
_LENGTH = 0.1  # m: size of a payload, for scaling only


def possible_gains(
    problem: GainProblem, equations: Equations, loads: Sequence[KnownLoad], start: CurrentFit, anchor: int
) -> CurrentFit:
    """Gains, base parameters and payload of bodies that can exist, drives that do not push.

    Args:
        problem: robot and weights.
        equations: all of the problem's or those without a block.
        loads: what is known of the payload in each mounting.
        start: gains to begin with, whose covariance is kept.
        anchor: place of the gain that stays while solving.

    Raises:
        InputError: if the gains do not settle or no bodies explain the currents.
    """
    to_x, to_bodies, rules = _variables(problem, loads, start.x)
    k, x, n, m = start.k.copy(), start.x.copy(), len(start.k), to_x.shape[1]
    keep = [*range(m), *(m + j for j in range(n) if j != anchor)]
    A = np.zeros((len(rules) + n - 1, len(keep)))
    A[: len(rules), :m], A[len(rules) :, m:] = rules, np.eye(n - 1)
    bodies = np.zeros((*to_bodies.shape[:2], len(keep)))
    bodies[:, :, :m] = to_bodies
    for _ in range(_MOST):
        # The linearised currents: columns z, then k over its present value for each joint, then the right side.
        rows = []
        for j, (factor, w) in enumerate(zip(equations.factors, problem.weights, strict=True)):
            current = k[j] * factor[:, :-1] @ x
            own = np.zeros((len(factor), n))
            own[:, j] = current if j != anchor else 0.0
            right = factor[:, -1] + (current if j != anchor else 0.0)
            rows.append(w * np.column_stack([k[j] * factor[:, :-1] @ to_x, own, right]))
        top = triangular(np.vstack(rows))[: m + n]  # below it stands what no unknown explains
        try:
            solution = solve_in_turn(ConeProgram(top[:, keep], top[:, -1], A, np.zeros(len(A)), bodies), _WAYS)
        except SolverError as error:
            raise InputError(f"gains of bodies that can exist were not found ({error.words})") from None
        ratio = np.insert(solution.z[m:], anchor, 1.0)
        share = float(solution.z[m - 1])  # of the load
        if share <= 0.0 or (ratio <= 0.0).any():
            raise InputError("no gain explains the currents: check units, signs, order of joints and the payload")
        x = to_x @ solution.z[:m] / share
        ratio *= share
        k = k * ratio
        if np.abs(ratio - 1.0).max() < _ENOUGH:
            return start._replace(k=k, x=x)
    raise InputError(
        "the gains of bodies that can exist do not settle: check units, signs and order of the currents"
    )


def _variables(problem: GainProblem, loads: Sequence[KnownLoad], x: Array) -> tuple[Array, Array, Array]:
    """Maps of the cone program's z to the base parameters and the payload's ten, c x m, and to bodies, p x 10 x m.

    z are standard parameters of the robot, what is unknown of the payload, and the share of what is known, scaled;
    last the rows A z that must not be negative.
    """
    base, length = problem.base, typical_length(problem.robot)
    free = [(k, name) for k, load in enumerate(loads) for name in load.free]
    known = [parameter_kind(name) == SPRING for name in base.standard]
    names = [name for name, fixed in zip(base.standard, known, strict=True) if not fixed]
    standard = len(names)
    m = standard + len(free) + 1
    scale = np.ones(m)
    # One mass and one length for all links, one size for friction.
    own = dict(zip(base.columns, np.abs(x), strict=False))
    masses = [v / length ** POWERS[parameter_kind(k)] for k, v in own.items() if parameter_kind(k) in INERTIAL]
    others = [v for k, v in own.items() if k in names and parameter_kind(k) not in POWERS]
    mass, friction = float(np.median(masses)) or 1.0, max(float(np.median(others or [1.0])), 1e-6)
    kinds = [parameter_kind(name) for name in names]
    scale[:standard] = [mass * length ** POWERS[kind] if kind in POWERS else friction for kind in kinds]
    scale[standard:-1] = [loads[k].mass * _LENGTH ** POWERS[name.removesuffix("_L")] for k, name in free]
    to_x = np.zeros((len(base.columns) + len(loads) * len(PAYLOAD), m))
    to_x[: len(base.columns), :standard] = base.grouping[:, np.logical_not(known)]
    to_x[: len(base.columns), -1] = base.grouping[:, known].sum(axis=1)  # a spring's torque: its parameter is 1
    weights = np.zeros((len(loads), len(PAYLOAD), m))
    for place, (k, name) in enumerate(free, standard):
        weights[k, PAYLOAD.index(name), place] = 1.0
    weights[:, :, -1] = [load.ten for load in loads]
    to_x[len(base.columns) :] = weights.reshape(-1, m)
    links = [np.eye(standard, m)[places] for places in link_places(problem.robot, names)]
    rules = RobotRules.of(problem.robot, names, scale[:standard], None).A
    A = np.zeros((len(rules) + 1, m))
    A[:-1, :standard] = rules
    A[-1, -1] = 1.0
    # A body whose ten are all known needs no cone: it was checked when it was read.
    open_ones = [body for body, load in zip(weights, loads, strict=True) if load.free]
    bodies = np.array([*links, *open_ones]) * scale
    return to_x * scale, bodies, A
