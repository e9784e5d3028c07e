"""Time of a log: its unit and origin are found out, rows that repeat a time are dropped and counted."""

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...common.errors import InputError
from ...estimation.signals.pieces import typical_step
from .quantity import factor
from .table import RawLog

_SLOWEST = {"s": 0.5, "ms": 100.0, "us": 1e5, "ns": 1e8}
"""Longest step that each unit is taken for: robots are recorded at 10 Hz to 10 kHz, so units stay apart."""
_EPOCH = 1e8  # s: more than three years; such a time counts from 1970 or from the start of a machine
_MOST_REPEATED = 0.9  # of the rows


class Clock:
    """Makes seconds of a log's column of time, block after block."""

    def __init__(self, raw: RawLog, column: str, unit: str) -> None:
        """Nothing is read yet.

        Args:
            column: its column of time.
            unit: of it; empty: it is found out by the first block.
        """
        self._raw, self._column = raw, column
        self._factor = factor("time", unit) if unit else 0.0
        self._origin: float | None = None
        self._last, self._rows, self._repeated = -np.inf, 0, 0
        self._found = ""

    def seconds(self, values: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Times [s] of the next rows, and which of them come after the row before.

        Raises:
            InputError: if time runs back, or counts rows.
        """
        if not self._factor:
            self._factor = self._found_factor(np.diff(values))
        if self._origin is None:
            self._origin = float(values[0]) if values[0] * self._factor > _EPOCH else 0.0
        t = (values - self._origin) * self._factor
        steps = np.diff(t, prepend=self._last)
        if (steps < 0.0).any():
            k = int(np.argmax(steps < 0.0))
            raise InputError(
                f"{self._raw.path}: {self._raw.place(self._rows + k)}, column {self._column!r}: time runs back "
                f"({t[k] - steps[k]:g} s, then {t[k]:g} s): split the file there and give both parts"
            )
        later = steps > 0.0
        self._rows, self._last = self._rows + len(t), float(t[-1])
        self._repeated += len(t) - int(later.sum())
        return t, later

    @property
    def origin(self) -> float:
        """What the column's time holds where seconds are 0 [s]."""
        return (self._origin or 0.0) * self._factor

    def notes(self) -> list[str]:
        """What was found out, and how many rows were dropped.

        Raises:
            InputError: if almost all were.
        """
        share = self._repeated / max(self._rows, 1)
        self._check_repeated(share)
        notes = [self._found] if self._found else []
        if self._repeated:
            rows = "1 row repeats" if self._repeated == 1 else f"{self._repeated} rows repeat"
            notes.append(f"{rows} the time of the row before ({100 * share:.2g} %): left out")
        return notes

    def _check_repeated(self, share: float) -> None:
        """Refuse a time most of whose rows repeat it."""
        if share > _MOST_REPEATED:
            raise InputError(
                f"{self._raw.path}: column {self._column!r}: time stands still in {100 * share:.0f} % of the rows: "
                "write it with more digits"
            )

    def _found_factor(self, steps: Array) -> float:
        """What makes seconds of the numbers, by the time from row to row.

        Raises:
            InputError: if rows are counted, or no unit fits.
        """
        rising = steps[steps > 0.0]
        self._check_repeated(float(np.mean(steps == 0.0)) if len(steps) else 0.0)
        typical = float(np.median(rising)) if len(rising) else 0.0
        where = f"{self._raw.path}: column {self._column!r}"
        if len(steps) > 1 and (steps == 1.0).all():
            raise InputError(
                f"{where} counts by ones: --units t=500Hz takes it for the number of a row (or another rate), "
                "--units t=ms for milliseconds"
            )
        unit = next((unit for unit, slowest in _SLOWEST.items() if typical <= slowest), "")
        if not unit:
            raise InputError(f"{where}: {typical:g} from row to row is no unit of time that is known: --units t=..")
        if unit != "s":
            self._found = f"time is in {unit} (steps of {typical:g}); --units t=.. takes another unit"
        return factor("time", unit)


def check_rate(raw: RawLog, column: str, t: Array) -> None:
    """Refuse times [s] in another unit."""
    typical = typical_step(t)
    if typical > _SLOWEST["s"]:
        raise InputError(
            f"{raw.path}: column {column!r}: {typical:g} s from row to row: t must be in seconds; is it in ms? "
            "(--units t=ms)"
        )
