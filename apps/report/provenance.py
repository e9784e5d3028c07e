"""The origin of a report (command, files with checksums, date, versions), and the page that ends with it."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import NamedTuple

from ... import __version__
from ...common.errors import InputError
from .blocks import Block, Code, Notes, Page, Section, Table, Text, columns


class SourceFile(NamedTuple):
    """A file that was read: what for, its name and the SHA-256 checksum of its bytes."""

    role: str
    name: str
    sha256: str


@dataclass(frozen=True)
class Provenance:
    """Everything that is needed to repeat a result.

    Attributes:
        command: that made it, as typed.
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

    @property
    def foot(self) -> str:
        """The last line of a page."""
        return f"dynident {__version__}, {self.day}"


def now() -> datetime:
    """The time in UTC, or that of SOURCE_DATE_EPOCH, by which the same input gives the same file.

    Raises:
        InputError: if that variable is no number of seconds.
    """
    fixed = os.environ.get("SOURCE_DATE_EPOCH")
    if not fixed:
        return datetime.now(UTC)
    try:
        return datetime.fromtimestamp(int(fixed), UTC)
    except (ValueError, OverflowError, OSError):
        raise InputError(f"SOURCE_DATE_EPOCH {fixed!r} is not a time: give seconds since 1970") from None


def report_page(
    title: str,
    subtitle: str,
    lead: Sequence[Block],
    sections: Sequence[Section],
    notes: Sequence[str],
    provenance: Provenance,
) -> Page:
    """A page with what leads, sections, and what it was made from.

    Args:
        lead: the answer, before everything else.
        notes: on the data.
    """
    data: list[Block] = [Notes(notes)]
    if provenance.files:
        rows = [tuple(file) for file in provenance.files]
        data.append(Table("Files that were read", columns(("",), ("file", "SHA-256")), rows, style="plain"))
    for name, heading, words in (
        ("Settings", "value", provenance.settings),
        ("Versions", "version", provenance.versions),
    ):
        if words:
            data.append(Table(name, columns(("",), (heading,)), list(words.items()), style="plain"))
    data += [Text("Command that repeats it", "heading"), Code("command", provenance.command)]
    last = Section("data", "Data, settings and how to repeat it", data)
    return Page(title, subtitle, lead, [*sections, last], provenance.foot)
