"""Large arrays live in a temporary file; the system keeps in memory what is in use.

A long recording and what is made of it are larger than all else that a command holds. Whoever works on one goes
through its rows by ``parts``: after each stretch the pages of all such arrays are given back, so that the peak does
not grow with the recording. Their values stay; what is read again comes from the system's cache or the disk.
"""

import math
import mmap
import os
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import IO, Any
from weakref import WeakSet

import numpy as np
from numpy.typing import NDArray

from .errors import InputError

LARGE = 16 * 2**20
"""Bytes: a larger array goes to a file."""
ROWS = 1 << 16
"""Rows that are worked on at once."""
_mapped: WeakSet[mmap.mmap] = WeakSet()
"""The files' memory, as long as an array uses it."""


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
            for start in range(0, size, 1 << 20):
                file.write(bytes(min(1 << 20, size - start)))
            file.flush()
        return _array(file, shape)


def parts(rows: int, at_once: int = 0) -> Iterator[slice]:
    """Consecutive stretches of ``ROWS`` rows or as many as told; after each of several memory is given back."""
    at_once = at_once or ROWS
    for start in range(0, rows, at_once):
        yield slice(start, min(start + at_once, rows))
        if rows > at_once:
            give_back()


def give_back() -> None:
    """Give back the memory of all arrays that live in files."""
    advice = getattr(mmap, "MADV_DONTNEED", None)
    if advice is not None:
        for memory in list(_mapped):
            memory.madvise(advice)


def collected(blocks: Iterable[Sequence[NDArray[Any]]], widths: Sequence[int]) -> list[NDArray[np.float64]]:
    """Arrays whose rows arrive in blocks, locked, so that a recording need not copy them.

    Args:
        blocks: the next rows of each array.
        widths: numbers in a row of each array.

    Raises:
        InputError: if there is no room for a file.
    """
    with ExitStack() as opened:
        files = [opened.enter_context(tempfile.SpooledTemporaryFile(max_size=LARGE)) for _ in widths]
        for block in blocks:
            with _room():
                for file, values in zip(files, block, strict=True):
                    file.write(np.ascontiguousarray(values, dtype=np.float64).data)
        with _room():
            return [_rows(file, width) for file, width in zip(files, widths, strict=True)]


def _rows(file: IO[bytes], width: int) -> NDArray[np.float64]:
    """What was written, in memory or in the file; closes it."""
    with file:
        shape = file.tell() // (8 * width), width
        if file.tell() > LARGE:
            file.flush()
            array = _array(file, shape)
            array.setflags(write=False)
            return array
        file.seek(0)
        return np.frombuffer(file.read()).reshape(shape)


def _array(file: IO[bytes], shape: Sequence[int]) -> NDArray[np.float64]:
    memory = mmap.mmap(file.fileno(), 8 * math.prod(shape))
    _mapped.add(memory)
    return np.ndarray(tuple(shape), np.float64, memory)


@contextmanager
def _room() -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise InputError(
            f"no room for a long recording's numbers in {os.environ.get('TMPDIR', 'the temporary folder')} "
            f"({error.strerror or error}): free some, or name another folder by the environment variable TMPDIR"
        ) from None
