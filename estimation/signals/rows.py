"""Which rows of a recording are used: the robot moves, the speed's sign is known, the filter has settled."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...common.paged import parts
from ...model import Motion, Processing

_BRIDGE = 0.3  # s: a pause shorter than this does not end a moving stretch
_STRETCH = 1.0  # s: a moving stretch shorter than this is left out
_SETTLES = 3.0  # periods of the cut-off after which the filter has forgotten that the motion was cut: to 1e-3
_FULL_MOTION = 0.1  # of a joint's largest speed
_MOST_LOST = 0.05  # of a recording, at either end

Mask = NDArray[np.bool_]


class UsedRows(NamedTuple):
    """Rows of one motion that are used.

    ``moving`` (N,): samples at which the robot is on its way; ``least`` (n,): speeds below which a joint's rows are
    left out [rad/s or m/s].
    """

    moving: Mask
    least: Array

    def of(self, qd: Array, part: slice) -> Mask:
        """Rows of some samples that are used, N x n, by the samples' speeds."""
        speed = np.abs(qd)
        fast: Mask = (speed >= self.least) & (speed > 0.0)
        fast[~self.moving[part]] = False
        return fast


def used_rows(motion: Motion, processing: Processing) -> UsedRows:
    """Rows of a motion that are used; decimated ones go by the sample in their middle.

    The filter does not know how a motion goes on before the first and after the last sample: where the robot is in
    full motion there, three periods of the cut-off (5 % of the recording at most) are left out.
    """
    t, qd = motion.t, motion.qd
    moving = moving_parts(motion, processing.still_speed)
    if processing.cutoff:
        largest = _fastest(qd, np.ones(len(t), dtype=bool))
        full = np.maximum(_FULL_MOTION * largest, processing.still_speed)
        seconds = min(_SETTLES / processing.cutoff, _MOST_LOST * float(t[-1] - t[0]))
        if (np.abs(qd[0]) > full).any():
            moving[: np.searchsorted(t, t[0] + seconds)] = False
        if (np.abs(qd[-1]) > full).any():
            moving[np.searchsorted(t, t[-1] - seconds, side="right") :] = False
    return UsedRows(moving, least_speed(_fastest(qd, moving), processing))


def least_speed(fastest: Array, processing: Processing) -> Array:
    """Speed that a row must have to be used, by each joint's largest [rad/s or m/s], shape (n,)."""
    return np.asarray(np.maximum(processing.slow_fraction * fastest, processing.slow_speed))


def kept_rows(motion: Motion, processing: Processing) -> Mask:
    """Rows of a motion that are used, all at once, N x n."""
    return used_rows(motion, processing).of(motion.qd, slice(None))


def moving_parts(motion: Motion, still_speed: float) -> Mask:
    """Samples at which the robot is on its way, shape (N,).

    Pauses under 0.3 s belong to the motion; a stretch under 1 s (controllers often jog to the start) is left out,
    unless there is no longer one.

    Args:
        still_speed: a joint below it stands still [rad/s or m/s].
    """
    t, on_its_way = motion.t, np.zeros(len(motion.t), dtype=bool)
    for part in parts(len(t)):
        for speed in motion.qd[part].T:
            on_its_way[part] |= np.abs(speed) > still_speed
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on_its_way, [False]])))
    starts, stops = edges[::2], edges[1::2]
    mask = np.zeros(len(on_its_way), dtype=bool)
    if starts.size == 0:
        return mask
    begins, ends = t[starts], t[stops - 1]
    new = begins[1:] - ends[:-1] > _BRIDGE
    starts, begins = starts[np.append(True, new)], begins[np.append(True, new)]
    stops, ends = stops[np.append(new, True)], ends[np.append(new, True)]
    lasts = ends - begins
    for start, stop, last in zip(starts, stops, lasts, strict=True):
        mask[start:stop] = last >= min(_STRETCH, lasts.max())
    return mask


def _fastest(qd: Array, chosen: Mask) -> Array:
    """Each joint's largest speed, shape (n,), over the chosen ones of the samples, N x n."""
    largest = np.zeros(qd.shape[1])
    for part in parts(len(qd)):
        for j, speed in enumerate(qd[part].T):  # one joint after the other: six times as fast as row by row
            largest[j] = max(largest[j], np.abs(speed[chosen[part]]).max(initial=0.0))
    return largest
