"""The origin of a report: command, files with checksums, date, versions."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import NamedTuple

from ...common.errors import InputError
from .blocks import Table


class SourceFile(NamedTuple):
    """A file that was read: its role, its name and the SHA-256 checksum of its bytes."""

    role: str
    name: str
    sha256: str


@dataclass(frozen=True)
class Provenance:
    """Command as typed, files that were read, versions of packages and settings: all that repeats a result."""

    command: str
    date: datetime
    files: tuple[SourceFile, ...] = ()
    versions: Mapping[str, str] = field(default_factory=dict)
    settings: Mapping[str, str] = field(default_factory=dict)

    @property
    def tables(self) -> list[Table]:
        """Files, settings and versions, as far as there are any."""
        parts = (
            ("Files that were read", ("file", "SHA-256"), self.files),
            ("Settings", ("value",), list(self.settings.items())),
            ("Versions", ("version",), list(self.versions.items())),
        )
        return [Table(title, ("", *headings), rows) for title, headings, rows in parts if rows]


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
