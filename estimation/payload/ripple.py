"""Ripple of the gears: torque that is periodic in a joint's position and came with the payload.

What both recordings have alike goes with their difference. What changes with the load repeats with the motion: no
block of time shows it, and it moves the mass. Waves that a joint's equations clearly hold are therefore estimated
besides the payload, one after the other, each with all that a slightly wrong wavelength would leave. A ripple of
less than one wave over the joint's range is no different from weight and is not looked for.
"""

from collections.abc import Sequence
from itertools import accumulate
from typing import NamedTuple

import numpy as np
from msgspec import field
from scipy.special import fdtrc

from ...common import Array, Document, Mask, decomposed
from ..equations.observer import Observation, Used
from ..fit.blocks import inflation
from ..signals.filtering import decimated

RIPPLE_CHANCE = 0.05  # probability of finding a wave in the noise of one joint in one recording
_FINER = 6  # candidates from one whole wave over the range to the next
_FURTHEST = 40  # waves over the range
_MOST = 4  # per joint
_ROWS_EACH = 20  # rows for each wave: of fewer nothing is looked for
_PASSED = 0.1  # of a wave's amplitude: what decimation leaves less of is not looked for
_AT_ONCE = 2**19  # waves times samples that are held at once, or one wave
_DEPENDENT = 0.05  # of a wave's power: explained by the payload but for this, it cannot be separated from it


class Wave(Document, frozen=True):
    """A wave over the turn of a joint in one recording, and the probability of any such wave in noise alone.

    ``joint``: number; ``waves``: [1 per 2 pi rad or 2 pi m]; ``amplitude``: as found alone [N·m or N].
    """

    source: str
    joint: int
    waves: float = field(name="waves_per_turn")
    amplitude: float
    probability_by_noise: float = RIPPLE_CHANCE


def ripple_of(
    source: str, matrices: Sequence[Array], recording: Observation, used: Used
) -> tuple[tuple[Wave, ...], tuple[Array, ...]]:
    """Find waves that the equations of a difference of torques hold besides the payload and what is free.

    ``matrices``: columns of the payload and of what is free, per joint; ``used``: the measurement they come from.

    Returns:
        The waves, and for each joint their columns, r_j x 4 times the largest number of waves of a joint.
    """
    (data, keep, decimate), waves, columns = used, list[Wave](), list[Array]()
    for j, (W, Y) in enumerate(zip(matrices, recording.Y, strict=True)):
        position = data.motion.q[:, j] - data.motion.q[:, j].mean()
        span, speed = float(np.ptp(position)), float(np.abs(data.motion.qd[keep[:, j], j]).max(initial=0.0))
        candidates = np.zeros(0)
        if span > 0.0 and speed > 0.0:  # from one wave over the range to the most that the samples resolve
            candidates = 2.0 * np.pi / span * (1.0 + np.arange(_FINER * (_FURTHEST - 1) + 1) / _FINER)
            candidates = candidates[candidates * speed / data.motion.rate < np.pi]
        found = _Search(position, keep[::decimate, j], decimate, candidates).found(W, Y, recording.t[j])
        columns.append(np.hstack([np.zeros((len(Y), 0)), *(own for *_, own in found)]))
        waves += [Wave(source, j + 1, wave, float(np.sqrt(2.0 * gain / len(Y)))) for wave, gain, _ in found]
    most = max(own.shape[1] for own in columns)
    return tuple(waves), tuple(np.pad(own, ((0, 0), (0, most - own.shape[1]))) for own in columns)


class _Search(NamedTuple):
    """Joint's positions about their middle, rows to use, decimation, and waves to try [rad per rad]."""

    position: Array
    keep: Mask
    decimate: int
    waves: Array

    def found(self, W: Array, torque: Array, t: Array) -> list[tuple[float, float, Array]]:
        """Find the clearest wave, its gain and its columns, then the clearest besides it, ..

        Those are left out that may be the autocorrelated rest.
        """
        waves, most = self.waves, min(_MOST, len(torque) // _ROWS_EACH)
        if not len(waves) or not most:
            return []
        group = max(1, _AT_ONCE // len(self.position))  # at once, so that memory does not grow by their number
        Q, found = decomposed(W).range, list[tuple[float, float, Array]]()
        left = _less(torque, Q)
        while len(found) < most:
            gains = np.concatenate(
                [self._gains(waves[k : k + group], Q, left) for k in range(0, len(waves), group)]
            )
            wave, gain = float(waves[np.argmax(gains)]), float(np.max(gains))
            spare = len(torque) - Q.shape[1] - 2
            if _chance(gain, float(left @ left - gain), spare) * len(waves) > RIPPLE_CHANCE:
                break
            # Sine and cosine of a wave, and their slopes by the wavelength, which is not known exactly.
            shapes = np.array([np.sin(wave * self.position), np.cos(wave * self.position)])
            columns = self._seen(np.vstack([shapes, wave * self.position * shapes]))
            found.append((wave, gain, columns))
            Q = decomposed(np.column_stack([Q, columns])).range
            left = _less(torque, Q)
        rest, spare = inflation([(t, left)]) * float(left @ left), len(torque) - Q.shape[1]
        return [wave for wave in found if _chance(wave[1], rest, spare) * len(waves) <= RIPPLE_CHANCE]

    def _seen(self, signals: Array) -> Array:
        """Filter signals on all samples, k x N, as the equations see them, rows x k."""
        return np.asarray(decimated(signals, self.decimate)[:, self.keep].T)

    def _gains(self, waves: Array, Q: Array, left: Array) -> Array:
        """Fall of the sum of squares ``left`` by each wave, with the columns of Q taken out.

        0 where its sine and cosine hardly stand out.
        """
        first, *further = np.exp(1j * np.outer([waves[0], *np.diff(waves[:2])], self.position))  # evenly spaced
        turning = np.array(list(accumulate([first, *further * (len(waves) - 1)], np.multiply)))
        sines, cosines = self._seen(turning.imag), self._seen(turning.real)
        passed = np.sum(sines**2 + cosines**2, axis=0) > _PASSED**2 * len(left)
        s, c = _less(sines, Q), _less(cosines, Q)
        ss, cc, sc = (np.sum(product, axis=0) for product in (s * s, c * c, s * c))
        a, b = s.T @ left, c.T @ left
        # The normal equations of sine and cosine by Cramer's rule: what both take off is (a, b) N^-1 (a, b)'.
        determinant = ss * cc - sc**2
        independent = determinant > (_DEPENDENT * 0.5 * len(left)) ** 2
        raised = a**2 * cc - 2.0 * a * b * sc + b**2 * ss
        return np.asarray(np.divide(raised, determinant, out=np.zeros_like(raised), where=independent & passed))


def _chance(gain: float, rest: float, spare: int) -> float:
    """Probability that white noise lowers the sum of squares to ``rest`` by as much (F test)."""
    return float(fdtrc(2, spare, 0.5 * gain / rest * spare)) if spare > 0 and rest > 0.0 else 1.0


def _less(columns: Array, Q: Array) -> Array:
    return np.asarray(columns - Q @ (Q.T @ columns))
