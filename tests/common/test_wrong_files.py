"""One key of a file wrong: one line that names the file and the key, whatever the file and whatever the key."""

import copy
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple, get_args

import msgspec
import pytest
from dynident.apps.logs.map import LogMap, read_log_map
from dynident.apps.results import read_stored_gains, read_stored_payload, read_stored_robot
from dynident.common.errors import InputError
from dynident.common.schema import Table, chosen, json_text, read_toml, toml_text
from dynident.estimation import GainsResult, PayloadResult, RobotResult
from dynident.estimation.answers.gains import KnownLoad
from dynident.model import load_robot, read_payload
from dynident.model.files import robot_file
from dynident.model.files.robot_file import RobotTable
from dynident.tests.model.test_robot_file import FULL
from dynident.tests.trajectories.test_scene import WHOLE
from dynident.trajectories import read_scene
from dynident.trajectories.design.scene import Scene
from msgspec import inspect


class Mistake(NamedTuple):
    """One mistake in a file's data; ``key``: where the line must say that it is; empty where it is none."""

    what: str
    key: str
    data: dict[str, Any]


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
        yield Mistake(f"{name} left out", name if field.required else "", edited(data, table, key, {}))
        yield Mistake(f"{name} misspelt", f"{name}x", edited(data, table, key, {f"{key}x": value}))
        node = inspect.type_info(field.type)
        if isinstance(node, inspect.AnyType):
            continue
        wrong_value = 3 if isinstance(value, dict) else {"other": "type"}
        yield Mistake(f"{name} of another type", name, edited(data, table, key, {key: wrong_value}))
        if isinstance(node, inspect.TupleType):
            yield Mistake(f"{name} too short", name, edited(data, table, key, {key: value[1:]}))
            yield Mistake(f"{name} with a gap", name, edited(data, table, key, {key: [{}, *value[1:]]}))
        nodes = node.types if isinstance(node, inspect.UnionType) else (node,)
        if any(isinstance(node, inspect.FloatType) and node.le is not None for node in nodes):
            yield Mistake(f"{name} out of range", name, edited(data, table, key, {key: 1e300}))


def edited(data: Any, table: tuple[str | int, ...], key: str, more: dict[str, Any]) -> dict[str, Any]:
    """A copy with a key of a table left out, and what stands in its place."""
    changed = copy.deepcopy(data)
    place = changed
    for step in table:
        place = place[step]
    del place[key]
    place.update(more)
    return dict(changed)


MAP = """
title = "a log"
joints = ["a", "b"]

[file]
delimiter = "semicolon"
decimal = ","
names = ["t", "q1..2"]
skip_lines = 1
numbers_per_row = 3
topic = "x"

[[files]]
name = "q.csv"
names = ["q1..2"]

[time]
column = "t"
unit = "ms"

[motor]
gear_ratios = [100, 50]
coupling = [{motor = 2, joint = 1, ratio = 3}]

[pose]
columns = ["x", "y", "z"]
unit = "mm"
rotation = ["a", "b", "c"]
form = "rpy"
rotation_unit = "deg"

[position]
columns = "q{}"
unit = "deg"
side = "motor"
sign = [1, -1]
zero_deg = [90, 0]

[torque]
unit = "percent"
rated = [10, 20]

[position_reference]
columns = "qd{}"
unit = "deg"
"""
LOAD = "mass = 6\nmass_sigma = 0.01\ncom = [0.03, 0.12, 0.06]\ninertia_com = [0.03, 0, 0, 0.04, 0, 0.02]\n"
TEN = "XX = 0.2\nXY = 0\nXZ = 0\nYY = 0.2\nYZ = 0\nZZ = 0.1\nMX = 0\nMY = 0\nMZ = 0.1\nM = 3\n"


class File(NamedTuple):
    """A kind of file: what is right, the type and the function it is read by, and how it is written."""

    name: str
    data: dict[str, Any]
    kind: type[Table]
    read: Callable[[Path], Any]


def toml(name: str, text: str, kind: type[Table], read: Callable[[Path], Any]) -> File:
    return File(f"{name}.toml", tomllib.loads(text), kind, read)


