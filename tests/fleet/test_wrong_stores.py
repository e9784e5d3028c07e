"""Stores that somebody changed: told in a line, whatever was changed."""

import contextlib
from collections.abc import Iterator
from pathlib import Path

import pytest
from dynident.tests.commands.lines import make_recordings
from dynident.tests.commands.test_faults import run
from dynident.tests.frozen.inputs import unpack


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    place = tmp_path_factory.mktemp("wrong_stores")
    unpack(place)
    with contextlib.chdir(place):
        make_recordings(place)
        yield place


WRONG = ["", "{", "[]", "3", '{"robot": 3}', '{"logs": [{"file": "a.csv"}]}', 3000 * "["]


@pytest.mark.parametrize("text", WRONG)
def test_a_changed_index_of_a_store_is_named(text: str, folder: Path) -> None:
    path = folder / "nightly/logs.parquet"
    good = path.read_bytes()
    path.write_text(text)
    status, out, err = run(["fleet", "report", "nightly", "--json", "-"])
    path.write_bytes(good)
    assert (status, out) == (2, "")
    assert "logs.parquet" in err
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize("text", WRONG)
def test_a_changed_description_of_a_store_is_named(text: str, folder: Path) -> None:
    path = folder / "nightly/store.json"
    good = path.read_bytes()
    path.write_text(text)
    status, out, err = run(["fleet", "reduce", "first.csv", "--robot", "rx90", "--store", "nightly"])
    path.write_bytes(good)
    assert (status, out) == (2, "")
    assert "store.json" in err
    assert len(err.splitlines()) == 1
