"""Descents of a search to the nearest minimum, and the limits that they keep on their way.

Descent: BFGS from the curvature that it has learnt (Nocedal and Wright, Numerical Optimization, chapter 6), with a
line search for the weak Wolfe conditions by bisection (Lewis and Overton, Nonsmooth optimization via quasi-Newton
methods, 2013); elsewhere L-BFGS. Limits low <= y <= high: an augmented Lagrangian (Rockafellar; Nocedal and Wright,
chapter 17) whose intervals are drawn in until the fine grid shows none missed.
"""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from ...common import Array
from ..motions.family import Samples
from .goal import Family
from .limits import Penalty, Pullback, excess
from .problem import DesignProblem
from .score import FINER, TOLERANCE

Smooth = Callable[[Array], tuple[float, Array]]
"""Smooth function of a motion, with its gradient; inf where it has no value."""
WIDTH, FINE_WIDTH = 0.05, 0.01  # width of the smoothed sign while optimising, and at the end [rad/s or m/s]
_MEMORY = 40  # pairs of steps and slopes that L-BFGS keeps
_LARGE = 1e6  # stands for inf: the line search then goes back
_FLAT, _STILL = 1e-6, 1e-8  # slope, and a step's relative gain, at which a descent ends
_FALL, _BEND = 1e-4, 0.9  # Wolfe: of the first slope, what a step gains at least; what is left of it at most
_TRIALS = 25  # steps of one line search
_SAFETY = 1e-3  # of a limit: stays free on the fine grid
_SMALL = 0.01  # in the limits' units: smaller violations are left to the multipliers
_SHRINK = 0.3  # what an update should leave of a violation
_STIFFER, _STIFFEST = 4.0, 1e4


def _by_steps(function: Smooth, x: Array, family: Family, iterations: int) -> Array:
    """Descend within a family's bounds by the last steps alone (L-BFGS)."""
    from scipy.optimize import minimize

    def finite(y: Array) -> tuple[float, Array]:
        value, slope = function(y)
        return (value, slope) if np.isfinite(value) else (_LARGE, slope)

    bounds = np.column_stack([family.low, family.high])
    options = {"maxiter": iterations, "maxfun": 2 * iterations, "maxcor": _MEMORY, "ftol": _STILL, "gtol": _FLAT}
    return np.asarray(minimize(finite, x, jac=True, method="L-BFGS-B", bounds=bounds, options=options).x)


def _by_matrix(
    function: Smooth, x: Array, family: Family, iterations: int, H: Array | None = None
) -> tuple[Array, Array | None]:
    """Descend by all curvature learnt on the way (BFGS), returned inverted; ``H``: that of a descent before."""
    value, slope = function(x)
    for _ in range(iterations):
        # A step leaves numbers at a bound alone if the slope pushes them against it, and is cut at the bounds.
        free = ~(((x <= family.low) & (slope > 0.0)) | ((x >= family.high) & (slope < 0.0)))
        if np.abs(slope[free]).max(initial=0.0) <= _FLAT:
            break
        for learnt in (H, None):
            way = -slope / np.abs(slope).sum() if learnt is None else -learnt @ slope
            way = np.where(free, np.clip(x + way, family.low, family.high) - x, 0.0)
            if slope @ way < 0.0:
                H = learnt
                break
        else:
            break
        room = np.where(way > 0.0, family.high - x, x - family.low)
        longest = max(1.0, float((room[way != 0.0] / np.abs(way[way != 0.0])).min(initial=np.inf)))
        step, new, new_slope = _step(function, x, value, float(slope @ way), way, longest)
        if not new < value:
            if H is None:
                break
            H = None  # what was known leads nowhere here
            continue
        s, y, gain = step * way, new_slope - slope, value - new
        x, value, slope = x + s, new, new_slope
        if s @ y > 0.0:
            H = np.eye(len(x)) * ((s @ y) / (y @ y)) if H is None else H
            # Nocedal and Wright (6.17), multiplied out; the first H by (6.20).
            inverse, Hy = 1.0 / (s @ y), H @ y
            cross = np.outer(s, inverse * Hy)
            H = H - cross - cross.T + np.outer(s, s * (inverse * (1.0 + inverse * (y @ Hy))))
        if gain <= _STILL * max(abs(value), 1.0):
            break
    return x, H


