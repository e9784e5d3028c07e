"""Intervals of a payload that must exist: the convex profile.

The interval of a number f(x) runs from its smallest to its largest value over all payloads x that hold the
constraints and lie no farther from the free estimate than d^2 = k2 + 1.2 t^2: k2 is the smallest distance that the
constraints allow, t Student's 97.5 % point. One rule, whether or not a constraint is active; where none is it gives
the usual interval, 1.1 times as long.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..model.arrays import Array
from .constrained import ConstrainedEstimate
from .profile import ProfileSet
from .robust import student95
from .scaling import ScaledProblem

WIDENING = 1.2
"""Of t^2, found by simulation: with 1 instead, intervals at an active constraint hold the truth in 91 to 93 %."""
_ROUNDS = 10
"""Linearisations of a number that is not linear; fewer where nothing is gained."""
_GAIN = 1e-4
"""A smaller gain, as a fraction of the way so far, is none."""
_STEPS: Array = np.linspace(0.125, 1.0, 8)
"""Parts of the way to a new point that are tried."""
_NOT_NEGATIVE = [0, 3, 5, 9]  # XX, YY, ZZ, M
_UPPER = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


@dataclass(frozen=True)
class Intervals:
    """95 % intervals, each [low, high].

    Centre of mass and inertia are infinitely uncertain where the data allow a payload without mass. All are nan
    where constraints contradict the data: however short, no interval would mean anything.

    Attributes:
        parameters: of the ten, 10 x 2.
        com: of the centre of mass [m], 3 x 2.
        inertia_com: of the inertia at the centre of mass in the frame's axes [kg m^2], 3 x 3 x 2.
        principal_moments: of its eigenvalues in rising order [kg m^2], 3 x 2.
    """

    parameters: Array
    com: Array
    inertia_com: Array
    principal_moments: Array

    def __post_init__(self) -> None:
        """Lock the arrays."""
        shapes = {"parameters": (10, 2), "com": (3, 2), "inertia_com": (3, 3, 2), "principal_moments": (3, 2)}
        for name, shape in shapes.items():
            values = np.asarray(getattr(self, name), dtype=float).reshape(shape).copy()
            values.setflags(write=False)
            object.__setattr__(self, name, values)


NO_INTERVALS = Intervals(*(np.full(shape, np.nan) for shape in ((10, 2), (3, 2), (3, 3, 2), (3, 2))))
"""Where constraints contradict the data."""


class _Number(NamedTuple):
    """f = <V, I>, I the inertia at the centre of mass: ``of`` k x 3 x 3 inertias (k,), ``V`` at one of them."""

    of: Callable[[Array], Array]
    V: Callable[[Array], Array]


def profile_intervals(result: ConstrainedEstimate) -> Intervals:
    """Intervals of the ten and of what follows from them.

    The ten and the centre of mass are exact, one cone program for each end. The inertia at the centre of mass and
    its principal moments are found by repeated linearisation, which stays in the set and only ever gains.

    Args:
        result: the nearest payload; the covariance and the degrees of freedom of its free estimate are those that
            the intervals go by.

    Raises:
        SolverError: for anything but a clean solve.
    """
    problem = ScaledProblem.of(result.free, result.constraints)
    nearest = problem.select @ result.values / problem.scale
    profile = ProfileSet(problem, nearest, WIDENING * student95(result.free.degrees_of_freedom) ** 2)
    ten = _ten(profile, result.values)
    if not ten[9, 0] > 0.0:
        unknown = np.array([-np.inf, np.inf])
        return Intervals(ten, np.tile(unknown, (3, 1)), np.tile(unknown, (3, 3, 1)), np.tile(unknown, (3, 1)))
    com = _com(profile, result.body.com)
    numbers = [*(_entry(i, j) for i, j in _UPPER), *(_moment(k) for k in (0, 2, 1))]
    ends = _searched(profile, numbers, nearest)
    inertia = np.zeros((3, 3, 2))
    for (i, j), both in zip(_UPPER, ends, strict=False):
        inertia[i, j] = inertia[j, i] = both
    # A body that can exist has none of these negative; the solver's points may by rounding.
    ten[_NOT_NEGATIVE] = np.maximum(ten[_NOT_NEGATIVE], 0.0)
    inertia[range(3), range(3)] = np.maximum(inertia[range(3), range(3)], 0.0)
    return Intervals(ten, com, inertia, np.maximum(ends[[6, 8, 7]], 0.0))


def _ten(profile: ProfileSet, values: Array) -> Array:
    """10 x 2; eliminated parameters are zero and certain."""
    problem = profile.problem
    ends = [[unit @ profile.farthest(sign * unit) for sign in (-1.0, 1.0)] for unit in np.eye(len(problem.scale))]
    return _holding(problem.select.T @ (np.array(ends) * problem.scale[:, None]), values)


def _com(profile: ProfileSet, com: Array) -> Array:
    """3 x 2; zero and certain where the first moment was eliminated."""
    problem = profile.problem
    columns = (problem.scale[:, None] * problem.select)[:, 6:10]
    mass = int(problem.select[:, 9].argmax())
    ends = np.zeros((3, 2))
    for k, c in enumerate(columns[:, :3].T / problem.scale[mass]):
        if c.any():
            ends[k] = [sign * profile.largest_ratio(sign * c, mass) for sign in (-1.0, 1.0)]
    return _holding(ends, com)


def _holding(ends: Array, values: Array) -> Array:
    """Intervals stretched by rounding to hold the estimate itself."""
    return np.column_stack([np.minimum(ends[:, 0], values), np.maximum(ends[:, 1], values)])


def _entry(i: int, j: int) -> _Number:
    V = np.zeros((3, 3))
    V[i, j] += 0.5
    V[j, i] += 0.5
    return _Number(lambda inertias: np.asarray(inertias[:, i, j]), lambda _: V)


def _moment(k: int) -> _Number:
    def direction(inertia: Array) -> Array:
        v = np.linalg.eigh(inertia)[1][:, k]
        return np.outer(v, v)

    return _Number(lambda inertias: np.asarray(np.linalg.eigvalsh(inertias)[:, k]), direction)


def _searched(profile: ProfileSet, numbers: Sequence[_Number], start: Array) -> Array:
    """Smallest and largest value of each number, k x 2; a search starts from the best point found for any other."""
    points = [start]
    for number in numbers:
        for sign in (-1.0, 1.0):
            _climb(profile, number, sign, points)
    values = [number.of(_inertias(profile.problem.full(np.array(points)))) for number in numbers]
    return np.array([[ends.min(), ends.max()] for ends in values])


def _climb(profile: ProfileSet, number: _Number, sign: float, points: list[Array]) -> None:
    """Adds points with ever larger sign f: along its gradient to the farthest, or as far on the way as it gains."""
    problem = profile.problem
    known = sign * number.of(_inertias(problem.full(np.array(points))))
    first, best, z = float(known[0]), float(known.max()), points[int(known.argmax())]
    for _ in range(_ROUNDS):
        x = problem.full(z)
        gradient = problem.select @ _gradient(x, number.V(_inertias(x[None])[0])) * problem.scale
        if not gradient.any():  # all it depends on was eliminated
            break
        tried = z + _STEPS[:, None] * (profile.farthest(sign * gradient) - z)
        values = sign * number.of(_inertias(problem.full(tried)))
        gain, k = float(values.max()) - best, int(values.argmax())
        if gain <= 0.0:
            break
        z, best = tried[k], float(values[k])
        points.append(z)
        if gain < _GAIN * (best - first):
            break


def _inertias(x: Array) -> Array:
    """I = I_0 - (|h|^2 1 - h h') / M of k x 10 parameters, k x 3 x 3."""
    h, M = x[:, 6:9], x[:, 9, None, None]
    squares = (h * h).sum(axis=1)[:, None, None] * np.eye(3) - h[:, :, None] * h[:, None, :]
    return np.asarray(x[:, [[0, 1, 2], [1, 3, 4], [2, 4, 5]]] - squares / M)


def _gradient(x: Array, V: Array) -> Array:
    """Of <V, I> by the ten at x, V held fixed; (10,)."""
    h, M = x[6:9], x[9]
    turned = np.trace(V) * h - V @ h
    upper = (V * (2.0 - np.eye(3)))[np.triu_indices(3)]
    return np.concatenate([upper, -2.0 * turned / M, [h @ turned / M**2]])
