"""The table of wrong assumptions: of torque channels, of the robot's description, of how joints are read.

Each family undoes what it suspects and yields the misfit that is left.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations, product
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...model import Coupling, Robot, load_robot, robot_names
from .misfit import Model
from .reading import Reading

_LONGEST = 0.5  # s
_STEP = 0.01  # s
_CLOCKS = 0.03  # s: a delay that changes by more than this within a recording comes from two clocks
_LEAST = 0.02  # a factor beyond this, or beyond its inverse, is no unit but a channel without content
_UNIT = 0.3  # logarithm of a factor that counts as another unit
_GAIN = 0.15  # logarithm: a gain that is wrong by less is not worth a word


class Suspect(NamedTuple):
    """What may be wrong, in words, and the misfit that remains once it is corrected."""

    words: str
    misfit: float


def delays(model: Model) -> Iterator[Suspect]:
    """Torque written later or earlier than position."""
    best, misfit = _best_delay(model)
    if abs(best) >= 0.5 * _STEP:
        late = "lags" if best > 0.0 else "leads"
        yield Suspect(f"torque {late} position by about {abs(best):.2f} s", misfit)


def drifting_clocks(model: Model) -> Iterator[Suspect]:
    """A delay that grows from the first to the last third of the recording."""
    sample = model.sample
    third = len(sample.t) // 3
    if third == 0:
        return
    parts = (sample.part(0, third), sample.part(2 * third, len(sample.t)))
    first, last = (_best_delay(model.beside(model.robot, part))[0] for part in parts)
    if abs(last - first) < _CLOCKS:
        return
    start, stop = (float(np.mean(part.t)) for part in parts)
    delay = first + (last - first) / (stop - start) * (sample.t - start)
    yield Suspect(
        f"torque and position ran on two clocks (torque lags by {first:.2f} s early on and {last:.2f} s late)",
        model.misfit(sample.later(delay).torque),
    )


def _best_delay(model: Model) -> tuple[float, float]:
    tried = np.arange(-_LONGEST, _LONGEST + 0.5 * _STEP, _STEP)
    scores = [model.misfit(model.sample.later(delay).torque) for delay in tried]
    best = int(np.argmin(scores))
    return float(tried[best]), scores[best]


def signs(model: Model) -> Iterator[Suspect]:
    """One torque channel with the wrong sign."""
    for j in range(model.robot.n):
        torque = Reading.as_recorded(model.robot.n).pushed(j).of(model.sample).torque
        yield Suspect(f"the sign of the torque of joint {j + 1} is wrong", model.misfit(torque))


def swaps(model: Model) -> Iterator[Suspect]:
    """Two torque channels exchanged."""
    for i, j in combinations(range(model.robot.n), 2):
        torque = Reading.as_recorded(model.robot.n).swapped(i, j).of(model.sample).torque
        yield Suspect(f"the torques of joints {i + 1} and {j + 1} are exchanged", model.misfit(torque))


def offsets(model: Model) -> Iterator[Suspect]:
    """One torque channel with an offset, constant or growing with time."""
    t = model.sample.t
    time = (t - t.mean()) / max(float(np.ptp(t)), 1e-300)
    for j in range(model.robot.n):
        for shape, words in ((np.ones(len(t)), "holds an offset of"), (time, "drifts by")):
            column = np.zeros(model.sample.torque.shape)
            column[:, j] = shape
            size, misfit = model.with_column(column)
            yield Suspect(f"the torque of joint {j + 1} {words} {size:.3g} (N·m or N)", misfit)


def gains(model: Model) -> Iterator[Suspect]:
    """One torque channel in another unit or with a wrong drive gain."""
    for j in range(model.robot.n):
        ratio = model.gain(j)
        if not _LEAST < ratio < 1.0 / _LEAST or abs(np.log(ratio)) < _GAIN:
            continue
        torque = model.sample.torque * _at(model.robot.n, j, ratio)
        size = f"{1.0 / ratio:.2g} times too large" if ratio < 1.0 else f"{ratio:.2g} times too small"
        yield Suspect(f"the torque of joint {j + 1} is about {size} (drive gain or unit)", model.misfit(torque))


def units(model: Model) -> Iterator[Suspect]:
    """Channels that share no unit, as percent of each drive's own maximum."""
    factors = model.gains()
    usable = (factors > _LEAST) & (factors < 1.0 / _LEAST)
    if usable.all() and (np.abs(np.log(factors)) > _UNIT).sum() > 1:
        sizes = ", ".join(f"{1.0 / factor:.2g}" for factor in factors)
        yield Suspect(
            f"the torques of the joints share no unit (they are {sizes} times too large, joint by joint), as "
            "motor-side torques or percent of each drive's maximum do",
            model.misfit(model.sample.torque * factors),
        )


