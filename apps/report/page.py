"""A report as one self-contained HTML file that says where it comes from, and its figures as files.

The page is what ``templates/`` makes of the report: ``page.html`` is its layout, ``blocks.html`` the look of each
kind of block, ``style.css`` colours and widths. Every text is escaped where it enters.
"""

import html
import os
import re
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ... import __version__
from ...common.errors import InputError
from ...common.files import made_folder
from ...common.versions import versions
from .blocks import Block, Drawing, Report, Table
from .figures.canvas import save_figure, svg_text

if TYPE_CHECKING:
    from jinja2 import Environment

_ENDINGS = ("png", "svg", "pdf")
_WIDE = 7.5  # inches: a wider figure scrolls where the screen is narrow
_HEAD = re.compile(r"^.*?(?=<svg\b)", re.DOTALL)
_METADATA = re.compile(r"<metadata>.*?</metadata>\s*", re.DOTALL)
_FONTS = re.compile(r"(font: [^;\"]*?)'DejaVu Sans'[^;\"]*")


def write_plots(folder: str | Path, report: Report) -> None:
    """Write the figures as PNG, SVG and PDF; the folder is made if missing, a report without figures refused."""
    drawings = list(report.drawings())
    if not drawings:
        raise InputError("plots: there is nothing to draw")
    folder = made_folder(folder)
    for drawing in drawings:
        for ending in _ENDINGS:
            save_figure(drawing.figure, folder / f"{drawing.name}.{ending}")


def page_html(
    report: Report,
    command: str,
    files: Sequence[tuple[str, str, str]] = (),
    settings: Mapping[str, str] | None = None,
) -> str:
    """The file's text, with all that repeats it: the command as typed, files that were read, settings, versions.

    ``files``: role, name and SHA-256 checksum of each. By SOURCE_DATE_EPOCH the same input gives the same file.
    """
    fixed = os.environ.get("SOURCE_DATE_EPOCH")
    try:
        date = datetime.fromtimestamp(int(fixed), UTC) if fixed else datetime.now(UTC)
    except (ValueError, OverflowError, OSError):
        raise InputError(f"SOURCE_DATE_EPOCH {fixed!r} is not a time: give seconds since 1970") from None
    parts = (
        ("Files that were read", ("", "file", "SHA-256"), files),
        ("Settings", ("", "value"), list((settings or {}).items())),
        ("Versions", ("", "version"), list(versions().items())),
    )
    tables = [Table(title, headings, rows) for title, headings, rows in parts if rows]
    day = date.strftime("%Y-%m-%d %H:%M UTC")
    page = _environment().get_template("page.html")
    return page.render(report=report, command=command, tables=tables, day=day, version=__version__)


def blocks_html(blocks: Sequence[Block]) -> str:
    """Some blocks alone."""
    templates: Any = _environment().get_template("blocks.html").module
    return str(templates.show(blocks))


@cache
def _environment() -> "Environment":
    from jinja2 import Environment, PackageLoader, StrictUndefined

    loader = PackageLoader(str(__package__))
    environment = Environment(
        loader=loader,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
    )
    environment.filters["kind"] = lambda block: type(block).__name__
    environment.filters["svg"] = _inline_svg
    environment.filters["content"] = lambda name: loader.get_source(environment, name)[0]
    environment.tests["wide"] = lambda drawing: drawing.figure.get_figwidth() > _WIDE
    return environment


def _inline_svg(drawing: Drawing) -> str:
    """The drawing alone, its text as text in the reader's fonts, with a description for those who do not see it."""
    text = _HEAD.sub("", svg_text(drawing.figure, drawing.name))
    text = re.sub(r' xmlns(?::xlink)?="[^"]*"', "", text).replace("xlink:href", "href")  # HTML needs no address
    text = _FONTS.sub(r"\1sans-serif", _METADATA.sub("", text))
    # Identifiers are hashes that only one figure has; those that nothing refers to go.
    used = set(re.findall(r'(?:href="#|url\(#)([^")]+)', text))
    text = re.sub(r' id="([^"]+)"', lambda m: m[0] if m[1] in used else "", text)
    text = re.sub(r' (?:width|height)="[\d.]+pt"', "", text, count=2)
    text = text.replace("<svg ", f'<svg role="img" aria-labelledby="{drawing.name}-text" ', 1)
    head, _, rest = text.partition(">")
    title = f'<title id="{drawing.name}-text">{html.escape(drawing.text or drawing.caption)}</title>'
    return f"{head}>{title}{rest}"  # whose names of files matplotlib has escaped
