"""Read-only float arrays, for values that are checked once and never change."""

from collections.abc import Sequence
from typing import TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def frozen_array(values: ArrayLike, shape: Sequence[int | None], name: str) -> Array:
    """A read-only float array of ``values``: a copy, unless they are one that is locked and nobody else's view.

    Args:
        values: numbers.
        shape: expected shape; None stands for any length.
        name: how an error calls the array.

    Raises:
        ValueError: if the shape is another or a number is not finite.
    """
    array = values if _is_locked(values) else np.array(values, dtype=np.float64)
    expected = tuple(shape)
    if array.ndim != len(expected) or any(
        want is not None and want != got for want, got in zip(expected, array.shape, strict=True)
    ):
        wanted = " x ".join("any" if size is None else str(size) for size in expected)
        raise ValueError(f"{name} has shape {array.shape}, expected {wanted}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} holds a number that is not finite")
    array.setflags(write=False)
    return array


def _is_locked(values: ArrayLike) -> TypeGuard[Array]:
    """Whether it is a float array that can no longer change."""
    while isinstance(values, np.ndarray) and values.dtype == np.float64 and not values.flags.writeable:
        if values.base is None:
            return True
        values = values.base
    return False
