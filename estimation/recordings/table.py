"""What every reader gives: named columns of numbers, block by block."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...common.arrays import Array

BLOCK = 16384
"""Rows that are read at once."""


@dataclass(frozen=True)
class Table:
    """Some rows of a log, as they stand there.

    Attributes:
        names: names of the columns, k.
        values: rows x k, read-only, in the log's own units.
    """

    names: tuple[str, ...]
    values: Array

    def __post_init__(self) -> None:
        """Lock the numbers and check that each column has a name."""
        if self.values.ndim != 2 or self.values.shape[1] != len(self.names):
            raise ValueError(f"{len(self.names)} names for columns of shape {self.values.shape}")
        self.values.setflags(write=False)

    def columns(self, names: Sequence[str]) -> Array:
        """Some of the columns, rows x ``len(names)``."""
        return self.values[:, [self.names.index(name) for name in names]]


@dataclass(frozen=True)
class RawLog:
    """A log that is open for reading.

    Attributes:
        path: the file or folder.
        names: names of all its columns.
        blocks: gives the wanted columns as tables of at most ``BLOCK`` rows.
        place: tells where a row stands, "line 7"; rows count from 0.
        joints: names of joints, where the format has them.
    """

    path: Path
    names: tuple[str, ...]
    blocks: Callable[[Sequence[str]], Iterator[Table]]
    place: Callable[[int], str] = lambda row: f"row {row + 1}"
    joints: tuple[str, ...] = ()


def sliced(wanted: Sequence[str], column: Callable[[str], Array], rows: int) -> Iterator[Table]:
    """Blocks of columns that can be had whole, one by one."""
    columns = [column(name) for name in wanted]
    for start in range(0, rows, BLOCK):
        part = [np.asarray(values[start : start + BLOCK], dtype=np.float64) for values in columns]
        yield Table(tuple(wanted), np.column_stack(part))