def filled(node: inspect.Type, within: tuple[type, ...] = ()) -> Any:
    """Plain data of a type: every key there, every list of one entry, or of one of each kind of table."""
    match node:
        case inspect.Metadata(extra_json_schema={"description": words}):
            return [[0.25]] if "lists" in words else [0.25]
        case inspect.UnionType(types=types):
            return filled(types[0], within)
        case inspect.LiteralType(values=values):
            return values[-1]
        case inspect.TupleType(item_types=items):
            return [filled(item, within) for item in items]
        case inspect.ListType(item_type=item) | inspect.VarTupleType(item_type=item):
            each = item.types if isinstance(item, inspect.UnionType) else (item,)
            return [
                filled(kind, within) for kind in each if isinstance(kind, inspect.StructType) or kind is each[0]
            ]
        case inspect.DictType(key_type=key, value_type=value):
            return {filled(key, within): filled(value, within)}
        case inspect.StructType(cls=kind, fields=fields, tag_field=tag):
            own = [field for field in fields if field.required or kind not in within]
            data = {field.encode_name: filled(field.type, (*within, kind)) for field in own}
            return ({tag: node.tag} if tag else {}) | data
    plain = {inspect.BoolType: True, inspect.IntType: 1, inspect.FloatType: 0.25, inspect.StrType: "use"}
    return plain.get(type(node))


def stored(name: str, kind: type[Table], read: Callable[[Path], Any]) -> File:
    """A document that later runs read."""
    return File(f"{name}.json", filled(inspect.type_info(kind)), kind, read)


FILES = [
    toml("robot", FULL, RobotTable, load_robot),
    toml("scene", WHOLE, Scene, read_scene),
    toml("map", MAP, LogMap, read_log_map),
    toml("load", LOAD, KnownLoad, lambda path: read_toml(path, KnownLoad)),
    toml("body", LOAD.replace("mass_sigma = 0.01\n", ""), robot_file.BodyTable, read_payload),
    toml("ten", TEN, robot_file.TenTable, read_payload),
    stored("robot", RobotResult, read_stored_robot),
    stored("gains", GainsResult, read_stored_gains),
    stored("payload", PayloadResult, read_stored_payload),
]


def write(folder: Path, file: File, data: dict[str, Any]) -> Path:
    path = folder / file.name
    path.write_bytes(toml_text(data).encode() if file.name.endswith(".toml") else json_text(data))
    return path


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_the_file_is_read_when_it_is_right(file: File, tmp_path: Path) -> None:
    assert file.read(write(tmp_path, file, file.data))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_one_line_names_file_and_key(file: File, tmp_path: Path) -> None:
    """Every mistake in every key is refused so."""
    problems = {mistake.what: problem(file, mistake, tmp_path) for mistake in mistakes(file.data, file.kind)}
    assert problems
    assert not {mistake: text for mistake, text in problems.items() if text}


@pytest.mark.parametrize("tag", [None, 3, "other", [], {}])
def test_a_tag_of_no_table(tag: Any, tmp_path: Path) -> None:
    file = next(file for file in FILES if file.name == "payload.json")
    first, *others = file.data["estimates"]
    with pytest.raises(InputError, match=r"payload\.json: key 'estimates\[1\]\.estimator': .* not a kind of table"):
        file.read(write(tmp_path, file, {**file.data, "estimates": [{**first, "estimator": tag}, *others]}))
    first = {key: value for key, value in first.items() if key != "estimator"}
    with pytest.raises(InputError, match=r"payload\.json: key 'estimates\[1\]\.estimator': missing: must be text"):
        file.read(write(tmp_path, file, {**file.data, "estimates": [first, *others]}))


def problem(file: File, mistake: Mistake, folder: Path) -> str:
    """A fault in how a mistake is refused; empty if there is none."""
    try:
        file.read(write(folder, file, mistake.data))
    except InputError as error:
        line = str(error)
        says = "\n" not in line and file.name in line and (not mistake.key or f"key '{mistake.key}" in line)
        return "" if says else line
    return "read in silence" if mistake.key else ""


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", b"= [", b"[]", b"3"])
@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_what_is_no_such_file_at_all_is_one_line(file: File, content: bytes, tmp_path: Path) -> None:
    path = tmp_path / file.name
    path.write_bytes(content)
    with pytest.raises(InputError, match=file.name) as refused:
        file.read(path)
    assert "\n" not in str(refused.value)
    folder = tmp_path / "folder"
    folder.mkdir()
    for nothing in (folder, tmp_path / "none"):
        with pytest.raises(InputError, match=nothing.name) as refused:
            file.read(nothing)
        assert str(refused.value).count(str(nothing)) == 1
