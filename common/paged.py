"""Large arrays live in a temporary file; the system keeps in memory what is in use.

A long recording and what is made of it are larger than all else that a command holds. Their pages are given back
after every stretch of rows that was worked on, so that the peak does not grow with them.
"""

import math
import mmap
import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from .errors import InputError

LARGE = 16 * 2**20
"""Bytes: a larger array goes to a file."""
ROWS = 1 << 16
"""Rows that are worked on at once."""


def empty(shape: Sequence[int]) -> NDArray[np.float64]:
    """An array without values yet, in memory or in a file.

    Raises:
        InputError: if there is no room for the file.
    """
    size = 8 * math.prod(shape)
    if size <= LARGE:
        return np.empty(shape)
    with _room(), tempfile.TemporaryFile() as file:
        # A full disk is told here, not by a crash later.
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(file.fileno(), 0, size)
        else:
            _fill(file, size)
        return _mapped(file, shape)


def parts(rows: int, *arrays: NDArray[Any]) -> Iterator[slice]:
    """Consecutive stretches of rows; after each of them the arrays' pages are given back."""
    for start in range(0, rows, ROWS):
        yield slice(start, min(start + ROWS, rows))
        release(*arrays)


def release(*arrays: NDArray[Any]) -> None:
    """Give back the memory of arrays that live in a file; their values stay."""
    advice = getattr(mmap, "MADV_DONTNEED", None)
    for array in arrays:
        memory = owner(array)
        if advice is not None and isinstance(memory, mmap.mmap):
            memory.madvise(advice)


def owner(array: Any) -> Any:
    """What holds an array's memory: a file's mapping, or None for memory of its own."""
    while isinstance(array, np.ndarray):
        array = array.base
    return array


class Growing:
    """Rows that arrive in blocks; beyond ``LARGE`` they go to a file."""

    def __init__(self, width: int) -> None:
        """Nothing yet, ``width`` numbers a row."""
        self._width, self._rows = width, 0
        self._held: list[NDArray[np.float64]] = []
        self._file: IO[bytes] | None = None

    def add(self, block: NDArray[np.float64]) -> None:
        """Take the next rows."""
        self._rows += len(block)
        self._held.append(np.array(block, dtype=np.float64).reshape(len(block), self._width))
        if 8 * self._width * sum(map(len, self._held)) > LARGE:
            with _room():
                # Closed when the rows are taken.
                self._file = self._file or tempfile.TemporaryFile()  # noqa: SIM115
                self._spill(self._file)

    def taken(self) -> NDArray[np.float64]:
        """The rows, locked, so that a recording need not copy them; nothing may be added any more."""
        if self._file is None:
            array = np.concatenate([np.empty((0, self._width)), *self._held])
        else:
            with _room(), self._file as file:
                self._spill(file)
                file.flush()
                array = _mapped(file, (self._rows, self._width))
        self._held = []
        array.setflags(write=False)
        return array

    def _spill(self, file: IO[bytes]) -> None:
        for block in self._held:
            file.write(block.tobytes())
        self._held = []


def _fill(file: IO[bytes], size: int) -> None:
    """Zeros that take their room on the disk."""
    block = bytes(1 << 20)
    for start in range(0, size, len(block)):
        file.write(block[: size - start])
    file.flush()


def _mapped(file: IO[bytes], shape: Sequence[int]) -> NDArray[np.float64]:
    return np.ndarray(tuple(shape), np.float64, mmap.mmap(file.fileno(), 8 * math.prod(shape)))


@contextmanager
def _room() -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise InputError(
            f"no room for a long recording's numbers in {os.environ.get('TMPDIR', 'the temporary folder')} "
            f"({error.strerror or error}): free some, or name another folder by the environment variable TMPDIR"
        ) from None
