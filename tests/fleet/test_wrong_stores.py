"""Stores that somebody changed: told in a line, whatever was changed."""

import contextlib
from collections.abc import Iterator
from pathlib import Path

import pytest
from dynident.tests.commands.lines import make_recordings
from dynident.tests.commands.test_faults import run
from dynident.tests.frozen.inputs import unpack

TABLES = {
    "a byte that is no text": b"\xff",
    "no header": b"",
    "a column gone": b"file,sha256,arm,day,payload,key\na,b,c,d,e,f\n",
    "a cell gone": b"file,sha256,arm,day,temperature,payload,key\na,b\n",
    "a cell too many": b"file,sha256,arm,day,temperature,payload,key\na,b,c,d,e,f,g,h\n",
    "a cell without end": b"file,sha256,arm,day,temperature,payload,key\n" + 200_000 * b"x",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    place = tmp_path_factory.mktemp("wrong_stores")
    unpack(place)
    with contextlib.chdir(place):
        make_recordings(place)
        yield place


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
