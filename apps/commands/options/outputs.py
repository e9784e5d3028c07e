"""Options of the files and views that a command writes, and the writing of them."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from .... import estimation
from ....common.errors import InputError
from ....common.files import checksum, is_device, place_of, write_text
from ....common.versions import versions
from ... import report
from ... import view as views
from ..progress import note, quiet, status
from .reading import Options, is_settings_file, option, settings_text

if TYPE_CHECKING:
    from ...report import Page, Provenance, Screen
    from ...view.moving import View


def print_lines(*lines: str) -> None:
    """Print lines no wider than the terminal, unless the run is quiet."""
    if not quiet():
        report.print_blocks([report.Notes(lines)])


@dataclass(frozen=True)
class ResultOptions(Options):
    """The result as JSON."""

    GROUP: ClassVar[str] = "files"

    json: str | None = option(
        writes="stream", metavar="F", help="write the result as JSON; - for standard output, the screen goes aside"
    )
    details: bool = option(action="store_true", help="print what the answer rests on, too")

    @property
    def document(self) -> str | None:
        """The file that the JSON is written to."""
        return None if self.json == "-" else self.json

    def show(self, screen: Screen) -> None:
        """Print a screen, or all of it; beside standard output where that takes the JSON."""
        if not quiet():
            report.print_screen(screen, self.details, sys.stderr if self.json == "-" else None)

    def write_json(self, document: Callable[[], Any]) -> None:
        """Write the document; it is made only if it was asked for."""
        if self.json == "-":
            sys.stdout.write(report.documents.json_text(document()).decode())
        elif self.json:
            report.documents.write_json(self.json, document())


@dataclass(frozen=True)
class PageOptions(ResultOptions):
    """The result as JSON, and as an HTML report with its figures.

    Attributes:
        argv, parser: the command line, and the ``cli.Parser`` that has read it.
        config: file of options that was read.
    """

    report: str | None = option(
        writes="file",
        metavar="F.html",
        help="write a report, one self-contained HTML file, and F.run.toml, which repeats the run by --config",
    )
    plots: str | None = option(
        writes="folder", metavar="DIR", help="write its figures as PNG, SVG and PDF; made if missing"
    )
    argv: tuple[str, ...] = ()
    parser: Any = None
    config: str | None = None

    @property
    def settings_file(self) -> Path | None:
        """The file beside the report that repeats the run by ``--config``; none if it was made from that file.

        None beside what is no file, such as a pipe.
        """
        if not self.report or self.parser is None or is_device(Path(self.report)):
            return None
        path = Path(self.report).with_suffix(".run.toml")
        return None if self.config and place_of(self.config) == place_of(path) else path

    def named(self, kind: Literal["reads", "writes"]) -> Iterator[tuple[str, str, str]]:
        """Paths that options name, and the file beside the report.

        Raises:
            InputError: if a file stands there that no run has written.
        """
        yield from super().named(kind)
        if kind == "writes" and (path := self.settings_file) is not None:
            if path.exists() and not is_settings_file(path):
                raise InputError(
                    f"--report {self.report!r}: {path} beside it would be overwritten, which holds no options of a "
                    "run: move it, or give the report another name"
                )
            yield "--report's options", "file", str(path)

    def write_page(self, page: Callable[[], Page]) -> None:
        """Write report and figures; the page is made only if one of them was asked for."""
        if not (self.report or self.plots):
            return
        content = page()
        if self.report:
            report.write_report(self.report, content)
            if self.parser is not None and (path := self.settings_file) is not None:
                write_text(path, settings_text(self.parser, self.parser.typed))
        if self.plots:
            report.write_plots(self.plots, content)

    def provenance(self, settings: Mapping[str, str], *parts: Options) -> Provenance:
        """What the report was made from.

        Args:
            settings: in words.
            parts: options that name files.
        """
        files = tuple(
            report.SourceFile(role, path, checksum(path))
            for part in parts
            for _, role, path in part.named("reads")
            if Path(path).is_file()
        )
        command = shlex.join(["dynident", *self.argv])
        date, used = report.provenance.now(), versions()
        return report.Provenance(command, date, files, used, settings)


@dataclass(frozen=True)
class EquationOptions(PageOptions):
    """The equations beside the report."""

    npz: str | None = option(
        writes="file", metavar="F", help="write W, Y, weights and reduced factors for your own solver"
    )

    def write_equations(self, system: Callable[[], estimation.ObservationSystem]) -> None:
        """Write them, held whole; they are made only if they were asked for."""
        if self.npz:
            report.recordings.write_npz(self.npz, system())


@dataclass(frozen=True)
class ViewOptions(Options):
    """The arm in three dimensions."""

    GROUP: ClassVar[str] = "view"

    view: str | None = option(
        writes="stream",
        metavar="F.html",
        help="the arm in three dimensions, one file that plays without a server; - opens it in the browser",
    )

    def check_view(self) -> None:
        """Refuse a view that could not be made, before any work is done."""
        if self.view:
            views.require_viewer()

    def write_view(self, view: Callable[[], View]) -> None:
        """Write or open the view; it is made only if it was asked for."""
        if not self.view:
            return
        shown = None
        with status("drawing the view"):
            scene = view()
            if self.view == "-":
                shown = views.show_view(None, scene)
            else:
                views.write_view(self.view, scene)
        for text in scene.notes:
            note(text)
        if shown:
            note(f"the view is open in the browser: {shown}")
