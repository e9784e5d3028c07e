"""Options of the view in three dimensions, and the writing of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from ... import report
from ..progress import note, status
from .reading import Options, option

if TYPE_CHECKING:
    from ...report.view.moving import View


@dataclass(frozen=True)
class ViewOptions(Options):
    """The arm in three dimensions."""

    GROUP: ClassVar[str] = "view"

    view: str | None = option(
        writes="file", metavar="F.html", help="the arm in three dimensions, one file that plays without a server"
    )
    show: bool = option(action="store_true", help="open the view in the browser")

    def check_view(self) -> None:
        """Refuse a view that could not be made, before any work is done."""
        if self.view or self.show:
            report.view.require_viewer()

    def write_view(self, view: Callable[[], View]) -> None:
        """Write and open what was asked for; the view is made only then."""
        if not (self.view or self.show):
            return
        with status("drawing the view"):
            scene = view()
            if self.view:
                report.view.write_view(self.view, scene)
        for text in scene.notes:
            note(text)
        if self.show:
            note(f"the view is open in the browser: {report.view.show_view(self.view, scene)}")
