"""``dynident check``, ``verify``, ``compare``, ``fleet``: a recording, several side by side, or many robots'."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import field, replace
from functools import partial
from itertools import groupby
from typing import Annotated, ClassVar

from cyclopts import Parameter

from ... import estimation
from ...common.errors import InputError
from ...common.files import checksum
from ...common.progress import each, silent
from .. import logs
from ..fleet.comparing import arm_of, excess, fleet_of, side_by_side, widened
from ..fleet.reduction import Recipe, Store, catalog, dask_executor, found_logs, reduce_fleet
from ..logs.log_check import check_log, following_change, longest, read_following, robot_fits
from ..report.documents import Look, check_document
from ..report.sections import recordings as sections
from .entry import note, status
from .options import PageOptions, RecordingOptions
from .values import LOG, SEVERAL, Count, DataFiles, NewFolder, Reads, RobotFile


class _Check(PageOptions, RecordingOptions, without=["gain_sigma"]):
    rules: ClassVar = {"mount": ("robot",), "chain": ("robot",)}

    data: DataFiles = field(default=(), kw_only=False)
    """Recordings, with or without payload."""
    robot: RobotFile = ""
    """An included robot, TOML or URDF (default: lists the included robots that fit)."""

    def __call__(self) -> bool:
        if not self.data:
            raise InputError("give a log: dynident check LOG")
        setup = self.setup() if self.robot else None
        looks: list[Look] = []
        for path in logs.grouped(self.data):
            fits, chosen = None, setup
            if chosen is None:  # the robot that fits it best
                fits = robot_fits(path, self.how())
                self.show(sections.fits_report(fits))
                if fits.fault:
                    looks.append((None, fits))
                    continue
                chosen = replace(self, robot=fits.fitting[0].robot).setup()
            robot = chosen.robot
            # Without gains its torques stay currents.
            currents = chosen.gains is None and logs.named(path, robot, chosen.log_map).holds_currents_only
            gains = (1.0,) * robot.n if currents else chosen.gains
            pieces = replace(chosen, gains=gains, told=set()).read([path])
            check = check_log(robot, longest(pieces), chosen.processing, currents)
            if len(pieces) > 1:
                text = f"Rows are missing: of {len(pieces)} pieces the longest is looked at; "
                text += "record without losing rows"
                check = check.completed([estimation.Finding("note", "recording", text)])
            self.show(sections.log_report(check))
            looks.append((check, fits))
        words, named = (setup.in_words(), setup.robot) if setup else ({}, None)
        told = replace(self, quiet=True)  # each look was shown when it was done
        told.give(sections.check_report(looks), lambda: check_document(named, looks), words)
        return all(check and check.usable for check, _ in looks)


_STILL = ("mount", "rate", "cutoff", "equation_rate", "offsets", "coulomb", "gain_sigma")  # gravity does not count


class _Verify(PageOptions, RecordingOptions, without=_STILL):
    before: Annotated[tuple[Annotated[str, Reads("before"), LOG], ...], SEVERAL]
    """Before the new number: one motion (or its files of one signal each), with columns qref1.. (commanded
    positions) or tauref1.. (torque predicted, N·m), or what --log-map names."""
    after: Annotated[tuple[Annotated[str, Reads("after"), LOG], ...], SEVERAL]
    """That motion again, with the new number."""

    def __call__(self) -> bool:
        setup = self.setup()
        given = [logs.grouped(paths) for paths in (self.before, self.after)]
        for several in given:
            if several[1:]:
                raise InputError(f"{', '.join(map(str, several))}: give one recording, or its files, one a signal")
        old, new = (read_following(own[0], setup.robot, setup.gains, setup.log_map) for own in given)
        change = following_change(old, new, setup.robot.processing.still_speed)
        self.give(sections.following_report(change, setup.robot), lambda: change, {})
        return not (change.tells and change.total.clear == "rose")


class _Compare(PageOptions, RecordingOptions, without=("report", "plots", "gain_sigma")):
    data: DataFiles = field(kw_only=False)
    """Recordings of one robot without payload."""

    def __call__(self) -> None:
        if len(paths := logs.grouped(self.data)) < 2:
            raise InputError("one recording: give two or more to compare")
        first = dict[str, str]()
        for path in self.data:
            if first.setdefault(checksum(path), path) != path or self.data.count(path) > 1:
                raise InputError(f"{path} is given twice: a recording counts once")
        setup = self.setup()
        with status("identifying") as progress:
            settings = self.settings(setup, silent, friction=setup.robot.drives.friction)
            estimates = [
                estimation.identify(setup.robot, setup.read([path]), settings).estimate
                for path in each(paths, "identifying {}".format, progress)
            ]
        names = [path if isinstance(path, str) else " and ".join(path) for path in paths]
        compared = side_by_side(names, [widened(own, excess(own, own.sigma_robust)) for own in estimates])
        self.give(sections.compared_report(compared), lambda: compared, {})


class _Reduce(PageOptions, RecordingOptions, without=("report", "plots")):
    data: Annotated[tuple[str, ...], LOG] = field(kw_only=False)
    """Logs without payload: files, folders, globs."""
    store: NewFolder
    """Folder of the reduced recordings."""
    pattern: Annotated[str, Parameter(metavar="PATH")] = ""
    """Ends of paths, such as '{arm}/{day}.csv', or with {payload} (reported, kg); * stands for anything else."""
    workers: Count = 1
    """Processes of this machine (default: 1, this one)."""
    cluster: Annotated[str | None, Parameter(metavar="ADDRESS")] = None
    """A Dask scheduler, tcp://host:8786, whose workers do it."""

    def __call__(self) -> bool:
        setup = self.setup()
        entries = catalog(found_logs(self.data), self.pattern)
        recipe = Recipe(setup.processing, setup.gains, self.settings(setup, silent).gains, setup.log_map)
        executor = dask_executor(self.cluster) if self.cluster else nullcontext(self.workers)
        with status("reducing") as progress, executor as able:
            reduced = reduce_fleet(entries, setup.robot, self.store, recipe, able, partial(progress, "reducing"))
        if lost := reduced.workers_lost:
            note(f"workers were lost {lost} times and replaced: nothing is lost, nothing counts twice")
        self.give(sections.reduced_report(reduced), lambda: reduced, {})
        return bool(reduced.new or reduced.known)


class _FleetReport(PageOptions):
    store: Annotated[str, Parameter(metavar="STORE")] = field(kw_only=False)
    """The folder given to 'dynident fleet reduce --store'."""

    def __call__(self) -> None:
        opened = Store.opened(self.store)
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
        self.give(sections.fleet_report(told), lambda: told, {"robot": told.arms[0]})
