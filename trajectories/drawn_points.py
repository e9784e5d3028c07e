"""Random via points to start a search from."""

from collections.abc import Callable

import numpy as np

from ..common.arrays import Array
from .bounds import JointBounds
from .samples import Clear

_TRIES = 200  # to find a point that can be reached
_SPAN = 0.75  # of the position range that random points use

Nearer = Callable[[int, Array, Array], Array]
"""Move's number, where it starts and where it ends -> an end as near as the move's time allows."""


def as_drawn(move: int, before: Array, point: Array) -> Array:
    """Any end."""
    return point


def reachable_points(
    bounds: JointBounds,
    count: int,
    draw: np.random.Generator,
    clear: Clear,
    start: Array | None = None,
    nearer: Nearer = as_drawn,
) -> Array:
    """Points, each reached from the one before on a straight line, unless _TRIES points cannot be.

    Args:
        bounds: of the positions.
        count: number of points.
        draw: random numbers.
        clear: whether poses may be taken.
        start: the first point [rad or m], shape (n,); None for any.
        nearer: moves a point towards the one before, where a move's duration is given.

    Returns:
        Positions [rad or m], shape (count, n).
    """
    middle, reach = bounds.middle, _SPAN * bounds.half
    on_line = np.linspace(0.0, 1.0, 21)[:, None]
    points = np.empty((count, len(middle)))
    for k in range(count):
        if k == 0 and start is not None:
            points[0] = start
            continue
        for _ in range(_TRIES):
            points[k] = middle + reach * draw.uniform(-1.0, 1.0, len(middle))
            before = points[max(k - 1, 0)]
            if k > 0:
                points[k] = nearer(k - 1, before, points[k])
            if clear(before + on_line * (points[k] - before)):
                break
    return points
