"""Large arrays in a file: the same numbers, nothing copied, and one line where there is no room."""

import errno
import mmap
from typing import Any

import numpy as np
import pytest
from dynident.common import paged
from dynident.common.arrays import equal, frozen_array, rising
from dynident.common.errors import InputError
from dynident.model import Motion


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """What counts as large is small, and stretches are short."""
    monkeypatch.setattr(paged, "LARGE", 1000)
    monkeypatch.setattr(paged, "ROWS", 7)


def in_file(array: np.ndarray) -> bool:
    memory: Any = array
    while isinstance(memory, np.ndarray):
        memory = memory.base
    return isinstance(memory, mmap.mmap)


def test_large_arrays_live_in_a_file(small: None) -> None:
    assert in_file(paged.empty((100, 3)))
    assert not in_file(paged.empty((10, 3)))


def test_values_stay_when_memory_is_given_back(small: None) -> None:
    array = paged.empty((1000, 3))
    array[:] = np.arange(3000.0).reshape(1000, 3)
    paged.give_back()
    assert np.array_equal(array, np.arange(3000.0).reshape(1000, 3))
    assert np.concatenate([array[part] for part in paged.parts(1000)]).sum() == np.arange(3000.0).sum()


@pytest.mark.parametrize("rows", [0, 5, 500])
def test_rows_that_arrive_in_blocks(small: None, rows: int) -> None:
    table = np.random.default_rng(0).uniform(size=(rows, 4))
    blocks = [(table[k : k + 33, 0], table[k : k + 33]) for k in range(0, rows, 33)]
    first, columns = paged.collected(blocks, (1, 4))
    assert np.array_equal(first, table[:, :1])
    assert np.array_equal(columns, table)
    assert in_file(columns) == (rows == 500)
    assert not columns.flags.writeable
    assert frozen_array(columns, (None, 4), "rows") is columns


def test_what_is_locked_is_not_copied(small: None) -> None:
    array = paged.empty((300, 2))
    array[:] = 1.0
    assert not in_file(frozen_array(array, (None, 2), "a"))  # it may still change: copied
    array.setflags(write=False)
    assert in_file(frozen_array(array, (None, 2), "a"))
    assert in_file(frozen_array(array[10:], (None, 2), "a"))


def test_a_number_far_in_is_found(small: None) -> None:
    array = np.zeros((300, 2))
    array[200, 1] = np.nan
    with pytest.raises(ValueError, match="not finite"):
        frozen_array(array, (None, 2), "a")
    table = np.zeros((300, 2))
    table[299, 1] = 1.0
    assert not equal(np.zeros((300, 2)), table)
    assert equal(table, table.copy())
    assert not equal(table, table[:-1])


@pytest.mark.parametrize("k", [1, 6, 7, 8, 299])
def test_time_that_stands_still_is_found_in_every_stretch(small: None, k: int) -> None:
    t = np.arange(300.0)
    assert rising(t)
    t[k] = t[k - 1]
    assert not rising(t)
    with pytest.raises(ValueError, match="must rise"):
        Motion(t, *(np.zeros((300, 1)) for _ in range(3)))


def test_no_room_is_told(small: None, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("os.posix_fallocate", full, raising=False)
    with pytest.raises(InputError, match=r"no room.*No space left.*TMPDIR"):
        paged.empty((1000, 3))
