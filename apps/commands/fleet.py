"""``dynident fleet``: recordings of many robots to a store of equations, in parallel, and what changed by them."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import Any

from ... import estimation
from ...common.errors import InputError
from ...common.files import made_folder
from ...common.schema import given, json_text
from .. import fleet, report
from . import ANSWERED, COMMANDS, DO_NOT_USE
from .options import (
    GainOptions,
    Options,
    PageOptions,
    ProcessingOptions,
    ResultOptions,
    RobotOptions,
    Setup,
    add_command,
    option,
)
from .progress import bar, note
from .values import positive


def add_parser(commands: Any) -> None:
    """Arguments of the commands below it."""
    parser = commands.add_parser("fleet", help=COMMANDS["fleet"])
    below = parser.add_subparsers(required=True, metavar="what")
    add_command(below, "reduce", run_reduce, help="each recording to its equations in a store")
    add_command(below, "report", run_report, help="friction, payload, scales: what changed")


@dataclass(frozen=True)
class _Reduce(Options):
    """Logs, what is known of them, and who reduces them."""

    logs: tuple[str, ...] = option(
        "logs", nargs="*", metavar="LOG", help="logs without payload: files, folders, globs, URLs with fsspec"
    )
    store: str = option(writes="folder", required=True, metavar="DIR", help="folder of the reduced recordings")
    table: str | None = option(
        either="known",
        reads="table of logs",
        metavar="CSV",
        help="columns file, arm, and perhaps day, temperature (deg C), payload (told, kg); of all logs",
    )
    pattern: str = option(
        either="known",
        default="",
        metavar="PATH",
        help="how paths end, such as '{arm}/{day}.csv'; * stands for anything else in a name",
    )
    workers: int = option(type=positive, default=1, metavar="N", help="processes (default: 1, this one)")
    scheduler: str | None = option(
        metavar="ADDRESS", help="a Dask scheduler, tcp://host:8786, or 'local' for one of --workers processes"
    )
    batch: int | None = option(type=positive, metavar="N", help="recordings a task of Dask (default: 4)")

    def entries(self) -> tuple[fleet.Log, ...]:
        """The logs with what is known of them."""
        if not self.logs and self.table is None:
            raise InputError("no logs: give files, folders or globs, or --table")
        return fleet.catalog.catalog(fleet.catalog.found_logs(self.logs), self.pattern, self.table)


def run_reduce(
    arm: RobotOptions, request: _Reduce, drives: GainOptions, processing: ProcessingOptions, files: ResultOptions
) -> int:
    """Run ``fleet reduce``."""
    if request.scheduler is None:
        request.refuse("batch", "belongs to --scheduler: a process takes one recording at a time")
    setup, entries = processing.setup(arm.load()), request.entries()
    recipe = _recipe(setup, drives.errors(setup, [], []))
    address = None if request.scheduler == "local" else request.scheduler
    cluster = (
        fleet.reduction.dask_executor(address, request.workers)
        if request.scheduler
        else nullcontext((None, request.workers))
    )
    with bar("reducing") as progress, cluster as (executor, workers):
        reduced = fleet.reduce_fleet(
            entries,
            setup.robot,
            request.store,
            recipe,
            setup.log_map,
            executor,
            workers,
            (request.batch or 4) if executor else 1,
            progress,
        )
    if reduced.workers_lost:
        note(f"workers were lost {reduced.workers_lost} times and replaced: nothing is lost, nothing counts twice")
    files.show(report.reduced_screen(reduced))
    files.write_json(lambda: reduced)
    return ANSWERED if reduced.new or reduced.known else DO_NOT_USE


def _recipe(setup: Setup, gains: estimation.Gains | None) -> fleet.Recipe:
    """How this run makes its numbers, as the store remembers it."""
    how = {key: entry for key, entry in given(setup.log_map).items() if key != "title"}
    sure = replace(gains, notes=()) if gains is not None else None  # notes speak of single recordings
    return fleet.Recipe(setup.processing, setup.gains, sure, json_text(how).decode() if how else "")


@dataclass(frozen=True)
class _Store(Options):
    """A store, and where its numbers go."""

    store: str = option("store", metavar="STORE", help="the --store of 'dynident fleet reduce'")
    parquet: str | None = option(
        writes="folder", metavar="DIR", help="every night's numbers as Parquet (needs pyarrow)"
    )


def run_report(request: _Store, files: PageOptions) -> int:
    """Run ``fleet report``."""
    store = fleet.Store.opened(request.store)
    history, refused = fleet.fleet_of(_arms(store)), store.refused()
    files.show(report.fleet_screen(history, refused))
    files.write_json(lambda: report.documents.fleet_document(history, refused))
    words = {"robot": history.arms[0].name}
    files.write_page(lambda: report.fleet_page(history, refused, files.provenance(words, request)))
    if request.parquet:
        _write_tables(Path(made_folder(request.parquet)), history)
    return ANSWERED


def _arms(store: fleet.Store) -> list[fleet.nights.Arm]:
    """Each arm by its recordings, one arm in memory at a time.

    Raises:
        InputError: if the store is empty, or does not say whose the recordings are.
    """
    logs = sorted(store.logs(), key=lambda log: log.about.get("arm", ""))
    if not logs:
        raise InputError(f"{store.root}: no recording in it")
    arms, done = [], 0
    with bar("reading nights") as progress:
        for _, own in groupby(logs, key=lambda log: log.about.get("arm", "")):
            arms.append(fleet.nights.arm_of([store.read(log.key) for log in own]))
            done += len(arms[-1].days)
            progress(done / len(logs))
    return arms


def _write_tables(folder: Path, history: fleet.Fleet) -> None:
    """Every night's numbers.

    Raises:
        InputError: without pyarrow.
    """
    nights = [
        (arm.name, day, temperature, told, line.quantity, float(line.values[k]), float(line.sigma[k]))
        for arm in history.arms
        for k, (day, temperature, told) in enumerate(zip(arm.days, arm.temperatures, arm.told, strict=True))
        for line in arm.series
    ]
    names = ("arm", "day", "temperature", "told", "quantity", "value", "sigma")
    if not fleet.store.write_parquet(folder / "nights.parquet", names, nights):
        raise InputError("--parquet needs pyarrow: pip install 'dynident[fleet]'")
