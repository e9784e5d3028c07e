"""Torque that is periodic in a joint's position and came with the payload: ripple of the gears.

What both recordings have alike goes with their difference. What changes with the load repeats with the motion: no
block of time shows it, and it moves the mass. Waves that a joint's equations clearly hold are therefore estimated
beside the payload, one after the other, each with all that a slightly wrong wavelength would leave. A ripple of
less than one wave over the joint's range is no different from weight and is not looked for.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from ...common.arrays import Array
from ...common.linear import decomposed
from ...model.motion import Measurement
from ..equations.observer import Observation
from ..fit.blocks import autocorrelation_time
from ..signals.decimation import decimated
from ..signals.rows import Mask

RIPPLE_CHANCE = 0.05
"""Probability of finding a wave in the noise of one joint in one recording."""
_FINER = 6  # candidates from one whole wave over the range to the next
_FURTHEST = 40  # waves over the range
_MOST = 4  # per joint
_ROWS_EACH = 20  # rows for each wave: of fewer nothing is looked for
_PASSED = 0.1  # of a wave's amplitude: what decimation leaves less of is not looked for
_AT_ONCE = 2**19  # waves times samples that are held at once, or one wave
_DEPENDENT = 0.05  # of a wave's power: explained by the payload but for this share, it cannot be separated from it


class Wave(NamedTuple):
    """``joint``: number; ``waves``: [1 per 2 pi rad or 2 pi m]; ``amplitude``: as found alone [N·m or N]."""

    joint: int
    waves: float
    amplitude: float


class _Found(NamedTuple):
    """``gain``: by how much it lowers the sum of squares."""

    waves: float
    gain: float
    columns: Array


def ripple_of(
    recording: Observation, data: Measurement, keep: Mask, decimate: int
) -> tuple[tuple[Wave, ...], tuple[Array, ...]]:
    """Waves that the equations hold beside the payload and what is free.

    Args:
        recording: the equations of a difference of torques.
        data: the measurement they come from.
        keep: its rows that were used, N x n.
        decimate: its parallel decimation.

    Returns:
        The waves, and for each joint their columns, r_j x 4 times the largest number of waves of a joint.
    """
    per_joint = []
    for j, (W, Y) in enumerate(zip(recording.W, recording.Y, strict=True)):
        position = data.motion.q[:, j] - data.motion.q[:, j].mean()
        speed = float(np.abs(data.motion.qd[keep[:, j], j]).max(initial=0.0))
        rows = _Rows(position, keep[::decimate, j], decimate, speed / data.motion.rate)
        per_joint.append(_search(W, Y, recording.t[j], rows))
    most = max(map(len, per_joint))
    waves = tuple(
        Wave(j, component.waves, float(np.sqrt(2.0 * component.gain / len(recording.Y[j - 1]))))
        for j, own in enumerate(per_joint, 1)
        for component in own
    )
    columns = []
    for own, Y in zip(per_joint, recording.Y, strict=True):
        wide = np.zeros((len(Y), 4 * most))
        for k, component in enumerate(own):
            wide[:, 4 * k : 4 * (k + 1)] = component.columns
        columns.append(wide)
    return waves, tuple(columns)


class _Rows(NamedTuple):
    """A joint's positions about their middle, rows to use, decimation, largest step from sample to sample."""

    position: Array
    keep: Mask
    decimate: int
    step: float

    def of(self, signals: Array) -> Array:
        """Signals on all samples, k x N, as the equations see them, rows x k."""
        return np.asarray(decimated(signals, self.decimate)[:, self.keep].T)

    def candidates(self) -> Array:
        """Waves from one over the range to the most that the samples resolve [rad per rad]."""
        span = float(np.ptp(self.position))
        if span <= 0.0 or self.step <= 0.0:
            return np.zeros(0)
        base = 2.0 * np.pi / span
        waves = base * (1.0 + np.arange(_FINER * (_FURTHEST - 1) + 1) / _FINER)
        return np.asarray(waves[waves * self.step < np.pi])

    def parts(self, waves: Array) -> list[Array]:
        """The waves in groups, so that memory does not grow by their number."""
        group = max(1, _AT_ONCE // len(self.position))
        return [waves[k : k + group] for k in range(0, len(waves), group)]


def _search(W: Array, torque: Array, t: Array, rows: _Rows) -> list[_Found]:
    """The clearest wave, then the clearest beside it, ..; those too large to be the autocorrelated rest."""
    waves = rows.candidates()
    most = min(_MOST, len(torque) // _ROWS_EACH)
    if not len(waves) or not most:
        return []
    Q, components = decomposed(W).range, list[_Found]()
    left = _less(torque, Q)
    while len(components) < most:
        gains = np.concatenate([_gains_of(part, rows, Q, left) for part in rows.parts(waves)])
        best = int(np.argmax(gains))
        rest = float(left @ left - gains[best])
        if _chance(float(gains[best]), rest, len(torque) - Q.shape[1] - 2) * len(waves) > RIPPLE_CHANCE:
            break
        components.append(_found(float(waves[best]), float(gains[best]), rows))
        Q = decomposed(np.column_stack([Q, components[-1].columns])).range
        left = _less(torque, Q)
    memory = max(1.0, 2.0 * autocorrelation_time([(t, left)], step) / step) if (step := _step(t)) else 1.0
    rest, spare = memory * float(left @ left), len(torque) - Q.shape[1]
    return [
        component for component in components if _chance(component.gain, rest, spare) * len(waves) <= RIPPLE_CHANCE
    ]


def _gains_of(waves: Array, rows: _Rows, Q: Array, left: Array) -> Array:
    """By how much each wave, with the columns of Q taken out, lowers the sum of squares ``left``."""
    turning = _turned(waves, rows.position)
    sines, cosines = rows.of(turning.imag), rows.of(turning.real)
    passed = np.sum(sines**2 + cosines**2, axis=0) > _PASSED**2 * len(left)
    return np.where(passed, _gains(_less(sines, Q), _less(cosines, Q), left, len(left)), 0.0)


def _turned(waves: Array, position: Array) -> NDArray[np.complex128]:
    """exp(i wave position) of evenly spaced waves, (k, N): each is the one before, turned by the same angle."""
    turning = np.empty((len(waves), len(position)), dtype=complex)
    turning[0] = np.exp(1j * waves[0] * position)
    further = np.exp(1j * (waves[1] - waves[0]) * position) if len(waves) > 1 else turning[0]
    for k in range(1, len(waves)):
        np.multiply(turning[k - 1], further, out=turning[k])
    return turning


def _found(wave: float, gain: float, rows: _Rows) -> _Found:
    """Sine and cosine of a wave, and their slopes by the wavelength, which is not known exactly."""
    turns = wave * rows.position
    shapes = [np.sin(turns), np.cos(turns)]
    return _Found(wave, gain, rows.of(np.array([*shapes, *(turns * shape for shape in shapes)])))


def _chance(gain: float, rest: float, spare: int) -> float:
    """Probability that white noise lowers the sum of squares to ``rest`` by as much (F test)."""
    return float(fdtrc(2, spare, 0.5 * gain / rest * spare)) if spare > 0 and rest > 0.0 else 1.0


def _step(t: Array) -> float:
    return float(np.diff(t).min(initial=np.inf)) if len(t) > 1 else 0.0


def _gains(s: Array, c: Array, left: Array, rows: int) -> Array:
    """By how much each pair of columns lowers the sum of squares; 0 where the pair hardly stands out."""
    ss, cc, sc = np.sum(s * s, axis=0), np.sum(c * c, axis=0), np.sum(s * c, axis=0)
    a, b = s.T @ left, c.T @ left
    determinant = ss * cc - sc**2
    independent = determinant > (_DEPENDENT * 0.5 * rows) ** 2
    raised = a**2 * cc - 2.0 * a * b * sc + b**2 * ss
    gains: Array = np.divide(raised, determinant, out=np.zeros_like(raised), where=independent)
    return gains


def _less(columns: Array, Q: Array) -> Array:
    return np.asarray(columns - Q @ (Q.T @ columns))
