"""Rests of a recording: poses that are held, the side each joint came from, and the torque that holds them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...common import Array, InputError, without
from ...model import Processing, Recording
from .filtering import measurement

_SHORTEST = 0.6  # s: where a motion only turns round, the arm rests for less
_SETTLED = 0.5, 0.8  # of a rest: before, its torque settles; after, the next motion begins
_TREND = 0.2  # s of a rest after which its torque oscillates only where something swings
_CAME = 2e-3  # rad or m: a joint that came from less far away did not move
_BIN, _FASTEST = 0.1, 10.0  # Hz


class Rests(NamedTuple):
    """R rests of one recording of n joints, each after a motion."""

    q: Array  # mean once settled [rad or m], R x n
    torque: Array  # mean once settled [N·m or N], R x n
    side: Array  # way a joint came, 1, -1 or 0, R x n
    moving: Array  # deviation of the torques on the way, (n,)
    held: tuple[Array, ...]  # torques at rest, m x n
    rate: float  # of those [Hz]


def rests_of(recording: Recording, processing: Processing) -> Rests:
    """Find the rests of a recording: slower than ``still_speed`` for 0.6 s, and after a motion."""
    data = measurement(recording, processing)
    q, torque, rate = data.motion.q, data.torque, data.motion.rate
    still = (np.abs(data.motion.qd) < processing.still_speed).all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], still, [False]]))).reshape(-1, 2)
    earlier, found, held = 0, list[tuple[Array, ...]](), list[Array]()
    for start, stop in edges[np.diff(edges)[:, 0] >= _SHORTEST * rate].tolist():
        if start > 0:
            settled = slice(*(start + int(part * (stop - start)) for part in _SETTLED))
            pose = q[settled].mean(axis=0)
            away = (q[earlier:start] - pose)[::-1]
            far = np.abs(away) > _CAME
            side = -np.sign(np.take_along_axis(away * far, far.argmax(axis=0)[None], axis=0)[0])
            found.append((pose, torque[settled].mean(axis=0), side))
            held.append(torque[start + int(_TREND * rate) : stop])
        earlier = stop
    if not found:
        raise InputError(
            f"{recording.source}: no pose is held for {_SHORTEST:g} s after a motion, all joints slower than "
            f"{processing.still_speed:g} rad/s or m/s: let it rest, or weigh without --static"
        )
    pose, mean, side = map(np.array, zip(*found, strict=True))
    return Rests(pose, mean, side, torque[~still].std(axis=0), tuple(held), rate)


def oscillation(rests: Sequence[Rests]) -> tuple[Array, Array]:
    """Frequencies [Hz], (F,), and rms of the torques' oscillations at rest [N·m or N], F x n, trends taken off."""
    frequencies, squares = np.arange(_BIN, _FASTEST, _BIN), list[Array]()
    for one in rests:
        for held in one.held:
            line = np.column_stack([np.ones(len(held)), np.linspace(0.0, 1.0, len(held))])
            waves = np.fft.rfft(without(held, line), max(round(one.rate / _BIN), len(held)), axis=0)
            squares.append(2.0 * np.abs(waves[1 : len(frequencies) + 1]) ** 2 / len(held) ** 2)
    return frequencies, np.asarray(np.sqrt(np.mean(squares, axis=0)))
