"""``dynident fleet reduce``: recordings to a store of equations, in parallel."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass, replace

from ... import estimation
from ...common.errors import InputError
from ...common.schema import given, json_text
from .. import fleet, report
from . import ANSWERED, DO_NOT_USE
from .options import GainOptions, Options, ProcessingOptions, ResultOptions, RobotOptions, Setup, option
from .progress import bar, note
from .values import positive

_LOCAL = "local"


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

    def entries(self) -> tuple[fleet.catalog.Entry, ...]:
        """The logs with what is known of them."""
        if not self.logs and self.table is None:
            raise InputError("no logs: give files, folders or globs, or --table")
        return fleet.catalog.catalog(fleet.catalog.found_logs(self.logs), self.pattern, self.table)


def run(
    arm: RobotOptions, request: _Reduce, drives: GainOptions, processing: ProcessingOptions, files: ResultOptions
) -> int:
    """Run it."""
    if request.scheduler is None:
        request.refuse("batch", "belongs to --scheduler: a process takes one recording at a time")
    setup, entries = processing.setup(arm.load()), request.entries()
    recipe = _recipe(setup, drives.errors(setup, [], []))
    address = None if request.scheduler == _LOCAL else request.scheduler
    cluster = (
        fleet.engine.dask_executor(address, request.workers)
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
    if reduced.crashes:
        note(f"workers were lost {reduced.crashes} times and replaced: nothing is lost, nothing counts twice")
    files.show(report.reduced_screen(reduced))
    files.write_json(lambda: report.documents.reduced_document(reduced))
    return ANSWERED if reduced.new or reduced.known else DO_NOT_USE


def _recipe(setup: Setup, gains: estimation.Gains | None) -> fleet.Recipe:
    """How this run makes its numbers, as the store remembers it."""
    how = {key: entry for key, entry in given(setup.log_map).items() if key != "title"}
    sure = replace(gains, notes=()) if gains is not None else None  # notes speak of single recordings
    return fleet.Recipe(setup.processing, setup.gains, sure, json_text(how).decode() if how else "")
