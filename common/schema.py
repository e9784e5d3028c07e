"""TOML and JSON files by their types: each key is declared once.

A kind of file is a ``Table``: its fields are the keys, their types what may stand there, their defaults what is
meant where a key is left out. Keys that are not declared are refused. Whatever is wrong with a file is told in one
line, by an ``InputError`` that names the file and the key.
"""

import json
import re
import tomllib
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from difflib import get_close_matches
from functools import partial
from pathlib import Path
from types import NoneType, UnionType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NewType, Self, TypeVar, Union, get_args, get_origin

import msgspec
import numpy as np
from msgspec import Meta, inspect

from .arrays import Brief
from .errors import InputError, encodable
from .files import opened, write_bytes

LARGEST = 1e9  # bound of numbers in files; no length, angle or parameter of an arm comes near it


def words(kind: Any, many: bool = False) -> str:
    """Describe in text what may stand at a key, by its type; of ``many`` such values."""
    match node := kind if isinstance(kind, inspect.Type) else inspect.type_info(kind):
        case inspect.UnionType(types=types):
            named = (words(kind, many) for kind in types if not isinstance(kind, inspect.NoneType))
            return " or ".join(dict.fromkeys(named))
        case inspect.FloatType() | inspect.IntType():
            number = "number" if many else "finite number"
            plain = "whole number" if isinstance(node, inspect.IntType) else number
            bound = "" if node.ge in (None, -LARGEST, -1e6) else f" of at least {node.ge:g}"
            bound = bound if node.gt is None else f" above {node.gt:g}"
            return (f"{plain}s" if many else f"a {plain}") + bound
        case inspect.TupleType(item_types=items):
            return f"{'lists' if many else 'a list'} of {len(items)} {words(items[0], True)}"
        case inspect.VarTupleType(item_type=item, min_length=fewest):
            least = f", at least {fewest}" if fewest else ""
            return f"{'lists' if many else 'a list'} of {words(item, True)}{least}"
        case inspect.LiteralType(values=values):
            return " or ".join(map(repr, values))
        case inspect.Metadata(extra_json_schema=schema) if schema:
            return str(schema["description"])
    kinds = {inspect.StrType: ("text", "texts"), inspect.BoolType: ("true or false",) * 2}
    return kinds.get(type(node), ("a table", "tables"))[many]


def shown(value: Any) -> str:
    """Show the beginning of a value as Python writes it."""
    try:
        return repr(value)[:40]
    except (ValueError, RecursionError):  # a number of thousands of digits, a list in a list and so on
        return "more than can be shown"


_DEEP = re.compile(r"""(?<![\w"'-])(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){20}""")


def toml_data(text: str, source: str | Path) -> dict[str, Any]:
    """Parse TOML, whatever its tables."""
    # The parser would need a time that grows with the square of a key's parts.
    if deep := _DEEP.search(text):
        raise InputError(f"{source}: a key of twenty parts or more ({deep[0][:20]}...): no table is as deep")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        fault = f"not valid TOML: {error}"
    except RecursionError:
        fault = "not valid TOML here: nested too deeply"
    except ValueError:
        fault = "holds a number of thousands of digits: shorten it"
    raise InputError(f"{source}: {fault}")


def toml_text(data: "Mapping[str, Any] | Table", above: str = "") -> str:
    """Write a plain mapping, or a table without keys at their defaults, at a path ``above``, as TOML.

    Lists stand on one line, whole numbers without a point.
    """
    own = tables = ""
    if isinstance(data, Table):
        fields = [(field, getattr(data, field.name)) for field in msgspec.structs.fields(data)]
        data = {field.encode_name: value for field, value in fields if value not in (field.default, {})}
    for key, value in data.items():
        rows = [value] if isinstance(value, Mapping | Table) else value if isinstance(value, list | tuple) else []
        name = key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _toml_value(key)
        if not rows or not all(isinstance(row, Mapping | Table) for row in rows):
            own += f"{name} = {_toml_value(value)}\n"
            continue
        path, (left, right) = f"{above}{name}", ("[[", "]]") if rows is value else ("[", "]")
        for row in rows:
            tables += f"\n{left}{path}{right}\n{toml_text(row, f'{path}.')}"
    return own + tables


