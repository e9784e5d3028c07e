"""Signal processing: uneven time to even, Butterworth, central differences.

scipy.signal and scipy.interpolate are imported where they are used: they are slow to import.
"""

import math

import numpy as np

from ..model import InputError, Measurement, Motion, Processing, Recording
from ..model.arrays import Array

_ORDER = 4  # of the Butterworth filter on positions and speeds
_MOST_OVERSAMPLING = 1.25  # of the mean recorded rate: interpolated samples are not measurements
_FEWEST = 30  # samples
_MOVES = 1e-3  # rad or m: rms of a joint that moves
_MOST_LOST = 0.01  # of a joint's rms motion: good cut-offs change it by 1e-3 and less
_EVEN = 1e-2  # time steps that differ by less than this fraction count as even


def measurement(recording: Recording, processing: Processing) -> Measurement:
    """Make a recording even in time and filter positions and speeds; torques stay as they are.

    Accelerations are central differences of the filtered speeds, speeds of the filtered positions where the
    controller writes none. The filter runs forward and backward, so that nothing is delayed.

    Raises:
        InputError: if the recording is too short or the cut-off too high for its rate.
    """
    even = resampled(recording, processing.rate)
    step = float(even.t[1] - even.t[0])
    q = lowpass(even.q, step, processing.cutoff, recording.source)
    _check_cutoff(even.q, q, processing.cutoff, recording.source)
    if even.qd is None:
        qd = np.gradient(q, step, axis=0)
    else:
        qd = lowpass(even.qd, step, processing.cutoff, recording.source)
    return Measurement(Motion(even.t, q, qd, np.gradient(qd, step, axis=0)), even.torque)


def resampled(recording: Recording, rate: float | None) -> Recording:
    """The recording on an even time grid.

    Args:
        recording: the recording.
        rate: wanted rate [Hz]; None keeps a recording that is even already, and gives an uneven one its mean
            rate.

    Raises:
        InputError: if the rate is far above the recorded one, or leaves too few samples.
    """
    steps = np.diff(recording.t)
    mean = float(steps.mean())
    even = float(np.abs(steps - mean).max()) < _EVEN * mean
    if even and (rate is None or abs(rate * mean - 1.0) < 1e-6):
        t = recording.t[0] + mean * np.arange(len(recording.t))
        return Recording(t, recording.q, recording.torque, recording.qd, recording.source, recording.notes)
    rate = rate or 1.0 / mean
    if rate * mean > _MOST_OVERSAMPLING:
        raise InputError(
            f"{recording.source}: was recorded at {1 / mean:.4g} Hz; {rate:g} Hz would only interpolate: "
            "lower --rate"
        )
    count = math.floor((recording.t[-1] - recording.t[0]) * rate * (1.0 + 1e-12)) + 1
    if count < _FEWEST:
        raise InputError(
            f"{recording.source}: {count} samples at {rate:g} Hz are too few: raise --rate, record longer"
        )
    return on_grid(recording, recording.t[0] + np.arange(count) / rate)


def on_grid(recording: Recording, t: Array) -> Recording:
    """The recording at other times within its own, by monotone cubic interpolation (PCHIP)."""
    from scipy.interpolate import PchipInterpolator

    blocks = [recording.q, recording.torque] + ([recording.qd] if recording.qd is not None else [])
    times = np.clip(t, recording.t[0], recording.t[-1])
    values = PchipInterpolator(recording.t, np.hstack(blocks), axis=0)(times)
    parts = np.split(values, len(blocks), axis=1)
    qd = parts[2] if recording.qd is not None else None
    return Recording(t, parts[0], parts[1], qd, recording.source, recording.notes)


def _check_cutoff(raw: Array, filtered: Array, cutoff: float | None, source: str) -> None:
    """A filter that changes the positions themselves is too low for the motion."""
    spread = np.linalg.norm(raw - raw.mean(axis=0), axis=0)
    lost = np.linalg.norm(raw - filtered, axis=0)
    share = np.where(spread > _MOVES * np.sqrt(len(raw)), lost / np.where(spread > 0.0, spread, 1.0), 0.0)
    j = int(np.argmax(share))
    if cutoff is not None and share[j] > _MOST_LOST:
        raise InputError(
            f"{source}: a cut-off of {cutoff:g} Hz takes {100 * share[j]:.1f} % off the motion of joint {j + 1}: "
            "the cut-off lies below the motion; raise --cutoff"
        )


def lowpass(signals: Array, step: float, cutoff: float | None, source: str) -> Array:
    """Zero-phase Butterworth filter of signals (N, k), ``step`` [s] apart; no cut-off [Hz] leaves them as they are.

    Raises:
        InputError: names the source if the cut-off does not suit it.
    """
    if cutoff is None:
        return signals
    if cutoff * step >= 0.5:
        raise InputError(
            f"{source}: cut-off {cutoff:g} Hz is not below half the sampling rate of {1 / step:.4g} Hz: "
            "lower --cutoff"
        )
    if cutoff * step * len(signals) < 1.0:
        raise InputError(
            f"{source}: a cut-off of {cutoff:g} Hz leaves nothing of {step * len(signals):.4g} s: raise --cutoff"
        )
    from scipy.signal import butter, sosfiltfilt

    sos = butter(_ORDER, 2.0 * cutoff * step, output="sos")
    if len(signals) < _FEWEST:
        raise InputError(f"{source}: {len(signals)} samples are too few to filter: record longer")
    return np.asarray(sosfiltfilt(sos, signals, axis=0))
