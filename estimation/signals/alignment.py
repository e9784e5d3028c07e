"""Brings two recordings of the same trajectory onto one time."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...common import Array, InputError
from ...model import Recording
from .filtering import monotone_cubic, on_grid, resampled, taken

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


def aligned(unloaded: Recording, loaded: Recording, rate: float | None, max_mismatch: float) -> AlignedPair:
    """Align recordings of one trajectory as ``best_aligned`` does, refuse others as ``check_mismatch`` does."""
    pair = best_aligned(unloaded, loaded, rate)
    check_mismatch(pair, max_mismatch)
    return pair


def check_mismatch(pair: AlignedPair, max_mismatch: float) -> None:
    """Refuse a pair whose positions differ by more than that, rms of the worst joint [rad or m]."""
    if pair.rms_mismatch <= max_mismatch:
        return
    joint = int(np.argmax(np.hypot(pair.constant, pair.changing)))
    how = f" by a constant {pair.constant[joint]:+.3g}" if joint in pair.new_zeros else ""
    raise _different(
        pair.unloaded,
        pair.loaded,
        f"q{joint + 1} differs{how} by {pair.rms_mismatch:.3g} (rms, limit {max_mismatch:g}; rad or m) after "
        "alignment",
        ", or raise the setting max-mismatch" * (pair.rms_mismatch < _NEAR_LIMIT * max_mismatch),
    )


def best_aligned(
    unloaded: Recording, loaded: Recording, rate: float | None, near: float | None = None
) -> AlignedPair:
    """Align recordings of one trajectory by cross-correlation of the positions, to a fraction of a sample.

    ``rate``: even rate to resample to [Hz], by default the loaded one's mean; ``near``: the lag [s] to a sample,
    where it is known.
    """
    loaded = resampled(loaded, rate)
    step = float(loaded.t[1] - loaded.t[0])
    reference = resampled(unloaded, 1.0 / step)
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
    lag = _fine_lag(unloaded, loaded, near, step, every)
    low = max(loaded.t[0], unloaded.t[0] + lag)
    high = min(loaded.t[-1], unloaded.t[-1] + lag)
    inside = slice(*np.searchsorted(loaded.t, [low, np.nextafter(high, np.inf)]))
    if inside.stop - inside.start < 0.5 * min(len(loaded.t), len(reference.t)):
        raise _different(unloaded, loaded, "they overlap by less than half")
    b = taken(loaded, inside)
    a = replace(on_grid(unloaded, b.t - lag), t=b.t)
    difference = b.q - a.q
    return AlignedPair(
        a,
        b,
        lag,
        max_mismatch=float(np.abs(difference).max()),
        rms_mismatch=float(np.sqrt(np.mean(difference**2, axis=0)).max()),
        constant=tuple(difference.mean(axis=0).tolist()),
        changing=tuple(difference.std(axis=0).tolist()),
    )


def _different(unloaded: Recording, loaded: Recording, why: str, or_else: str = "") -> InputError:
    return InputError(
        f"{unloaded.source} and {loaded.source} are not the same trajectory: {why}: run the same motion without "
        f"and with the payload{or_else}"
    )


def _fine_lag(unloaded: Recording, loaded: Recording, coarse: float, step: float, every: int) -> float:
    """Find the lag with the smallest squared difference of position, by a parabola around the best fine step.

    ``coarse`` is sure to ``every`` steps. Of long recordings some stretches are compared.
    """
    width, compared = 2.0 * step * every, list[tuple[Array, Array, Callable[[Array], Array]]]()
    size = len(loaded.t) if len(loaded.t) <= _COMPARED else _COMPARED // _STRETCHES
    for start in range(0, len(loaded.t), max(size, len(loaded.t) // _STRETCHES)):
        t, q = loaded.t[start : start + size], loaded.q[start : start + size]
        low, high = np.searchsorted(unloaded.t, [t[0] - coarse - 2.0 * width, t[-1] - coarse + 2.0 * width])
        near = slice(max(int(low) - _NEIGHBOURS, 0), int(high) + _NEIGHBOURS)
        if len(unloaded.t[near]) > 1:
            compared.append((t, q, monotone_cubic(unloaded.t[near], unloaded.q[near])))

    def mismatch(lag: float) -> float:
        difference = np.concatenate([positions(t - lag) - q for t, q, positions in compared])
        return float(np.nanmean(difference**2)) if np.isfinite(difference).any() else np.inf

    lag = coarse
    while width > step / _FINE:
        candidates = lag + width * np.linspace(-1.0, 1.0, 9)
        lag = float(candidates[int(np.argmin([mismatch(c) for c in candidates]))])
        width /= 4.0
    low, mid, high = (mismatch(lag + d) for d in (-width, 0.0, width))
    curve = low - 2.0 * mid + high
    return lag + (0.5 * width * (low - high) / curve if 0.0 < curve < np.inf else 0.0)
