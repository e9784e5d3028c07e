"""Time of a log: its unit and origin are found out, rows that repeat a time are dropped and counted."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...common.errors import InputError
from ...estimation.signals.rows import typical_step
from .quantity import factor
from .table import RawLog

_SLOWEST = {"s": 0.5, "ms": 100.0, "us": 1e5, "ns": 1e8}
"""Longest step that each unit is taken for: robots are recorded at 10 Hz to 10 kHz, so units stay apart."""
_EPOCH = 1e8  # s: more than three years; such a time counts from 1970 or from the start of a machine
_MOST_REPEATED = 0.9  # of the rows


class Clock(NamedTuple):
    """A log's time: seconds of each row that comes ``later`` than the row before, and what is to be said of it.

    ``origin``: what the column holds where seconds are 0 [s].
    """

    t: Array
    later: NDArray[np.bool_]
    origin: float = 0.0
    notes: tuple[str, ...] = ()


def clock_of(raw: RawLog, column: str, unit: str, values: Array) -> Clock:
    """Seconds of a log's column of time; ``unit`` of it, empty: it is found out.

    Raises:
        InputError: if time runs back or stands still, counts rows, or no unit fits.
    """
    if not len(values):
        return Clock(values, np.zeros(0, dtype=bool))
    where, steps = f"{raw.path}: column {column!r}", np.diff(values)
    share = float(np.mean(steps == 0.0)) if len(steps) else 0.0
    if share > _MOST_REPEATED:
        raise InputError(
            f"{where}: time stands still in {100 * share:.0f} % of the rows: write it with more digits"
        )
    scale, notes = (factor("time", unit), []) if unit else _found_factor(where, steps)
    origin = float(values[0]) if values[0] * scale > _EPOCH else 0.0
    t = (values - origin) * scale
    if (steps < 0.0).any():
        k = int(np.argmax(steps < 0.0))
        raise InputError(
            f"{raw.path}: {raw.place(k + 1)}, column {column!r}: time runs back ({t[k]:g} s, then {t[k + 1]:g} s): "
            "split the file there and give both parts"
        )
    later = np.append(True, np.diff(t) > 0.0)
    if repeated := len(t) - int(later.sum()):
        rows = "1 row repeats" if repeated == 1 else f"{repeated} rows repeat"
        notes.append(f"{rows} the time of the row before ({100 * repeated / len(t):.2g} %): left out")
    return Clock(t[later], later, origin * scale, tuple(notes))


def _found_factor(where: str, steps: Array) -> tuple[float, list[str]]:
    """What makes seconds of the numbers, by the time from row to row, and what to say of it.

    Raises:
        InputError: if rows are counted, or no unit fits.
    """
    rising = steps[steps > 0.0]
    typical = float(np.median(rising)) if len(rising) else 0.0
    if len(steps) > 1 and (steps == 1.0).all():
        raise InputError(
            f"{where} counts by ones: --units t=500Hz takes it for the number of a row (or another rate), "
            "--units t=ms for milliseconds"
        )
    unit = next((unit for unit, slowest in _SLOWEST.items() if typical <= slowest), "")
    if not unit:
        raise InputError(f"{where}: {typical:g} from row to row is no unit of time that is known: --units t=..")
    said = f"time is in {unit} (steps of {typical:g}); --units t=.. takes another unit"
    return factor("time", unit), [said] if unit != "s" else []


def check_rate(raw: RawLog, column: str, t: Array) -> None:
    """Refuse times [s] in another unit."""
    typical = typical_step(t)
    if typical > _SLOWEST["s"]:
        raise InputError(
            f"{raw.path}: column {column!r}: {typical:g} s from row to row: t must be in seconds; is it in ms? "
            "(--units t=ms)"
        )
