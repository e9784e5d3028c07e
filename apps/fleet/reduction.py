"""A fleet's recordings, each reduced to its equations, by whatever executor there is."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Executor
from dataclasses import dataclass
from pathlib import Path

from ...common.errors import InputError
from ...common.files import checksum
from ...model import Robot
from ..logs.map import LogMap
from .catalog import Entry, same_time
from .results import results_of
from .store import Row, Store, key_of
from .stored import Recipe, packed
from .worker import Done, Plan, Task, local


@dataclass(frozen=True)
class Reduced:
    """What a run did.

    Attributes:
        store: where the equations are.
        new: recordings that were reduced now.
        known: that were in the store already.
        refused: logs that are not in the store, and why.
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
    """Reduce recordings to equations in a store; what is there already is left as it is.

    Killed at any moment and started again it ends in the same store, byte for byte. Workers need this package and
    the logs; only this process writes.

    Args:
        entries: logs, with what is known of them or by their paths alone; see ``catalog``.
        robot: the type, with the structure that is asked for.
        store: its folder.
        recipe: settings; the robot's own by default.
        executor: of ``concurrent.futures`` or of its form (Dask's ``client.get_executor()``); processes of this
            machine by default.
        workers: number of those processes, 1 for this one alone; or how many the executor has.
        batch: recordings a task.
        progress: told which share is done.

    Raises:
        InputError: if the store is another's or cannot be written, or the workers are lost; what is done stays.
    """
    recipe = recipe or Recipe(robot.processing)
    plan, place = Plan(packed((robot, recipe)), log_map or LogMap()), Store.made(store, robot, recipe)
    before = {row.file: row for row in place.rows()}
    tasks, refused = _tasks(list(map(_entry, entries)), recipe, before)
    missing = [task for task in tasks if not place.path(task.key).exists()]
    results = results_of(plan, [missing[k : k + batch] for k in range(0, len(missing), batch)], executor, workers)
    bad, crashes = _kept(results, place, len(missing), progress)
    refused |= {task.entry.path: bad[task.key] for task in missing if task.key in bad}
    good = [task for task in tasks if task.key not in bad]
    _list_anew(place, good, before, refused)
    known = len(tasks) - len(missing)
    return Reduced(place, len(good) - known, known, refused, crashes)


def _list_anew(place: Store, good: Sequence[Task], before: Mapping[str, Row], refused: Mapping[str, str]) -> None:
    """Write the store's lists: what this run reduced and refused, and of earlier runs what it does not replace."""
    rows = {task.entry.path: Row(task.entry.path, task.sha256, task.entry.about, task.key) for task in good}
    earlier = {file: why for file, why in place.refused().items() if file not in before and file not in rows}
    place.finish({file: row for file, row in before.items() if file not in refused} | rows, {**earlier, **refused})


def _kept(
    results: Iterator[Done | str], place: Store, count: int, progress: Callable[[float], None]
) -> tuple[dict[str, str], int]:
    """Put what is done into the store; why there is none, by its name, and how often workers were lost.

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
    tasks, first_files = list[Task](), {row.sha256: row.file for row in earlier}
    for entry in sorted(
        (candidate for candidate in entries if candidate.path not in refused), key=lambda entry: entry.path
    ):
        try:
            digest = _digest(entry.path)
        except InputError as error:
            refused[entry.path] = str(error)
            continue
        if digest in first_files:
            refused[entry.path] = f"holds the same bytes as {first_files[digest]}: a recording counts once"
            continue
        first_files[digest] = entry.path
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
