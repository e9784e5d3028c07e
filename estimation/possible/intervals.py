"""Intervals of a payload that must exist: the convex profile.

The interval of a number f(x) runs from its smallest to its largest value over all payloads x that hold the
constraints and lie no farther from the free estimate than d^2 = k^2 + q with q = 1.2 t^2: k is the smallest
distance that the constraints allow, t Student's 97.5 % point. One rule, whether or not a constraint is active;
where none is, the interval is the usual one, 1.1 times as long. For the inertia of what may be as thin as a rod, or
a point, q is 2 t^2.

Seen from the nearest point, z = nearest + sqrt(q) R^-1 u, the distance says |u|^2 + 2 kappa e'u <= 1 with kappa =
k / sqrt(q) and the unit vector e along R (nearest - centre), or ||(u, kappa e'u)|| <= 1 - kappa e'u. All u are then
within the unit ball, however fine the data are and however far the constraints: the programs stay well scaled. Only
the direction changes from one question to the next, so a solver is set up once.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations_with_replacement, product
from typing import Any

import numpy as np

from ...common import Array, Brief, one_thread
from ...model.inertia import gradients, symmetric
from ..equations.equations import PAYLOAD
from ..fit.covariance import student95
from .constraints import PSEUDO_INERTIA, TRIANGLE, Part, SolverError, cone_solver
from .payload import Possible, ScaledProblem

WIDENING = 1.2
"""Factor on t^2, by simulation: with 1 instead, intervals at an active constraint hold the truth in 91 to 93 %."""
THIN = 2.0
"""The same for the inertia of a body thin in two directions: with 1.2, intervals of a point's hold 87 to 100 %."""
_ROUNDS = 10  # largest number of linearisations of a number that is not linear; fewer where nothing is gained
_GAIN = 1e-4  # gain, as a fraction of the way so far, below which it is none
_STEPS: Array = np.linspace(0.125, 1.0, 8)  # fractions of the way to a new point that are tried
_NEXT_TO_NOTHING = 1e-3
"""Fraction of the upper end: where the lower one of what no body has negative is smaller, it is zero."""
_NOT_NEGATIVE = np.isin(range(10), [0, 3, 5, 9])  # XX, YY, ZZ, M


def profile_set(
    problem: ScaledProblem, nearest: Array, q: float
) -> tuple[Callable[[Array], Array], Callable[[Array], float]]:
    """Pose the payloads that keep a scaled problem's constraints, squared distances up to q above the nearest's.

    Gives two functions of c, (n,): the point z of the set with the largest c'z, and the largest c'z / z_k, z_k the
    mass, positive in the whole set: such a ratio is linear in z / z_k and 1 / z_k.
    """
    R, _, A, b, _ = problem.program
    inverse = np.asarray(np.linalg.inv(R), dtype=float)
    offset = R @ (nearest - problem.centre) / np.sqrt(q)  # kappa e
    radius = float(np.sqrt(q * (1.0 + offset @ offset)))
    to_z = np.column_stack([np.sqrt(q) * inverse, nearest])  # z = to_z (u, 1)
    n, bounds, body = len(nearest), A @ to_z, TRIANGLE @ problem.select.T @ to_z
    bounds[:, -1] += b
    distance = np.vstack([np.append(-offset, 1.0), np.eye(n, n + 1), np.append(offset, 0.0)])
    K: list[Part] = [("Nonnegative", bounds), ("SecondOrder", distance), ("PSDTriangle", body)]
    # In (u / z_k, 1 / z_k).
    ratios: list[Part] = [("Zero", np.append(-(problem.select[:, 9] @ to_z), 1.0)[None])]
    ratios += [(kind, np.pad(rows, ((0, 0), (0, 1)))) for kind, rows in K]
    of_point, of_ratios = (
        cone_solver(np.zeros(n + k), own, 1e-7, reused=True) for k, own in enumerate((K, ratios))
    )

    def farthest(c: Array) -> Array:
        direction = c @ inverse
        by_distance = problem.centre + radius * inverse @ direction / np.linalg.norm(direction)
        if problem.holds(by_distance):  # no constraint is in the way
            return np.asarray(by_distance)
        return np.asarray(to_z @ np.append(_least(of_point, K, -direction), 1.0))

    return farthest, lambda c: float(c @ to_z @ _least(of_ratios, ratios, -(c @ to_z)))


