"""Which rows of a recording are used: the robot moves, the speed's sign is known, the filter has settled."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..model import Motion, Processing
from ..model.arrays import Array
from ..model.paged import parts

_BRIDGE = 0.3  # s: a pause shorter than this does not end a moving stretch
_STRETCH = 1.0  # s: a moving stretch shorter than this is left out
_SETTLES = 3.0  # periods of the cut-off after which the filter has forgotten that the motion was cut: to 1e-3
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

    The filter does not know how a motion goes on before the first and after the last sample: where the robot is on
    its way there, three periods of the cut-off (5 % of the recording at most) are left out.
    """
    moving = used_samples(motion.t, _on_its_way(motion, processing.still_speed), processing)
    return UsedRows(moving, _fastest(motion, moving), processing.slow_fraction)


def used_samples(t: Array, on_its_way: Mask, processing: Processing) -> Mask:
    """Samples of which rows are used, from the times and whether some joint moves at each of them, (N,)."""
    moving = _stretches(t, on_its_way)
    if processing.cutoff:
        _leave_ends(t, on_its_way, moving, _SETTLES / processing.cutoff)
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
    for part in parts(len(mask), motion.qd):
        mask[part] = (np.abs(motion.qd[part]) > still_speed).any(axis=1)
    return mask


def _leave_ends(t: Array, on_its_way: Mask, moving: Mask, seconds: float) -> None:
    """Leave out the ends at which the robot is on its way."""
    seconds = min(seconds, _MOST_LOST * float(t[-1] - t[0]))
    if on_its_way[0]:
        moving[: np.searchsorted(t, t[0] + seconds)] = False
    if on_its_way[-1]:
        moving[np.searchsorted(t, t[-1] - seconds, side="right") :] = False


def _fastest(motion: Motion, moving: Mask) -> Array:
    fastest = np.zeros(motion.n)
    for part in parts(len(moving), motion.qd):
        own = np.abs(motion.qd[part][moving[part]])
        fastest = np.maximum(fastest, own.max(axis=0, initial=0.0))
    return fastest
