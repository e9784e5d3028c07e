"""Recordings of a fleet: logs, the store of their equations, and processes that reduce logs to equations."""

import hashlib
import multiprocessing
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from msgspec.structs import replace

from ...common.errors import InputError, encodable
from ...common.files import checksum, made_folder, write_bytes
from ...common.schema import Document, convert, naming, read_json, write_json
from ...estimation import Equations, Estimate, Gains, Settings, identify
from ...model import BaseParameters, Processing, Robot
from ..extras import extra, parquet_bytes, parquet_rows
from ..logs.map import LogMap
from ..logs.read import SUFFIXES, read_recordings

_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
KNOWN = ("arm", "day", "payload")
"""Facts that may be known of a log: the arm's own name, ISO day or time, and kg that the controller was told."""
_AGAIN = "run 'dynident fleet reduce' again, what is done is kept"
_REMEDY = f"delete it and {_AGAIN}"
_INDEX = "logs.parquet"  # table of the logs of a store, of those that were refused too
_AHEAD = 3  # logs that wait for each worker
_CLOCKS = (9.0e8, 4.1e9)  # s since 1970: 1998 to 2099
_NIGHT = timedelta(days=2)
"""Time that a log's clock may be beside the day told: a day without time, zones, a night's two days."""
KILLS = "ends whatever process reads it, alone too: look at this log, and report it if it is a good one"
"""Why a log is refused that no worker survives."""


class Log(Document, frozen=True, omit_defaults=True):
    """A log and what is known of it; ``reason``: why it is refused, if it is.

    ``sha256`` of its bytes and ``key``, the name of its equations in a store, once they are known.
    """

    file: str
    arm: str | None = None
    day: str | None = None
    payload: str | None = None
    reason: str = ""
    sha256: str = ""
    key: str = ""


def found_logs(paths: Sequence[str]) -> tuple[str, ...]:
    """Find logs by names, globs and folders, none of them in vain: each log once, in the order of their names."""
    logs = set[str]()
    for path in paths:
        place, anchor = Path(path), Path(path).anchor
        inside = [place] if place.exists() else Path(anchor).glob(str(place.relative_to(anchor)))
        if place.is_dir():
            inside = (file for file in place.rglob("*") if file.name.endswith(SUFFIXES))
        found = {str(file) for file in inside if file == place or file.is_file()}
        logs |= found
        if not found:
            raise InputError(f"{path}: no log there")
    return tuple(sorted(logs))


def catalog(logs: Sequence[str], pattern: str = "") -> tuple[Log, ...]:
    """Tell by each log's path what is known of it; a pattern that no path has is refused.

    ``pattern`` is the end of a path, "{arm}/{day}.csv": words of ``KNOWN`` in braces, ``*`` for anything else.
    """
    if not pattern:
        return tuple(map(Log, logs))
    if unknown := [word for word in re.findall(r"\{(\w+)\}", pattern) if word not in KNOWN]:
        raise InputError(f"--pattern {pattern!r}: {{{unknown[0]}}} is not known; known: {', '.join(KNOWN)}")
    form = re.sub(r"\\\{(\w+)\\\}", r"(?P<\1>[^/]+?)", re.escape(pattern).replace(r"\*", "[^/]*"))
    try:
        ending = re.compile(f"(?:^|/){form}$")
    except re.error as error:
        raise InputError(f"--pattern {pattern!r}: {error}") from None
    found = []
    for path in logs:
        match = ending.search(Path(path).as_posix())
        log = Log(path, **(match.groupdict() if match else {}))
        wrong = f"day {log.day!r} is no date: write 2026-01-31 or 2026-01-31T02:00"
        with suppress(ValueError):
            year = datetime.fromisoformat(log.day or "2000-01-01").year
            wrong = f"payload {log.payload!r} is no number"
            float(log.payload or 0.0)
            wrong = "no arm is named" if log.arm == "" else ""
            if not 1970 <= year <= 2100:
                wrong = f"day {log.day!r} is of no recording: years 1970 to 2100 are"
        wrong = wrong if match else f"its path does not end in {pattern}"
        found.append(replace(log, reason=wrong))
    if all(log.reason for log in found):
        raise InputError(f"--pattern {pattern!r}: no log's path ends so; {logs[0]}: {found[0].reason}")
    return tuple(found)


