"""The way from random starts to a motion that keeps every limit: an interior point method."""

from ..common.arrays import Array
from .constraints import Constraints
from .criterion import ORDERS
from .ipopt import Ipopt
from .margins import Margins
from .search import MARGIN, Search
from .settle import FINE_WIDTH, WIDTH, settled


def search_interior(search: Search) -> None:
    """Improve several random starts for a while, the best of them to the end; then settle it within its limits."""
    problem, orders = search.problem, ORDERS[search.problem.criterion.kind]
    x = search.random()
    constraints = Constraints(problem, x, WIDTH)
    found: list[tuple[bool, float, int, Array]] = []
    margins = Margins(problem.limits, problem.state(x, WIDTH), MARGIN)
    for k in range(search.starts):
        x = x if k == 0 else search.random()
        search.consider(x, f"start {k + 1}")
        for order in orders[:2]:
            x = _improved(search, constraints, x, order, WIDTH, margins, 60)
        merit, _ = problem.evaluate(x, orders[-1], WIDTH)
        search.consider(x, f"start {k + 1} improved")
        found.append((search.astray(x, margins), merit, k, x))
    *_, x = min(found, key=lambda one: one[:3])
    for stage, width in enumerate((WIDTH, FINE_WIDTH)):
        x = _improved(search, constraints, x, orders[-1], width, margins, 150)
        search.consider(x, f"refined {stage + 1}")
    for turn in range(8):
        if settled(problem, x, margins):
            break
        x = _improved(search, constraints, x, orders[-1], FINE_WIDTH, margins, 40)
        search.consider(x, f"settled {turn + 1}")


def _improved(
    search: Search,
    constraints: Constraints,
    x: Array,
    order: float,
    width: float,
    margins: Margins,
    iterations: int,
) -> Array:
    before = search.evaluations

    def look(y: Array) -> None:
        search.evaluations = before + ipopt.evaluations
        search.consider(y, "interior point method")

    ipopt = Ipopt(search.problem, constraints, look)
    x = ipopt.minimise(x, order, width, margins, iterations)
    search.evaluations = before + ipopt.evaluations
    return x
