"""``--report`` and ``--plots``: what several commands share to make the HTML report and its figures."""

from __future__ import annotations

import argparse
import hashlib
import os
import platform
import shlex
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING

from .. import __version__, model, report
from ..common.errors import InputError

if TYPE_CHECKING:
    from datetime import datetime
_PACKAGES = ("casadi", "clarabel", "matplotlib", "numpy", "scipy")


def report_arguments(parser: argparse.ArgumentParser, default: str = "") -> None:
    """``--report`` and ``--plots``; ``default``: where the report goes anyway."""
    group = parser.add_argument_group("report")
    written = "write a report, one self-contained HTML file" + (f" (default: {default})" if default else "")
    group.add_argument("--report", metavar="F.html", help=written)
    group.add_argument("--plots", metavar="DIR", help="write its figures as PNG, SVG and PDF; made if missing")


def write_page(arguments: argparse.Namespace, page: Callable[[], report.Page]) -> None:
    """Write what was asked for; ``page`` is called only then."""
    if not (arguments.report or arguments.plots):
        return
    made = page()
    if arguments.report:
        report.write_report(arguments.report, made)
    if arguments.plots:
        report.write_plots(arguments.plots, made)


def provenance(
    arguments: argparse.Namespace, files: Mapping[str, Sequence[str]], settings: Mapping[str, str]
) -> report.Provenance:
    """What the report was made from.

    Args:
        arguments: of the command.
        files: role -> paths of the files that were read.
        settings: in words.
    """
    found = [report.SourceFile(role, path, checksum(path)) for role, paths in files.items() for path in paths]
    for role, path in (("robot", "robot"), ("log map", "log_map"), ("drive gains", "gains_file")):
        given = getattr(arguments, path, None)
        if given and Path(given).is_file():
            found.append(report.SourceFile(role, given, checksum(given)))
    command = shlex.join(["dynident", *arguments.argv])
    return report.Provenance(command, now(), tuple(found), versions(), settings)


def checksum(path: str | Path) -> str:
    """SHA-256 of a file's bytes."""
    with Path(path).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


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


def versions() -> dict[str, str]:
    """Of dynident, Python, and the packages that decide numbers and figures."""
    found = {"dynident": __version__, "Python": platform.python_version()}
    for package in _PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found


def settings_in_words(
    robot: model.Robot,
    processing: model.Processing,
    gains: Sequence[float] | None,
    more: Mapping[str, str] | None = None,
) -> dict[str, str]:
    """Robot and processing for the report.

    Args:
        robot: the robot.
        processing: settings.
        gains: torque per current [N·m/A], if currents were read.
        more: what else was set.
    """
    rate = f"{processing.rate:g} Hz" if processing.rate else "the recording's own"
    cutoff = f"{processing.cutoff:g} Hz" if processing.cutoff else "none"
    coupling = robot.coupling
    words = {
        "robot": f"{robot.title or robot.name} ({robot.name})",
        "sampling rate": rate,
        "low-pass (Butterworth, 4th order, zero phase)": cutoff,
        "decimation": str(processing.decimate),
        "slow rows left out below": f"{100.0 * processing.slow_fraction:g} % of a joint's largest speed",
        "drive gains [N·m/A]": ", ".join(f"{gain:g}" for gain in gains) if gains else "torques were read",
        "offset of each joint": "identified" if robot.drives.offsets else "none",
    }
    if coupling is not None:
        words["Coulomb friction of coupled drives"] = coupling.coulomb
    if robot.spring is not None:
        words["spring"] = f"known torque on joint {robot.spring.joint}"
    return words | dict(more or {})
