"""Compresses equations by QR, block by block and joint by joint; W is never held whole."""

from collections.abc import Iterable

import numpy as np
from scipy.linalg import lapack

from ..model import Measurement, Motion, Processing
from ..model.arrays import Array
from .decimation import noise_bandwidth
from .observation import Block, Mask, Observation, Observer
from .problem import ReducedProblem, triangular

_ROWS = 2048  # per QR: the rows and the factor stay in the processor's cache


def reduced_measurement(
    observer: Observer, data: Measurement, processing: Processing, partner: Motion | None = None
) -> ReducedProblem:
    """Reduce one measurement; arguments as in ``Observer.blocks``."""
    return _reduced(observer, observer.blocks(data, processing, partner), processing.decimate)


def reduced_stream(
    observer: Observer, pieces: Iterable[Measurement], slow_speed: Array, decimate: int = 1
) -> ReducedProblem:
    """Reduce one recording that arrives in pieces, however long it is.

    Args:
        observer: whose columns.
        pieces: consecutive pieces, even in time if they are to be decimated.
        slow_speed: rows of a joint slower than this are left out, shape (n,) [rad/s or m/s].
        decimate: parallel decimation of Y and W.
    """

    def kept(data: Measurement) -> Mask:
        speed = np.abs(data.motion.qd)
        mask: Mask = (speed >= slow_speed) & (speed > 0.0)
        return mask

    return _reduced(observer, observer.stream(((data, kept(data)) for data in pieces), decimate), decimate)


def reduced(observation: Observation) -> ReducedProblem:
    """Reduce equations that are held whole."""
    factors = tuple(
        _folded(np.empty((0, W.shape[1] + 1)), np.column_stack([W, Y]))
        for W, Y in zip(observation.W, observation.Y, strict=True)
    )
    rows = tuple(len(Y) for Y in observation.Y)
    effective = tuple(observation.bandwidth * count for count in rows)
    return ReducedProblem(observation.columns, factors, rows, effective)


def _reduced(observer: Observer, blocks: Iterable[Block], decimate: int) -> ReducedProblem:
    """Each joint's rows touch only its own columns: a QR of those alone, spread out at the end."""
    n = observer.robot.n
    widths = [own.stop - own.start + 1 for own in observer.rows]
    factors = [np.empty((0, width)) for width in widths]
    rows = np.zeros(n, dtype=int)
    for block in blocks:
        for j, own in enumerate(observer.rows):
            equations = np.concatenate([block.entries[own], block.torque[j : j + 1]])
            if not block.keep[j].all():
                equations = equations[:, block.keep[j]]
            rows[j] += equations.shape[1]
            factors[j] = _folded(factors[j], equations.T)
    bandwidth = noise_bandwidth(decimate)
    return ReducedProblem(
        observer.columns,
        tuple(_spread(observer, factor, own) for factor, own in zip(factors, observer.rows, strict=True)),
        tuple(int(count) for count in rows),
        tuple(float(bandwidth * count) for count in rows),
    )


def _folded(factor: Array, equations: Array) -> Array:
    """R of a factor with more rows below it."""
    width = factor.shape[1]
    for start in range(0, len(equations), _ROWS):
        part = equations[start : start + _ROWS]
        stack = np.empty((len(factor) + len(part), width), order="F")
        stack[: len(factor)] = factor
        stack[len(factor) :] = part
        if len(stack) > width:
            decomposed, *_ = lapack.dgeqrf(stack, overwrite_a=1)
            stack = np.triu(decomposed[:width])
        factor = stack
    return factor


def _spread(observer: Observer, factor: Array, own: slice) -> Array:
    """A joint's factor in all columns that were asked for."""
    wide = np.zeros((len(factor), observer.distinct + 1))
    wide[:, observer.entry_columns[own]] = factor[:, :-1]
    wide[:, -1] = factor[:, -1]
    return triangular(wide[:, [*observer.place, observer.distinct]])
