"""Every way in which one key of a file can be wrong, from a file that is right and the type it is read by."""

import copy
from collections.abc import Iterator
from typing import Any, NamedTuple, get_args

import msgspec
from dynident.common.schema import Table, chosen
from msgspec import inspect


class Mistake(NamedTuple):
    """One mistake in a file's data; ``key``: where the line must say that it is; empty where it is none.

    ``edit``: the arguments of ``edited``; thousands of copies would wait for their tests.
    """

    what: str
    key: str
    edit: tuple[Any, ...]

    @property
    def data(self) -> dict[str, Any]:
        """The data with the mistake."""
        return edited(*self.edit)


class Place(NamedTuple):
    """A key of a table: ``path`` as keys and numbers, ``name`` as an error says it."""

    path: tuple[str | int, ...]
    name: str
    field: Any
    value: Any


def places(data: Any, kind: Any, path: tuple[str | int, ...] = (), name: str = "") -> Iterator[Place]:
    """Every key of every table of a file."""
    kind = chosen(kind, data)
    if isinstance(data, dict) and isinstance(kind, type) and issubclass(kind, Table):
        for field in msgspec.structs.fields(kind):
            if field.encode_name in data:
                value, full = data[field.encode_name], f"{name}.{field.encode_name}".removeprefix(".")
                here = (*path, field.encode_name)
                yield Place(here, full, field, value)
                yield from places(value, field.type, here, full)
    elif isinstance(data, list) and data and get_args(kind):
        for number, value in enumerate(data):
            yield from places(value, get_args(kind)[0], (*path, number), f"{name}[{number + 1}]")


def mistakes(data: dict[str, Any], kind: type[Table]) -> Iterator[Mistake]:
    """Each key left out, misspelt, of another type, and out of range where there is one."""
    for path, name, field, value in places(data, kind):
        table, key = path[:-1], str(path[-1])
        yield Mistake(f"{name} left out", name if field.required else "", (data, table, key))
        yield Mistake(f"{name} misspelt", f"{name}x", (data, table, key, f"{key}x", value))
        node = inspect.type_info(field.type)
        if isinstance(node, inspect.AnyType):
            continue
        wrong_value = 3 if isinstance(value, dict) else {"other": "type"}
        yield Mistake(f"{name} of another type", name, (data, table, key, key, wrong_value))
        nodes = node.types if isinstance(node, inspect.UnionType) else (node,)
        if any(isinstance(node, inspect.FloatType) and node.le is not None for node in nodes):
            yield Mistake(f"{name} out of range", name, (data, table, key, key, 1e300))


def edited(
    data: Any, table: tuple[str | int, ...], key: str, new: str | None = None, value: Any = None
) -> dict[str, Any]:
    """A copy with a key of a table left out, and another one in its place if there is one."""
    changed = copy.deepcopy(data)
    place = changed
    for step in table:
        place = place[step]
    del place[key]
    if new is not None:
        place[new] = value
    return dict(changed)
