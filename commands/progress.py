"""What is being done, on the error stream; names of files are text, never markup."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import Progress
from rich.text import Text


@contextmanager
def status(what: str) -> Iterator[Callable[[str], None]]:
    """Show what is being done; gives a function that changes the words."""
    with Console(stderr=True).status(Text(what)) as shown:
        yield lambda words: shown.update(Text(words))


@contextmanager
def bar(what: str) -> Iterator[Callable[[float], None]]:
    """Show how much of something is done; gives a function of the finished share."""
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(what, total=1.0)

        def show(part: float) -> None:
            progress.update(task, completed=part)

        yield show
