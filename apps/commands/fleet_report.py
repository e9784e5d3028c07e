"""``dynident fleet report``: what changed in a fleet, by the recordings of its nights."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from ...common.errors import InputError
from ...common.files import made_folder
from .. import fleet, report
from . import ANSWERED
from .options import Options, PageOptions, option
from .progress import bar


@dataclass(frozen=True)
class _Store(Options):
    """A store, and where its numbers go."""

    store: str = option("store", metavar="STORE", help="the --store of 'dynident fleet reduce'")
    parquet: str | None = option(
        writes="folder", metavar="DIR", help="every night's numbers as Parquet (needs pyarrow)"
    )


def run(request: _Store, files: PageOptions) -> int:
    """Run it."""
    store = fleet.Store.opened(request.store)
    history, refused = fleet.fleet_of(_arms(store)), store.refused()
    files.show(report.fleet_screen(history, refused))
    files.write_json(lambda: report.documents.fleet_document(history, refused))
    words = {"robot": history.arms[0].name}
    files.write_page(lambda: report.fleet_page(history, refused, files.provenance(words, request)))
    if request.parquet:
        write_tables(Path(made_folder(request.parquet)), history)
    return ANSWERED


def _arms(store: fleet.Store) -> list[fleet.nights.Arm]:
    """Each arm by its recordings, one arm in memory at a time.

    Raises:
        InputError: if the store is empty, or does not say whose the recordings are.
    """
    rows = sorted(store.rows(), key=lambda row: row.about.get("arm", ""))
    if not rows:
        raise InputError(f"{store.root}: no recording in it")
    arms, done = [], 0
    with bar("reading nights") as progress:
        for _, arm_rows in groupby(rows, key=lambda row: row.about.get("arm", "")):
            recordings = [store.read(row.key) for row in arm_rows]
            arms.append(fleet.nights.arm_of(recordings))
            done += len(recordings)
            progress(done / len(rows))
    return arms


def write_tables(folder: Path, history: fleet.Fleet) -> None:
    """Every night's numbers.

    Raises:
        InputError: without pyarrow.
    """
    nights = [
        (arm.name, night.day, night.temperature, night.told, name, *number)
        for arm in history.arms
        for night in arm.nights
        for name, number in night.numbers.items()
    ]
    names = ("arm", "day", "temperature", "told", "quantity", "value", "sigma")
    if not fleet.store.write_parquet(folder / "nights.parquet", names, nights):
        raise InputError("--parquet needs pyarrow: pip install 'dynident[fleet]'")
