"""``dynident fleet``: recordings of many robots to a store of equations, in parallel, and what changed by them."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

from ...common.errors import InputError
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
        "logs", nargs="+", metavar="LOG", help="logs without payload: files, folders, globs"
    )
    store: str = option(writes="folder", required=True, metavar="DIR", help="folder of the reduced recordings")
    pattern: str = option(
        default="",
        metavar="PATH",
        help="how paths end, such as '{arm}/{day}.csv', or with {payload} (told, kg); * stands for anything else",
    )
    workers: int = option(type=positive, default=1, metavar="N", help="processes (default: 1, this one)")
    scheduler: str | None = option(
        metavar="ADDRESS", help="a Dask scheduler, tcp://host:8786, or 'local' for one of --workers processes"
    )


def run_reduce(
    arm: RobotOptions, request: _Reduce, drives: GainOptions, processing: ProcessingOptions, files: ResultOptions
) -> int:
    """Run ``fleet reduce``."""
    setup = processing.setup(arm.load())
    entries = fleet.store.catalog(fleet.store.found_logs(request.logs), request.pattern)
    gains = drives.errors(setup, [], [])
    gains = replace(gains, notes=()) if gains is not None else None  # notes speak of single recordings
    how = {key: entry for key, entry in given(setup.log_map).items() if key != "title"}
    recipe = fleet.Recipe(setup.processing, setup.gains, gains, json_text(how).decode() if how else "")
    address = None if request.scheduler == "local" else request.scheduler
    cluster = (
        fleet.reduction.dask_executor(address, request.workers)
        if request.scheduler
        else nullcontext((None, request.workers))
    )
    with bar("reducing") as progress, cluster as (executor, workers):
        reduced = fleet.reduce_fleet(
            entries, setup.robot, request.store, recipe, setup.log_map, executor, workers, progress
        )
    if reduced.workers_lost:
        note(f"workers were lost {reduced.workers_lost} times and replaced: nothing is lost, nothing counts twice")
    files.show(report.reduced_screen(reduced))
    files.write_json(lambda: reduced)
    return ANSWERED if reduced.new or reduced.known else DO_NOT_USE


@dataclass(frozen=True)
class _Store(Options):
    """A store."""

    store: str = option("store", metavar="STORE", help="the --store of 'dynident fleet reduce'")


def run_report(request: _Store, files: PageOptions) -> int:
    """Run ``fleet report``."""
    store = fleet.Store.opened(request.store)
    index = store.index()
    logs = sorted(index.logs, key=lambda log: log.about.get("arm", ""))
    if not logs:
        raise InputError(f"{store.root}: no recording in it")
    arms, done = [], 0
    with bar("reading nights") as progress:
        for _, own in groupby(logs, key=lambda log: log.about.get("arm", "")):  # one arm in memory at a time
            arms.append(fleet.nights.arm_of([store.read(log.key) for log in own]))
            done += len(arms[-1].days)
            progress(done / len(logs))
    history, refused = fleet.fleet_of(arms), {bad.file: bad.reason for bad in index.refused}
    files.show(report.fleet_screen(history, refused))
    files.write_json(lambda: report.documents.fleet_document(history, refused))
    words = {"robot": history.arms[0].name}
    files.write_page(lambda: report.fleet_page(history, refused, files.provenance(words, request)))
    return ANSWERED