def gravity(model: Model) -> Iterator[Suspect]:
    """Gravity missing from the torques, or along another axis."""
    usual = np.array(model.robot.gravity)
    size = float(np.linalg.norm(usual)) or 9.81
    yield _mounted(model, np.zeros(3), "the torques hold no gravity (they are gravity-compensated)")
    yield _mounted(model, -usual, "gravity points the other way (the robot is mounted upside down)")
    for axis in range(3):
        if abs(usual[axis]) > 0.9 * size:
            continue
        for sign in (1.0, -1.0):
            along = f"{'-' * (sign < 0)}{'xyz'[axis]}"
            words = f"gravity points along {along} of frame 0 (the robot is mounted on a wall)"
            yield _mounted(model, sign * size * np.eye(3)[axis], words)


def _mounted(model: Model, g: Array, words: str) -> Suspect:
    return _described(model, replace(model.robot, gravity=(float(g[0]), float(g[1]), float(g[2]))), words)


def _described(model: Model, robot: Robot, words: str) -> Suspect:
    """The sample seen as another robot's."""
    return Suspect(words, model.beside(robot, model.sample).misfit())


def coupled(model: Model) -> Iterator[Suspect]:
    """The last two drives coupled, where the description knows nothing of it and the torques would show it."""
    robot = model.robot
    if robot.coupling is None and robot.n > 1 and robot.drives.rotor_inertia and robot.drives.friction:
        pair = (robot.n - 1, robot.n)
        variant = replace(robot, drives=replace(robot.drives, coupling=Coupling(pair)))
        words = f"the drives of joints {pair[0]} and {pair[1]} are coupled, which the description leaves out"
        yield _described(model, variant, words)


def lengths(model: Model) -> Iterator[Suspect]:
    """A length that is a tenth off."""
    robot = model.robot
    for j, joint in enumerate(robot.joints):
        for name in ("d", "r"):
            length = getattr(joint, name)
            for factor, word in ((0.9, "shorter"), (1.1, "longer")) if length != 0.0 else ():
                changed = replace(joint, **{name: factor * length})
                variant = replace(robot, joints=(*robot.joints[:j], changed, *robot.joints[j + 1 :]))
                words = f"the length {name}{j + 1} is {word} than the {length:g} m of the description"
                yield _described(model, variant, words)


def other_robots(model: Model) -> Iterator[Suspect]:
    """The recording of another robot that comes with the package."""
    for name in robot_names():
        candidate = load_robot(name)
        if name != model.robot.name and candidate.n == model.robot.n:
            yield _described(model, candidate, f"it is a recording of robot {name!r}")


def backwards(model: Model) -> Iterator[Suspect]:
    """A joint that turns the other way, in position alone or in torque too."""
    for j in range(model.robot.n):
        variant = _read(model, Reading.as_recorded(model.robot.n).turned(j))
        yield Suspect(f"the sign of q{j + 1} is wrong", variant.misfit(model.sample.torque))
        yield Suspect(f"joint {j + 1} is counted the other way, in position and torque", variant.misfit())


def exchanged(model: Model) -> Iterator[Suspect]:
    """Two joints that changed places."""
    for i, j in combinations(range(model.robot.n), 2):
        variant = _read(model, Reading.as_recorded(model.robot.n).swapped(i, j))
        yield Suspect(f"joints {i + 1} and {j + 1} are exchanged", variant.misfit())
        misfit = variant.misfit(model.sample.torque)
        yield Suspect(f"the positions of joints {i + 1} and {j + 1} are exchanged", misfit)


def zeros(model: Model) -> Iterator[Suspect]:
    """A joint whose zero lies a quarter or half turn away."""
    for j, quarters in product(range(1, model.robot.n), (1, 3, 2)):
        misfit = _read(model, Reading.as_recorded(model.robot.n).moved(j, quarters)).misfit()
        yield Suspect(f"the zero of q{j + 1} is off by {180 if quarters == 2 else 90} degrees", misfit)


def _read(model: Model, reading: Reading) -> Model:
    """The sample with its joints read in another way."""
    return model.beside(model.robot, reading.of(model.sample))


def frozen(model: Model) -> Iterator[Suspect]:
    """An encoder that sticks while the robot moves on."""
    sample = model.sample
    for j in range(model.robot.n):
        still = sample.stuck[:, j]
        if still.any() and not still.all():
            rest = replace(sample, keep=sample.keep & ~still[:, None])
            start, stop = sample.t[still][0], sample.t[still][-1]
            words = f"the encoder of joint {j + 1} is stuck from {start:.3g} s to {stop:.3g} s"
            yield Suspect(words, model.beside(model.robot, rest).misfit())


def _at(n: int, j: int, value: float) -> Array:
    """Ones, but ``value`` for one joint, shape (n,)."""
    factors = np.ones(n)
    factors[j] = value
    return factors


FAMILIES: tuple[Callable[[Model], Iterator[Suspect]], ...] = (
    delays,
    signs,
    swaps,
    gravity,
    exchanged,
    backwards,
    drifting_clocks,
    other_robots,
    coupled,
    offsets,
    gains,
    units,
    zeros,
    frozen,
    lengths,
)
"""The likelier ones first: where two explain the same, the first is reported."""