def _toml_value(value: Any) -> str:
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml_value, value))}]"
    if isinstance(value, float):
        return repr(int(value)) if value == int(value) else repr(value)
    # JSON's texts, numbers and truth values are TOML's too, but for the one control character JSON leaves as it is.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


TOML_BYTES = 1_000_000  # largest TOML file that is read, in bytes; one that a user writes comes nowhere near
Real = Annotated[float, Meta(ge=-LARGEST, le=LARGEST)]
"""A finite number; no length, angle or parameter of an arm comes near the bounds."""
Float = float
"""A number that was computed; null in a document where it is not finite."""
Triple = tuple[Real, Real, Real]  # three numbers along x, y and z
_MANY = 24  # keys: so many are a program's, whose names say nothing to who gave another file
_Row = np.ndarray[tuple[int], np.dtype[np.float64]]
_Rows = np.ndarray[tuple[int, int], np.dtype[np.float64]]
_ROW_SCHEMA = {"type": "array", "items": {"type": ["number", "null"]}}
_SCHEMA = {"description": "a list of numbers", **_ROW_SCHEMA}
_ROWS_SCHEMA = {"description": "a list of lists of numbers", "type": "array", "items": _ROW_SCHEMA}
Vector = _Row
"""Numbers in a row; null stands for one that is not finite."""
Matrix = _Rows  # rows of numbers
if not TYPE_CHECKING:  # signatures show the names, not all that may stand in a document
    Float = NewType("Float", float | None)
    Vector = NewType("Vector", Annotated[_Row, Meta(extra_json_schema=_SCHEMA)])
    Matrix = NewType("Matrix", Annotated[_Rows, Meta(extra_json_schema=_ROWS_SCHEMA)])
_NUMBERS: dict[Any, Any] = {_Row: tuple[float | None, ...], _Rows: tuple[tuple[float | None, ...], ...]}


