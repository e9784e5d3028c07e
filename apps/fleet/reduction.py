"""A fleet's recordings, each reduced to its equations by processes or by whatever executor there is."""

import multiprocessing
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from functools import partial
from itertools import islice
from pathlib import Path

from msgspec.structs import replace

from ...common.errors import InputError, encodable
from ...common.files import checksum, write_bytes
from ...common.schema import Document
from ...estimation import Settings, identify
from ...model import Robot
from ..extras import extra
from ..logs.read import read_recordings
from .store import Log, Recipe, Store, Stored

_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
_AHEAD = 3  # logs that wait for each worker
_CLOCKS = (9.0e8, 4.1e9)  # s since 1970: 1998 to 2099
_NIGHT = timedelta(days=2)
"""Time that a log's clock may be beside the day told: a day without time, zones, a night's two days."""
KILLS = "ends whatever process reads it, alone too: look at this log, and report it if it is a good one"
"""Why a log is refused that no worker survives."""

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
            return replace(log, reason="changed while it was reduced: run it again"), b""
        pieces = read_recordings(log.file, robot, recipe.drive_gains, recipe.log_map, recipe.processing)
        # Only times since 1970 tell a day: those from a log's own start, or by a clock that was never set, do not.
        if log.day is not None and _CLOCKS[0] <= pieces[0].origin <= _CLOCKS[1]:
            stated, own = datetime.fromisoformat(log.day), datetime.fromtimestamp(pieces[0].origin, UTC)
            if abs(stated.replace(tzinfo=stated.tzinfo or UTC) - own) >= _NIGHT:
                fault = f"its clock starts on {own:%Y-%m-%d} but it is said to be of {log.day}"
                advice = "correct the path, or the log's times (from 0 on, they state no day)"
                return replace(log, reason=f"{fault}: {advice}"), b""
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
        for log in islice(waiting, free):
            pending[executor.submit(reduced, log)] = log
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
