"""A recording as it grows: samples in the controller's own time, and what is wrong with them."""

import gzip
import math
import struct
from collections import Counter
from collections.abc import Callable, Sequence
from io import StringIO
from pathlib import Path

from ...common.errors import InputError
from ...common.files import write_bytes
from .fields import POSITION, SAFETY, TIME, LinkError, Recipe, Samples, stop_of

_STILL = 2.0
"""s: time that stands still for so many samples is no clock."""
_TICK = 1e-4
"""s: steps of the clock that differ by less are one."""
_MOVED = 0.17
"""rad: a joint that has gone farther counts as moved."""
SUFFIXES = (".csv", ".csv.gz", ".parquet")
"""What a recording can be written as, by the file's name."""


class Recorder:
    """Samples of one connection, in rising time.

    The controller's time stamps count, not the arrival: what is missing between them was dropped.

    Attributes:
        recipe: fields of a sample.
        rate: samples a second that were asked for [Hz].
        length: in the controller's time, after which nothing is kept any more [s].
        count: samples that are kept.
        repeated: samples that came twice, and are kept once.
        stops: what stopped the arm, with the time since the start [s].
    """

    def __init__(self, recipe: Recipe, rate: float, length: float = math.inf) -> None:
        """Begin an empty one, that ends after a length [s]."""
        self.recipe, self.rate, self.length = recipe, rate, length
        self.count = self.repeated = 0
        self.stops: list[tuple[float, str]] = []
        self._kept = bytearray()
        self._steps = Counter[int]()
        self._reach: list[list[float]] = []
        self._standing, self._first, self._last, self._mode = 0, 0.0, 0.0, ""

    @property
    def seconds(self) -> float:
        """Length in the controller's time [s]."""
        return self._last - self._first

    @property
    def over(self) -> bool:
        """Whether the length is reached."""
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
        return [j + 1 for j, (low, high) in enumerate(self._reach) if high - low > _MOVED]

    def add(self, samples: Samples) -> Samples:
        """Keep further samples; gives those that are new.

        Raises:
            LinkError: if time runs back or stands still; what came before is kept.
        """
        size, count = self.recipe.layout.size, len(self._kept)
        time = struct.Struct(">d")
        for start in range(0, len(samples.packed), size):
            if self.over:
                break
            (now,) = time.unpack_from(samples.packed, start)
            if self._new(now):
                self._kept += samples.packed[start : start + size]
                self.count += 1
        new = Samples(self.recipe, bytes(self._kept[count:]))
        self._watch(new)
        return new

    def _new(self, now: float) -> bool:
        """Whether a sample of this time is one more, and what is missing before it."""
        if not self.count:
            self._first = self._last = now
            return True
        step = now - self._last
        if not -1e9 < step < 1e9 or step < 0.0:
            raise LinkError(f"the controller's time runs back after {self.seconds:.1f} s: was it restarted?")
        if step == 0.0:
            self.repeated, self._standing = self.repeated + 1, self._standing + 1
            if self._standing * self.step > _STILL:
                raise LinkError(f"the controller's time stands still after {self.seconds:.1f} s")
            return False
        self._steps[max(round(step / _TICK), 1)] += 1
        self._last, self._standing = now, 0
        return True

    def _watch(self, samples: Samples) -> None:
        """Remember when the arm was stopped, and how far its joints went."""
        for j, joint in enumerate(zip(*samples.of(POSITION), strict=True)):
            if j == len(self._reach):
                self._reach.append([joint[0], joint[0]])
            self._reach[j] = [min(self._reach[j][0], *joint), max(self._reach[j][1], *joint)]
        for (time,), (mode,) in zip(samples.of(TIME), samples.of(SAFETY), strict=False):
            stop = stop_of(mode)
            if stop and stop != self._mode:
                self.stops.append((time - self._first, stop))
            self._mode = stop

    def write(self, path: str | Path) -> None:
        """Write what there is, in one step, in the format that the name says.

        Raises:
            InputError: if nothing was recorded, or the file cannot be written.
        """
        if not self.count:
            raise InputError(f"{path}: not written: no sample came")
        rows = list(Samples(self.recipe, bytes(self._kept)).rows())
        write_bytes(path, writer_of(path)(self.recipe.columns, rows))


Rows = Sequence[tuple[float, ...]]


def writer_of(path: str | Path) -> Callable[[Sequence[str], Rows], bytes]:
    """What makes the content of a file of this name.

    Raises:
        InputError: for another name than those of ``SUFFIXES``, or without the package that Parquet needs.
    """
    name = Path(path).name.lower()
    if name.endswith(".csv"):
        return _csv
    if name.endswith(".csv.gz"):
        return _compressed
    if name.endswith(".parquet"):
        try:
            import pyarrow  # noqa: F401  a recording is not begun that cannot be written
        except ImportError:
            raise InputError(f"{path}: Parquet needs pyarrow: install dynident[logs], or write .csv") from None
        return _parquet
    raise InputError(f"{path}: a recording is written as {', '.join(SUFFIXES)}")


def _csv(columns: Sequence[str], rows: Rows) -> bytes:
    text = StringIO()
    text.write(",".join(columns) + "\n")
    text.writelines(",".join(map(repr, row)) + "\n" for row in rows)
    return text.getvalue().encode()


def _compressed(columns: Sequence[str], rows: Rows) -> bytes:
    return gzip.compress(_csv(columns, rows), mtime=0)


def _parquet(columns: Sequence[str], rows: Rows) -> bytes:
    import pyarrow.parquet

    table = pyarrow.table(dict(zip(columns, map(list, zip(*rows, strict=True)), strict=True)))
    stream = pyarrow.BufferOutputStream()
    pyarrow.parquet.write_table(table, stream)
    return bytes(stream.getvalue())
