"""Second-order recursive filters by LAPACK: to import ``scipy.signal`` takes longer than a command's work."""

from collections.abc import Sequence

import numpy as np
from scipy.linalg.lapack import dtbtrs

from .arrays import Array

Section = tuple[float, float, float, float, float]
"""Factors b0, b1, b2, a1, a2 of a second-order filter (b0 + b1/z + b2/z²) / (1 + a1/z + a2/z²)."""


def butterworth(order: int, cutoff: float) -> tuple[Section, ...]:
    """Sections of a Butterworth low-pass of even order, the most resonant last; ``cutoff``: fraction of Nyquist."""
    # Bilinear transform of its poles, prewarped.
    k = np.tan(0.5 * np.pi * cutoff)
    sections = []
    for pair in reversed(range(order // 2)):
        damping = 2.0 * np.sin(0.5 * np.pi * (2 * pair + 1) / order)
        norm = 1.0 + damping * k + k**2
        gain = k**2 / norm
        sections.append((gain, 2.0 * gain, gain, 2.0 * (k**2 - 1.0) / norm, (1.0 - damping * k + k**2) / norm))
    return tuple(sections)


def filtered(sections: Sequence[Section], signals: Array, before: Array) -> Array:
    """Filter signals (N, k), which stood at ``before`` (k,) until then, by sections of gain 1 in turn."""
    for b0, b1, b2, a1, a2 in sections:
        driven = b0 * signals
        driven[1:] += b1 * signals[:-1]
        driven[2:] += b2 * signals[:-2]
        # What earlier samples add to the first two.
        level = (b0 + b1 + b2) / (1.0 + a1 + a2) if before.any() else 0.0
        last = b2 - a2 * level
        driven[:2] += np.outer([b1 - a1 * level + last, last], before)[: len(driven)]
        band = np.empty((3, len(signals)), order="F")
        band[:] = [[1.0], [a1], [a2]]
        signals = dtbtrs(band, np.asfortranarray(driven), uplo="L", diag="U", overwrite_b=True)[0]
    return signals
