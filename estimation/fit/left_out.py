"""Least squares without each block of time in turn, weights fixed: the whole solution downdated, all at once.

With R the factor of all weighted equations, A_b and Y_b those of block b, Q_b = A_b R^-1 and e_b = Y_b - A_b x, the
solution without the block is x - R^-1 S_b^-1 Q_b' e_b with S_b = 1 - Q_b'Q_b: what the others hold of each
direction, 1 where the block says nothing. Where a block holds next to all of one, S_b is rounding: the others'
equations are then factored anew.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

from ...common.arrays import Array
from ..equations.equations import Equations
from ..equations.leave_one_out import WithoutEach
from .least_squares import checked

_HELD = 1e-6
"""Share of a direction that the other blocks must hold: differences then keep ten digits."""


_AT_ONCE = 16
"""Blocks that are worked on together: few enough for little memory."""


class LeftOut(NamedTuple):
    """Solutions without each of B blocks, and last the whole one, for m right-hand sides.

    ``values``: (B + 1) x c x m; ``covariance``: for errors of variance 1, (B + 1) x c x c; ``variance``: of the
    weighted errors, (B + 1) x m.
    """

    values: Array
    covariance: Array
    variance: Array


class _Solution(NamedTuple):
    """``x`` c x m; its ``covariance`` for variance 1; ``squares`` of the weighted errors (m,)."""

    x: Array
    covariance: Array
    squares: Array


def left_out(
    equations: Equations,
    columns: Sequence[str],
    weights: Array,
    known: Sequence[str] = (),
    near: Array | None = None,
) -> LeftOut:
    """Solve without each of the equations' blocks in turn.

    Args:
        equations: with two blocks at least.
        columns: whose parameters are solved for.
        weights: of the joints, shape (n,).
        known: other columns, each a right-hand side of its own; the last one is Y.
        near: further equations that no block holds, weighted, m x (c + k + 1): in columns, known ones, and Y.

    Raises:
        InputError: if what is left does not determine the parameters.
    """
    names, less = tuple(columns), equations.leave_one_out
    places = [*(equations.columns.index(name) for name in (*names, *known)), -1]
    near = np.zeros((0, len(places))) if near is None else near
    count = _counts([equations]) + len(near)
    root, whole = _solved(np.vstack([_weighted([equations], weights)[0][:, places], near]), names, count[0])
    if isinstance(less, WithoutEach):
        counts = count - _counts(less.blocks)
        chunks = [
            _downdated(root, whole, _weighted(less.blocks[k : k + _AT_ONCE], weights)[:, :, places])
            for k in range(0, len(less), _AT_ONCE)
        ]
        little = np.concatenate([own for own, _ in chunks])
        parts = _Solution(*(np.concatenate(arrays) for arrays in zip(*(own for _, own in chunks), strict=True)))
        for b in np.flatnonzero(little | (counts[:, 0] < len(names)) | (counts[:, 1] <= len(names))):
            others = _weighted([*less.blocks[:b], *less.blocks[b + 1 :]], weights)[:, :, places]
            for array, value in zip(parts, _solved(np.vstack([*others, near]), names, counts[b])[1], strict=True):
                array[b] = value
    else:
        counts, rows = _counts(less) + len(near), _weighted(less, weights)[:, :, places]
        each = [_solved(np.vstack([part, near]), names, own)[1] for part, own in zip(rows, counts, strict=True)]
        parts = _Solution(*map(np.array, zip(*each, strict=True)))
    x, covariance, squares = (np.concatenate([a, b[None]]) for a, b in zip(parts, whole, strict=True))
    return LeftOut(x, covariance, squares / (np.vstack([counts, count])[:, 1:] - len(names)))


def _counts(parts: Sequence[Equations]) -> Array:
    """Number of equations, and of those with independent noise, of each part."""
    return np.array([(part.equations, sum(part.effective_rows)) for part in parts])


def _solved(rows: Array, names: tuple[str, ...], counts: Array) -> tuple[Array, _Solution]:
    """R^-1 and the solution of equations, N x (c + m), by their numbers of rows and of independent ones."""
    c = len(names)
    R = checked(rows, names, int(counts[0]), float(counts[1]))
    root = solve_triangular(R[:c, :c], np.eye(c))
    return root, _Solution(root @ R[:c, c:], root @ root.T, np.sum(R[c:, c:] ** 2, axis=0))


def _downdated(root: Array, whole: _Solution, rows: Array) -> tuple[Array, _Solution]:
    """Solutions without each block, from the whole one; first, of which too little is left for that.

    Args:
        root: R^-1 of all equations.
        whole: their solution.
        rows: of the blocks, B x k x (c + m).
    """
    c = len(root)
    Q, errors = rows[:, :, :c] @ root, rows[:, :, c:] - rows[:, :, :c] @ whole.x
    back = Q.transpose(0, 2, 1)
    try:
        inverse = np.linalg.inv(np.eye(c) - back @ Q)
    except np.linalg.LinAlgError:  # a block holds all there is of a direction
        inverse = np.broadcast_to(np.eye(c) / np.finfo(float).eps, (len(Q), c, c))
    pull = back @ errors
    change = inverse @ pull
    squares = whole.squares - np.sum(errors**2, axis=1) - np.sum(pull * change, axis=1)
    little = np.linalg.norm(inverse, axis=(1, 2)) > 1.0 / _HELD
    return little, _Solution(whole.x - root @ change, root @ inverse @ root.T, squares)


def _weighted(blocks: Sequence[Equations], weights: Array) -> Array:
    """Weighted rows of all joints, block by block, B x k x (c + 1), rows of zeros below the shorter ones."""
    rows = [np.vstack([w * factor for w, factor in zip(weights, part.factors, strict=True)]) for part in blocks]
    result = np.zeros((len(rows), max(map(len, rows)), rows[0].shape[1]))
    for place, part in zip(result, rows, strict=True):
        place[: len(part)] = part
    return result
