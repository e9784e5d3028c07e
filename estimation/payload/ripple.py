"""Ripple of the gears: torque that is periodic in a joint's position and came with the payload.

What both recordings have alike goes with their difference. What changes with the load repeats with the motion: no
block of time shows it, and it moves the mass. Waves that a joint's equations clearly hold are therefore estimated
besides the payload, one after the other, each with all that a slightly wrong wavelength would leave. A ripple of
less than one wave over the joint's range is no different from weight and is not looked for.
"""

from collections.abc import Sequence

import numpy as np
from msgspec import field
from scipy.special import fdtrc

from ...common import Array, Document, decomposed
from ..equations.observer import Observation, Used
from ..fit.blocks import inflation
from ..signals.filtering import decimated

RIPPLE_CHANCE = 0.05  # probability of finding a wave in the noise of one joint in one recording
_FINER = 6  # candidates from one whole wave over the range to the next
_FURTHEST = 40  # waves over the range
_MOST = 4  # per joint
_ROWS_EACH = 20  # rows for each wave: of fewer nothing is looked for
_PASSED = 0.1  # of a wave's amplitude: what decimation leaves less of is not looked for
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
    waves, columns = list[Wave](), list[Array]()
    for j, (W, Y, t) in enumerate(zip(matrices, recording.Y, recording.t, strict=True)):
        found = _waves(used, j, W, Y, t)
        columns.append(np.hstack([np.zeros((len(Y), 0)), *(own for *_, own in found)]))
        waves += [Wave(source, j + 1, wave, float(np.sqrt(2.0 * gain / len(Y)))) for wave, gain, _ in found]
    most = max(own.shape[1] for own in columns)
    return tuple(waves), tuple(np.pad(own, ((0, 0), (0, most - own.shape[1]))) for own in columns)


def _waves(used: Used, j: int, W: Array, torque: Array, t: Array) -> list[tuple[float, float, Array]]:
    """Find the clearest wave of a joint, its gain and its columns, then the clearest besides it, ..

    Those are left out that may be the autocorrelated rest.
    """
    (data, keep, decimate), most = used, min(_MOST, len(torque) // _ROWS_EACH)
    position = data.motion.q[:, j] - data.motion.q[:, j].mean()
    span, speed = float(np.ptp(position)), float(np.abs(data.motion.qd[keep[:, j], j]).max(initial=0.0))
    # From one wave over the range to the most that the samples resolve.
    waves = 2.0 * np.pi / max(span, 1e-9) * (1.0 + np.arange(_FINER * (_FURTHEST - 1) + 1) / _FINER)
    waves = waves[waves * speed / data.motion.rate < np.pi]
    if not (most and span and speed and len(waves)):
        return []

    def seen(signals: Sequence[Array]) -> Array:  # as the equations see them
        return np.asarray(decimated(np.array(signals), decimate)[:, keep[::decimate, j]].T)

    def fall(wave: float, Q: Array, left: Array) -> float:
        """Fall of the sum of squares by a wave beside Q; 0 where it hardly stands out."""
        pair = seen([np.sin(wave * position), np.cos(wave * position)])
        passed, pair = np.sum(pair**2) > _PASSED**2 * len(left), _less(pair, Q)
        N, b = pair.T @ pair, pair.T @ left
        independent = np.linalg.det(N) > (_DEPENDENT * 0.5 * len(left)) ** 2
        return float(b @ np.linalg.solve(N, b)) if passed and independent else 0.0

    Q, found = decomposed(W).range, list[tuple[float, float, Array]]()
    left = _less(torque, Q)
    while len(found) < most:
        gains = [fall(wave, Q, left) for wave in waves]
        gain, wave = max(gains), float(waves[np.argmax(gains)])
        if _chance(gain, float(left @ left - gain), len(torque) - Q.shape[1] - 2) * len(waves) > RIPPLE_CHANCE:
            break
        # Sine and cosine of a wave, and their slopes by the wavelength, which is not known exactly.
        shapes = [np.sin(wave * position), np.cos(wave * position)]
        found.append((wave, gain, seen([*shapes, *(wave * position * shape for shape in shapes)])))
        Q = decomposed(np.column_stack([Q, found[-1][2]])).range
        left = _less(torque, Q)
    rest, spare = inflation([(t, left)]) * float(left @ left), len(torque) - Q.shape[1]
    return [wave for wave in found if _chance(wave[1], rest, spare) * len(waves) <= RIPPLE_CHANCE]


def _chance(gain: float, rest: float, spare: int) -> float:
    """Probability that white noise lowers the sum of squares to ``rest`` by as much (F test)."""
    return float(fdtrc(2, spare, 0.5 * gain / rest * spare)) if spare > 0 and rest > 0.0 else 1.0


def _less(columns: Array, Q: Array) -> Array:
    return np.asarray(columns - Q @ (Q.T @ columns))
