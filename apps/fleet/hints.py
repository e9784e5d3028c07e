"""Whether a value is what a field says that it holds."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

Check = Callable[[Any], bool]


@cache
def checks(kind: type) -> dict[str, Check]:
    """For each field of a kind of value, what tells whether a value may stand there."""
    return {name: check(hint) for name, hint in get_type_hints(kind).items()}


@cache
def check(hint: Any) -> Check:
    """What tells whether a value, or each of a tuple or mapping, is what is said; of a protocol, has its names."""
    origin, parts = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        kinds = [check(part) for part in parts]
        return lambda value: any(fits(value) for fits in kinds)
    if origin is Literal:
        return lambda value: value in parts
    if origin is Mapping:
        return _map_check(parts)
    if origin in (tuple, Sequence):
        return _row_check(origin, parts)
    return _plain_check(origin or hint)


def _plain_check(kind: Any) -> Check:
    """What tells whether a value is of a class, a number, or has the names of a protocol."""
    if kind in (int, float):
        kinds_of_number = (int, float) if kind is float else (int,)
        return lambda value: isinstance(value, kinds_of_number) and not isinstance(value, bool)
    if not isinstance(kind, type):
        return lambda value: True
    if getattr(kind, "_is_protocol", False):
        names = [name for name in vars(kind) if not name.startswith("_")]
        return lambda value: all(hasattr(value, name) for name in names)
    return lambda value: isinstance(value, kind)


def _map_check(parts: Sequence[Any]) -> Check:
    """What tells whether keys and entries of a mapping are what is said of them."""
    key_fits, entry_fits = map(check, parts)
    return lambda value: (
        isinstance(value, Mapping) and all(key_fits(key) and entry_fits(entry) for key, entry in value.items())
    )


def _row_check(origin: Any, parts: Sequence[Any]) -> Check:
    """What tells whether the values of a tuple are what is said of them; other rows are not looked into."""
    if origin is tuple and parts[-1] is not ...:
        kinds = [check(part) for part in parts]
        return lambda value: (
            isinstance(value, tuple)
            and len(value) == len(kinds)
            and all(fits(part) for fits, part in zip(kinds, value, strict=True))
        )
    each = check(parts[0])
    return lambda value: (
        all(map(each, value))
        if isinstance(value, tuple)
        else isinstance(value, origin) and not isinstance(value, str)
    )
