"""Values whose ``repr`` is short whatever they hold."""

from dataclasses import fields
from reprlib import Repr
from typing import Any, cast

import numpy as np
from msgspec import UNSET

_LONGEST = 600  # largest length of a ``repr``: eight lines of a screen
_LISTS = (str, tuple, dict)  # which say nothing if they are empty
_FEW = 3  # largest size of an array whose numbers are shown


class _Short(Repr):
    """Cuts texts, lists and nested values, and shows arrays by their shape."""

    def __init__(self) -> None:
        super().__init__()
        self.maxlevel, self.maxtuple, self.maxlist, self.maxdict, self.maxstring, self.maxother = 2, 4, 4, 3, 60, 60

    def repr_ndarray(self, array: Any, level: int) -> str:
        """Show a small array by its numbers, a large one by its shape."""
        if array.size <= _FEW and array.dtype.kind == "f":
            return str(np.array2string(array, formatter={"float_kind": lambda x: f"{x:.5g}"}, separator=", "))
        return f"<{' x '.join(map(str, array.shape))}>"


_SHORT = _Short()


class Brief:
    """Base class of frozen values: ``repr`` names the fields that say something, each cut."""

    __slots__ = ()

    def __repr__(self) -> str:
        """Name the type and its fields, empty ones left out."""
        names: Any = getattr(self, "__struct_fields__", None) or [field.name for field in fields(cast(Any, self))]
        said = ((name, getattr(self, name)) for name in names)
        told = [(name, x) for name, x in said if not (x is None or x is UNSET or (isinstance(x, _LISTS) and not x))]
        text = f"{type(self).__name__}({', '.join(f'{name}={_SHORT.repr(x)}' for name, x in told)})"
        return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 5]} ...)"
