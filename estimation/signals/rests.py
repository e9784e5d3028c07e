"""Rests of a recording: poses that are held, the side each joint came from, and the torque that holds them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...common.arrays import Array
from ...common.brief import Brief
from ...common.errors import InputError
from ...common.linear import decomposed
from ...model import Processing, Recording
from .filtering import measurement

SHORTEST = 0.6
"""Duration [s] of a rest that counts; where a motion only turns round the arm stands still for less."""
_SETTLES = 0.5  # of a rest: its first part, in which the torque settles
_CAME = 2e-3  # rad or m: a joint that came from less far away did not move
_BEFORE = 0.3  # s of motion before a rest
_TREND = 0.2  # s of a rest after which torque oscillates only where something swings
_SLOWEST, _FASTEST, _STEP = 0.5, 10.0, 0.1  # Hz


@dataclass(frozen=True, eq=False, repr=False)
class Rests(Brief):
    """Rests of one recording that follow a motion, R of n joints.

    Attributes:
        t: middle of what is averaged [s], shape (R,).
        q: positions [rad or m], R x n.
        torque: mean once it has settled [N·m or N], R x n.
        before: mean torque at the end of the motion before [N·m or N], R x n.
        side: direction each joint came in, 1 or -1, 0 for one that did not move, R x n.
        held: times [s], (m,), and torques, m x n, of each rest but for its beginning.
    """

    t: Array
    q: Array
    torque: Array
    before: Array
    side: Array
    held: tuple[tuple[Array, Array], ...]


def rests_of(recording: Recording, processing: Processing) -> Rests:
    """Find the rests of a recording, slower than ``still_speed`` for 0.6 s; one that nothing precedes has no side.

    Raises:
        InputError: if there are none.
    """
    data = measurement(recording, processing)
    t, q, torque = data.motion.t, data.motion.q, data.torque
    still = (np.abs(data.motion.qd) < processing.still_speed).all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], still, [False]])))
    spans = [(a, b) for a, b in edges.reshape(-1, 2).tolist() if t[b - 1] - t[a] >= SHORTEST]
    earlier, found, held = 0, list[tuple[Array, ...]](), list[tuple[Array, Array]]()
    for start, stop in spans:
        settled, trend = np.searchsorted(t, t[start] + [_SETTLES * (t[stop - 1] - t[start]), _TREND])
        if start > 0:
            pose = q[settled:stop].mean(axis=0)
            away = q[earlier:start] - pose
            last = len(away) - 1 - np.argmax(np.abs(away[::-1]) > _CAME, axis=0)
            side = -np.sign(away[last, range(len(pose))]) * (np.abs(away) > _CAME).any(axis=0)
            before = torque[max(earlier, int(np.searchsorted(t, t[start] - _BEFORE))) : start].mean(axis=0)
            found.append((t[settled:stop].mean(), pose, torque[settled:stop].mean(axis=0), before, side))
            held.append((t[trend:stop], torque[trend:stop]))
        earlier = stop
    if not found:
        raise InputError(
            f"{recording.source}: no pose is held for {SHORTEST:g} s after a motion: record a motion that rests, "
            "as 'dynident near --static' gives, or weigh in motion, without --static"
        )
    at, pose, mean, before, side = map(np.array, zip(*found, strict=True))
    return Rests(at, pose, mean, before, side, tuple(held))


def oscillation(rests: Sequence[Rests]) -> tuple[Array, Array, Array]:
    """Torque that oscillates during rests, whatever its phase in each, beside a constant and a trend.

    Returns:
        Frequencies [Hz], (F,); rms of the oscillation [N·m or N], F x n; its power over that of white noise, F x n.
    """
    frequencies, held = np.arange(_SLOWEST, _FASTEST, _STEP), [own for one in rests for own in one.held]
    explained, left = np.zeros((2, len(frequencies), rests[0].q.shape[1]))
    for t, torque in held:
        trend = decomposed(np.column_stack([np.ones(len(t)), t - t[0]])).range
        rest, turns = torque - trend @ (trend.T @ torque), 2.0 * np.pi * np.outer(t - t[0], frequencies)
        c, s = (wave - trend @ (trend.T @ wave) for wave in (np.cos(turns), np.sin(turns)))
        cc, ss, cs = (np.sum(product, axis=0)[:, None] for product in (c * c, s * s, c * s))
        a, b, whole = c.T @ rest, s.T @ rest, (turns[-1] >= 2.0 * np.pi)[:, None]  # less is no other than a trend
        raised = (a**2 * ss - 2.0 * a * b * cs + b**2 * cc) / (cc * ss - cs**2)
        explained += whole * raised / len(t)
        left += whole * np.maximum(np.sum(rest**2, axis=0) - raised, 0.0) / len(t) / max(len(t) - 4, 1)
    white = np.divide(explained, 2.0 * left, out=np.zeros_like(left), where=left > 0.0)
    return frequencies, np.sqrt(explained / max(len(held), 1)), white