@dataclass(frozen=True)
class Recipe:
    """Settings that make equations of logs."""

    processing: Processing
    drive_gains: tuple[float, ...] | None = None  # [N·m/A or N/A], if currents were read
    gains: Gains | None = None  # unless these are taken as exact
    log_map: LogMap = LogMap()

    @property
    def fingerprint(self) -> str:
        """Short text that differs between recipes; what a log map is called counts for nothing."""
        return hashlib.sha256(packed(vars(self) | {"log_map": replace(self.log_map, source="")})).hexdigest()[:16]

    def key(self, log: Log) -> str:
        """Name of a recording's file: by the log's bytes, what is known of it, and the recipe."""
        identity = packed([log.sha256, log.arm, log.day, log.payload, self.fingerprint])
        return hashlib.sha256(identity).hexdigest()[:32]


@dataclass(frozen=True)
class Stored:
    """A recording of a store: its log, and equations in the robot's base parameters, in blocks of time."""

    log: Log
    robot: Robot
    base: BaseParameters
    equations: Equations

    def parquet(self, estimate: Estimate) -> bytes:
        """A table of one row: the log, the parameters identified by it alone, and the equations, packed."""
        row = {fact: getattr(self.log, fact) for fact in ("file", *KNOWN)} | {"equations": packed(self)}
        row |= {"parameters": estimate.names, "values": estimate.values, "sigma": estimate.sigma}
        return parquet_bytes({name: [value] for name, value in row.items()})


def packed(value: Any) -> bytes:
    """Frozen values as bytes; the same for the same values."""
    return msgspec.msgpack.encode(value, enc_hook=_plain)


def _plain(value: Any) -> Any:
    """An array as its shape, its order in memory, which sums round by, and its bytes; a mapping as a plain one."""
    if isinstance(value, np.ndarray):
        turned = value.flags.f_contiguous and not value.flags.c_contiguous
        return [value.shape, "F" if turned else "C", np.asarray(value, "<f8").tobytes("F" if turned else "C")]
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"{type(value).__name__} has no place in a store")


def _made(kind: Any, value: Any) -> Any:
    shape, order, content = value
    return np.frombuffer(content, "<f8").reshape(shape, order=order)


@dataclass(frozen=True)
class Store:
    """A folder of reduced recordings of one type of robot, made by one recipe; each file is written in one step."""

    root: Path

    @staticmethod
    def made(root: str | Path, robot: Robot, recipe: Recipe) -> "Store":
        """Open the store at a place, made if there is none; one of another robot or recipe is refused."""
        labels = {"robot": robot.name, "fingerprint": robot.fingerprint, "recipe": recipe.fingerprint}
        store, path = Store(Path(root)), Path(root) / "store.json"
        if path.exists():
            there = read_json(path, dict[str, str], "give another folder")
            if there != labels:
                kind = "recipe" if there.get("fingerprint") == labels["fingerprint"] else "robot"
                raise InputError(f"{root}: a store of another {kind} ({there.get('robot')}): give another folder")
        elif store.root.is_dir() and any(store.root.iterdir()):
            raise InputError(f"{root}: is a folder of other things: give a new one")
        made_folder(store.root / "recordings")
        if not path.exists():
            write_json(path, labels)
        return store

    @staticmethod
    def opened(root: str | Path) -> "Store":
        """Open a store that is there and was finished once."""
        store = Store(Path(root))
        if not (store.root / "store.json").exists():
            raise InputError(f"{root}: no store: give the --store of 'dynident fleet reduce'")
        if not (store.root / _INDEX).exists():
            raise InputError(f"{root}: reduced in part: {_AGAIN}")
        return store

    def path(self, key: str) -> Path:
        """Place of a recording's equations."""
        return self.root / "recordings" / f"{key}.parquet"

    def logs(self) -> tuple[Log, ...]:
        """The logs, by name, with a ``reason`` where refused; none as long as the store was never finished."""
        index = self.root / _INDEX
        if not index.exists():
            return ()
        with naming(index, _REMEDY):
            return convert(parquet_rows(index, _REMEDY), tuple[Log, ...])

    def finish(self, logs: Iterable[Log]) -> None:
        """Write what is in it, and what was refused, and why."""
        ordered = sorted(logs, key=lambda log: log.file)
        columns = {name: [getattr(log, name) for log in ordered] for name in Log.__struct_fields__}
        write_bytes(self.root / _INDEX, parquet_bytes(columns))

    def read(self, key: str) -> Stored:
        """Read a recording's equations."""
        path = self.path(key)
        rows = parquet_rows(path, _REMEDY, ["equations"])
        try:
            return msgspec.msgpack.decode(rows[0]["equations"], type=Stored, dec_hook=_made)
        except (LookupError, ValueError, TypeError) as error:
            fault = f"not as it was written, or by another version ({error})"
            raise InputError(f"{path}: {fault}: reduce it again") from None


