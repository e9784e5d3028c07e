"""Torque channels that were written late, with another sign, in another order or unit."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from ....model import Robot
from .misfit import Model
from .suspect import Suspect

_LONGEST = 0.5  # s
_STEP = 0.01  # s
_CLOCKS = 0.03  # s: a delay that changes by more than this within a recording comes from two clocks
_LEAST = 0.02  # a factor beyond this, or beyond its inverse, is no unit but a channel without content
_UNIT = 0.3  # logarithm of a factor that counts as another unit
_GAIN = 0.15  # logarithm: a gain that is wrong by less is not worth a word


def delays(model: Model) -> Iterator[Suspect]:
    """Torque written later or earlier than position."""
    best, misfit = _best_delay(model)
    if abs(best) < 0.5 * _STEP:
        return
    late = "lags" if best > 0.0 else "leads"
    yield Suspect(f"torque {late} position by about {abs(best):.2f} s", misfit)


def drifting_clocks(robot: Robot, model: Model) -> Iterator[Suspect]:
    """A delay that grows from the first to the last third of the recording."""
    sample = model.sample
    third = len(sample.t) // 3
    if third == 0:
        return
    parts = (sample.part(0, third), sample.part(2 * third, len(sample.t)))
    first, last = (_best_delay(Model.of(robot, part))[0] for part in parts)
    if abs(last - first) < _CLOCKS:
        return
    start, stop = (float(np.mean(part.t)) for part in parts)
    delay = first + (last - first) / (stop - start) * (sample.t - start)
    yield Suspect(
        f"torque and position ran on two clocks (torque lags by {first:.2f} s early on and {last:.2f} s late)",
        model.misfit(sample.later(delay).torque),
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


def offsets(model: Model) -> Iterator[Suspect]:
    """One torque channel with an offset, constant or growing with time."""
    t = model.sample.t
    time = (t - t.mean()) / max(float(np.ptp(t)), 1e-300)
    for j in range(model.sample.torque.shape[1]):
        for shape, words in ((np.ones(len(t)), "holds an offset of"), (time, "drifts by")):
            column = np.zeros(model.sample.torque.shape)
            column[:, j] = shape
            size, misfit = model.with_column(column)
            yield Suspect(f"the torque of joint {j + 1} {words} {size:.3g} (N·m or N)", misfit)


def gains(model: Model) -> Iterator[Suspect]:
    """One torque channel in another unit or with a wrong drive gain."""
    for j in range(model.sample.torque.shape[1]):
        ratio = model.gain(j)
        if not _LEAST < ratio < 1.0 / _LEAST or abs(np.log(ratio)) < _GAIN:
            continue
        torque = np.array(model.sample.torque)
        torque[:, j] *= ratio
        size = f"{1.0 / ratio:.2g} times too large" if ratio < 1.0 else f"{ratio:.2g} times too small"
        yield Suspect(f"the torque of joint {j + 1} is about {size} (drive gain or unit)", model.misfit(torque))


def units(model: Model) -> Iterator[Suspect]:
    """Channels that share no unit, as percent of each drive's own maximum."""
    factors = model.gains()
    usable = (factors > _LEAST) & (factors < 1.0 / _LEAST)
    if usable.all() and (np.abs(np.log(factors)) > _UNIT).sum() > 1:
        told = ", ".join(f"{1.0 / factor:.2g}" for factor in factors)
        yield Suspect(
            f"the torques of the joints share no unit (they are {told} times too large, joint by joint), as "
            "motor-side torques or percent of each drive's maximum do",
            model.misfit(model.sample.torque * factors),
        )


def _best_delay(model: Model) -> tuple[float, float]:
    tried = np.arange(-_LONGEST, _LONGEST + 0.5 * _STEP, _STEP)
    scores = [model.misfit(model.sample.later(delay).torque) for delay in tried]
    best = int(np.argmin(scores))
    return float(tried[best]), scores[best]
