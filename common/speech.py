"""Results that show themselves in a line, on a screen, on a page, in files.

A result holds values alone and knows nothing of words, pages and formats. Who speaks for it stands in a room above
its own, which the package names: no result imports it.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar


class Speaks:
    """Base class of the results of whole questions.

    ``str`` gives the screen that the command prints, ``repr`` one line, a notebook the first block of the report.

    Attributes:
        shown_by: gives the module that shows results; the package sets it.
    """

    __slots__ = ()
    shown_by: ClassVar[Callable[[], Any]]

    @property
    def headline(self) -> str:
        """State the result in a line; that of its ``result``, where it is one with its working."""
        answer: Any = self
        return str(answer.result.headline)

    def __repr__(self) -> str:
        """State the result in a line, whatever it holds."""
        return f"<{type(self).__name__}: {self.headline}>"

    def __str__(self) -> str:
        """Show the screen that the command prints."""
        return self.summary()

    def _repr_html_(self) -> str:
        """Show the first block of the report, for notebooks."""
        return str(Speaks.shown_by().first_block(self))

    def summary(self, details: bool = False) -> str:
        """Show the screen that the command prints, 80 columns wide; with ``details`` all of it."""
        return str(Speaks.shown_by().summary(self, details))

    def to_dict(self) -> dict[str, Any]:
        """Convert to the plain values that the command's ``--json`` writes; nan and inf become None."""
        return dict(Speaks.shown_by().plain(self))

    def to_frame(self) -> Any:
        """Convert the first screen's table to a pandas DataFrame, numbers as numbers.

        Raises:
            ImportError: without pandas.
        """
        return Speaks.shown_by().frame(self)

    def report(self, path: str | Path) -> None:
        """Write the report, one self-contained HTML file."""
        Speaks.shown_by().write_report(self, path)

    def plot(self, name: str | None = None) -> Any:
        """Draw a figure of the report with Matplotlib; the first one unless it is named.

        Raises:
            InputError: if there is no such figure; names those there are.
        """
        return Speaks.shown_by().figure(self, name)