def _least(solver: Any, parts: list[Part], cost: Array) -> Array:
    """Find, of all x whose parts lie in their cones, the one of least cost, by a solver of these parts."""
    unit = cost / np.linalg.norm(cost)  # a cost of norm 1 is what the solver's tolerances are made for
    solver.update(q=unit)
    solution = solver.solve()
    if str(solution.status) != "Solved":
        # About once in 100,000 directions the rows' own scale will not do: begin anew with the solver's.
        solution = cone_solver(unit, parts).solve()
    if str(solution.status) != "Solved":
        raise SolverError(str(solution.status))
    return np.asarray(solution.x)


@dataclass(frozen=True, eq=False, repr=False)
class Intervals(Brief):
    """95 % intervals, each [low, high].

    Centre of mass and inertia are infinitely uncertain where the data allow a payload without mass. All are nan
    where constraints contradict the data: no interval would mean anything.
    """

    parameters: Array  # of the ten, 10 x 2
    com: Array  # of the centre of mass [m], 3 x 2
    inertia_com: Array  # of the inertia at the centre of mass in the frame's axes [kg m^2], 3 x 3 x 2
    principal_moments: Array  # of its eigenvalues in rising order [kg m^2], 3 x 2

    def __post_init__(self) -> None:
        for values in vars(self).values():
            values.setflags(write=False)


NO_INTERVALS = Intervals(*(np.full(shape, np.nan) for shape in ((10, 2), (3, 2), (3, 3, 2), (3, 2))))


@one_thread()
def profile_intervals(result: Possible) -> Intervals:
    """Intervals of the ten and of what follows from them.

    The ten and the centre of mass are exact, one cone program for each end. The inertia at the centre of mass is
    found by repeated linearisation, which stays in the set and only ever gains. Principal moments go by the delta
    method: simulated for a disc, a cube and three unequal moments it covers 89 to 100 %, the profile 72 to 99 %.

    ``result``: the nearest payload; intervals go by covariance and degrees of freedom of its free estimate.

    Raises:
        SolverError: for anything but a clean solve.
    """
    problem = ScaledProblem.of(result.free, result.constraints)
    nearest = problem.select @ result.values / problem.scale
    t = student95(result.free.degrees_of_freedom)
    farthest, per_mass = profile_set(problem, nearest, WIDENING * t**2)
    of_inertia = profile_set(problem, nearest, THIN * t**2)[0] if thin_directions(result) > 1 else farthest
    units, signs = np.eye(len(problem.scale)), (-1.0, 1.0)
    sets = [of_inertia if k < 6 else farthest for k in problem.select.argmax(axis=1)]
    ends = np.array([[u @ end(sign * u) for sign in signs] for u, end in zip(units, sets, strict=True)])
    # Eliminated parameters are zero and certain; stretched by rounding, intervals hold the estimate itself.
    ten = np.sort(np.column_stack([problem.ten.T @ ends, result.values]))[:, [0, 2]]
    ten[_NOT_NEGATIVE & (ten[:, 0] <= _NEXT_TO_NOTHING * ten[:, 1]), 0] = 0.0
    if ten[9, 0] == 0.0:
        unknown = np.tile([-np.inf, np.inf], (3, 3, 1))
        return Intervals(ten, unknown[0], unknown, unknown[0])
    com, by_mass = np.zeros((3, 2)), problem.scale / (problem.scale @ problem.select[:, 9])
    for axis, c in enumerate((by_mass[:, None] * problem.select)[:, 6:9].T):
        if c.any():
            com[axis] = [sign * per_mass(sign * c) for sign in signs]
    # Points of ever larger I_ij, of both signs: along its gradient to the farthest, or as far that way as it gains.
    points = [nearest]
    for (i, j), sign in product(combinations_with_replacement(range(3), 2), signs):
        known = sign * _inertias(np.array(points) @ problem.ten)[:, i, j]  # a search starts from the best so far
        first, best, z = float(known[0]), float(known.max()), points[int(known.argmax())]
        for _ in range(_ROUNDS):
            gradient = problem.ten @ symmetric(gradients(z @ problem.ten)[3:])[i, j]
            if not gradient.any():  # all it depends on was eliminated
                break
            tried = z + _STEPS[:, None] * (of_inertia(sign * gradient) - z)
            values = sign * _inertias(tried @ problem.ten)[:, i, j]
            gain, k = float(values.max()) - best, int(values.argmax())
            if gain <= 0.0:
                break
            z, best = tried[k], float(values[k])
            points.append(z)
            if gain < _GAIN * (best - first):
                break
    every = _inertias(np.array(points) @ problem.ten)
    inertia = np.stack([every.min(axis=0), every.max(axis=0)], axis=-1)
    inertia[(inertia[..., 0] <= _NEXT_TO_NOTHING * inertia[..., 1]) & np.eye(3, dtype=bool), 0] = 0.0
    com = np.sort(np.column_stack([com, result.body.com]))[:, [0, 2]]
    return Intervals(ten, com, inertia, _moments(result, float(np.sqrt(WIDENING)) * t))


