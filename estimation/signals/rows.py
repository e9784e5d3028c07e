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

    ``moving`` (N,): samples at which the robot is on its way; ``fastest`` (n,): each joint's largest speed there;
    ``slow_fraction``: of it, below which a joint's rows are left out.
    """

    moving: Mask
    fastest: Array
    slow_fraction: float

    def of(self, qd: Array, part: slice) -> Mask:
        """Those of some samples with the speeds ``qd``, N x n."""
        speed = np.abs(qd)
        fast: Mask = (speed >= self.slow_fraction * self.fastest) & (speed > 0.0)
        fast[~self.moving[part]] = False
        return fast


def used_rows(motion: Motion, processing: Processing) -> UsedRows:
    """Rows of a motion that are used; decimated ones go by the sample in their middle.

    The filter does not know how a motion goes on before the first and after the last sample: where the robot is in
    full motion there, three periods of the cut-off (5 % of the recording at most) are left out.
    """
    on_its_way = _on_its_way(motion, processing.still_speed)
    largest = fastest(motion.qd, np.ones(len(motion.t), dtype=bool))
    cut = cut_ends(motion.qd[[0, -1]], largest, processing)
    moving = used_samples(motion.t, on_its_way, cut, processing)
    return UsedRows(moving, fastest(motion.qd, moving), processing.slow_fraction)


def cut_ends(ends: Array, largest: Array, processing: Processing) -> tuple[bool, bool]:
    """Whether a recording was cut in full motion, at its beginning and at its end.

    Args:
        ends: speeds of the first and the last sample, 2 x n.
        largest: each joint's largest speed, shape (n,).
        processing: settings.
    """
    full = np.maximum(_FULL_MOTION * largest, processing.still_speed)
    return bool((np.abs(ends[0]) > full).any()), bool((np.abs(ends[1]) > full).any())


def used_samples(t: Array, on_its_way: Mask, cut: tuple[bool, bool], processing: Processing) -> Mask:
    """Samples of which rows are used, shape (N,).

    Args:
        t: times, shape (N,).
        on_its_way: whether some joint moves at each of them, shape (N,).
        cut: as ``cut_ends`` tells.
        processing: settings.
    """
    moving = _stretches(t, on_its_way)
    if processing.cutoff:
        seconds = min(_SETTLES / processing.cutoff, _MOST_LOST * float(t[-1] - t[0]))
        if cut[0]:
            moving[: np.searchsorted(t, t[0] + seconds)] = False
        if cut[1]:
            moving[np.searchsorted(t, t[-1] - seconds, side="right") :] = False
    return moving


def kept_rows(motion: Motion, processing: Processing) -> Mask:
    """The same at once, N x n."""
    return used_rows(motion, processing).of(motion.qd, slice(None))


def moving_parts(motion: Motion, still_speed: float) -> Mask:
    """Samples at which the robot is on its way, shape (N,).

    Pauses under 0.3 s belong to the motion; a stretch under 1 s (controllers often jog to the start) is left out,
    unless there is no longer one.

    Args:
        motion: the motion.
        still_speed: a joint below it stands still [rad/s or m/s].
    """
    return _stretches(motion.t, _on_its_way(motion, still_speed))


def _stretches(t: Array, on_its_way: Mask) -> Mask:
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


def _on_its_way(motion: Motion, still_speed: float) -> Mask:
    mask = np.empty(len(motion.t), dtype=bool)
    for part in parts(len(mask)):
        mask[part] = (np.abs(motion.qd[part]) > still_speed).any(axis=1)
    return mask


def fastest(qd: Array, chosen: Mask) -> Array:
    """Each joint's largest speed, shape (n,), over the chosen ones of the samples, N x n."""
    largest = np.zeros(qd.shape[1])
    for part in parts(len(qd)):
        largest = np.maximum(largest, np.abs(qd[part][chosen[part]]).max(axis=0, initial=0.0))
    return largest
