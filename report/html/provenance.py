"""What a report was made from: command, files with checksums, date, versions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from typing import NamedTuple

from ... import __version__
from .markup import Html, joined, paragraph, table, tag


class SourceFile(NamedTuple):
    """A file that was read: what for, its name and the SHA-256 checksum of its bytes."""

    role: str
    name: str
    sha256: str


@dataclass(frozen=True)
class Provenance:
    """What is needed to repeat a result.

    Attributes:
        command: that made it, as typed.
        date: when.
        files: that were read.
        versions: of the packages that decide the numbers.
        settings: of processing, in words.
    """

    command: str
    date: datetime
    files: tuple[SourceFile, ...] = ()
    versions: Mapping[str, str] = field(default_factory=dict)
    settings: Mapping[str, str] = field(default_factory=dict)

    @property
    def day(self) -> str:
        """Date and time, to the minute."""
        return self.date.strftime("%Y-%m-%d %H:%M UTC")


def files_table(provenance: Provenance) -> Html:
    """Names and whole checksums of the files that were read; nothing without any."""
    if not provenance.files:
        return Html()
    rows = [(one.role, one.name, one.sha256) for one in provenance.files]
    return table("Files that were read", ("", "file", "SHA-256"), rows, class_="scroll plain")


def provenance_content(provenance: Provenance) -> Html:
    """Settings, versions and the command, for the last section."""
    parts = []
    if provenance.settings:
        rows = list(provenance.settings.items())
        parts.append(table("Settings", ("", "value"), rows, class_="scroll plain"))
    if provenance.versions:
        parts.append(table("Versions", ("", "version"), list(provenance.versions.items()), class_="scroll plain"))
    command = copyable("command", provenance.command)
    return joined(*parts, tag("h3", "Command that repeats it"), command)


def copyable(name: str, text: str) -> Html:
    """Text in a block with a button that copies it; ``name``: its identifier."""
    button = tag("button", "Copy", type="button", data_copy=name, hidden="hidden")
    return tag("div", button, tag("pre", tag("code", text, id=name), tabindex="0"), class_="block")


def foot(provenance: Provenance) -> Html:
    """The last line of a page."""
    return paragraph(f"dynident {__version__}, {provenance.day}")
