"""Compresses equations by QR, block by block and joint by joint; W is never held whole."""

from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np
from scipy.linalg import lapack

from ...common.arrays import Array
from ...model.motion import Measurement
from ..signals.decimation import noise_bandwidth
from ..signals.rows import Mask
from .equations import Equations, SharedTorque, compressed, merged, refilled, shared_torques
from .observer import Block, Observation, Observer, Residuals, Used

_ROWS = 1024  # per QR: the rows and the factor stay in the processor's cache
_PANEL = 8  # columns that the QR takes at once


class Recorded:
    """The equations of one recording, row by row: made once, and cut as often as wanted."""

    def __init__(self, observer: Observer, data: Measurement, keep: Mask, factor: int) -> None:
        """Evaluate the equations of a measurement, of the rows to use (N x n), thinned by a factor."""
        self._observer, self._factor = observer, factor
        count, at = -(-len(keep) // factor), 0
        self._equations = np.empty((observer.rows[-1].stop, count))
        self._keep, self._t = np.empty((observer.robot.n, count), dtype=bool), np.empty(count)
        for block in observer.stream([(data, keep)], factor):
            here = slice(at, at := at + len(block.t))
            self._equations[:, here], self._keep[:, here], self._t[here] = block.equations, block.keep, block.t

    def cut(self, edges: Array) -> list[Equations]:
        """Cut the equations at edges [s], and reduce each stretch."""
        ends = np.searchsorted(self._t, edges).tolist()
        return [_reduced(self._observer, self._blocks(*pair), self._factor) for pair in pairwise(ends)]

    def residuals(self, values: Array) -> Residuals:
        """Residuals of the first columns' values."""
        chi = np.zeros(self._observer.distinct)
        np.add.at(chi, self._observer.index[: len(values)], values)
        errors = []
        for own, touched, keep in zip(self._observer.rows, self._observer.touched, self._keep, strict=True):
            entries = self._equations[own]
            errors.append((entries[len(touched)] - chi[touched] @ entries[: len(touched)])[keep])
        return Residuals(tuple(self._t[keep] for keep in self._keep), tuple(errors))

    def _blocks(self, first: int, last: int) -> Iterator[Block]:
        """Take the equations of some rows, copied, for the QR uses them up."""
        for start in range(first, last, _ROWS):
            rows = slice(start, min(start + _ROWS, last))
            yield Block(self._equations[:, rows].copy(), self._keep[:, rows], self._t[rows])


def recorded(observer: Observer, recordings: Iterable[Used]) -> tuple[Equations, list[Recorded]]:
    """Reduce all recordings of one load, and keep the equations of each."""
    each = [Recorded(observer, *recording) for recording in recordings]
    return merged(recording.cut(np.array([-np.inf, np.inf]))[0] for recording in each), each


def reduced_pieces(observer: Observer, pieces: Iterable[tuple[Measurement, Mask]], decimate: int = 1) -> Equations:
    """Reduce one recording that arrives in pieces, however long it is.

    Args:
        pieces: consecutive pieces, even in time if they are to be decimated, each with its rows to use, N x n.
        decimate: parallel decimation of Y and W.
    """
    return _reduced(observer, observer.stream(pieces, decimate), decimate)


def reduced(observation: Observation) -> Equations:
    """Reduce equations that are held whole; each joint's factor has rows for the columns that it touches alone."""
    factors, shared = [], list[SharedTorque]()
    for j, (W, Y) in enumerate(zip(observation.W, observation.Y, strict=True)):
        touched = np.flatnonzero(W.any(axis=0))
        others, width = shared_torques(observation.shared, j, len(Y)), len(touched) + 1
        factor = np.zeros((width + others.shape[1],) * 2, order="F")
        for start in range(0, len(Y), _ROWS):
            part = slice(start, start + _ROWS)
            stacked = np.column_stack([W[part][:, touched], Y[part], others[part]])
            factor = _folded(factor, np.asfortranarray(stacked))
        wide = np.zeros((width, W.shape[1] + 1))
        wide[:, [*touched, -1]] = np.triu(factor[:width, :width])
        factors.append(wide)
        shared += refilled(observation.shared, j, factor[:width, width:])
    rows = tuple(len(Y) for Y in observation.Y)
    effective = tuple(observation.bandwidth * count for count in rows)
    return Equations(observation.columns, tuple(factors), rows, effective, tuple(shared))


def _reduced(observer: Observer, blocks: Iterable[Block], decimate: int) -> Equations:
    """Reduce by QR the columns that each joint's rows touch, spread out at the end.

    The blocks' equations are used up: the QR works where they stand.
    """
    factors = [np.zeros((own.stop - own.start,) * 2, order="F") for own in observer.rows]
    rows = np.zeros(len(factors), dtype=int)
    for block in blocks:
        rows += block.keep.sum(axis=1)
        for j, own in enumerate(observer.rows):
            equations = block.equations[own]
            if not block.keep[j].all():
                equations *= block.keep[j]  # a row of zeros says nothing
            factors[j] = _folded(factors[j], equations.T)
    spread, shared = [], list[SharedTorque]()
    for j, (factor, touched, motors) in enumerate(zip(factors, observer.touched, observer.motors, strict=True)):
        part = np.triu(factor)[: len(touched) + 1]  # what stands below is of the others' torques alone
        wide = np.zeros((len(part), observer.distinct + 1 + len(motors)))
        wide[:, touched], wide[:, observer.distinct :] = part[:, : len(touched)], part[:, len(touched) :]
        asked = [*observer.index, *range(observer.distinct, wide.shape[1])]
        factor, others = compressed(wide[:, asked], len(motors))
        spread.append(factor)
        shared += [SharedTorque(j, motor, others[:, k]) for k, motor in enumerate(motors)]
    effective = tuple((noise_bandwidth(decimate) * rows).tolist())
    return Equations(observer.columns, tuple(spread), tuple(rows.tolist()), effective, tuple(shared))


def _folded(factor: Array, equations: Array) -> Array:
    """R of a factor with more rows below it; both are Fortran-ordered, and overwritten.

    LAPACK's QR of a triangle above a rectangle: faster than a QR of both as one matrix.
    """
    if len(equations):
        factor, _, _, failed = lapack.dtpqrt(
            0, min(_PANEL, len(factor)), factor, equations, overwrite_a=1, overwrite_b=1
        )
        if failed:
            raise ValueError(f"QR: LAPACK refuses argument {-failed}")
    return factor
