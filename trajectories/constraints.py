"""The limits of a design as sparse constraints low <= g(x) <= high with their exact Jacobian.

At every sample a limit is a function of that sample's states, and these depend on few entries of x: those of the
points and times about it. A slope of each limit's column in the states, found for all samples at once by the same
adjoints that the gradient takes, times the family's Jacobian gives the rows.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.arrays import Array
from .limits import Limit, Slopes, State, StateLimit
from .margins import Margins
from .problem import DesignProblem
from .samples import Jacobian, Samples


class Pattern(NamedTuple):
    """Where a sparse matrix is not zero, column by column.

    Attributes:
        shape: rows and columns.
        starts: where each column begins, and the end, shape (columns + 1,).
        rows: of the entries.
    """

    shape: tuple[int, int]
    starts: NDArray[np.intp]
    rows: NDArray[np.intp]


class _Block(NamedTuple):
    """A limit's column at all samples, or a limit on the motion as a whole.

    Attributes:
        limit, column: whose values.
        joints: whose states count; None where the motion as a whole does.
    """

    limit: Limit
    column: int
    joints: tuple[int, ...] | None


class Constraints:
    """All limits that bound anything, block by block; a block holds one column of a limit.

    Attributes:
        pattern: of the Jacobian.
    """

    def __init__(self, problem: DesignProblem, x: Array, width: float) -> None:
        """Find the pattern, which is the same for every x."""
        self._problem, self._n = problem, problem.robot.n
        state, own = problem.state(x, width), problem.family.jacobian(x)
        self._blocks = [block for limit in problem.limits for block in _blocks(limit, state, self._n)]
        rows, columns, self._count = [], [], 0
        for block in self._blocks:
            where = self._columns(block, own)
            height = len(block.limit.values(state))
            rows.append(np.repeat(np.arange(self._count, self._count + height), where.size // height))
            columns.append(where.ravel())
            self._count += height
        size = problem.family.size
        row, column = np.concatenate(rows), np.concatenate(columns)
        self._kept = column < size
        places, self._place = np.unique(column[self._kept] * self._count + row[self._kept], return_inverse=True)
        starts = np.searchsorted(places, np.arange(size + 1) * self._count)
        self.pattern = Pattern((self._count, size), starts, places % self._count)

    def bounds(self, margins: Margins) -> tuple[Array, Array]:
        """low and high of every row, drawn in."""
        intervals = dict(zip(map(id, margins.limits), margins.intervals(), strict=True))
        rows = [[side[:, column] for side in intervals[id(limit)]] for limit, column, _ in self._blocks]
        low, high = zip(*rows, strict=True)
        return np.concatenate(low), np.concatenate(high)

    def values(self, state: State) -> Array:
        """g, in the limits' units."""
        values = {id(limit): limit.values(state) for limit in self._problem.limits}
        return np.concatenate([values[id(limit)][:, column] for limit, column, _ in self._blocks])

    def jacobian(self, x: Array, state: State, width: float) -> Array:
        """Entries of the Jacobian in the order of ``pattern``."""
        own = self._problem.family.jacobian(x)
        entries = np.concatenate([self._entries(block, x, state, width, own).ravel() for block in self._blocks])
        return np.bincount(self._place, entries[self._kept], len(self.pattern.rows)).astype(float)

    def _columns(self, block: _Block, own: Jacobian) -> NDArray[np.intp]:
        """Columns of x on which each row depends, (rows, ...)."""
        if block.joints is None:
            return np.arange(own.size)[None]
        return own.columns[:, block.joints].reshape(len(own.columns), -1)

    def _entries(self, block: _Block, x: Array, state: State, width: float, own: Jacobian) -> Array:
        """The rows' derivatives in them."""
        slopes = Slopes(Samples.zeros(state.samples), np.zeros_like(state.entries))
        unit = np.zeros((len(state.samples.q) if block.joints is not None else 1, len(block.limit.low)))
        unit[:, block.column] = 1.0
        block.limit.pullback(state, unit, slopes)
        states = list(slopes.samples[1:])
        if slopes.seed.any():
            kernel = self._problem.kernel.state_slope(state.samples, width, slopes.seed)
            states = [a + b for a, b in zip(states, kernel, strict=True)]
        if block.joints is None:
            return self._problem.family.pullback(x, Samples(slopes.samples.weight, *states))
        joints = list(block.joints)
        return np.asarray(
            sum(part[:, joints, None] * values[:, joints] for part, values in zip(states, own[1:4], strict=True))
        )


def _blocks(limit: Limit, state: State, n: int) -> list[_Block]:
    """One for each column with a finite bound."""
    whole = len(limit.values(state)) != len(state.samples.q)
    bound = np.flatnonzero(np.isfinite(limit.low) | np.isfinite(limit.high))

    def joints(column: int) -> tuple[int, ...] | None:
        if whole:
            return None
        return (column,) if isinstance(limit, StateLimit) else tuple(range(n))

    return [_Block(limit, int(column), joints(int(column))) for column in bound]
