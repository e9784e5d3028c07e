"""Compresses equations by QR, block by block and joint by joint."""

from collections.abc import Iterable

import numpy as np
from scipy.linalg import lapack

from ...common.arrays import Array
from ...model.motion import Measurement
from ..signals.rows import Mask
from .equations import Equations, SharedTorque, compressed, merged
from .observer import Layout, Observation, Observer, Used

_ROWS = 1024  # per QR: the rows and the factor stay in the processor's cache
_PANEL = 8  # columns that the QR takes at once


def recorded(observer: Observer, recordings: Iterable[Used]) -> tuple[Equations, list[Observation]]:
    """Reduce all recordings of one load, and keep the equations of each."""
    each = [observer.observe_rows(*recording) for recording in recordings]
    return merged(map(reduced, each)), each


def reduced(observation: Observation) -> Equations:
    """Reduce the equations of one recording."""
    return _reduced(observation.layout, [observation])


def reduced_pieces(observer: Observer, pieces: Iterable[tuple[Measurement, Mask]], decimate: int = 1) -> Equations:
    """Reduce one recording that arrives in pieces, however long it is: its equations are never held whole.

    Args:
        pieces: consecutive pieces, even in time if they are to be decimated, each with its rows to use, N x n.
        decimate: parallel decimation of Y and W.
    """
    return _reduced(observer.layout, observer.stream(pieces, decimate))


def _reduced(layout: Layout, parts: Iterable[Observation]) -> Equations:
    """Reduce by QR the columns that each joint's rows touch, spread out at the end."""
    factors = [np.zeros((size, size), order="F") for size in layout.sizes]
    count, bandwidth = np.zeros(len(factors), dtype=int), 1.0
    for part in parts:
        bandwidth = part.bandwidth
        for j, own in enumerate(part.rows):
            count[j] += own.shape[1]
            for start in range(0, own.shape[1], _ROWS):
                factors[j] = _folded(factors[j], own[:, start : start + _ROWS])
    spread, shared = [], list[SharedTorque]()
    for j, (factor, touched, motors) in enumerate(zip(factors, layout.touched, layout.motors, strict=True)):
        own = np.triu(factor)[: len(touched) + 1]  # what stands below is of the others' torques alone
        wide = np.zeros((len(own), layout.distinct + 1 + len(motors)))
        wide[:, touched], wide[:, layout.distinct :] = own[:, : len(touched)], own[:, len(touched) :]
        asked = [*layout.index, *range(layout.distinct, wide.shape[1])]
        factor, others = compressed(wide[:, asked], len(motors))
        spread.append(factor)
        shared += [SharedTorque(j, motor, others[:, k]) for k, motor in enumerate(motors)]
    return Equations(
        layout.columns, tuple(spread), tuple(count.tolist()), tuple((bandwidth * count).tolist()), tuple(shared)
    )


def _folded(factor: Array, equations: Array) -> Array:
    """R of a factor, Fortran-ordered and overwritten, with more rows below it, the columns of ``equations``.

    LAPACK's QR of a triangle above a rectangle: faster than a QR of both as one matrix.
    """
    rows = np.array(equations.T, order="F")  # the QR uses them up
    factor, _, _, failed = lapack.dtpqrt(0, min(_PANEL, len(factor)), factor, rows, overwrite_a=1, overwrite_b=1)
    if failed:
        raise ValueError(f"QR: LAPACK refuses argument {-failed}")
    return factor
