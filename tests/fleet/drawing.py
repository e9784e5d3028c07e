"""Recordings that never were: reduced equations drawn on a real motion's factors, with parameters of one's own."""

from dataclasses import replace

import numpy as np
from dynident.apps.fleet.comparing import compared_by
from dynident.apps.fleet.store import Log, Stored
from dynident.common.arrays import Array
from dynident.estimation.equations.equations import Blocks, Equations, merged


def noise_of(recording: Stored) -> Array:
    """Standard deviation of white noise on each joint's equations that spreads estimates as a recording's errors.

    The residual's own, times what the jackknife finds beyond the formula on the whole, shape (n,).
    """
    equations = recording.equations
    estimate, ratio = compared_by(equations)
    rows = np.maximum(np.array(equations.rows, dtype=float), 1.0)
    return np.asarray(equations.error_norms(estimate.values) / np.sqrt(rows) * float(np.median(ratio)))


def drawn(
    recording: Stored,
    values: Array,
    noise: Array,
    draw: np.random.Generator,
    log: Log,
) -> Stored:
    """A recording as that motion would give it on another night.

    Args:
        recording: whose motion, robot and recipe.
        values: the base parameters then, shape (c,).
        noise: of each joint's equations, shape (n,); see ``noise_of``.
        draw: what draws.
        log: that never was, with its arm, day and told payload.
    """
    cut = recording.equations.blocks
    parts = recording.equations.parts() if cut else [recording.equations.whole]
    drawn_parts = [_drawn_block(part, values, noise, draw) for part in parts]
    blocks = Blocks.of(drawn_parts, cut.length) if cut else cut
    return replace(recording, log=log, equations=replace(merged(drawn_parts), blocks=blocks))


def _drawn_block(block: Equations, values: Array, noise: Array, draw: np.random.Generator) -> Equations:
    """One block of time: white noise stays white in a factor's rows; what is left over goes to its last row."""
    factors = []
    for factor, rows, sigma in zip(block.factors, block.rows, noise, strict=True):
        drawn_rows, y = np.array(factor), factor[:, :-1] @ values
        there = min(len(y), rows)  # of fewer rows than the factor has the rest is empty
        y[:there] += sigma * draw.standard_normal(there)
        over = rows - len(y)
        if over > 0:
            y[-1] = np.hypot(y[-1] - factor[-1, :-1] @ values, sigma * np.sqrt(draw.chisquare(over)))
            y[-1] += factor[-1, :-1] @ values
        drawn_rows[:, -1] = y
        factors.append(drawn_rows)
    return replace(block, factors=tuple(factors))
