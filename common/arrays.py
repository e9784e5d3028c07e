"""Read-only float arrays, for values that are checked once and never change."""

import mmap
from collections.abc import Sequence
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .paged import parts

Array = NDArray[np.float64]
_SMALL = 100_000  # numbers that are looked at in one piece


def frozen_array(values: ArrayLike, shape: Sequence[int | None], name: str) -> Array:
    """A read-only float array of ``values``: a copy, unless they are one that is locked and nobody else's view.

    Args:
        shape: expected shape; None stands for any length.
        name: how an error calls the array.

    Raises:
        ValueError: if the shape is another or a number is not finite.
    """
    array = values if _is_locked(values) else np.array(values, dtype=np.float64)
    if len(array.shape) != len(shape) or array.shape != tuple(map(_either, shape, array.shape)):
        sizes = " x ".join("any" if size is None else str(size) for size in shape)
        raise ValueError(f"{name} has shape {array.shape}, expected {sizes}")
    if not _finite(array):
        raise ValueError(f"{name} holds a number that is not finite")
    array.setflags(write=False)
    return array


def _either(size: int | None, own: int) -> int:
    return own if size is None else size


def _is_locked(values: ArrayLike) -> TypeGuard[Array]:
    """Whether it is a float array that can no longer change."""
    owner: Any = values
    while isinstance(owner, np.ndarray) and owner.dtype == np.float64 and not owner.flags.writeable:
        base: Any = owner.base
        if base is None or isinstance(base, mmap.mmap | bytes):
            return True
        owner = base
    return False


def _finite(array: Array) -> bool:
    if array.size < _SMALL:
        return bool(np.isfinite(array).all())
    return all(bool(np.isfinite(array[part]).all()) for part in parts(len(array)))


def rising(t: Array) -> bool:
    """Whether every number is larger than the one before."""
    return all(bool((np.diff(t[part.start : part.stop + 1]) > 0.0).all()) for part in parts(len(t)))


def equal(a: Array, b: Array) -> bool:
    """Whether two arrays hold the same numbers."""
    return a.shape == b.shape and all(bool((a[part] == b[part]).all()) for part in parts(len(a)))
