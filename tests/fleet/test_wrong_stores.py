"""Stores and passports that somebody changed: told in a line, whatever was changed, a seal made anew too."""

import contextlib
import copy
import hashlib
import io
import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps import fleet
from dynident.cli import main
from dynident.common.errors import InputError
from dynident.tests.commands.lines import LINES, make_passports
from dynident.tests.commands.test_faults import run
from dynident.tests.frozen.inputs import unpack

ODD: tuple[Any, ...] = (
    None,
    True,
    -1,
    1e300,
    "x",
    [],
    ["x", "x"],
    {"number": "nan"},
    {"kind": ["Log", {}]},
    {"array": [0, 3]},
)
TABLES = {
    "a byte that is no text": b"\xff",
    "no header": b"",
    "a column gone": b"file,sha256,arm,day,payload,passport\na,b,c,d,e,f\n",
    "a cell gone": b"file,sha256,arm,day,temperature,payload,passport\na,b\n",
    "a cell too many": b"file,sha256,arm,day,temperature,payload,passport\na,b,c,d,e,f,g,h\n",
    "a cell without end": b"file,sha256,arm,day,temperature,payload,passport\n" + 200_000 * b"x",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    place = tmp_path_factory.mktemp("wrong_stores")
    unpack(place)
    with contextlib.chdir(place):
        make_passports(place)
        yield place


def sealed(content: bytes, tree: Any) -> bytes:
    """A passport's file with another tree, and a seal that fits."""
    with np.load(io.BytesIO(content), allow_pickle=False) as data:
        arrays = {**data, "tree": np.frombuffer(json.dumps(tree).encode(), dtype=np.uint8)}
    stream = io.BytesIO()
    np.savez(stream, **arrays)
    archive = stream.getvalue()[:-2] + struct.pack("<H", 64)
    return archive + hashlib.sha256(archive).hexdigest().encode()


def places(tree: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Where values stand; of a row the first one."""
    below = (
        list(tree.items())
        if isinstance(tree, dict)
        else list(enumerate(tree))[:2]
        if isinstance(tree, list)
        else []
    )
    for key, value in below:
        yield (*path, key)
        yield from places(value, (*path, key))


@pytest.mark.parametrize("name", ["first", pytest.param("payload", marks=pytest.mark.long)])
def test_no_forged_passport_breaks_a_command(name: str, folder: Path) -> None:
    """Each field of each kind of value in turn holds something else: it is read as a passport, or refused."""
    if name == "payload":
        main(["payload", *LINES["payload"].split(), "--passport", "payload.npz", "--quiet"])
    content = Path(f"{name}.npz").read_bytes()
    with np.load(io.BytesIO(content), allow_pickle=False) as data:
        tree = json.loads(data["tree"].tobytes())
    fields = {tuple(key for key in path if isinstance(key, str)): path for path in places(tree)}
    refused = []
    for number, path in enumerate(fields.values()):
        forged = copy.deepcopy(tree)
        place = forged
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = ODD[number % len(ODD)]
        try:
            fleet.files.passport_of(sealed(content, forged))
        except InputError as error:
            refused.append(str(error))
    assert len(refused) > 0.8 * len(fields) > 40
    assert not any("\n" in line for line in refused)


@pytest.mark.parametrize("change", TABLES)
@pytest.mark.parametrize("table", ["index.csv", "refused.csv"])
def test_a_changed_table_of_a_store_is_named(table: str, change: str, folder: Path) -> None:
    path = folder / "nightly" / table
    good = path.read_bytes()
    path.write_bytes(TABLES[change])
    status, out, err = run(["fleet", "report", "nightly", "--json", "-"])
    path.write_bytes(good)
    assert (status, out) == (2, "")
    assert table in err
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize("text", ["", "{", "[]", "3", '{"robot": 3}', 3000 * "["])
def test_a_changed_description_of_a_store_is_named(text: str, folder: Path) -> None:
    path = folder / "nightly/store.json"
    good = path.read_bytes()
    path.write_text(text)
    status, out, err = run(["fleet", "reduce", "first.csv", "--robot", "rx90", "--store", "nightly"])
    path.write_bytes(good)
    assert (status, out) == (2, "")
    assert "store.json" in err
    assert len(err.splitlines()) == 1