_Done = tuple[Log, bytes]  # the bytes of its equations, or none and in the log why
_Reduce = Callable[[Log], _Done]


class ReducedDocument(Document, frozen=True):
    """Result of ``fleet reduce``: recordings reduced now, those that were there, and what was refused."""

    store: str
    new: int
    known: int
    refused: tuple[Log, ...]
    workers_lost: int


def reduce_fleet(
    logs: Sequence[Log | str],
    robot: Robot,
    store: str | Path,
    recipe: Recipe | None = None,
    workers: "int | tuple[Executor, int]" = 1,
    progress: Callable[[float], None] = lambda _: None,
) -> ReducedDocument:
    """Reduce recordings to equations in a store's folder; those that are there already stay as they are.

    Killed at any moment and started again it ends in the same store, byte for byte. Workers need this package and
    the logs; only this process writes.

    Args:
        logs: with what is known of them or by their paths alone; see ``catalog``.
        robot: the type, with the structure that is asked for.
        recipe: settings; the robot's own by default.
        workers: number of processes of this machine, 1 for this one alone; or an executor of ``concurrent.futures``
            or of its form (Dask's ``client.get_executor()``), and how many workers it has.
        progress: told which share is done.

    Raises:
        InputError: if the store is another's or cannot be written, or the workers are lost; what is done stays.
    """
    recipe = recipe or Recipe(robot.processing)
    target, reduced = Store.made(store, robot, recipe), partial(reduce_log, robot, recipe)
    before = {log.file: log for log in target.logs()}
    given = [log if isinstance(log, Log) else Log(log) for log in logs]
    for k, log in enumerate(given):  # a store can hold no other path
        if (name := encodable(log.file)) != log.file:
            given[k] = Log(name, reason="its path is not UTF-8: rename the file or folder")
    now, files = dict[str, Log](), {log.file for log in given}
    # A recording counts once, and an arm has one at a time.
    earlier = [log for log in before.values() if not log.reason and log.file not in files]
    first_files = {log.sha256: log.file for log in earlier}
    nights = {(log.arm, log.day): log.file for log in earlier}
    for log in sorted(given, key=lambda log: log.file):
        name, wrong, digest, night = log.file, log.reason, "", (log.arm, log.day)
        if not wrong and None not in night and (owner := nights.setdefault(night, name)) != name:
            wrong = f"{owner} is of arm {log.arm!r} at {log.day} too: give times, or another name"
        try:
            if not wrong and (first := first_files.setdefault(digest := checksum(name), name)) != name:
                wrong = f"holds the same bytes as {first}: a recording counts once"
        except (InputError, OSError) as error:
            wrong = getattr(error, "strerror", None) or str(error)
        known = replace(log, reason=wrong, sha256=digest)
        now[name] = known if wrong else replace(known, key=recipe.key(known))
    missing = [log for log in now.values() if not log.reason and not target.path(log.key).exists()]
    results: Iterator[_Done | None] = map(reduced, missing)
    if isinstance(workers, tuple):
        results = _by(workers[0], reduced, missing, workers[1])
    elif workers > 1:
        results = _by_processes(reduced, missing, workers)
    done = lost = 0
    try:
        for result in results:
            if result is None:
                lost += 1
                continue
            log, content = result
            now[log.file] = log
            if not log.reason:
                write_bytes(target.path(log.key), content)
            done += 1
            progress(done / len(missing))
    except BrokenExecutor as error:
        lost_after = f"the workers were lost after {done} of {len(missing)} recordings ({error})"
        raise InputError(f"{lost_after}: run it again, what is done is kept") from None
    target.finish((before | now).values())
    refused = tuple(log for log in now.values() if log.reason)
    new = sum(not now[log.file].reason for log in missing)
    return ReducedDocument(str(target.root), new, len(now) - len(refused) - new, refused, lost)


