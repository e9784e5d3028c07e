"""Recordings made even in time, filtered and decimated, and two of one trajectory brought onto one time.

Rows are used where the robot moves, the speed's sign is known and the filter has settled.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import cache
from itertools import chain
from typing import NamedTuple
from weakref import finalize

import numpy as np

from ...common import Array, InputError, Mask
from ...common.recursion import butterworth, filtered
from ...model import Motion, Processing, Recording
from ...model.motion import Measurement

_ORDER = 4  # of the Butterworth filter on positions and speeds
_MOST_OVERSAMPLING = 1.25  # of the mean recorded rate: interpolated samples are not measurements
_FEWEST = 30  # samples
_BRIEF = 1.0  # duration [s] below which the filter errs at both ends, and a higher cut-off helps little
_SHORTEST = 0.1  # duration [s] below which a recording shows no motion, whatever the cut-off
_MOVES = 1e-3  # rad or m: rms of a joint that moves
_MOST_LOST = 0.01  # of a joint's rms motion: good cut-offs change it by 1e-3 and less
_ENDS = 1.5  # periods of the cut-off by which an end is mirrored where a motion was cut
_WINDOW = 0.1  # periods, over which the speed at an end is taken
_FULL_MOTION = 0.1  # of a joint's largest speed
_BRIDGE = 0.3  # s: a pause shorter than this does not end a moving stretch
_STRETCH = 1.0  # s: a moving stretch shorter than this is left out
_SETTLES = 3.0  # periods of the cut-off after which the filter has forgotten that the motion was cut: to 1e-3
_LEFT_OUT = 0.05  # of a recording, at either end, at most
_EVEN = 1e-2  # time steps that differ by less than this fraction count as even
_HALF = 10  # decimated samples that the filter reaches to either side
_CUTOFF = 0.8  # of the new Nyquist frequency
_GROUP = 8  # decimated samples computed by one matrix product: few zeros in it, few products


def monotone_cubic(t: Array, values: Array) -> Callable[[Array], Array]:
    """Interpolate values (N, k) between rising times (N,) without overshoot (PCHIP); nan beyond the ends."""
    from scipy.interpolate import PchipInterpolator  # takes its time to import

    interpolated: Callable[[Array], Array] = PchipInterpolator(t, values, extrapolate=False)
    return interpolated


_made: dict[tuple[int, float | None, float | None], Measurement] = {}  # by a recording's identity, rate and cut-off


def measurement(recording: Recording, processing: Processing) -> Measurement:
    """Make a recording even in time and filter positions and speeds; torques stay as they are.

    Accelerations are central differences of the filtered speeds, speeds of the filtered positions where the
    controller writes none. The filter runs both ways: nothing is delayed. What it gives is kept with the recording.
    """
    key = id(recording), grid_rate(recording, processing), processing.cutoff
    if key in _made:
        return _made[key]
    even = resampled(recording, key[1])
    step, ends = float(even.t[1] - even.t[0]), (0, 0)
    window, mirrored = (int(periods * even.rate / (processing.cutoff or np.inf)) for periods in (_WINDOW, _ENDS))
    if window and len(even.t) >= 3 * mirrored:  # an end where a motion was cut is mirrored, as if it went on
        moves = np.abs(even.q[window:] - even.q[:-window])[:, even.q.std(axis=0) > _MOVES]
        full = _FULL_MOTION * moves.max(axis=0, initial=0.0)
        ends = mirrored * bool((moves[0] > full).any()), mirrored * bool((moves[-1] > full).any())
    how = step, processing.cutoff, recording.source, ends
    q = lowpass(even.q, *how)
    # A filter that changes the positions themselves is too low for the motion.
    spread, inner = even.q.std(axis=0), slice(ends[0], len(q) - ends[1])
    lost = np.sqrt(np.mean((even.q - q)[inner] ** 2, axis=0))
    ratio = np.where(spread > _MOVES, lost / np.where(spread > 0.0, spread, 1.0), 0.0)
    j = int(np.argmax(ratio))
    if ratio[j] > _MOST_LOST:
        reason = "raise --cutoff"
        if step * len(q) < _BRIEF:
            reason = f"{step * len(q):.2g} s is too short for it; record longer"
        removed = f"removes {100 * ratio[j]:.1f} % of the motion of joint {j + 1}"
        raise InputError(f"{recording.source}: a cut-off of {processing.cutoff:g} Hz {removed}: {reason}")
    qd = np.gradient(q, step, axis=0) if even.qd is None else lowpass(even.qd, *how)
    _made[key] = Measurement(Motion(even.t, q, qd, np.gradient(qd, step, axis=0)), even.torque)
    finalize(recording, _made.pop, key, None)
    return _made[key]


def grid_rate(recording: Recording, processing: Processing) -> float | None:
    """Even rate [Hz] to which a recording is resampled; None keeps its own."""
    return None if processing.rate is None else processing.grid_rate(recording.rate)


def resampled(recording: Recording, rate: float | None) -> Recording:
    """Resample the recording on an even time grid of a rate [Hz]; None: its mean, unless it is even."""
    times, count = recording.t, len(recording.t)
    mean = float(times[-1] - times[0]) / (count - 1)
    step = 1.0 / rate if rate else mean
    if abs(mean / step - 1.0) < 1e-6 and (np.abs(np.diff(times) - mean) < _EVEN * mean).all():
        return replace(recording, t=times[0] + mean * np.arange(count))
    fault, count = "", math.floor((times[-1] - times[0]) / step * (1.0 + 1e-12)) + 1
    if mean / step > _MOST_OVERSAMPLING:
        fault = f"was recorded at {1 / mean:.4g} Hz; {rate:g} Hz would only interpolate: lower rate"
    elif count < _FEWEST:
        fault = f"{count} samples at {1 / step:g} Hz are too few: raise rate, record longer"
    if fault:
        raise InputError(f"{recording.source}: {fault}")
    return on_grid(recording, times[0] + step * np.arange(count))


def on_grid(recording: Recording, t: Array) -> Recording:
    """Interpolate the recording at other times within its own, by monotone cubics (PCHIP)."""
    times = np.clip(t, recording.t[0], recording.t[-1])

    def there(values: Array) -> Array:  # one joint after the other, which takes less memory
        return np.column_stack([monotone_cubic(recording.t, own)(times) for own in values.T])

    speeds = there(recording.qd) if recording.qd is not None else None
    return replace(recording, t=t, q=there(recording.q), torque=there(recording.torque), qd=speeds)


def taken(recording: Recording, rows: slice) -> Recording:
    """Take some rows of a recording."""
    qd = None if recording.qd is None else recording.qd[rows]
    return replace(recording, t=recording.t[rows], q=recording.q[rows], torque=recording.torque[rows], qd=qd)


def lowpass(signals: Array, step: float, cutoff: float | None, name: str, ends: tuple[int, int] = (0, 0)) -> Array:
    """Filter signals (N, k), ``step`` [s] apart, by a zero-phase Butterworth; unchanged without a cut-off [Hz].

    Both ends are mirrored by as many samples as in ``scipy.signal.sosfiltfilt``, or by ``ends`` if these are more.
    """
    if cutoff is None:
        return signals
    count, seconds, fault = len(signals), step * len(signals), ""
    if cutoff * step >= 0.5:
        fault = f"cut-off {cutoff:g} Hz is not below {0.5 / step:.4g} Hz, half the sampling rate: lower --cutoff"
    elif count < _FEWEST or seconds < _SHORTEST:
        fault = f"{count} samples in {seconds:.3g} s are too few to filter: record longer"
    elif cutoff * step * count < 1.0:
        fault = f"a cut-off of {cutoff:g} Hz leaves nothing of {seconds:.4g} s: raise --cutoff"
    if fault:
        raise InputError(f"{name}: {fault}")
    sections = butterworth(_ORDER, 2.0 * cutoff * step)
    first, last = (max(3 * (2 * len(sections) + 1), end) for end in ends)
    before = 2.0 * signals[0] - signals[first:0:-1]
    after = 2.0 * signals[-1] - signals[-2 : -last - 2 : -1]
    forward = filtered(sections, np.concatenate([before, signals, after]), before[0])
    return np.ascontiguousarray(filtered(sections, forward[::-1], forward[-1])[::-1][first:-last])


def used_rows(motion: Motion, processing: Processing) -> Mask:
    """Mark the rows of a motion that are used, N x n; decimated ones go by the sample in their middle.

    The robot is on its way there, the joint not slow and the filter settled. Where it is in full motion at an end,
    three periods of the cut-off (5 % of the recording at most) are left out: how it goes on the filter cannot know.
    """
    t, speed, inner = motion.t, np.abs(motion.qd), moving_parts(motion, processing.still_speed)
    if processing.cutoff:
        full = np.maximum(_FULL_MOTION * speed.max(axis=0), processing.still_speed)
        seconds = min(_SETTLES / processing.cutoff, _LEFT_OUT * float(t[-1] - t[0]))
        first, last = (speed[[0, -1]] > full).any(axis=1)
        inner &= ~(first & (t < t[0] + seconds)) & ~(last & (t > t[-1] - seconds))
    least = least_speed(speed[inner].max(axis=0, initial=0.0), processing)
    return np.asarray((speed >= least) & (speed > 0.0) & inner[:, None])


def least_speed(fastest: Array, processing: Processing) -> Array:
    """Smallest speed of a row that is used, by each joint's largest [rad/s or m/s], shape (n,).

    None is fast enough of a joint that only creeps: friction holds it, and its torque is any within that.
    """
    least = np.maximum(processing.slow_fraction * fastest, processing.slow_speed)
    return np.where(fastest > processing.still_speed, least, np.inf)


def moving_parts(motion: Motion, still_speed: float) -> Mask:
    """Mark the samples at which some joint is faster than ``still_speed`` [rad/s or m/s], shape (N,).

    Pauses under 0.3 s belong to the motion; stretches under 1 s (a jog to the start) do not, if one is longer.
    """
    t, mask = motion.t, np.zeros(len(motion.t), dtype=bool)
    edges = np.flatnonzero(np.diff((np.abs(motion.qd) > still_speed).any(axis=1), prepend=False, append=False))
    starts, stops = edges[::2], edges[1::2]
    if starts.size == 0:
        return mask
    new = t[starts[1:]] - t[stops[:-1] - 1] > _BRIDGE
    starts, stops = starts[np.append(True, new)], stops[np.append(new, True)]
    lasts = t[stops - 1] - t[starts]
    for start, stop, last in zip(starts, stops, lasts, strict=True):
        mask[start:stop] = last >= min(_STRETCH, lasts.max())
    return mask


@cache
def _taps(factor: int) -> Array:
    """Coefficients of the low-pass filter, 20 * factor + 1, symmetric, sum 1 (Hamming window)."""
    lags = np.arange(-_HALF * factor, _HALF * factor + 1) if factor > 1 else np.zeros(1)
    taps = np.sinc(_CUTOFF / factor * lags) * np.hamming(len(lags))
    return np.asarray(taps / taps.sum())


def noise_bandwidth(factor: int) -> float:
    """Fraction of the new frequency range that white noise still fills after decimation.

    r decimated rows hold as much independent noise as ``noise_bandwidth * r`` white ones: in the pass band, where
    the columns of W live, the noise keeps its density, but its variance is smaller by this factor.
    """
    return float(factor * np.sum(_taps(factor) ** 2))


def decimated(pieces: Iterable[Array], rows: int, factor: int) -> Iterator[Array]:
    """Low-pass and keep every k-th sample, without delay; pieces of a recording give what it gives as a whole.

    Beyond the ends of a recording everything counts as zero, in Y as in W: one linear operation keeps Y = W chi.

    ``pieces``: one after the other, rows x N; each gives the decimated samples that are complete, rows x M, and
    the end those that still waited for it. ``factor`` 1 passes them through.
    """
    if factor == 1:
        yield from pieces
        return
    waiting = beyond = np.zeros((rows, _HALF * factor))
    width, taps = 2 * _HALF * factor + 1, np.pad(_taps(factor), (0, (_GROUP - 1) * factor))
    # It turns a stretch of samples into _GROUP decimated ones: one product instead of many filters.
    band = np.column_stack([np.roll(taps, k * factor) for k in range(_GROUP)])
    for signals in chain(pieces, [beyond]):
        waiting = np.concatenate([waiting, signals], axis=1)
        result = np.empty((rows, max(0, (waiting.shape[1] - width) // factor + 1)))
        for start in range(0, result.shape[1], _GROUP):
            outputs = min(_GROUP, result.shape[1] - start)
            used = waiting[:, start * factor : (start + outputs - 1) * factor + width]
            result[:, start : start + outputs] = used @ band[: used.shape[1], :outputs]
        waiting = waiting[:, result.shape[1] * factor :]
        yield result


_NEIGHBOURS = 3  # samples on either side of an interval that decide its cubic
_FINE = 50  # steps per sample in the search for the best lag
_MOST = 200_000  # samples that are correlated, of longer recordings
_COMPARED = 40_000  # samples that are compared in the search for the best lag, of longer recordings
_STRETCHES = 50  # in as many stretches
_NEAR_LIMIT = 5.0  # of the largest mismatch allowed, below which a user may mean to allow more

OFFSET, CONSTANT = 0.002, 0.2
"""Difference of positions [rad or m] of one motion if an encoder's zero was set anew, and the fraction of it that
may change: an arm that sags differs by more where its load is far out."""
CHANGING = 0.01  # difference of positions [rad or m, rms], constants aside, above which they are not of one motion


class AlignedPair(NamedTuple):
    """Two recordings of one trajectory on the same even time, and how far their positions differ [rad or m]."""

    unloaded: Recording
    loaded: Recording
    lag: float  # what the loaded recording's clock shows more at the same point of the trajectory [s]
    max_mismatch: float  # largest difference of all
    rms_mismatch: float  # root mean square of the joint that differs most
    constant: tuple[float, ...] = ()  # mean of loaded less unloaded positions, (n,)
    changing: tuple[float, ...] = ()  # root mean square of what differs besides, (n,)

    @property
    def new_zeros(self) -> tuple[int, ...]:
        """Find the joints (from 0) whose positions differ by a constant in two recordings of one motion."""
        apart, rest = np.abs(self.constant), np.array(self.changing)
        if not len(rest) or rest.max() > CHANGING:
            return ()
        return tuple(int(j) for j in np.flatnonzero((apart > OFFSET) & (rest < CONSTANT * apart)))


def check_mismatch(pair: AlignedPair, max_mismatch: float) -> None:
    """Refuse a pair whose positions differ by more than that, rms of the worst joint [rad or m]."""
    if (rms := pair.rms_mismatch) <= max_mismatch:
        return
    joint = int(np.argmax(np.hypot(pair.constant, pair.changing)))
    how = f" by a constant {pair.constant[joint]:+.3g}" if joint in pair.new_zeros else ""
    far = f"q{joint + 1} differs{how} by {rms:.3g} (rms, limit {max_mismatch:g}; rad or m) after alignment"
    or_else = ", or raise the setting max-mismatch" * (rms < _NEAR_LIMIT * max_mismatch)
    raise _different(pair.unloaded, pair.loaded, far, or_else)


def aligned(
    unloaded: Recording, loaded: Recording, rate: float | None, most: float = np.inf, near: float | None = None
) -> AlignedPair:
    """Align recordings of one trajectory by cross-correlation of the positions, to a fraction of a sample.

    Args:
        rate: even rate to resample to [Hz]; None: the loaded one's mean.
        most: largest mismatch allowed, as of ``check_mismatch``.
        near: the lag [s] to a sample, where it is known.

    Raises:
        InputError: if they overlap by less than half, or differ by more.
    """
    loaded = resampled(loaded, rate)
    step = float(loaded.t[1] - loaded.t[0])
    reference = resampled(replace(unloaded, qd=None), 1.0 / step)
    every = 1 + max(len(reference.t), len(loaded.t)) // _MOST
    if near is None:
        # The largest cross-correlation of all joints; one at rest is exactly zero.
        early, late = (own.q[::every] - own.q[0] for own in (reference, loaded))
        lags = len(early) + len(late) - 1
        length = 1 << (lags - 1).bit_length()  # of the transforms: at least as many as there are lags
        spectrum = np.zeros(length // 2 + 1, dtype=complex)
        for x, y in zip((early - early.mean(axis=0)).T, (late - late.mean(axis=0)).T, strict=True):
            if (size := float(np.linalg.norm(x) * np.linalg.norm(y))) > 0.0:
                spectrum += np.fft.rfft(x, length).conj() * np.fft.rfft(y, length) / size
        # Lags below zero stand at the end.
        correlation = np.roll(np.fft.irfft(spectrum, length), len(early) - 1)[:lags]
        near = every * step * (int(np.argmax(correlation)) - len(early) + 1) + loaded.t[0] - reference.t[0]
    # To ``every`` steps the lag is known; of long recordings some stretches are compared.
    width, compared = 2.0 * step * every, list[tuple[Array, Array, Callable[[Array], Array]]]()
    size = len(loaded.t) if len(loaded.t) <= _COMPARED else _COMPARED // _STRETCHES
    for start in range(0, len(loaded.t), max(size, len(loaded.t) // _STRETCHES)):
        t, q = loaded.t[start : start + size], loaded.q[start : start + size]
        low, high = np.searchsorted(unloaded.t, [t[0] - near - 2.0 * width, t[-1] - near + 2.0 * width])
        around = slice(max(int(low) - _NEIGHBOURS, 0), int(high) + _NEIGHBOURS)
        if len(unloaded.t[around]) > 1:
            compared.append((t, q, monotone_cubic(unloaded.t[around], unloaded.q[around])))

    def squares(lag: float) -> float:
        difference = np.concatenate([positions(t - lag) - q for t, q, positions in compared])
        there = difference[~np.isnan(difference).any(axis=1)]  # beyond an end no joint is known
        return float(np.mean(there**2)) if len(there) else np.inf

    # The smallest squared difference of position, by a parabola around the best fine step.
    lag = near
    while width > step / _FINE:
        candidates = lag + width * np.linspace(-1.0, 1.0, 9)
        lag = float(candidates[int(np.argmin([squares(c) for c in candidates]))])
        width /= 4.0
    before, middle, after = (squares(lag + d) for d in (-width, 0.0, width))
    curve = before - 2.0 * middle + after
    lag += 0.5 * width * (before - after) / curve if 0.0 < curve < np.inf else 0.0
    low, high = max(loaded.t[0], unloaded.t[0] + lag), min(loaded.t[-1], unloaded.t[-1] + lag)
    inside = slice(*np.searchsorted(loaded.t, [low, np.nextafter(high, np.inf)]))
    if inside.stop - inside.start < 0.5 * min(len(loaded.t), len(reference.t)):
        raise _different(unloaded, loaded, "they overlap by less than half")
    b = taken(loaded, inside)
    a = replace(on_grid(unloaded, b.t - lag), t=b.t)
    apart = b.q - a.q
    largest, rms = float(np.abs(apart).max()), float(np.sqrt(np.mean(apart**2, axis=0)).max())
    constant, changing = tuple(apart.mean(axis=0).tolist()), tuple(apart.std(axis=0).tolist())
    check_mismatch(pair := AlignedPair(a, b, lag, largest, rms, constant, changing), most)
    return pair


def _different(unloaded: Recording, loaded: Recording, why: str, or_else: str = "") -> InputError:
    return InputError(
        f"{unloaded.source} and {loaded.source} are not the same trajectory: {why}: run the same motion without "
        f"and with the payload{or_else}"
    )
