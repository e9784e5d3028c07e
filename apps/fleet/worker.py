"""What a worker does: a recording to the bytes of its equations, or why there is none."""

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from ...common.errors import InputError
from ...common.files import checksum
from ...estimation.answers.identification import identify
from ...model import Robot
from ..logs.map import LogMap
from ..logs.read import read_recordings
from .catalog import Entry, other_day
from .stored import Recipe, Stored, packed, unpacked


class Plan(NamedTuple):
    """What a worker needs beside a log, alike for all: ``content`` is ``stored.packed`` robot and recipe."""

    content: bytes
    log_map: LogMap


class Task(NamedTuple):
    """One recording: its log, the log's checksum, and its name in the store."""

    entry: Entry
    sha256: str
    key: str


class Done(NamedTuple):
    """What became of one: its equations' bytes, or why there is none."""

    key: str
    content: bytes
    reason: str


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
    """What a worker does: each recording to the bytes of its equations, or why there is none."""
    robot, recipe = _unpacked(plan.content)
    return [_reduced(robot, recipe, plan.log_map, task) for task in batch]


@lru_cache(maxsize=4)
def _unpacked(content: bytes) -> tuple[Robot, Recipe]:
    """Robot and recipe, put together once a worker."""
    return unpacked(content, tuple[Robot, Recipe])


def _reduced(robot: Robot, recipe: Recipe, log_map: LogMap, task: Task) -> Done:
    entry = task.entry
    try:
        with local(entry.path) as path:
            if checksum(path) != task.sha256:
                return Done(task.key, b"", "changed while it was reduced: run it again")
            pieces = read_recordings(path, robot, recipe.drive_gains, log_map, recipe.processing)
            if wrong := other_day(entry.about, pieces[0].origin):
                return Done(task.key, b"", wrong)
            result = identify(robot, pieces, recipe.processing, gains=recipe.gains)
            stored = Stored.of(entry.path, robot, result.base, result.problem, entry.about)
            return Done(task.key, packed(stored), "")
    except (InputError, OSError) as error:
        return Done(task.key, b"", " ".join(str(error).split()))
    except Exception as fault:  # one bad log stops nobody; it is named, and so is the fault
        return Done(task.key, b"", f"a fault of ours, please report it: {type(fault).__name__}: {fault}")
