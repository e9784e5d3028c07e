"""``dynident fleet`` and ``compare``: recordings of many robots to a store of equations, or of one side by side."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from itertools import groupby
from typing import Annotated

from cyclopts import Parameter

from ... import estimation
from ...common.errors import InputError
from ...common.files import checksum
from ...common.progress import each, silent
from .. import logs
from ..fleet.comparing import arm_of, excess, fleet_of, side_by_side, widened
from ..fleet.reduction import dask_executor, reduce_fleet
from ..fleet.store import Recipe, Store, catalog, found_logs
from ..report.sections.recordings import compared_report, fleet_report, reduced_report
from .entry import command
from .options import GainOptions, PageOptions, ProcessingOptions, ResultOptions, RobotOptions
from .progress import note, status
from .values import LOG, Count, DataFiles, NewFolder

_Store = Annotated[str, Parameter(metavar="STORE", help="The folder given to 'dynident fleet reduce --store'.")]
_Logs = Annotated[DataFiles, Parameter(help="Recordings of one robot without payload.")]


@command
def run_reduce(
    data: Annotated[tuple[str, ...], LOG, Parameter(help="Logs without payload: files, folders, globs.")],
    *,
    arm: RobotOptions,
    store: NewFolder,
    pattern: Annotated[str, Parameter(metavar="PATH")] = "",
    workers: Count = 1,
    cluster: Annotated[str | None, Parameter(metavar="ADDRESS")] = None,
    drives: GainOptions,
    processing: ProcessingOptions,
    files: ResultOptions,
) -> bool:
    """Run ``fleet reduce``.

    Args:
        store: Folder of the reduced recordings.
        pattern: Ends of paths, such as '{arm}/{day}.csv', or with {payload} (reported, kg); * stands for anything
            else.
        workers: Processes of this machine (default: 1, this one).
        cluster: A Dask scheduler, tcp://host:8786, whose workers do it.
    """
    setup = processing.setup(arm.load())
    entries = catalog(found_logs(data), pattern)
    gains = drives.errors(setup, [], [])
    gains = replace(gains, notes=()) if gains is not None else None  # notes speak of single recordings
    recipe = Recipe(setup.processing, setup.gains, gains, setup.log_map)
    executor = dask_executor(cluster) if cluster else nullcontext(workers)
    with status("reducing") as progress, executor as able:
        told = partial(progress, "reducing")
        reduced = reduce_fleet(entries, setup.robot, store, recipe, able, told)
    if reduced.workers_lost:
        note(f"workers were lost {reduced.workers_lost} times and replaced: nothing is lost, nothing counts twice")
    files.give(reduced_report(reduced), lambda: reduced, {})
    return bool(reduced.new or reduced.known)


@command
def run_report(store: _Store, *, files: PageOptions) -> None:
    """Run ``fleet report``."""
    opened = Store.opened(store)
    every = opened.logs()
    logs = sorted((log for log in every if not log.reason), key=lambda log: log.arm or "")
    if not logs:
        raise InputError(f"{opened.root}: no recording in it")
    arms, done = [], 0
    with status("reading nights") as progress:
        for _, own in groupby(logs, key=lambda log: log.arm or ""):  # one arm in memory at a time
            arms.append(arm_of([opened.read(log.key) for log in own]))
            done += len(arms[-1].days)
            progress("reading nights", done / len(logs))
    told = fleet_of(arms, [log for log in every if log.reason])
    files.give(fleet_report(told), lambda: told, {"robot": told.arms[0]})


@command
def run_compare(data: _Logs, *, arm: RobotOptions, processing: ProcessingOptions, files: ResultOptions) -> None:
    """Run ``compare``."""
    if len(paths := logs.grouped(data)) < 2:
        raise InputError("one recording: give two or more to compare")
    first = dict[str, str]()
    for path in data:
        if first.setdefault(checksum(path), path) != path or data.count(path) > 1:
            raise InputError(f"{path} is given twice: a recording counts once")
    setup = processing.setup(arm.load())
    with status("identifying") as progress:
        settings = setup.settings(silent, friction=setup.robot.drives.friction, gains=setup.identified)
        estimates = [
            estimation.identify(setup.robot, setup.read([path]), settings).estimate
            for path in each(paths, "identifying {}".format, progress)
        ]
    names = [path if isinstance(path, str) else " and ".join(path) for path in paths]
    compared = side_by_side(names, [widened(own, excess(own, own.sigma_robust)) for own in estimates])
    files.give(compared_report(compared), lambda: compared, {})
