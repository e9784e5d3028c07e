"""Every reader of a format gives the same: named columns of numbers."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from .map import LONGEST_NAME

_HUGE = 1e30  # a time in nanoseconds is 2e18


@dataclass(frozen=True)
class RawLog:
    """A log that is open for reading, its numbers as they stand there."""

    path: Path  # file or folder
    names: tuple[str, ...]  # of all its columns
    read: Callable[[Sequence[str]], Array]  # gives all rows of the columns that are asked for, in that order
    place: Callable[[int], str] = lambda row: f"row {row + 1}"  # tells where a row stands; rows count from 0
    joints: tuple[str, ...] = ()  # names, where the format has them
    units: Mapping[str, str] = field(default_factory=dict)  # of columns, where the file names them
    notes: Callable[[], tuple[str, ...]] = tuple  # on how it was read; after its rows were read, on these too
    gain_sigma: float | None = None  # relative error of its torques' scale, where the file tells it

    def __post_init__(self) -> None:
        """Refuse names that no recorder writes."""
        if longest := next((name for name in self.names if len(name) > LONGEST_NAME), ""):
            where = f"{self.path}: the column name that begins {longest[:20]!r} has {len(longest)} characters"
            raise InputError(f"{where}: is the first line a header? give short names")

    def whole(self, columns: Sequence[str]) -> Array:
        """All rows of the columns, rows x ``len(columns)``; refused where one is no time, place or torque."""
        values = np.ascontiguousarray(self.read(columns))
        if not (good := np.abs(values) < _HUGE).all():
            row, column = np.argwhere(~good)[0]
            bad = values[row, column]
            fault = f"{bad} is {'too large a number' if np.isfinite(bad) else 'not a finite number'}"
            where = f"{self.path}: {self.place(int(row))}, column {columns[column]!r}"
            raise InputError(f"{where}: {fault}: correct or remove the row")
        return values


@contextmanager
def reading(path: Path, kind: str, remedy: str = "save or copy it again") -> Iterator[None]:
    """Turn whatever a library finds wrong with a file of this kind into one line."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:  # of the library, of databases and of archives within, where a byte is wrong
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise InputError(f"{path}: not {kind}, or a damaged one ({reason}): {remedy}") from None
