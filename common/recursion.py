"""Second-order recursive filters by LAPACK: to import ``scipy.signal`` takes longer than a command's work."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dtbtrs

from .arrays import Array


class Section(NamedTuple):
    """Second-order filter (b0 + b1/z + b2/z²) / (1 + a1/z + a2/z²)."""

    b0: float
    b1: float
    b2: float
    a1: float
    a2: float

    def filtered(self, signals: Array, before: Array) -> Array:
        """Filter signals (N, k); ``before``: at which they stood until then, shape (k,)."""
        driven = self.b0 * signals
        driven[1:] += self.b1 * signals[:-1]
        driven[2:] += self.b2 * signals[:-2]
        # What earlier samples add to the first two.
        level = (self.b0 + self.b1 + self.b2) / (1.0 + self.a1 + self.a2)
        last = self.b2 - self.a2 * level
        driven[:2] += np.outer([self.b1 - self.a1 * level + last, last], before)[: len(driven)]
        band = np.empty((3, len(signals)), order="F")
        band[:] = [[1.0], [self.a1], [self.a2]]
        filtered: Array = dtbtrs(band, np.asfortranarray(driven), uplo="L", diag="U", overwrite_b=True)[0]
        return filtered


def butterworth(order: int, cutoff: float) -> tuple[Section, ...]:
    """Sections of a Butterworth low-pass of even order, the most resonant last; ``cutoff``: fraction of Nyquist."""
    # Bilinear transform of its poles, prewarped.
    k = np.tan(0.5 * np.pi * cutoff)
    sections = []
    for pair in reversed(range(order // 2)):
        damping = 2.0 * np.sin(0.5 * np.pi * (2 * pair + 1) / order)
        norm = 1.0 + damping * k + k**2
        gain = k**2 / norm
        sections.append(
            Section(gain, 2.0 * gain, gain, 2.0 * (k**2 - 1.0) / norm, (1.0 - damping * k + k**2) / norm)
        )
    return tuple(sections)


def filtered(sections: Sequence[Section], signals: Array) -> Array:
    """Filter signals (N, k), which stood at their first values before, by one section of gain 1 after the other."""
    before = signals[0]
    for section in sections:
        signals = section.filtered(signals, before)
    return signals
