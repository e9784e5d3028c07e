"""The way from random starts to a motion that keeps every limit: an augmented Lagrangian and L-BFGS."""

from functools import partial

from ..common.arrays import Array
from .criterion import ORDERS
from .lagrangian import Multipliers
from .minimise import minimised
from .search import MARGIN, Search
from .settle import FINE_WIDTH, WIDTH, settled

_STIFFNESS = 10.0  # of the augmented Lagrangian; values are of the order of 1
_FIRST = 160  # iterations of each start, shared by the surrogate's orders


def search_augmented(search: Search) -> None:
    """Improve several random starts for a while, the best of them to the end; then settle it within its limits."""
    problem, orders = search.problem, ORDERS[search.problem.criterion.kind]
    found: list[tuple[bool, float, int, Array, Multipliers]] = []
    for k in range(search.starts):
        x = _brought_in(search, search.random())
        search.consider(x, f"start {k + 1}")
        limits = Multipliers(problem.limits, problem.state(x, WIDTH), _STIFFNESS, MARGIN)
        for order in orders[:2]:
            x = _improved(search, x, order, WIDTH, limits, _FIRST // len(orders[:2]))
        merit, _ = problem.evaluate(x, orders[-1], WIDTH, limits)
        search.consider(x, f"start {k + 1} improved")
        found.append((search.astray(x, limits), merit, k, x, limits))
    *_, x, limits = min(found, key=lambda one: one[:3])
    for stage, width in enumerate((WIDTH, WIDTH, WIDTH, FINE_WIDTH)):
        x = _improved(search, x, orders[-1], width, limits, 150)
        search.consider(x, f"refined {stage + 1}")
    for turn in range(8):
        if settled(problem, x, limits):
            break
        x = _improved(search, x, orders[-1], FINE_WIDTH, limits, 60)
        search.consider(x, f"settled {turn + 1}")


def _improved(search: Search, x: Array, order: float, width: float, limits: Multipliers, iterations: int) -> Array:
    """A descent, and the multipliers' update where it ends."""
    problem = search.problem
    x, count = minimised(partial(problem.evaluate, order=order, width=width, limits=limits), x, problem, iterations)
    search.evaluations += count
    limits.update(problem.state(x, width))
    return x


def _brought_in(search: Search, x: Array) -> Array:
    """A motion near x that keeps the limits at its samples, if there is one that a descent finds."""
    problem = search.problem
    for _ in range(3):
        limits = Multipliers(problem.limits, problem.state(x, WIDTH), 1.0, 2.0 * MARGIN)
        if limits.violation(problem.state(x, WIDTH)) <= 0.0:
            break
        x, count = minimised(partial(problem.trespass, width=WIDTH, limits=limits), x, problem, 60)
        search.evaluations += count
    return x
