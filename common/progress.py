"""How long work tells what it is doing, and how much of it is done."""

from collections.abc import Callable, Iterator, Sequence
from typing import Protocol, TypeVar

_Item = TypeVar("_Item")


class Progress(Protocol):
    """Called with a line about what is being worked on."""

    def __call__(self, words: str, share: float | None = None, /) -> None:
        """Tell it; ``share``: how much of this work is done, 0 to 1, or None where nobody knows."""


def silent(_words: str, _share: float | None = None, /) -> None:
    """Tell nothing."""


def each(items: Sequence[_Item], words: Callable[[_Item], str], progress: Progress) -> Iterator[_Item]:
    """Go through items and tell which is worked on and how many are done; of a single one no share is known."""
    for k, item in enumerate(items):
        progress(words(item), k / len(items) if len(items) > 1 else None)
        yield item
