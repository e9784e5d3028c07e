"""Torque channels that were written late, with another sign, in another order or unit."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from .misfit import Model
from .suspect import Suspect

_LONGEST = 0.5  # s
_STEP = 0.01  # s
_CLOCKS = 0.03  # s: a delay that changes by more than this within a recording comes from two clocks
_GAIN = 0.15  # a gain that is wrong by less is not worth a word


def delays(model: Model) -> Iterator[Suspect]:
    """Torque written later or earlier than position."""
    best, misfit = _best_delay(model)
    if abs(best) < 0.5 * _STEP:
        return
    late = "lags" if best > 0.0 else "leads"
    yield Suspect(f"torque {late} position by about {abs(best):.2f} s", misfit)


def drifting_clocks(model: Model, third: "tuple[Model, Model]") -> Iterator[Suspect]:
    """A delay that grows from the first to the last third of the recording."""
    (first, a), (last, b) = (_best_delay(part) for part in third)
    if abs(last - first) < _CLOCKS:
        return
    sample = model.sample
    start, stop = (float(np.mean(part.sample.t)) for part in third)
    slope = (last - first) / (stop - start)
    shift = first + slope * (sample.t - start)
    torque = np.column_stack([np.interp(sample.t + shift, sample.all_t, channel) for channel in sample.all_torque.T])
    yield Suspect(
        f"torque and position run on two clocks: the lag of torque goes from {first:.2f} s to {last:.2f} s",
        model.misfit(torque),
    )


def signs(model: Model) -> Iterator[Suspect]:
    """One torque channel with the wrong sign."""
    for j in range(model.sample.torque.shape[1]):
        torque = np.array(model.sample.torque)
        torque[:, j] *= -1.0
        yield Suspect(f"the sign of the torque of joint {j + 1} is wrong", model.misfit(torque))


def swaps(model: Model) -> Iterator[Suspect]:
    """Two torque channels exchanged."""
    for i, j in combinations(range(model.sample.torque.shape[1]), 2):
        torque = np.array(model.sample.torque)
        torque[:, [i, j]] = torque[:, [j, i]]
        yield Suspect(f"the torques of joints {i + 1} and {j + 1} are exchanged", model.misfit(torque))


def gains(model: Model) -> Iterator[Suspect]:
    """One torque channel in another unit or with a wrong drive gain."""
    for j in range(model.sample.torque.shape[1]):
        ratio = model.gain(j)
        if not 0.02 < ratio < 50.0 or abs(np.log(ratio)) < _GAIN:
            continue
        torque = np.array(model.sample.torque)
        torque[:, j] *= ratio
        size = f"{1.0 / ratio:.2g} times too large" if ratio < 1.0 else f"{ratio:.2g} times too small"
        yield Suspect(f"the torque of joint {j + 1} is about {size}: its drive gain or unit", model.misfit(torque))


def _best_delay(model: Model) -> tuple[float, float]:
    tried = np.arange(-_LONGEST, _LONGEST + 0.5 * _STEP, _STEP)
    scores = [model.misfit(model.sample.later(delay).torque) for delay in tried]
    best = int(np.argmin(scores))
    return float(tried[best]), scores[best]