def reduce_log(robot: Robot, recipe: Recipe, log: Log) -> _Done:
    """Reduce a recording to the bytes of its equations, or tell why there is none; workers do this."""
    try:
        if checksum(log.file) != log.sha256:
            raise InputError("changed while it was reduced: run it again")
        pieces = read_recordings(log.file, robot, recipe.drive_gains, recipe.log_map, recipe.processing)
        # Only times since 1970 tell a day: those from a log's own start, or by a clock that was never set, do not.
        if log.day is not None and _CLOCKS[0] <= pieces[0].origin <= _CLOCKS[1]:
            stated, own = datetime.fromisoformat(log.day), datetime.fromtimestamp(pieces[0].origin, UTC)
            if abs(stated.replace(tzinfo=stated.tzinfo or UTC) - own) >= _NIGHT:
                fault = f"its clock starts on {own:%Y-%m-%d} but it is said to be of {log.day}"
                raise InputError(f"{fault}: correct the path, or the log's times (from 0 on, they state no day)")
        # Nights are compared parameter by parameter: the terms of friction are the same in all.
        settings = Settings(recipe.processing, friction=robot.drives.friction, gains=recipe.gains)
        result = identify(robot, pieces, settings)
        return log, Stored(log, robot, result.base, result.problem).parquet(result.estimate)
    except (InputError, OSError) as error:
        return replace(log, reason=" ".join(str(error).split())), b""
    except Exception as fault:  # one bad log stops nobody; it is named, and so is the fault
        return replace(log, reason=f"a fault of ours, please report it: {type(fault).__name__}: {fault}"), b""


def _by(executor: Executor, reduced: _Reduce, logs: Iterable[Log], workers: int) -> Iterator[_Done | None]:
    """Results as they come, a few logs ahead of the workers; None where workers were lost."""
    waiting, pending = iter(logs), dict[Future[_Done], Log]()
    free = _AHEAD * workers
    while True:
        pending |= {executor.submit(reduced, log): log for log in islice(waiting, free)}
        if not pending:
            return
        finished, _ = wait(pending, return_when=FIRST_COMPLETED)
        free = len(finished)
        # What is there is not lost with what failed.
        for future in sorted(finished, key=lambda one: one.cancelled() or one.exception() is not None):
            log = pending.pop(future)
            try:
                yield future.result()
            except BrokenExecutor:
                raise
            except Exception as error:
                # Dask's, for a task that each worker died of; told by its name, for Dask is an extra.
                if type(error).__name__ != "KilledWorker":
                    raise BrokenExecutor(f"{type(error).__name__}: {error}") from error
                yield None
                yield replace(log, reason=KILLS), b""


def _by_processes(reduced: _Reduce, logs: Sequence[Log], workers: int) -> Iterator[_Done | None]:
    """Results by processes of this machine; lost ones are replaced, a log that kills one by itself is refused."""
    left = {log.key: log for log in logs}
    while left:
        try:
            with process_pool(workers) as pool:
                for done in _by(pool, reduced, list(left.values()), workers):
                    assert done is not None
                    del left[done[0].key]
                    yield done
        except BrokenExecutor:
            yield None
            for log in list(left.values())[: 2 * workers]:  # they begin in this order
                with process_pool(1) as alone:
                    alone.submit(int).result()  # whether a process can be there at all
                    try:
                        yield alone.submit(reduced, log).result()
                    except BrokenExecutor:
                        yield replace(log, reason=KILLS), b""
                del left[log.key]


@contextmanager
def process_pool(workers: int) -> Iterator[Executor]:
    """Processes with one thread of linear algebra each; what waits is dropped when the block is left."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"))
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)
        for name, value in before.items():
            os.environ.pop(name) if value is None else os.environ.update({name: value})


@contextmanager
def dask_executor(address: str) -> Iterator[tuple[Executor, int]]:
    """Workers of a running Dask scheduler, "tcp://host:8786", and their number; refused where there are none."""
    distributed = extra("distributed", "--cluster needs Dask: pip install 'dynident[fleet]'")
    try:
        client = distributed.Client(address, timeout=10, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise InputError(f"no scheduler answers at {address}: {error}") from None
    with client:
        if not (workers := client.scheduler_info(n_workers=-1)["workers"]):
            raise InputError(f"the scheduler at {address} has no workers: start 'dask worker {address}'")
        yield client.get_executor(pure=False), len(workers)
