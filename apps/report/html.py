"""A page as one self-contained HTML file, and its figures as files."""

import html
import re
from collections.abc import Sequence
from functools import singledispatch
from importlib import resources
from pathlib import Path

from ...common.files import made_folder, write_text
from .blocks import (
    Banner,
    Block,
    Cell,
    Code,
    Column,
    Details,
    Drawing,
    Notes,
    Page,
    Pair,
    Section,
    Table,
    Text,
)
from .figures.canvas import save_figure, svg_text

_ENDINGS = ("png", "svg", "pdf")
_WIDE = 7.5  # inches: a wider figure scrolls where the screen is narrow
_HEAD = re.compile(r"^.*?(?=<svg\b)", re.DOTALL)
_METADATA = re.compile(r"<metadata>.*?</metadata>\s*", re.DOTALL)
_FONTS = re.compile(r"(font: [^;\"]*?)'DejaVu Sans'[^;\"]*")


class Html(str):
    """Text that is markup; every other text is escaped where it enters."""

    __slots__ = ()


def escaped(text: str) -> Html:
    """Markup as it is, other text escaped, for content and for attributes."""
    return text if isinstance(text, Html) else Html(html.escape(text))


def joined(*parts: str) -> Html:
    """One after the other."""
    return Html("\n".join(escaped(part) for part in parts if part))


def tag(name: str, *content: str, **attributes: str) -> Html:
    """An element; ``class_`` and ``aria_label`` become class and aria-label."""
    written = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{html.escape(value)}"' for key, value in attributes.items()
    )
    return Html(f"<{name}{written}>{''.join(escaped(part) for part in content)}</{name}>")


def write_report(path: str | Path, page: Page) -> None:
    """Write the page in one step."""
    write_text(path, page_html(page))


def write_plots(folder: str | Path, page: Page) -> None:
    """Write the page's figures as PNG, SVG and PDF; the folder is made if missing."""
    folder = made_folder(folder)
    for drawing in page.drawings():
        for ending in _ENDINGS:
            save_figure(drawing.figure, folder / f"{drawing.name}.{ending}")


def page_html(page: Page) -> str:
    """The file's text."""
    links = (tag("li", tag("a", section.title, href=f"#{section.name}")) for section in page.sections)
    contents = tag("nav", tag("ol", *links), aria_label="contents")
    lead = joined(tag("h1", page.title), tag("p", page.subtitle, class_="sub"), blocks_html(page.lead))
    main = tag("main", joined(lead, contents, *map(_section, page.sections)))
    head = joined(
        Html('<meta charset="utf-8">'),
        Html('<meta name="viewport" content="width=device-width, initial-scale=1">'),
        Html('<meta name="color-scheme" content="light dark">'),
        Html('<link rel="icon" href="data:,">'),
        tag("title", page.title),
        Html(f"<style>\n{_asset('style.css')}</style>"),
    )
    script = Html(f"<script>\n{_asset('copy.js')}</script>")
    body = joined(main, tag("footer", tag("p", page.foot)), script)
    return f'<!DOCTYPE html>\n<html lang="en">\n<head>\n{head}\n</head>\n<body>\n{body}\n</body>\n</html>\n'


def _section(section: Section) -> Html:
    return tag("section", joined(tag("h2", section.title), blocks_html(section.blocks)), id=section.name)


