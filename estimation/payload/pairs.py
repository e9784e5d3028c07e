"""Recordings of one trajectory without and with payload, whose torques (29) subtracts: their order, cut alike."""

from collections.abc import Sequence
from contextlib import suppress
from itertools import groupby, pairwise, product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...common import Array, InputError
from ...model import Processing, Recording, Robot
from ...model.motion import Measurement
from ..equations.observer import known_spring
from ..signals.filtering import aligned, grid_rate
from ..signals.rows import cut, origin, shortest_piece

_TRIED = 12  # number of combinations of pieces that are aligned in search of the lag
Recordings = Sequence[Recording]
_Pair = tuple[Recording, Recording, float | None]
"""Recordings without and with payload, and the lag where it is known [s]."""


class Order(NamedTuple):
    """Order of R recordings, those without payload first, and their times."""

    text: str
    unit: str
    t: Array  # by a clock in hours, (R,)
    # By the clock, how much later each loaded one is than its partner, over the mean step; none if all are later.
    gaps: Array

    @staticmethod
    def of(loaded: Recordings, unloaded: Recordings) -> "Order":
        """Order recordings by their clock, if they share one, else half of those unloaded first and half last."""
        recordings, bare, half = [*unloaded, *loaded], len(unloaded), (len(unloaded) + 1) // 2
        ends = np.array([one.origin + one.t[[0, -1]] for one in recordings])
        places, t = np.argsort(ends[:, 0], kind="stable"), ends.mean(axis=1) / 3600.0
        clocked = bool((ends[places[1:], 0] >= ends[places[:-1], 1]).all())
        if not clocked:
            places = np.array([*range(half), *range(bare, len(recordings)), *range(half, bare)])
            t = np.argsort(places).astype(float)
        text = ", ".join("loaded" if k >= bare else "unloaded" for k in places)
        gaps = (t[bare:] - t[:bare]) * (len(t) - 1) / np.ptp(t) if clocked and 2 * bare == len(t) else t[:0]
        gaps = gaps if gaps.size and gaps.min() < 0.0 < gaps.max() else t[:0]
        how, unit = (" by their clock", "hour") if clocked else (" as given", "recording")
        return Order(text + how, unit, t, gaps)


class PairedMeasurement(NamedTuple):
    """Measurements of one trajectory without and with payload, on the loaded recording's time."""

    unloaded: Measurement
    loaded: Measurement
    lag: float = 0.0  # what the loaded recording's clock shows more than the unloaded one's own [s]


def torque_change(robot: Robot, unloaded: Measurement, loaded: Measurement, path: Array) -> Measurement:
    """Difference of torques Y_T - Y_wL on the loaded motion; ``path``: by which the robot's own differ there.

    The observer moves the spring's torque into Y; in a difference it is there twice, and the first goes along.
    """
    spring = known_spring(robot)
    earlier = None if spring is None else spring.torque(unloaded.motion.q[:, spring.joint - 1])
    return Measurement(loaded.motion, loaded.torque - unloaded.torque, earlier, path)


def cut_alike(
    loaded: Recordings, unloaded: Recordings, processing: Processing
) -> tuple[Recordings, Recordings, Sequence[float | None]]:
    """Cut recordings alike where gaps split those of one file into more pieces; give the known lags [s] besides.

    They stay as they are where they form pairs already, or where no pairs can be made of them. The pieces of a file
    follow each other; the k-th file without payload is of the trajectory of the k-th with it.
    """
    whole = tuple(loaded), tuple(unloaded), (None,) * len(loaded)
    loaded_files, unloaded_files = ([[*own] for _, own in groupby(files, origin)] for files in (loaded, unloaded))
    if len(loaded) == len(unloaded) or len(loaded_files) != len(unloaded_files):
        return whole
    with suppress(InputError):  # no pair of one trajectory: method 3 refuses it where it is asked for
        files = zip(unloaded_files, loaded_files, strict=True)
        if pairs := [pair for a, b in files for pair in _pieces(a, b, processing)]:
            unloaded_pieces, loaded_pieces, lags = zip(*pairs, strict=True)
            return loaded_pieces, unloaded_pieces, lags
    return whole


def _pieces(unloaded: Recordings, loaded: Recordings, processing: Processing) -> list[_Pair]:
    """Pair pieces of two files between the gaps of either, on the same stretches of the motion."""
    if len(unloaded) == len(loaded) == 1:
        return [(unloaded[0], loaded[0], None)]
    # The lag of the files' clocks is that of two pieces that are alike, the longest first.
    longest = sorted(product(unloaded, loaded), key=lambda pair: -min(float(np.ptp(one.t)) for one in pair))
    for a, b in longest[:_TRIED]:
        with suppress(InputError):
            lag = aligned(a, b, grid_rate(b, processing), processing.max_mismatch).lag
            break
    else:
        raise InputError(f"{origin(unloaded[0])} and {origin(loaded[0])} are not the same trajectory")
    gaps = sorted(
        0.5 * float(before.t[-1] + after.t[0]) + ahead
        for pieces, ahead in ((loaded, 0.0), (unloaded, lag))
        for before, after in pairwise(pieces)
    )
    least, pairs = shortest_piece(processing.cutoff), list[_Pair]()

    def within(pieces: Recordings, low: float, high: float, partner: Recording) -> Recording | None:
        """Cut out what of a file lies between two times and is long enough; ``partner`` is named in a note."""
        for piece in pieces:
            rows = slice(*(int(row) for row in np.searchsorted(piece.t, [low, high])))
            if rows.stop - rows.start > 1 and piece.t[rows.stop - 1] - piece.t[rows.start] >= least:
                note = (
                    f"cut where {Path(origin(partner)).name} lacks rows, so that method 3 compares what both have"
                )
                return next(cut(piece, [rows], [note] * (rows != slice(0, len(piece.t)))))
        return None

    for low, high in pairwise([-np.inf, *gaps, np.inf]):
        without = within(unloaded, low - lag, high - lag, loaded[0])
        under_load = within(loaded, low, high, unloaded[0])
        if without is not None and under_load is not None:
            pairs.append((without, under_load, lag))
    return pairs