def _step(
    function: Smooth, x: Array, value: float, fall: float, way: Array, longest: float
) -> tuple[float, float, Array]:
    """Find a step along ``way``, whose slope is ``fall``, that gains enough: step, value and slope after it."""
    low, high, step = 0.0, np.inf, 1.0
    for _ in range(_TRIALS):
        new, slope = function(x + step * way)
        if not new <= value + _FALL * step * fall:
            high = step
            least = -0.5 * fall * step**2 / (new - value - fall * step)  # of the parabola through both
            step = float(np.clip(least, 0.1 * step, 0.5 * step)) if low == 0.0 else 0.5 * (low + high)
        elif slope @ way < _BEND * fall and step < longest:
            low = step
            step = min(2.0 * step, longest) if high == np.inf else 0.5 * (low + high)
        else:
            return step, new, slope
    return step, np.inf, slope


class Lagrangian:
    """The augmented Lagrangian of a problem's limits, and the motion that descents on it have reached.

    One signed multiplier a value, and intervals drawn in so that the motion ``x`` keeps the limits between samples.
    """

    def __init__(self, problem: DesignProblem, x: Array, stiffness: float, margin: float) -> None:
        self.problem, self.x, self.stiffness = problem, x, stiffness  # the last: weight of squared violations
        self._curvature: Array | None = None  # at x, as the last descent has learnt it
        state = problem.state(x, WIDTH)
        shapes = [limit.values(state).shape for limit in problem.limits]
        # Per limit and value, by how much its interval is drawn in on either side, in the limit's units.
        self.drawn = [np.full(shape, margin) for shape in shapes]
        self._values = [np.zeros(shape) for shape in shapes]
        self._last = 0.0

    def __call__(self, state: Samples, into: Samples) -> float:
        """Evaluate the terms; their slopes are added to ``into``."""
        total = 0.0
        for old, (new, pullback) in zip(self._values, self._next(state), strict=True):
            total += float((new**2).sum() - (old**2).sum()) / (2.0 * self.stiffness)
            if new.any():
                pullback(new, into)
        return total

    def descend(self, width: float, iterations: int, *terms: Penalty, matrix: bool = False) -> None:
        """Descend on the limits' terms and further ones; ``matrix``: by all curvature, which is remembered."""
        function, family = partial(self.problem.evaluate, width=width, terms=(*terms, self)), self.problem.family
        if matrix:
            self.x, self._curvature = _by_matrix(function, self.x, family, iterations, self._curvature)
        else:
            self.x = _by_steps(function, self.x, family, iterations)

    def update(self, width: float) -> None:
        """Update multipliers to first order at a minimum; violations that do not shrink gain weight."""
        state = self.problem.state(self.x, width)
        self._values = [values for values, _ in self._next(state)]
        violation = self.violation(state)
        if violation > max(_SMALL, _SHRINK * self._last):
            self.stiffness = min(_STIFFER * self.stiffness, _STIFFEST)
        self._last = violation

    def violation(self, state: Samples) -> float:
        """Largest violation of the drawn-in intervals, in the limits' units."""
        pairs = zip(self.problem.limits, self.drawn, strict=True)
        return max(0.0, *(float((excess(y, y.values(state)) + drawn).max()) for y, drawn in pairs))

    def settle(self) -> bool:
        """Draw intervals in around where a limit is not kept on the fine grid; true if all are kept."""
        fine, coarse = self.problem.state(self.x, 0.0, FINER), self.problem.state(self.x, FINE_WIDTH)
        # The coarse sample within whose time each fine one lies.
        nearest = np.searchsorted(np.cumsum(coarse.weight), np.cumsum(fine.weight) - 0.5 * fine.weight)
        nearest = np.minimum(nearest, len(coarse.weight) - 1)
        all_kept = True
        for limit, drawn in zip(self.problem.limits, self.drawn, strict=True):
            over, here = (excess(limit, limit.values(state)) for state in (fine, coarse))
            if over.max() <= TOLERANCE:
                continue
            all_kept = False
            worst = np.full(here.shape, -np.inf)
            np.maximum.at(worst, nearest if len(here) > 1 else np.zeros(len(over), dtype=int), over)
            # Between samples a motion goes further by worst - here; what is left is the solver's own error.
            needed = np.where(worst > 0.0, np.maximum(worst - here, 0.0) + _SAFETY, 0.0)
            again = np.where((worst > 0.0) & (drawn >= needed), drawn + worst, needed)
            padded = np.pad(again, ((1, 1), (0, 0)), mode="edge")  # neighbours are drawn in as well
            drawn[...] = np.maximum(drawn, np.maximum(again, np.maximum(padded[:-2], padded[2:])))
        return all_kept

    def _next(self, state: Samples) -> Iterator[tuple[Array, Pullback]]:
        for limit, drawn, old in zip(self.problem.limits, self.drawn, self._values, strict=True):
            values, pullback = limit.measure(state)
            z, low, high = old + self.stiffness * values, limit.low + drawn, limit.high - drawn
            yield z - np.clip(z, self.stiffness * low, self.stiffness * high), pullback
