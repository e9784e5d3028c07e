"""Which rows of a recording are used: the robot moves, the speed's sign is known, the filter has settled."""

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...model import Motion, Processing

_BRIDGE = 0.3  # s: a pause shorter than this does not end a moving stretch
_STRETCH = 1.0  # s: a moving stretch shorter than this is left out
_SETTLES = 3.0  # periods of the cut-off after which the filter has forgotten that the motion was cut: to 1e-3
_FULL_MOTION = 0.1  # of a joint's largest speed
_MOST_LOST = 0.05  # of a recording, at either end

Mask = NDArray[np.bool_]


def used_rows(motion: Motion, processing: Processing) -> Mask:
    """Rows of a motion that are used, N x n; decimated ones go by the sample in their middle."""
    inner, speed = inner_samples(motion, processing), np.abs(motion.qd)
    least = least_speed(speed[inner].max(axis=0, initial=0.0), processing)
    used: Mask = (speed >= least) & (speed > 0.0) & inner[:, None]
    return used


def inner_samples(motion: Motion, processing: Processing) -> Mask:
    """Samples at which the robot is on its way and the filter has settled, shape (N,).

    The filter does not know how a motion goes on before the first and after the last sample: where the robot is in
    full motion there, three periods of the cut-off (5 % of the recording at most) are left out.
    """
    t, qd = motion.t, motion.qd
    moving = moving_parts(motion, processing.still_speed)
    if processing.cutoff:
        full = np.maximum(_FULL_MOTION * np.abs(qd).max(axis=0), processing.still_speed)
        seconds = min(_SETTLES / processing.cutoff, _MOST_LOST * float(t[-1] - t[0]))
        if (np.abs(qd[0]) > full).any():
            moving[: np.searchsorted(t, t[0] + seconds)] = False
        if (np.abs(qd[-1]) > full).any():
            moving[np.searchsorted(t, t[-1] - seconds, side="right") :] = False
    return moving


def least_speed(fastest: Array, processing: Processing) -> Array:
    """Speed that a row must have to be used, by each joint's largest [rad/s or m/s], shape (n,)."""
    return np.asarray(np.maximum(processing.slow_fraction * fastest, processing.slow_speed))


def moving_parts(motion: Motion, still_speed: float) -> Mask:
    """Samples at which the robot is on its way, shape (N,).

    Pauses under 0.3 s belong to the motion; a stretch under 1 s (controllers often jog to the start) is left out,
    unless there is no longer one.

    Args:
        still_speed: a joint below it stands still [rad/s or m/s].
    """
    t, on_its_way = motion.t, np.asarray((np.abs(motion.qd) > still_speed).any(axis=1))
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
