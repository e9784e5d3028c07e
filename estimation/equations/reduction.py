"""Compresses equations by QR, block by block and joint by joint."""

from collections.abc import Iterable, Iterator

import numpy as np
from scipy.linalg import lapack

from ...common.arrays import Array
from ...model.motion import Measurement
from ..signals.decimation import noise_bandwidth
from ..signals.rows import Mask
from .equations import Equations, compressed, merged
from .observer import Layout, Observation, Observer, Used

_ROWS = 1024  # per QR: the rows and the factor stay in the processor's cache
_PANEL = 8  # columns that the QR takes at once


def recorded(observer: Observer, recordings: Iterable[Used]) -> tuple[Equations, list[Observation]]:
    """Reduce all recordings of one load, and keep the equations of each."""
    each = [observer.observe_rows(*recording) for recording in recordings]
    return merged(map(reduced, each)), each


def reduced(observation: Observation) -> Equations:
    """Reduce the equations of one recording."""
    starts = range(0, max(own.shape[1] for own in observation.rows), _ROWS)
    copies = ([own[:, k : k + _ROWS].copy() for own in observation.rows] for k in starts)
    parts = ((rows, [own.shape[1] for own in rows]) for rows in copies)
    return _reduced(observation.layout, parts, observation.bandwidth)


def reduced_pieces(observer: Observer, pieces: Iterable[tuple[Measurement, Mask]], decimate: int = 1) -> Equations:
    """Reduce one recording that arrives in pieces, however long it is: its equations are never held whole.

    Args:
        pieces: consecutive pieces, even in time if they are to be decimated, each with its rows to use, N x n.
        decimate: parallel decimation of Y and W.
    """

    def parts() -> Iterator[tuple[list[Array], list[int]]]:
        for equations, keep, _ in observer.stream(pieces, decimate):
            rows = [equations[own] for own in observer.layout.rows]
            for own, used in zip(rows, keep, strict=True):
                if not used.all():
                    own *= used  # a row of zeros says nothing
            yield rows, keep.sum(axis=1).tolist()

    return _reduced(observer.layout, parts(), noise_bandwidth(decimate))


def _reduced(layout: Layout, parts: Iterable[tuple[list[Array], list[int]]], bandwidth: float) -> Equations:
    """Reduce by QR the columns that each joint's rows touch, spread out at the end.

    ``parts``: rows as of an ``Observation``, used up for the QR works where they stand, and how many of them count.
    """
    factors = [np.zeros((own.stop - own.start,) * 2, order="F") for own in layout.rows]
    count = np.zeros(len(factors), dtype=int)
    for rows, counted in parts:
        count += counted
        factors = [_folded(factor, own.T) for factor, own in zip(factors, rows, strict=True)]
    spread, shared = [], dict[tuple[int, int], Array]()
    for j, (factor, touched, motors) in enumerate(zip(factors, layout.touched, layout.motors, strict=True)):
        own = np.triu(factor)[: len(touched) + 1]  # what stands below is of the others' torques alone
        wide = np.zeros((len(own), layout.distinct + 1 + len(motors)))
        wide[:, touched], wide[:, layout.distinct :] = own[:, : len(touched)], own[:, len(touched) :]
        asked = [*layout.index, *range(layout.distinct, wide.shape[1])]
        factor, others = compressed(wide[:, asked], len(motors))
        spread.append(factor)
        shared |= zip(((j, motor) for motor in motors), others.T, strict=True)
    effective = tuple((bandwidth * count).tolist())
    return Equations(layout.columns, tuple(spread), tuple(count.tolist()), effective, shared)


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
