"""Options of the files and views that a command writes, and the writing of them."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from .... import estimation
from ....common.files import checksum, write_text
from ....common.schema import json_text, write_json
from ....common.versions import versions
from ... import report
from ... import view as views
from ..entry import CALL, FILES, SETTING, Options, options, settings
from ..progress import note, quiet, status
from ..values import NewFile, NewFolder, NewPage, Reads, Stream

if TYPE_CHECKING:
    from ...report import Report
    from ...view.moving import View


def print_lines(*lines: str) -> None:
    """Print lines no wider than the terminal, unless the run is quiet."""
    if not quiet():
        report.print_blocks([report.Notes(lines)])


@options(FILES)
class ResultOptions(Options):
    """The result as JSON."""

    json: Stream | None = None
    """Write the result as JSON; - for standard output, the screen goes aside."""
    details: bool = False
    """Print what the answer rests on, too."""

    @property
    def document(self) -> str | None:
        """The file that the JSON is written to."""
        return None if self.json == "-" else self.json

    def show(self, shown: Report) -> None:
        """Print the screen, or all of it; beside standard output where that takes the JSON."""
        if not quiet():
            report.print_report(shown, self.details, sys.stderr if self.json == "-" else None)

    def write_json(self, document: Callable[[], Any]) -> None:
        """Write the document; it is made only if it was asked for."""
        if self.json == "-":
            sys.stdout.write(json_text(document()).decode())
        elif self.json:
            write_json(self.json, document())


@options(FILES)
class PageOptions(ResultOptions):
    """The result as JSON, and as an HTML report with its figures."""

    report: NewPage | None = None
    """Write a report, one self-contained HTML file, and F.run.toml, which repeats the run by --config."""
    plots: Annotated[NewFolder | None, SETTING] = None
    """Folder for the report's figures as PNG, SVG and PDF; made if missing."""

    def give(self, shown: Report, document: Callable[[], Any], settings_text: Mapping[str, str]) -> None:
        """Print the screen, and write document, page and figures, as far as they were asked for."""
        self.show(shown)
        self.write_json(document)
        self.write_page(shown, settings_text)

    def write_page(self, shown: Report, settings_text: Mapping[str, str]) -> None:
        """Write page and figures, as far as they were asked for; ``settings_text``: of processing."""
        if self.report:
            call = CALL.get()
            named = ((role, path) for _, role, path in call.named(Reads) if role != "options")
            files = [report.SourceFile(role, path, checksum(path)) for role, path in named if Path(path).is_file()]
            command, when = shlex.join(["dynident", *call.words]), report.now()
            made_from = report.Provenance(command, when, tuple(files), versions(), settings_text)
            report.write_report(self.report, shown, made_from)
            if (beside := call.settings_file(self.report)) is not None:
                write_text(beside, settings().settings_text(call))
        if self.plots:
            report.write_plots(self.plots, shown)


@options(FILES)
class EquationOptions(PageOptions):
    """The equations beside the report."""

    npz: NewFile | None = None
    """Write W, Y, weights and reduced factors for your own solver."""

    def write_equations(self, system: Callable[[], estimation.ObservationSystem]) -> None:
        """Write them, held whole; they are made only if they were asked for."""
        if self.npz:
            report.recordings.write_npz(self.npz, system())


@options(FILES)
class ViewOptions(Options):
    """The arm in three dimensions."""

    view: Annotated[Stream | None, Parameter(metavar="F.html")] = None
    """The arm in three dimensions, one file that plays without a server; - opens it in the browser."""

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
                shown = views.open_view(scene)
            else:
                views.write_view(self.view, scene)
        for text in scene.notes:
            note(text)
        if shown:
            note(f"the view is open in the browser: {shown}")


@options(FILES)
class ViewedPageOptions(PageOptions, ViewOptions):
    """The result as JSON and as a report, and the arm in three dimensions."""
