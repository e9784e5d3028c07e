"""Signal processing: uneven time to even, Butterworth, central differences."""

import math

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.interpolation import MonotoneCubic
from ...common.recursion import butterworth, filtered
from ...model import Motion, Processing, Recording
from ...model.motion import Measurement

_ORDER = 4  # of the Butterworth filter on positions and speeds
_MOST_OVERSAMPLING = 1.25  # of the mean recorded rate: interpolated samples are not measurements
_FEWEST = 30  # samples
_BRIEF = 1.0
"""s: in a shorter recording the filter errs at both ends, and a higher cut-off helps little."""
_SHORTEST = 0.1
"""s: a recording that is shorter shows no motion, whatever the cut-off."""
_MOVES = 1e-3  # rad or m: rms of a joint that moves
_MOST_LOST = 0.01  # of a joint's rms motion: good cut-offs change it by 1e-3 and less
_EVEN = 1e-2  # time steps that differ by less than this fraction count as even


def measured(recording: Recording, processing: Processing) -> Measurement:
    """Make a recording even in time and filter positions and speeds; torques stay as they are.

    Accelerations are central differences of the filtered speeds, speeds of the filtered positions where the
    controller writes none. The filter runs forward and backward, so that nothing is delayed.

    Raises:
        InputError: if the recording is too short or the cut-off too high for its rate.
    """
    even = resampled(recording, grid_rate(recording, processing))
    step = float(even.t[1] - even.t[0])
    q = lowpass(even.q, step, processing.cutoff, recording.source)
    _check_cutoff(even.q, q, processing.cutoff, recording.source, step * len(q))
    qd = slopes(q, step) if even.qd is None else lowpass(even.qd, step, processing.cutoff, recording.source)
    return Measurement(Motion(even.t, _locked(q), _locked(qd), _locked(slopes(qd, step))), even.torque)


def mean_rate(recording: Recording) -> float:
    """Samples a second [Hz]."""
    return (len(recording.t) - 1) / float(recording.t[-1] - recording.t[0])


def grid_rate(recording: Recording, processing: Processing) -> float | None:
    """The even rate [Hz] to which a recording is resampled; None keeps its own."""
    return None if processing.rate is None else processing.grid_rate(mean_rate(recording))


def resampled(recording: Recording, rate: float | None) -> Recording:
    """The recording on an even time grid.

    Args:
        rate: wanted rate [Hz]; None keeps a recording that is even already, and gives an uneven one its mean
            rate.

    Raises:
        InputError: if the rate is far above the recorded one, or leaves too few samples.
    """
    times = recording.t
    mean = float(times[-1] - times[0]) / (len(times) - 1)
    if (rate is None or abs(rate * mean - 1.0) < 1e-6) and _is_even(times, mean):
        t = _grid(times[0], mean, len(times))
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
    return on_grid(recording, _grid(times[0], 1.0 / rate, count))


def _is_even(t: Array, step: float) -> bool:
    return bool((np.abs(np.diff(t) - step) < _EVEN * step).all())


def _grid(start: float, step: float, count: int) -> Array:
    return _locked(np.asarray(start + step * np.arange(count), dtype=np.float64))


def _locked(array: Array) -> Array:
    """What no one changes any more, so that a motion need not copy it."""
    if array.flags.writeable:
        array.setflags(write=False)
    return array


def on_grid(recording: Recording, t: Array) -> Recording:
    """The recording at other times within its own, by monotone cubic interpolation (PCHIP)."""
    times = np.clip(t, recording.t[0], recording.t[-1])

    def there(values: Array) -> Array:  # one joint after the other, which takes less memory
        return _locked(np.hstack([MonotoneCubic(recording.t, own[:, None])(times) for own in values.T]))

    speeds = there(recording.qd) if recording.qd is not None else None
    return Recording(t, there(recording.q), there(recording.torque), speeds, recording.source, recording.notes)


def _check_cutoff(raw: Array, filtered: Array, cutoff: float | None, source: str, duration: float) -> None:
    """A filter that changes the positions themselves is too low for the motion."""
    spread, lost = raw.std(axis=0), np.sqrt(np.mean((raw - filtered) ** 2, axis=0))
    share = np.where(spread > _MOVES, lost / np.where(spread > 0.0, spread, 1.0), 0.0)
    j = int(np.argmax(share))
    if cutoff is not None and share[j] > _MOST_LOST:
        reason = "the cut-off lies below the motion; raise --cutoff"
        if duration < _BRIEF:
            reason = f"{duration:.2g} s are too short for it; record longer"
        raise InputError(
            f"{source}: a cut-off of {cutoff:g} Hz takes {100 * share[j]:.1f} % off the motion of joint {j + 1}: "
            f"{reason}"
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
    if len(signals) < _FEWEST or step * len(signals) < _SHORTEST:
        raise InputError(
            f"{source}: {len(signals)} samples in {step * len(signals):.3g} s are too few to filter: record longer"
        )
    if cutoff * step * len(signals) < 1.0:
        raise InputError(
            f"{source}: a cut-off of {cutoff:g} Hz leaves nothing of {step * len(signals):.4g} s: raise --cutoff"
        )
    return _forward_and_backward(signals, 2.0 * cutoff * step)


def _forward_and_backward(signals: Array, cutoff: float) -> Array:
    """What ``scipy.signal.sosfiltfilt`` gives of signals (N, k); ``cutoff``: share of the Nyquist frequency."""
    sections = butterworth(_ORDER, cutoff)
    edge = 3 * (2 * len(sections) + 1)  # samples by which the ends are mirrored, scipy's number
    before = 2.0 * signals[0] - signals[edge:0:-1]
    after = 2.0 * signals[-1] - signals[-2 : -edge - 2 : -1]
    forward = filtered(sections, np.concatenate([before, signals, after]))
    return np.ascontiguousarray(filtered(sections, forward[::-1])[::-1][edge:-edge])


def slopes(values: Array, step: float) -> Array:
    """Central differences of values (N, k) that are ``step`` [s] apart, one-sided at the ends."""
    return np.asarray(np.gradient(values, step, axis=0))
