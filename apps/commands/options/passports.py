"""The option of a passport, and what a command hands over for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from .... import estimation
from ....common.files import checksum
from ....common.schema import given, json_text
from ... import fleet
from .reading import Options, option
from .recordings import Setup

_LOGS = ("without payload", "with payload", "held out")


@dataclass(frozen=True)
class PassportOptions(Options):
    """The result with the equations it comes from."""

    GROUP: ClassVar[str] = "files"

    passport: str | None = option(
        writes="file",
        metavar="F",
        help="write the result's passport: its reduced equations, from which it is computed again without the logs",
    )

    def write(self, passport: Callable[[], fleet.Passport]) -> None:
        """Write the passport; it is made only if it was asked for."""
        if self.passport:
            fleet.write_passport(self.passport, passport())


def logs_of(options: Options) -> tuple[fleet.Log, ...]:
    """The logs that options name, with their checksums."""
    return tuple(fleet.Log(role, path, checksum(path)) for _, role, path in options.named("reads") if role in _LOGS)


def recipe_of(kind: fleet.passport.Kind, setup: Setup, gains: estimation.Gains | None, **more: Any) -> fleet.Recipe:
    """How a command makes its number; ``more``: what its own options say."""
    how = {key: entry for key, entry in given(setup.log_map).items() if key != "title"}
    sure = replace(gains, notes=()) if gains is not None else None  # notes speak of single recordings
    words = json_text(how).decode() if how else ""
    return fleet.Recipe(kind, setup.processing, setup.gains, sure, words, **more)
