"""``dynident passport``: what a passport holds, several merged, several compared."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from .. import fleet, report
from . import ANSWERED, COMMANDS, answered
from .options import Options, ResultOptions, add_command, option


@dataclass(frozen=True)
class _One(Options):
    """A passport."""

    file: str = option("file", reads="passport", metavar="F", help="what --passport or 'fleet reduce' wrote")


@dataclass(frozen=True)
class _Several(Options):
    """Passports of one robot, made by one recipe."""

    files: tuple[str, ...] = option(
        "files", reads="passport", nargs="+", metavar="F", help="passports of one robot, made by one recipe"
    )

    def read(self) -> list[fleet.Passport]:
        """Read them, every byte checked."""
        return [fleet.read_passport(path) for path in self.files]


@dataclass(frozen=True)
class _Merged(Options):
    """Where the merged passport goes."""

    out: str = option(writes="file", required=True, metavar="F", help="the merged passport")


@dataclass(frozen=True)
class _Quietly(ResultOptions):
    """The result as JSON; all of it is on the screen."""

    WITHOUT: ClassVar[frozenset[str]] = frozenset({"details"})


def add_parser(commands: Any) -> None:
    """Arguments of the command and of those below it."""
    parser = commands.add_parser("passport", help=COMMANDS["passport"])
    below = parser.add_subparsers(required=True, metavar="what")
    add_command(below, "show", run_show, help="value, interval and verdict by the passport alone")
    add_command(below, "merge", run_merge, help="one passport of all logs of several")
    add_command(below, "compare", run_compare, help="the same parameters by several passports")


def run_show(request: _One, files: ResultOptions) -> int:
    """Compute the answer again, and show it."""
    passport = fleet.read_passport(request.file)
    answer = fleet.answered(passport)
    files.show(report.passport_screen(passport, answer))
    files.write_json(lambda: report.documents.passport_document(passport, answer))
    return answered(answer.verdict.level)


def run_merge(request: _Several, merged: _Merged, files: _Quietly) -> int:
    """Merge passports that do not contradict each other."""
    passport = fleet.merged_passports(request.read())
    answer = fleet.answered(passport)
    fleet.write_passport(merged.out, passport)
    files.show(report.passport_screen(passport, answer))
    files.write_json(lambda: report.documents.passport_document(passport, answer))
    return answered(answer.verdict.level)


def run_compare(request: _Several, files: ResultOptions) -> int:
    """Set passports side by side."""
    compared = fleet.compared(request.read())
    files.show(report.compared_screen(compared))
    files.write_json(lambda: report.documents.compared_document(compared))
    return ANSWERED
