"""How a search descends to the nearest minimum, by BFGS from the curvature that it has learnt, and how long.

Nocedal and Wright, Numerical Optimization, chapter 6; line search for the weak Wolfe conditions by bisection: Lewis
and Overton, Nonsmooth optimization via quasi-Newton methods, 2013. Elsewhere L-BFGS.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ..motions.near import FreeNear
from ..motions.samples import Family
from ..motions.via_points import FreeViaPoints
from .problem import DesignProblem
from .score import Score

Smooth = Callable[[Array], tuple[float, Array]]
"""A smooth number of a motion, and its gradient; inf where there is none."""
_SMALL = 400  # numbers whose curvature is kept as a matrix
_MEMORY = 40  # pairs of steps and slopes that L-BFGS keeps
_LARGE = 1e6  # stands for inf: the line search then goes back
_FLAT, _STILL = 1e-6, 1e-8  # slope, and a step's relative gain, at which a descent ends
_FALL, _BEND = 1e-4, 0.9  # Wolfe: of the first slope, what a step gains at least; what is left of it at most
_TRIALS = 25  # steps of one line search


class Minimum(NamedTuple):
    """Where a descent ended.

    Attributes:
        evaluations: of the number and its gradient.
        curvature: inverse of the second derivatives as the steps showed them; None where it is not kept.
    """

    x: Array
    evaluations: int
    curvature: Array | None = None


def minimised(
    function: Smooth,
    x: Array,
    family: Family,
    iterations: int,
    *,
    by_matrix: bool = False,
    curvature: Array | None = None,
) -> Minimum:
    """Minimise a smooth number within a family's bounds.

    Args:
        function: gives the number and its gradient.
        x: where the descent begins.
        family: bounds x.
        iterations: at most.
        by_matrix: whether the curvature is kept, as a matrix; else the last steps alone.
        curvature: of an earlier descent whose minimum is near; None without.
    """

    def finite(y: Array) -> tuple[float, Array]:
        value, slope = function(y)
        return (value, slope) if np.isfinite(value) else (_LARGE, slope)

    if by_matrix:
        return _by_matrix(finite, x, family, iterations, curvature)
    return _by_memory(finite, x, family, iterations)


def _by_matrix(function: Smooth, x: Array, family: Family, iterations: int, curvature: Array | None) -> Minimum:
    """BFGS: H, the inverse of the second derivatives, by one update of rank two a step."""
    (value, slope), evaluations, H = function(x), 1, curvature
    for _ in range(iterations):
        if np.abs(slope[_free(x, slope, family)]).max(initial=0.0) <= _FLAT:
            break
        way = None if H is None else _within(-H @ slope, x, slope, family)
        if way is None:
            H, way = None, _within(-slope / np.abs(slope).sum(), x, slope, family)
        if way is None:
            break
        longest = _longest(way, x, family)
        step, new, new_slope, trials = _step(function, x, value, float(slope @ way), way, longest)
        evaluations += trials
        if not new < value:
            if H is None:
                break
            H = None  # what was known leads nowhere here
            continue
        s, y, gain = step * way, new_slope - slope, value - new
        x, value, slope = x + s, new, new_slope
        if s @ y > 0.0:
            H = _updated(np.eye(len(x)) * ((s @ y) / (y @ y)) if H is None else H, s, y)
        if gain <= _STILL * max(abs(value), 1.0):
            break
    return Minimum(x, evaluations, H)


def _free(x: Array, slope: Array, family: Family) -> NDArray[np.bool_]:
    """Numbers that a step may change: not those at a bound that the slope pushes them against."""
    return ~(((x <= family.low) & (slope > 0.0)) | ((x >= family.high) & (slope < 0.0)))


def _within(way: Array, x: Array, slope: Array, family: Family) -> Array | None:
    """A step cut at the family's bounds; None if it then leads up."""
    way = np.where(_free(x, slope, family), np.clip(x + way, family.low, family.high) - x, 0.0)
    return way if slope @ way < 0.0 else None


