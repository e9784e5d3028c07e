"""Read-only float arrays, for values that are checked once and never change."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]


def frozen_array(values: ArrayLike, shape: Sequence[int | None], name: str) -> Array:
    """Read-only float array of ``values``: a copy, unless they are one that is locked and no view.

    Args:
        shape: expected shape; None stands for any length.
        name: how an error calls the array.

    Raises:
        ValueError: if the shape is another or a number is not finite.
    """
    array = np.asarray(values, dtype=np.float64)
    if array is not values or array.base is not None or array.flags.writeable:
        array = np.array(values, dtype=np.float64)
    if len(shape) != array.ndim or not all(a in (None, b) for a, b in zip(shape, array.shape, strict=True)):
        sizes = " x ".join("any" if size is None else str(size) for size in shape)
        raise ValueError(f"{name} has shape {array.shape}, expected {sizes}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} has a number that is not finite")
    array.setflags(write=False)
    return array


def freeze_fields(value: object, **shapes: Sequence[int | None]) -> None:
    """Make fields of a frozen value read-only float arrays of the given shapes; a field that is None stays so."""
    for name, shape in shapes.items():
        if getattr(value, name) is not None:
            object.__setattr__(value, name, frozen_array(getattr(value, name), shape, name))
