"""What may stand at a key of a file, said in words by the key's type."""

from typing import Any

from msgspec import inspect

LARGEST = 1e9
"""Bound of numbers in files; no length, angle or parameter of an arm comes near it."""


def words(kind: Any) -> str:
    """What may stand at a key, in words."""
    return _words(inspect.type_info(kind))


def _words(node: inspect.Type, many: bool = False) -> str:
    match node:
        case inspect.UnionType(types=types):
            kinds = (_words(kind, many) for kind in types if not isinstance(kind, inspect.NoneType))
            return " or ".join(dict.fromkeys(kinds))
        case inspect.FloatType() | inspect.IntType():
            return _number_words(node, many)
        case inspect.TupleType() | inspect.VarTupleType():
            return f"{'lists' if many else 'a list'} of {_items_words(node)}"
        case inspect.LiteralType(values=values):
            return " or ".join(map(repr, values))
        case inspect.Metadata(extra_json_schema=schema) if schema:
            return str(schema["description"])
    plain = {inspect.StrType: ("text", "texts"), inspect.BoolType: ("true or false",) * 2}
    return plain.get(type(node), ("a table", "tables"))[many]


def _number_words(node: inspect.FloatType | inspect.IntType, many: bool) -> str:
    """A number with its lower bound."""
    kind = "whole number" if isinstance(node, inspect.IntType) else "number" if many else "finite number"
    bound = "" if node.ge in (None, -LARGEST, -1e6) else f" of at least {node.ge:g}"
    bound = bound if node.gt is None else f" above {node.gt:g}"
    return (f"{kind}s" if many else f"a {kind}") + bound


def _items_words(node: inspect.TupleType | inspect.VarTupleType) -> str:
    """What a list holds, and how many."""
    if isinstance(node, inspect.TupleType):
        return f"{len(node.item_types)} {_words(node.item_types[0], True)}"
    fewest = f", at least {node.min_length}" if node.min_length else ""
    return _words(node.item_type, True) + fewest


def shown(value: Any) -> str:
    """The beginning of a value as Python writes it."""
    try:
        return repr(value)[:40]
    except (ValueError, RecursionError):  # a number of thousands of digits, a list in a list and so on
        return "more than can be shown"