def _longest(way: Array, x: Array, family: Family) -> float:
    """Share of a step that the family's bounds allow, at least 1."""
    room = np.where(way > 0.0, family.high - x, x - family.low)
    shares = room[way != 0.0] / np.abs(way[way != 0.0])
    return max(1.0, float(shares.min(initial=np.inf)))


def _updated(H: Array, s: Array, y: Array) -> Array:
    """H after a step s that changed the slope by y, s'y > 0."""
    share, Hy = 1.0 / (s @ y), H @ y
    cross = np.outer(s, share * Hy)
    return np.asarray(H - cross - cross.T + np.outer(s, s * (share * (1.0 + share * (y @ Hy)))))


def _step(
    function: Smooth, x: Array, value: float, fall: float, way: Array, longest: float
) -> tuple[float, float, Array, int]:
    """A step along ``way`` that gains enough and leaves less slope: step, value, slope, trials.

    Args:
        value, fall: at x, the number and its slope along ``way``, negative.
        longest: step that stays within bounds.
    """
    low, high, step = 0.0, np.inf, 1.0
    for trial in range(1, _TRIALS + 1):
        new, slope = function(x + step * way)
        if not new <= value + _FALL * step * fall:
            high = step
            least = -0.5 * fall * step**2 / (new - value - fall * step)  # of the parabola through both
            step = float(np.clip(least, 0.1 * step, 0.5 * step)) if low == 0.0 else 0.5 * (low + high)
        elif slope @ way < _BEND * fall and step < longest:
            low = step
            step = min(2.0 * step, longest) if high == np.inf else 0.5 * (low + high)
        else:
            return step, new, slope, trial
    return step, np.inf, slope, _TRIALS


def _by_memory(function: Smooth, x: Array, family: Family, iterations: int) -> Minimum:
    from scipy.optimize import minimize

    bounds = np.column_stack([family.low, family.high])
    options = {"maxiter": iterations, "maxfun": 2 * iterations, "maxcor": _MEMORY, "ftol": _STILL, "gtol": _FLAT}
    answer = minimize(function, x, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    return Minimum(np.asarray(answer.x), int(answer.nfev))


class Effort(NamedTuple):
    """How long a search goes on.

    Attributes:
        first: iterations from a start, shared by the surrogate's orders.
        refined: iterations of each stage after that.
        settled: iterations of each turn of settling.
        stages: of refinement; the last has the fine sign.
        turns: of settling at most.
        by_matrix: whether descents go on from the curvature that the last one has learnt, kept as a matrix.
        gain: of the criterion, a stage that gains less is the last of its kind; None where a better may follow.
    """

    first: int
    refined: int
    settled: int
    stages: int
    turns: int
    by_matrix: bool
    gain: float | None = None


_NEAR, _VIA = Effort(150, 50, 40, 3, 8, True, 2e-3), Effort(100, 100, 50, 2, 14, True)
_FRESH = Effort(160, 150, 60, 4, 8, False)
"""Where each descent learns the curvature anew: many numbers, many minima, or a surrogate that changes."""


def effort_of(problem: DesignProblem) -> Effort:
    """The effort with which motions of a problem's family come out best for the time it takes."""
    family = problem.family
    if family.size <= _SMALL and isinstance(family, FreeNear):
        return _NEAR
    if family.size <= _SMALL and isinstance(family, FreeViaPoints) and problem.criterion.weighted:
        return _VIA
    return _FRESH


@dataclass
class Worth:
    """Whether stages of a search still gain.

    Attributes:
        gain: a stage that gains less is the last of its kind; None where any may be followed by a better one.
        value: the last motion's criterion; None where it did not keep its limits.
    """

    gain: float | None
    value: float | None = None

    def __call__(self, score: Score) -> bool:
        """Whether to go on: the last motion or this one misses a limit, or this one is clearly better."""
        before, self.value = self.value, score.value if score.feasible else None
        if self.gain is None or before is None or self.value is None:
            return True
        return before - self.value > self.gain