def thin_directions(result: Possible) -> int:
    """Count the axes along which the body may have no extent: the second moment's 95 % interval reaches zero.

    Second moments about the centre of mass, integrals of (v'x)^2 dm, are eigenvalues of the pseudo-inertia there.
    """
    if not result.body.mass > 0.0:
        return 3
    J, com = result.body.pseudo_inertia, result.body.com
    values, axes = np.linalg.eigh(J[:3, :3] - J[3, 3] * np.outer(com, com))
    v = np.vstack([axes, -com @ axes])  # v' J v is linear in the ten
    by_ten = np.einsum("kij,il,jl->lk", PSEUDO_INERTIA, v, v)[:, [PAYLOAD.index(n) for n in result.free.names]]
    variance = np.einsum("lk,km,lm->l", by_ten, result.free.covariance, by_ten)
    return int(np.sum(values <= student95(result.free.degrees_of_freedom) * np.sqrt(variance)))


def _moments(result: Possible, half: float) -> Array:
    """Principal moments of the constrained body by the delta method, 3 x 2.

    Of moments that may be equal, being closer than their own intervals, V' dI V decides, V their directions: its
    largest variance in any symmetric direction bounds theirs, however V is turned. Errors drive such moments apart:
    outer ends, from which they lead away, take the largest variance along V alone. Simulated: 3 to 11 % shorter,
    and they hold the truth as often.
    """
    values, vectors = np.linalg.eigh(result.body.inertia_com)
    slopes = symmetric(gradients(result.values)[3:, [PAYLOAD.index(name) for name in result.free.names]])

    def sigma(directions: Array) -> float:
        pairs = combinations_with_replacement(directions, 2)
        sizes = ((1.0 if v is w else np.sqrt(2.0), v, w) for v, w in pairs)
        J = np.array([size * np.einsum("i,ijk,j->k", v, slopes, w) for size, v, w in sizes])
        return float(np.sqrt(np.linalg.eigvalsh(J @ result.free.covariance @ J.T)[-1]))

    ends, own = np.zeros((3, 2)), np.array([sigma(v[None]) for v in vectors.T])
    for k in range(3):
        alike = np.abs(values - values[k]) <= half * own[k]
        bound, outer = sigma(vectors[:, alike].T), own[alike].max()
        ends[k] = values[k] + half * np.array([-outer if k == 0 else -bound, outer if k == 2 else bound])
    return np.maximum(ends, 0.0)


def _inertias(x: Array) -> Array:
    """Inertia I = I_0 - (|h|^2 1 - h h') / M of k x 10 parameters, k x 3 x 3."""
    h, M = x[:, 6:9], x[:, 9, None, None]
    squares = (h * h).sum(axis=1)[:, None, None] * np.eye(3) - h[:, :, None] * h[:, None, :]
    return np.asarray(x[:, [[0, 1, 2], [1, 3, 4], [2, 4, 5]]] - squares / M)
