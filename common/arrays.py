"""Frozen values: read-only arrays, and values that compare by what they hold and whose ``repr`` is short."""

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from reprlib import Repr
from typing import Any

import numpy as np
from msgspec import UNSET
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]


def frozen_array(values: ArrayLike, shape: Sequence[int | None], name: str) -> Array:
    """Read-only float array of ``values``: a copy, unless they are one that is locked and no view.

    ``shape``: expected shape, None stands for any length; ``name``: how an error calls the array. Raises ValueError
    if the shape is another or a number is not finite.
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


_LONGEST = 600  # largest length of a ``repr``: eight lines of a screen
_BY_IDENTITY: Any = object.__eq__
_BY_STATE: Any = object.__reduce__
_FEW = 3  # largest size of an array whose numbers are shown


def _short_array(array: Any, level: int) -> str:
    if array.size <= _FEW and array.dtype.kind == "f":
        return str(np.array2string(array, formatter={"float_kind": lambda x: f"{x:.5g}"}, separator=", "))
    return f"<{' x '.join(map(str, array.shape))}>"


_SHORT = Repr()
vars(_SHORT).update(
    repr_ndarray=_short_array, maxlevel=2, maxtuple=4, maxlist=4, maxdict=3, maxstring=60, maxother=60
)


class Brief:
    """Base class of frozen values, arrays among their fields: compared by all, shown by what says something."""

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        return same(self, other) if type(self) is type(other) else NotImplemented

    def __hash__(self) -> int:
        return hash(type(self))

    def __repr__(self) -> str:
        """Name the type and its fields, each cut; empty ones and those at their default are left out."""
        usual: dict[str, Any] = {x.name: x.default for x in fields(self)} if is_dataclass(self) else {}
        said = [(name, getattr(self, name)) for name in field_names(self)]
        said = [(name, value) for name, value in said if name not in usual or not same(value, usual[name])]
        said = [(name, value) for name, value in said if not isinstance(value, str | tuple | dict) or value]
        parts = [f"{name}={_SHORT.repr(value)}" for name, value in said if value is not None and value is not UNSET]
        text = f"{type(self).__name__}({', '.join(parts)})".replace("\n", " ")
        return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 5]} ...)"


def field_names(value: Any) -> tuple[str, ...]:
    """Names of the fields of a dataclass or Struct that count; none of anything else."""
    structs: tuple[str, ...] = getattr(value, "__struct_fields__", ())
    return structs or (tuple(x.name for x in fields(value) if x.compare) if is_dataclass(value) else ())


def same(a: Any, b: Any) -> bool:
    """True if two values of whatever types hold the same numbers and texts."""
    if a is b:
        return True
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        return a.shape == b.shape and bool(np.all((a == b) | ((a != a) & (b != b))))
    if type(a) is not type(b):
        return not isinstance(a, np.ndarray) and not isinstance(b, np.ndarray) and bool(a == b)
    if names := field_names(a):
        return all(same(getattr(a, name), getattr(b, name)) for name in names)
    if isinstance(a, Mapping):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if isinstance(a, tuple | list):
        return len(a) == len(b) and all(map(same, a, b))
    if type(a).__eq__ is _BY_IDENTITY and type(a).__reduce__ is not _BY_STATE:
        return same(a.__reduce__(), b.__reduce__())
    if type(a).__eq__ is _BY_IDENTITY and hasattr(a, "__dict__"):  # what was computed of one alone is left out
        return same(*({name: vars(x)[name] for name in vars(a).keys() & vars(b).keys()} for x in (a, b)))
    return bool(a == b) or bool(a != a and b != b)
