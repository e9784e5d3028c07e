"""Stores that somebody changed: told in a line, whatever was changed."""

import contextlib
from collections.abc import Iterator
from pathlib import Path

import pytest
from dynident.tests.commands.lines import make_recordings
from dynident.tests.commands.typed import refused
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
@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("logs.parquet", "fleet report nightly --json -"),
        ("store.json", "fleet reduce first.csv --robot rx90 --store nightly"),
    ],
)
def test_what_was_changed_in_a_store_is_named(name: str, line: str, text: str, folder: Path) -> None:
    path = folder / "nightly" / name
    good = path.read_bytes()
    path.write_text(text)
    error = refused(line)
    path.write_bytes(good)
    assert name in error