def _asset(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


def blocks_html(blocks: Sequence[Block]) -> Html:
    """Blocks, one after the other."""
    return joined(*map(block_html, blocks))


@singledispatch
def block_html(block: Block) -> Html:
    """One block."""
    raise TypeError(f"{type(block).__name__} is no block of a page")


@block_html.register
def _(block: Text) -> Html:
    if block.kind == "heading":
        return tag("h3", block.words)
    return tag("p", block.words, **({"class_": "note"} if block.kind == "note" else {}))


@block_html.register
def _(block: Notes) -> Html:
    return tag("ul", *(tag("li", line) for line in block.lines)) if block.lines else Html()


@block_html.register
def _(block: Banner) -> Html:
    """Render a banner, whose border differs in line as well as in colour."""
    return tag("div", tag("p", block.words), class_=f"verdict {block.level}", role="status")


@block_html.register
def _(block: Code) -> Html:
    button = tag("button", "Copy", type="button", data_copy=block.name, hidden="hidden")
    return tag("div", button, tag("pre", tag("code", block.text, id=block.name), tabindex="0"), class_="block")


@block_html.register
def _(block: Details) -> Html:
    opened = {"open": "open"} if block.opened else {}
    return tag("details", joined(tag("summary", block.summary), blocks_html(block.blocks)), **opened)


@block_html.register
def _(block: Pair) -> Html:
    return tag("div", tag("div", blocks_html(block.left)), tag("div", blocks_html(block.right)), class_="first")


@block_html.register
def _(block: Drawing) -> Html:
    wide = " wide" if block.figure.get_figwidth() > _WIDE else ""
    framed = tag("div", inline_svg(block), class_="drawing" + wide, tabindex="0", role="group",
                 aria_label=f"figure {block.name}")  # fmt: skip
    return tag("figure", framed, tag("figcaption", block.caption), id=f"figure-{block.name}")


@block_html.register
def _(block: Table) -> Html:
    head = tag("tr", *(_cell("th", column.heading, column, scope="col") for column in block.columns))
    bodies = [tag("tbody", *_rows(block, section)) for section in block.sections]
    table = tag("table", tag("caption", block.title), tag("thead", head), *bodies)
    if block.style == "quantities":
        return tag("div", table, class_="scroll quantities")
    kind = "scroll plain" if block.style == "plain" else "scroll"
    # It scrolls where the screen is narrow.
    return tag("div", table, class_=kind, tabindex="0", role="region", aria_label=block.title)


def _rows(table: Table, section: Sequence[tuple[Cell, ...]]) -> list[Html]:
    rows = []
    for k, (name, *cells) in enumerate(section):
        written = [_cell("th", str(name), table.columns[0], scope="row")]
        if table.style == "quantities":
            *cells, words = cells
        written += [_cell("td", str(cell), column) for cell, column in zip(cells, table.columns[1:], strict=False)]
        if table.style == "quantities" and k == 0:
            written.append(tag("td", str(words), class_="words", rowspan=str(len(section))))
        rows.append(tag("tr", *written))
    return rows


def _cell(name: str, text: str, column: Column, **attributes: str) -> Html:
    return tag(name, text, **({"class_": "number"} if column.numeric else {}), **attributes)


def inline_svg(drawing: Drawing) -> Html:
    """The drawing alone, with a description for those who do not see it.

    Text stays text, set in the reader's own fonts; the same figure gives the same text.
    """
    text = _HEAD.sub("", svg_text(drawing.figure, drawing.name))
    text = re.sub(r' xmlns(?::xlink)?="[^"]*"', "", text).replace("xlink:href", "href")  # HTML needs no address
    text = _METADATA.sub("", text)
    text = _FONTS.sub(r"\1sans-serif", text)
    text = _own_names(text, f"{drawing.name}-")
    text = re.sub(r' (?:width|height)="[\d.]+pt"', "", text, count=2)
    label = f"{drawing.name}-text"
    described = f'<svg role="img" aria-labelledby="{label}" '
    text = text.replace("<svg ", described, 1)
    at = text.index(">") + 1
    return Html(text[:at] + tag("title", drawing.text, id=label) + text[at:])


def _own_names(text: str, prefix: str) -> str:
    """Identifiers that only one figure has; those that nothing refers to go."""
    used = set(re.findall(r'(?:href="#|url\(#)([^")]+)', text))
    text = re.sub(r' id="([^"]+)"', lambda m: f' id="{prefix}{m[1]}"' if m[1] in used else "", text)
    return re.sub(r'(href="#|url\(#)', rf"\g<1>{prefix}", text)
