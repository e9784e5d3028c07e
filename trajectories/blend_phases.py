"""States in the phases of a motion with blends, and their derivatives in points and times.

A phase is the blend about point k, or the constant part of the move from it. With u the speed of the move to the
point and w that of the move from it, q - p, qd and qdd are a u + c w, with a and c that depend on the times alone.
"""

import numpy as np

from ..common.arrays import Array
from .blend_times import Times

TIMES = ((-1, 1), (0, 1), (-1, 0), (0, 0), (1, 0))
"""The times about point k on which its phases depend: (which from k, 1 at constant speed or 0 blend)."""


def lengths(times: Times) -> Array:
    """Of the phases [s]."""
    lengths = np.empty(2 * len(times.blends) - 1)
    lengths[::2], lengths[1::2] = times.blends, times.straight
    return lengths


def coefficients(times: Times, s: Array) -> tuple[Array, Array]:
    """What multiplies the speeds to and from a phase's point in q - p, qd and qdd, each (3, phases, samples)."""
    b, straight = times.blends[:, None], times.straight[:, None]
    into, out = (np.zeros((3, 2 * len(b) - 1, len(s))) for _ in range(2))
    into[0, ::2], into[1, ::2], into[2, ::2] = b * (s - 0.5 - 0.5 * s**2), 1.0 - s, -1.0 / b
    out[0, ::2], out[1, ::2], out[2, ::2] = 0.5 * b * s**2, s, 1.0 / b
    out[0, 1::2], out[1, 1::2] = 0.5 * b[:-1] + straight * s, 1.0
    return into, out


def derivatives(times: Times, s: Array, u: Array, w: Array) -> tuple[Array, list[Array]]:
    """Derivatives of q, qd, qdd in the points before, at and after, and in ``TIMES``.

    Args:
        times: of the motion.
        s: shares of a phase's time.
        u, w: speeds to and from each phase's point, (phases, n).

    Returns:
        By points (3, 3, phases, samples), points first; by times (3, phases, samples, n) each.
    """
    into, out = coefficients(times, s)
    k = np.arange(into.shape[1]) // 2
    rate = np.concatenate([[0.0], 1.0 / times.between, [0.0]])
    before, after = into * rate[k, None], out * rate[k + 1, None]
    at = before - after
    at[0] += 1.0
    by_before = -np.einsum("ofs,fj->ofsj", before, u)
    by_after = -np.einsum("ofs,fj->ofsj", after, w)
    by_blend, by_straight = _by_own_times(times, s[:, None], u[:, None], w[:, None])
    by_blend += 0.5 * (by_before + by_after)
    by_times = [by_before, by_straight + by_after, 0.5 * by_before, by_blend, 0.5 * by_after]
    return np.stack([-before, at, after]), by_times


def _by_own_times(times: Times, t: Array, u: Array, w: Array) -> tuple[Array, Array]:
    """Derivatives in the phases' own blends and times at constant speed, the speeds being fixed."""
    b = times.blends[:, None, None]
    by_blend, by_straight = np.zeros((2, 3, len(u), len(t), u.shape[2]))
    by_blend[0, ::2] = u[::2] * (t - 0.5 - 0.5 * t**2) + w[::2] * 0.5 * t**2
    by_blend[0, 1::2] = 0.5 * w[1::2]
    by_blend[2, ::2] = (u[::2] - w[::2]) / b**2
    by_straight[0, 1::2] = w[1::2] * t
    return by_blend, by_straight