class Table(Brief, msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Base class of the tables of a file; ``advice`` says of a key what no type tells."""

    __hash__ = msgspec.Struct.__hash__
    advice: ClassVar[Mapping[str, str]] = {}


class Document(Table, frozen=True, dict=True):
    """Base class of JSON documents and their parts, written and read, which keep what they were made from."""

    working: ClassVar[Any] = None
    """Values that it was made from; None where it was read from a file."""

    @classmethod
    def of(cls, *sources: Any, **more: Any) -> Self:
        """Take the fields of ``more``, and each other from the first source that has an attribute of its name."""
        for name in cls.__struct_fields__:
            owners = (source for source in sources if hasattr(source, name))
            if name not in more and (owner := next(owners, None)) is not None:
                more[name] = getattr(owner, name)
        return cls(**more)

    def __reduce__(self) -> str | tuple[Any, ...]:
        """Pickle and copy with what it was made from, which may hold the document itself."""
        if self.working is None:
            return super().__reduce__()
        own = {name: getattr(self, name) for name in self.__struct_fields__}
        return partial(type(self), **own), (), {"working": self.working}

    def made_by(self, working: Any) -> Self:
        """Keep what the document was made from, for ``working``."""
        vars(self)["working"] = working
        return self


class WrongKeyError(ValueError):
    """Fault of one key of a file: ``key`` as a path ("joints[2].d", counted from 1), ``problem``."""

    def __init__(self, key: str, problem: str) -> None:
        super().__init__(f"key {key!r}: {problem}")
        self.key, self.problem = key, problem


@contextmanager
def naming(source: str | Path, remedy: str = "") -> Iterator[None]:
    """Turn whatever is wrong with the content of a file into one line: the file's name, the fault, ``remedy``."""
    try:
        yield
    except ValueError as error:
        text = str(error)
        remedy = f": {remedy}" if remedy and not text.endswith(remedy) else ""
        raise InputError((text if text.startswith(f"{source}: ") else f"{source}: {text}") + remedy) from None


@contextmanager
def at(key: str) -> Iterator[None]:
    """Name the key at which whatever is wrong inside stands."""
    try:
        yield
    except WrongKeyError as fault:
        raise WrongKeyError(f"{key}.{fault.key}", fault.problem) from None
    except ValueError as error:
        raise WrongKeyError(key, str(error)) from None


_Kind = TypeVar("_Kind")


def present(value: _Kind | msgspec.UnsetType) -> _Kind | None:
    """Value of a key, None where the key is absent."""
    return None if isinstance(value, msgspec.UnsetType) else value


def read_toml(path: str | Path, kind: type[_Kind]) -> _Kind:
    """Read a TOML file."""
    text = read_text(path, TOML_BYTES)
    if not text.strip():
        raise InputError(f"{path}: is empty")
    data = toml_data(text, path)
    with naming(path):
        return convert(data, kind)


def read_json(path: str | Path, kind: type[_Kind], remedy: str) -> _Kind:
    """Read a JSON document; ``remedy`` says which file to give instead of one that holds something else."""
    with naming(path, remedy):
        text = read_text(path)
        try:
            data = msgspec.json.decode(text)
        except (msgspec.DecodeError, ValueError, RecursionError) as error:
            reason = "nested too deeply" if isinstance(error, RecursionError) else error
            raise InputError(f"cannot be read as JSON ({reason})") from None
        table: Any = kind
        fields = msgspec.structs.fields(table) if hasattr(table, "__struct_fields__") else ()
        own = {one.encode_name: one.default for one in fields}
        if isinstance(data, dict) and isinstance(wanted := own.get("kind"), str):
            held, others = data.get("kind", wanted), [key for key in data if key not in own and "kind" not in data]
            if isinstance(held, str) and held != wanted:
                raise InputError(f"is a result of the kind {held!r}, not {wanted!r}")
            if others:
                raise InputError(f"is no result of the kind {wanted!r}, which has no key {others[0]!r}")
        return convert(data, kind)


def read_text(path: str | Path, largest: int = 200_000_000) -> str:
    """Read a text file; InputError if there is none, or if it has more than ``largest`` bytes."""
    if Path(path).is_dir():
        raise InputError(f"{path}: is a folder: give a file")
    try:
        with opened(path) as stream:
            content = stream.read(largest + 1)
        if len(content) <= largest:
            return content.decode("utf-8-sig")  # editors of Windows begin a text with a byte order mark
        fault = f"larger than {largest // 1_000_000} MB: another kind of file?"
    except FileNotFoundError:
        fault = "no such file"
    except UnicodeDecodeError:
        fault = "not UTF-8 text: save it as UTF-8"
    except OSError as error:
        fault = f"cannot be read: {error.strerror or error}"
    raise InputError(f"{path}: {fault}")


def convert(data: Any, kind: type[_Kind]) -> _Kind:
    """Convert plain values to a table of its kind."""
    try:
        return msgspec.convert(data, kind, dec_hook=_array)
    except msgspec.ValidationError as error:
        raise _fault(error, data, kind) from None


def write_json(path: str | Path, document: Any) -> None:
    """Write a document in one step, so that a killed run leaves no half file."""
    write_bytes(path, json_text(document))


def json_text(document: Any) -> bytes:
    """Write a document as JSON text; nan and inf become null."""
    try:
        text = msgspec.json.encode(document, enc_hook=_plain)
    except UnicodeEncodeError:
        text = msgspec.json.encode(_encodable(msgspec.to_builtins(document, enc_hook=_plain)))
    return msgspec.json.format(text, indent=1) + b"\n"


def _encodable(value: Any) -> Any:
    if isinstance(value, dict):
        return {encodable(key): _encodable(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return list(map(_encodable, value))
    return encodable(value) if isinstance(value, str) else value


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no place in a document")


def _array(kind: Any, values: Any) -> Any:
    shape = "a list of numbers" if kind == _Row else "a list of lists of numbers"
    try:
        rows = msgspec.convert(values, _NUMBERS[kind])
    except msgspec.ValidationError:  # it would not tell where the list is
        raise ValueError(f"must be {shape}, got {shown(values)}") from None
    if kind == _Rows and len({len(row) for row in rows}) > 1:
        raise ValueError("rows must be of one length")
    array = np.array(rows, dtype=np.float64)
    array.setflags(write=False)
    return array


def _fault(error: msgspec.ValidationError, data: Any, kind: Any) -> ValueError:
    """Name the key that an error of msgspec speaks of, and what would do there."""
    text, _, path = str(error).partition(" - at `$")
    key, advice, cause = "", "", error.__cause__
    for name, index in re.findall(r"\.([^.\[`]+)|\[(\d+|\.\.\.)\]", path):
        kind = chosen(kind, data)
        if index.isdigit():
            kinds, position = get_args(kind), int(index)
            kind, data, advice = kinds[0] if kinds[-1] is ... else kinds[position], data[position], ""
            key += f"[{position + 1}]"
            continue
        if index:  # msgspec does not say which key of a mapping it is
            for name, value in data.items():
                with at(f"{key}.{name}"[1:]):
                    convert(value, get_args(kind)[1])
        elif name not in _fields(kind):  # the tag that says which of several tables it is
            return WrongKeyError(f"{key}.{name}"[1:], f"{shown(data.get(name))} is not a kind of table known here")
        else:
            advice, kind = kind.advice.get(name, ""), _fields(kind)[name]
        key, data = f"{key}.{name}", data[name]
    if isinstance(cause, WrongKeyError):
        return WrongKeyError(f"{key}.{cause.key}"[1:], cause.problem)
    if field := re.search(r"(required|unknown) field `(.*)`", text):
        table, name = chosen(kind, data), field[2]
        advised, known = table.advice.get(name), _fields(table)
        missing = f"missing: {advised or 'must be ' + words(known.get(name, str))}"  # a tag is no field
        problem = missing if field[1] == "required" else advised or unknown(known, name)
        return WrongKeyError(f"{key}.{name}"[1:], problem)
    problem = advice or f"must be {words(kind)}"
    problem = text if cause else f"{problem}, got {shown(data)}"
    return WrongKeyError(key[1:], problem) if key else ValueError(problem)


def unknown(known: Collection[str], key: str) -> str:
    """Say that a key is none of those known, and which of them may be meant."""
    near = get_close_matches(key, known, 1)
    in_unit = ", with its value in that unit" if near and near[0].startswith(f"{key}_") else ""
    hint = f": did you mean {near[0]!r}{in_unit}?" if near else ""
    listed = f"{'' if near else ';'} known here: {', '.join(sorted(known))}" if len(known) < _MANY else ""
    return f"unknown{hint}{listed}"


def _fields(table: type[Table]) -> dict[str, Any]:
    return {field.encode_name: field.type for field in msgspec.structs.fields(table)}


def chosen(kind: Any, data: Any) -> Any:
    """Choose the one kind of several that the data take: the table of that tag, a table, a list, or a mapping."""
    if get_origin(kind) is Annotated:
        return chosen(get_args(kind)[0], data)
    if get_origin(kind) not in (Union, UnionType):
        return kind
    several = [chosen(alternative, data) for alternative in get_args(kind) if alternative is not NoneType]
    for table in several if isinstance(data, dict) else ():
        config = getattr(table, "__struct_config__", None)
        if config is not None and config.tag is not None and data.get(config.tag_field) == config.tag:
            return table
    lists = isinstance(data, list)
    return next((alternative for alternative in several if (get_origin(alternative) is tuple) == lists), kind)
