"""The error stream: notes, what is being done and how much of it, internal errors; names of files are text."""

from __future__ import annotations

import shlex
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Literal

from ...common.errors import one_line
from ...common.progress import Progress
from ...common.versions import versions
from . import INTERNAL_ERROR

_TOLD = 200
"""Letters of a fault that are shown; the file has all."""
Manner = Literal["quiet", "plain", "verbose"]
_manner: ContextVar[Manner] = ContextVar("manner", default="plain")


@contextmanager
def speaking(manner: Manner, label: str) -> Iterator[None]:
    """A run that says nothing, what is worth knowing, or every step with its time and how long all of it took."""
    token, begin = _manner.set(manner), time.monotonic()
    try:
        yield
        if manner == "verbose":
            print(f"dynident: {time.monotonic() - begin:6.1f} s  {label}: done", file=sys.stderr)
    finally:
        _manner.reset(token)


def quiet() -> bool:
    """This run prints no screen: files and the exit status tell."""
    return _manner.get() == "quiet"


def note(text: str) -> None:
    """Print a line that is worth knowing."""
    if not quiet():
        print(f"dynident: note: {one_line(text)}", file=sys.stderr)


def withheld(done: str, why: str) -> bool:
    """Say that what was asked for is not done, and why, for its numbers must not be used; gives that."""
    print(one_line(f"dynident: not {done}: {why}"), file=sys.stderr)
    return False


@contextmanager
def status(label: str) -> Iterator[Progress]:
    """Show what is being done; gives a function that changes the words and tells the share, where it is known."""
    if (manner := _manner.get()) != "plain":
        begin, told = time.monotonic(), ""

        def step(words: str, _share: float | None = None, /) -> None:
            nonlocal told
            if manner == "verbose" and words != told:
                print(f"dynident: {time.monotonic() - begin:6.1f} s  {one_line(words)}", file=sys.stderr)
            told = words

        step(label)
        yield step
        return
    # A line that goes when the work is done; where no share is known its bar only moves. Names hold brackets.
    from rich import console as terminal
    from rich import progress as rich

    words = rich.TextColumn("{task.description}", markup=False)
    columns = (rich.SpinnerColumn(), words, rich.BarColumn(), rich.TaskProgressColumn(), rich.TimeRemainingColumn())
    console = terminal.Console(stderr=True)
    hidden = not console.is_terminal  # elsewhere it would leave an empty line
    with rich.Progress(*columns, console=console, transient=True, disable=hidden) as shown:
        task = shown.add_task(label, total=None)
        last: float | None = None

        def progress(words: str, share: float | None = None, /) -> None:
            nonlocal task, last
            if (share is None) != (last is None) or (share or 0.0) < (last or 0.0):  # other work: its own time left
                shown.remove_task(task)
                task = shown.add_task(words, total=None if share is None else 1.0)
            last = share
            shown.update(task, description=words, completed=share)

        yield progress


def report_fault(fault: Exception, words: Sequence[str]) -> int:
    """Say in a line that a command line met an internal error, with its details in a file; returns the status."""
    details = [f"dynident {shlex.join(words)}", *version_lines(), "", *traceback.format_exception(fault)]
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="dynident-fault-", suffix=".txt", delete=False, encoding="utf-8", errors="replace"
        ) as file:
            file.write("\n".join(details))
        where = f"with {file.name}"
    except OSError as error:
        where = f"(its details could not be written: {error.strerror})"
    message = one_line(f"{type(fault).__name__}: {fault}")
    print(f"dynident: internal error, please report {where}: {message[:_TOLD]}", file=sys.stderr)
    return INTERNAL_ERROR


def version_lines() -> list[str]:
    """Versions that a report of a fault should name."""
    return [f"{name.lower()} {number}" for name, number in versions().items()]
