"""A fleet's recordings, each reduced to its passport, by whatever executor there is."""

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from ..common.errors import InputError
from ..common.files import checksum
from ..estimation.answers.identification import identify
from ..estimation.recordings.map import LogMap
from ..estimation.recordings.read import read_recordings
from ..model import Robot
from .answers import robot_passport
from .catalog import Entry, same_time
from .engine import Here, process_pool
from .files import packed, passport_bytes, unpacked
from .passport import Log, Recipe
from .store import Row, Store, key_of

_AHEAD = 3  # batches that wait for each worker
_TRIES = 2  # processes that a log may kill by itself
_KILLED = "KilledWorker"  # what Dask raises for a task that each worker died of
KILLS = "ends whatever process reads it, alone too: look at this log, and report it if it is a good one"
"""Why a log is refused that no worker survives."""


class Plan(NamedTuple):
    """What a worker needs beside a log, alike for all: ``content`` holds robot and recipe, see ``files.packed``."""

    content: bytes
    log_map: LogMap


class Task(NamedTuple):
    """One recording: its log, the log's checksum, and its passport's name."""

    entry: Entry
    sha256: str
    key: str


class Done(NamedTuple):
    """What became of one: its passport's bytes, or why there is none."""

    key: str
    content: bytes
    reason: str


@dataclass(frozen=True)
class Reduced:
    """What a run did.

    Attributes:
        store: where the passports are.
        new: recordings that were reduced now.
        known: that were in the store already.
        refused: logs without a passport, and why.
        crashes: how often workers were lost and replaced.
    """

    store: Store
    new: int
    known: int
    refused: Mapping[str, str]
    crashes: int = 0


def reduce_fleet(
    entries: Sequence[Entry | str],
    robot: Robot,
    store: str | Path,
    recipe: Recipe | None = None,
    log_map: LogMap | None = None,
    executor: Executor | None = None,
    workers: int = 1,
    batch: int = 1,
    progress: Callable[[float], None] = lambda _: None,
) -> Reduced:
    """Reduce recordings to passports in a store; what is there already is left as it is.

    Killed at any moment and started again it ends in the same store, byte for byte. Workers need this package and
    the logs; only this process writes.

    Args:
        entries: logs, with what is known of them or by their paths alone; see ``catalog``.
        robot: the type, with the structure that is asked for.
        store: folder of the passports.
        recipe: settings; the robot's own by default.
        log_map: how logs are read.
        executor: of ``concurrent.futures`` or of its form (Dask's ``client.get_executor()``); processes of this
            machine by default.
        workers: number of those processes, 1 for this one alone; or how many the executor has.
        batch: recordings a task.
        progress: told which share is done.

    Raises:
        InputError: if the store is another's or cannot be written, or the workers are lost; what is done stays.
    """
    recipe = recipe or Recipe("identify", robot.processing)
    plan, place = Plan(packed((robot, recipe)), log_map or LogMap()), Store.made(store, robot, recipe)
    before = {row.file: row for row in place.rows()}
    tasks, refused = _tasks(list(map(_entry, entries)), recipe, before)
    missing = [task for task in tasks if not place.path(task.key).exists()]
    results = _results(plan, [missing[k : k + batch] for k in range(0, len(missing), batch)], executor, workers)
    bad, crashes = _kept(results, place, len(missing), progress)
    refused |= {task.entry.path: bad[task.key] for task in missing if task.key in bad}
    good = {t.entry.path: Row(t.entry.path, t.sha256, t.entry.about, t.key) for t in tasks if t.key not in bad}
    earlier = {file: why for file, why in place.refused().items() if file not in before and file not in good}
    place.finish({file: row for file, row in before.items() if file not in refused} | good, earlier | refused)
    known = len(tasks) - len(missing)
    return Reduced(place, len(good) - known, known, refused, crashes)


def _results(
    plan: Plan, batches: Sequence[Sequence[Task]], executor: Executor | None, workers: int
) -> Iterator[Done | str]:
    """Results as they come, by an executor, by processes, or by this one alone."""
    if executor is None and workers > 1:
        return _by_processes(plan, batches, workers)
    return _by(executor or Here(), plan, batches, workers)


def _kept(
    results: Iterator[Done | str], place: Store, count: int, progress: Callable[[float], None]
) -> tuple[dict[str, str], int]:
    """Put what is done into the store; why there is no passport, by its name, and how often workers were lost.

    Raises:
        InputError: if the workers are lost for good.
    """
    bad, done, crashes = dict[str, str](), 0, 0
    try:
        for result in results:
            if isinstance(result, str):
                crashes += 1
                continue
            done += 1
            if result.reason:
                bad[result.key] = result.reason
            else:
                place.put(result.key, result.content)
            progress(done / count)
    except BrokenExecutor as error:
        raise InputError(
            f"the workers were lost after {done} of {count} recordings ({error}): run it again, what is done is "
            "kept"
        ) from None
    return bad, crashes


def _tasks(
    entries: Sequence[Entry], recipe: Recipe, before: Mapping[str, Row]
) -> tuple[list[Task], dict[str, str]]:
    """What is to be done, and what cannot be, and why; ``before``: what the store held."""
    again = {entry.path for entry in entries}
    earlier = [row for file, row in before.items() if file not in again]
    refused = _wrong([*(Entry(row.file, row.about) for row in earlier), *entries])
    tasks, seen = list[Task](), {row.sha256: row.file for row in earlier}
    for entry in sorted((one for one in entries if one.path not in refused), key=lambda entry: entry.path):
        try:
            digest = _digest(entry.path)
        except InputError as error:
            refused[entry.path] = str(error)
            continue
        if digest in seen:
            refused[entry.path] = f"holds the same bytes as {seen[digest]}: a recording counts once"
            continue
        seen[digest] = entry.path
        tasks.append(Task(entry, digest, key_of(digest, entry.about, recipe)))
    return tasks, refused


