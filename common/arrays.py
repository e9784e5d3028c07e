"""Read-only float arrays, for values that are checked once and never change."""

from collections.abc import Sequence
from typing import TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def frozen_array(values: ArrayLike, shape: Sequence[int | None], name: str) -> Array:
    """A read-only float array of ``values``: a copy, unless they are one that is locked and no view.

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
    if not np.isfinite(array).all():
        raise ValueError(f"{name} holds a number that is not finite")
    array.setflags(write=False)
    return array


def _either(size: int | None, own: int) -> int:
    return own if size is None else size


def _is_locked(values: ArrayLike) -> TypeGuard[Array]:
    """Whether it is a float array that can no longer change."""
    if not isinstance(values, np.ndarray) or values.dtype != np.float64:
        return False
    return values.base is None and not values.flags.writeable
