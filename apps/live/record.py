"""A recording as it grows: samples in the controller's own time, and what is wrong with them."""

import gzip
import math
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.files import write_bytes
from ..parquet import parquet_bytes, pyarrow_for
from .rtde import POSITION, SAFETY, TIME, LinkError, Samples

_STILL = 2.0  # s: time that stands still for so many samples is no clock
_TICK = 1e-4  # s: steps of the clock that differ by less are one
_MOVED = 0.17  # rad: a joint that has gone farther counts as moved
_STOPS = {
    3: "protective stop",
    4: "recovery",
    5: "safeguard stop",
    6: "emergency stop of the system",
    7: "emergency stop of the robot",
    8: "violation",
    9: "fault",
}
"""Safety modes in which the arm does not move as it was told (the maker's guide, safety_mode)."""
SUFFIXES = (".csv", ".csv.gz", ".parquet")
"""Formats that a recording can be written in, by the file's name."""


class Recorder:
    """Samples of one connection, in rising time.

    The controller's time stamps count, not the arrival: what is missing between them was dropped.

    Attributes:
        rate: samples a second that were asked for [Hz].
        length: after it, in the controller's time, nothing is kept any more [s].
        repeated: number of samples that came twice, and are kept once.
        stops: what stopped the arm, with the time since the start [s].
    """

    def __init__(self, rate: float, length: float = math.inf) -> None:
        """Begin an empty one, that ends after a length [s]."""
        self.rate, self.length = rate, length
        self.count = self.repeated = 0
        self.stops: list[tuple[float, str]] = []
        self._kept: list[Samples] = []
        self._steps = Counter[int]()
        self._lowest: Array = np.full(6, np.inf)
        self._highest: Array = np.full(6, -np.inf)
        self._standing, self._first, self._last, self._stop = 0, 0.0, 0.0, ""

    @property
    def seconds(self) -> float:
        """Length in the controller's time [s]."""
        return self._last - self._first

    @property
    def over(self) -> bool:
        """Tell whether the length is reached."""
        return self.seconds >= self.length

    @property
    def step(self) -> float:
        """The usual time from one sample to the next [s]; that of the rate asked for while there are none."""
        return _TICK * self._steps.most_common(1)[0][0] if self._steps else 1.0 / self.rate

    @property
    def dropped(self) -> int:
        """Samples that are missing between those that are there, by their time stamps."""
        step = self.step
        missing = (count * (round(_TICK * ticks / step) - 1) for ticks, count in self._steps.items())
        return sum(max(lost, 0) for lost in missing)

    @property
    def moved(self) -> list[int]:
        """Numbers of the joints that have moved so far, by 10 degrees at least."""
        return [int(j) + 1 for j in np.flatnonzero(self._highest - self._lowest > _MOVED)]

    def add(self, samples: Samples) -> Samples:
        """Keep further samples, and give those that are new.

        Raises:
            LinkError: if time runs back or stands still; what came before is kept.
        """
        new: list[int] = []
        try:
            for k, now in enumerate(samples[TIME].tolist()):
                if self.over:
                    break
                step = now - self._last
                if not self.count:
                    self._first = now
                elif not 0.0 <= step < 1e9:
                    fault = f"the controller's time runs back after {self.seconds:.1f} s: was it restarted?"
                    raise LinkError(fault)
                elif step == 0.0:
                    self.repeated, self._standing = self.repeated + 1, self._standing + 1
                    if self._standing * self.step > _STILL:
                        raise LinkError(f"the controller's time stands still after {self.seconds:.1f} s")
                    continue
                else:
                    self._steps[max(round(step / _TICK), 1)] += 1
                self._last, self._standing = now, 0
                new.append(k)
                self.count += 1
        finally:
            self._kept.append(samples[new])
        kept = self._kept[-1]
        self._lowest = np.minimum(self._lowest, kept[POSITION].min(axis=0, initial=np.inf))
        self._highest = np.maximum(self._highest, kept[POSITION].max(axis=0, initial=-np.inf))
        modes = kept[SAFETY] if SAFETY in (kept.dtype.names or ()) else ()
        for now, mode in zip(kept[TIME].tolist(), modes, strict=False):
            stop = _STOPS.get(int(mode), "")
            if stop and stop != self._stop:
                self.stops.append((now - self._first, stop))
            self._stop = stop
        return kept

    def write(self, path: str | Path) -> None:
        """Write what there is, in one step, in the format that the name says; see ``check_name``.

        A field of several numbers counts its columns from 0.

        Raises:
            InputError: if nothing was recorded, or the file cannot be written.
        """
        if not self.count:
            raise InputError(f"{path}: not written: no sample came")
        samples = np.concatenate(self._kept)
        columns: dict[str, Any] = {}
        for name in samples.dtype.names or ():
            values = samples[name].astype(samples[name].dtype.newbyteorder("="))
            several = {f"{name}_{k}": column for k, column in enumerate(values.T)} if values.ndim > 1 else {}
            columns |= several or {name: values}
        if Path(path).name.lower().endswith(".parquet"):
            write_bytes(path, parquet_bytes(columns))
            return
        rows = zip(*(map(repr, column.tolist()) for column in columns.values()), strict=True)
        text = "".join(f"{','.join(row)}\n" for row in [tuple(columns), *rows]).encode()
        write_bytes(path, text if Path(path).name.lower().endswith(".csv") else gzip.compress(text, mtime=0))


def check_name(path: str | Path) -> None:
    """Refuse a file that no recording can be written as: a recording is not begun that cannot be written.

    Raises:
        InputError: for another name than those of ``SUFFIXES``, or without the package that Parquet needs.
    """
    name = Path(path).name.lower()
    if not name.endswith(SUFFIXES):
        raise InputError(f"{path}: a recording is written as {', '.join(SUFFIXES)}")
    if name.endswith(".parquet"):
        pyarrow_for(f"{path}: Parquet", "install dynident[logs], or write .csv")