def _wrong(entries: Sequence[Entry]) -> dict[str, str]:
    """What is known to be wrong before anything is read."""
    return {entry.path: entry.wrong for entry in entries if entry.wrong} | same_time(entries)


def _entry(log: Entry | str) -> Entry:
    return log if isinstance(log, Entry) else Entry(log, {})


def _digest(path: str) -> str:
    try:
        with local(path) as file:
            return checksum(file)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}") from None


@contextmanager
def local(path: str) -> Iterator[str]:
    """A log as a file of this machine; one at a URL is copied for the time being.

    Raises:
        InputError: if it cannot be.
    """
    if "://" not in path:
        yield path
        return
    try:
        import fsspec
    except ModuleNotFoundError:
        raise InputError("logs at a URL need fsspec: pip install 'dynident[fleet]'") from None
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / PurePosixPath(path).name
        try:
            with fsspec.open(path, "rb") as stream:
                copy.write_bytes(stream.read())
        except (OSError, ValueError, ImportError) as error:
            raise InputError(f"cannot be read: {error}") from None
        yield str(copy)


def reduce_batch(plan: Plan, batch: Sequence[Task]) -> list[Done]:
    """What a worker does: each recording to the bytes of its passport, or why there is none."""
    robot, recipe = _unpacked(plan.content)
    return [_reduced(robot, recipe, plan.log_map, task) for task in batch]


@lru_cache(maxsize=4)
def _unpacked(content: bytes) -> tuple[Robot, Recipe]:
    """Robot and recipe, put together once a worker."""
    robot, recipe = unpacked(content)
    return robot, recipe


def _reduced(robot: Robot, recipe: Recipe, log_map: LogMap, task: Task) -> Done:
    entry = task.entry
    try:
        with local(entry.path) as path:
            if checksum(path) != task.sha256:
                return Done(task.key, b"", "changed while it was reduced: run it again")
            pieces = read_recordings(path, robot, recipe.drive_gains, log_map, recipe.processing)
            result = identify(robot, pieces, recipe.processing, essential=recipe.essential, gains=recipe.gains)
            log = Log("without payload", entry.path, task.sha256)
            return Done(task.key, passport_bytes(robot_passport(result, recipe, [log], entry.about)), "")
    except (InputError, OSError) as error:
        return Done(task.key, b"", " ".join(str(error).split()))
    except Exception as fault:  # one bad log stops nobody; it is named, and so is the fault
        return Done(task.key, b"", f"a fault of ours, please report it: {type(fault).__name__}: {fault}")


def _by(executor: Executor, plan: Plan, batches: Sequence[Sequence[Task]], workers: int) -> Iterator[Done | str]:
    """Results as they come, a few batches ahead of the workers.

    Where the engine says that a batch kills whatever worker does it, its recordings are tried one by one.
    """
    waiting, pending = iter(batches), dict[Future[list[Done]], Sequence[Task]]()

    def submit(batch: Sequence[Task]) -> None:
        pending[executor.submit(reduce_batch, plan, batch)] = batch

    for batch in islice(waiting, _AHEAD * workers):
        submit(batch)
    while pending:
        finished, _ = wait(pending, return_when=FIRST_COMPLETED)
        for future in sorted(finished, key=_failed):  # what is there is not lost with what failed
            batch = pending.pop(future)
            try:
                yield from future.result()
            except BrokenExecutor:
                raise
            except Exception as error:  # of the engine: a worker's own end in a reason
                if type(error).__name__ != _KILLED:
                    raise BrokenExecutor(f"{type(error).__name__}: {error}") from error
                yield "a task killed its workers"
                if len(batch) == 1:
                    yield Done(batch[0].key, b"", KILLS)
                else:
                    for task in batch:
                        submit([task])
            for following in islice(waiting, 1):
                submit(following)


def _failed(future: Future[list[Done]]) -> bool:
    return future.cancelled() or future.exception() is not None


def _by_processes(plan: Plan, batches: Sequence[Sequence[Task]], workers: int) -> Iterator[Done | str]:
    """Results by processes of this machine; lost ones are replaced, a log that kills each of them is refused."""
    left = {task.key: task for batch in batches for task in batch}
    while left:
        try:
            with process_pool(workers) as pool:
                for done in _by(pool, plan, [[task] for task in left.values()], workers):
                    assert isinstance(done, Done)
                    del left[done.key]
                    yield done
        except BrokenExecutor:
            yield f"a worker was lost with {len(left)} recordings to go: it is replaced"
            for task in list(left.values())[: 2 * workers]:  # they begin in this order
                done = _alone(plan, task)
                del left[task.key]
                yield done


def _alone(plan: Plan, task: Task) -> Done:
    """One recording by a process of its own, and by another where that is lost.

    Raises:
        BrokenExecutor: if such processes are lost without any recording.
    """
    for _ in range(_TRIES):
        with process_pool(1) as pool:
            pool.submit(_there).result()
            try:
                (done,) = pool.submit(reduce_batch, plan, [task]).result()
            except BrokenExecutor:
                continue
            return done
    return Done(task.key, b"", KILLS)


def _there() -> None:
    """What a process does that is there at all."""
