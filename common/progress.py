"""Reports of progress: a line of text, and the fraction of the work that is done."""

from collections.abc import Callable, Iterator, Sequence
from typing import Protocol, TypeVar

_Item = TypeVar("_Item")


class Progress(Protocol):
    """Function that is called with a line about what is being worked on."""

    def __call__(self, text: str, fraction: float | None = None, /) -> None:
        """Report it; ``fraction``: part of this work that is done, 0 to 1, or None where nobody knows."""


def silent(_text: str, _fraction: float | None = None, /) -> None:
    """Report nothing."""


def each(items: Sequence[_Item], text: Callable[[_Item], str], progress: Progress) -> Iterator[_Item]:
    """Go through items and report which is worked on and how many are done; of a single one no fraction."""
    for k, item in enumerate(items):
        progress(text(item), k / len(items) if len(items) > 1 else None)
        yield item
