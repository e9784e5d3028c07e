"""Logs of a fleet's night in the working folder, and the store that one run makes of them."""

import contextlib
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from dynident.apps import fleet
from dynident.tests.fleet.night_logs import ROBOT, entries, write_logs


@pytest.fixture(scope="module")
def logs(
    shared: Callable[[str, Callable[[Path], object]], Path], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Path]:
    """Three good recordings, and every kind of wrong one; the working folder."""
    place = tmp_path_factory.mktemp("fleet") / "logs"
    shutil.copytree(shared("night_logs", write_logs), place)
    with contextlib.chdir(place):
        yield place


@pytest.fixture(scope="module")
def store(
    logs: Path, shared: Callable[[str, Callable[[Path], object]], Path], tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """The store that one run makes of them all."""
    place = tmp_path_factory.mktemp("stores") / "serial"
    shutil.copytree(shared("night_store", _reduce), place)
    return place


def _reduce(place: Path) -> None:
    reduced = fleet.reduce_fleet(entries(), ROBOT, place)
    assert (reduced.new, reduced.known) == (3, 0)
