"""A page: sections, each with its figures, in one self-contained file."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path

from ...common.files import write_text
from ..figures import Drawing, save_drawings
from .markup import Html, escaped, joined, tag
from .svg import figure_html


@dataclass(frozen=True, eq=False)
class Section:
    """A part of a page.

    Attributes:
        name: its identifier.
        title: its heading.
        content: paragraphs, tables and the like, before the figures.
        drawings: its figures.
        after: content behind the figures.
    """

    name: str
    title: str
    content: Html
    drawings: tuple[Drawing, ...] = ()
    after: Html = Html()

    def with_content(self, more: Html) -> Section:
        """The same with more content before its figures."""
        return replace(self, content=joined(self.content, more))

    def html(self) -> Html:
        """The section."""
        figures = joined(*(figure_html(drawing) for drawing in self.drawings))
        body = joined(tag("h2", self.title), self.content, figures, self.after)
        return tag("section", body, id=self.name)


@dataclass(frozen=True, eq=False)
class Page:
    """A whole report.

    Attributes:
        title: of the page.
        head: what stands on top, before the sections.
        sections: in order; None is left out.
        foot: last line.
        drawings: figures of the head.
    """

    title: str
    head: Html
    sections: tuple[Section, ...]
    foot: Html
    drawings: tuple[Drawing, ...] = ()

    def all_drawings(self) -> tuple[Drawing, ...]:
        """Every figure of the page."""
        return (*self.drawings, *(drawing for section in self.sections for drawing in section.drawings))

    def html(self) -> str:
        """The file's text."""
        contents = tag("nav", _contents(self.sections), aria_label="contents")
        main = tag("main", joined(self.head, contents, *(section.html() for section in self.sections)))
        head = joined(
            Html('<meta charset="utf-8">'),
            Html('<meta name="viewport" content="width=device-width, initial-scale=1">'),
            Html('<meta name="color-scheme" content="light dark">'),
            Html('<link rel="icon" href="data:,">'),
            tag("title", self.title),
            Html(f"<style>\n{_asset('style.css')}</style>"),
        )
        body = joined(main, tag("footer", self.foot), Html(f"<script>\n{_asset('copy.js')}</script>"))
        return f'<!DOCTYPE html>\n<html lang="en">\n<head>\n{head}\n</head>\n<body>\n{body}\n</body>\n</html>\n'


def write_report(path: str | Path, page: Page) -> None:
    """Write the page in one step."""
    write_text(path, page.html())


def write_plots(folder: str | Path, page: Page) -> None:
    """Write the page's figures as PNG, SVG and PDF; the folder is made if missing."""
    save_drawings(folder, page.all_drawings())


def _contents(sections: Iterable[Section]) -> Html:
    links = (tag("li", Html(f'<a href="#{escaped(one.name)}">{escaped(one.title)}</a>')) for one in sections)
    return tag("ol", *links)


def _asset(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")
