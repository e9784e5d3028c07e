"""Values that compare by what they hold, and whose ``repr`` is short whatever that is."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from reprlib import Repr
from typing import Any

import numpy as np
from msgspec import UNSET

_LONGEST = 600  # largest length of a ``repr``: eight lines of a screen
_BY_IDENTITY: Any = object.__eq__
_BY_STATE: Any = object.__reduce__
_FEW = 3  # largest size of an array whose numbers are shown


class _Short(Repr):
    def __init__(self) -> None:
        super().__init__()
        self.maxlevel, self.maxtuple, self.maxlist, self.maxdict, self.maxstring, self.maxother = 2, 4, 4, 3, 60, 60

    def repr_ndarray(self, array: Any, level: int) -> str:
        if array.size <= _FEW and array.dtype.kind == "f":
            return str(np.array2string(array, formatter={"float_kind": lambda x: f"{x:.5g}"}, separator=", "))
        return f"<{' x '.join(map(str, array.shape))}>"


_SHORT = _Short()


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
        parts = [f"{name}={_SHORT.repr(value)}" for name, value in said if not _silent(value)]
        text = f"{type(self).__name__}({', '.join(parts)})".replace("\n", " ")
        return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 5]} ...)"


def _silent(value: Any) -> bool:
    return value is None or value is UNSET or (isinstance(value, str | tuple | dict) and not value)


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
