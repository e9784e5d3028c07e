"""Results that show themselves: in a line, as a screen, as a page, as files.

An answer holds values alone and knows nothing of words, pages and formats. Those stand in the room ``report``, that
imports the answers; the methods here fetch it when they are called, so that no answer imports it.
"""

from importlib import import_module
from pathlib import Path
from typing import Any

_VOICE = "dynident.apps.report.speech"


class Speaks:
    """Base class of the results of whole questions.

    ``str`` gives the screen that the command prints, ``repr`` one line, a notebook the first block of the report.
    """

    __slots__ = ()

    @property
    def headline(self) -> str:
        """The result in a line."""
        raise NotImplementedError

    def __repr__(self) -> str:
        """One line, whatever the result holds."""
        return f"<{type(self).__name__}: {self.headline}>"

    def __str__(self) -> str:
        """The screen that the command prints."""
        return self.summary()

    def _repr_html_(self) -> str:
        """The first block of the report, for notebooks."""
        return str(voice().first_block(self))

    def summary(self, details: bool = False) -> str:
        """The screen that the command prints, 80 columns wide; with ``details`` all of it."""
        return str(voice().summary(self, details))

    def to_dict(self) -> dict[str, Any]:
        """What the command's ``--json`` writes, as plain values; nan and inf become None."""
        document: dict[str, Any] = voice().plain(self)
        return document

    def to_frame(self) -> Any:
        """The first screen's table as a pandas DataFrame, numbers as numbers.

        Raises:
            ImportError: without pandas.
        """
        return voice().frame(self)

    def report(self, path: str | Path) -> None:
        """Write the report, one self-contained HTML file.

        Raises:
            InputError: if it cannot be written.
        """
        voice().write_report(self, path)

    def plot(self, name: str | None = None) -> Any:
        """A figure of the report as Matplotlib's; the first one unless it is named.

        Raises:
            InputError: if there is no such figure; names those there are.
        """
        return voice().figure(self, name)


def voice() -> Any:
    """The module of the report that speaks for the answers."""
    return import_module(_VOICE)
