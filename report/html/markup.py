"""HTML as text that escapes whatever is not markup already."""

from __future__ import annotations

import html
from collections.abc import Sequence

from rich.table import Table

from ..sheet import Sheet, sheet_of


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
    told = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{html.escape(value)}"' for key, value in attributes.items()
    )
    return Html(f"<{name}{told}>{''.join(escaped(part) for part in content)}</{name}>")


def paragraph(text: str, **attributes: str) -> Html:
    """A paragraph."""
    return tag("p", text, **attributes)


def bullets(lines: Sequence[str]) -> Html:
    """A list; nothing without lines."""
    return tag("ul", *(tag("li", line) for line in lines)) if lines else Html()


def table(caption: str, headings: Sequence[str], rows: Sequence[Sequence[str]], **attributes: str) -> Html:
    """A table whose first column names its rows; it scrolls where the screen is narrow."""
    numeric = (False, *(True for _ in headings[1:]))
    return _table(
        Sheet(caption, tuple(headings), tuple(map(tuple, rows)), (False,) * len(rows), numeric), attributes
    )


def printed_table(shown: Table, **attributes: str) -> Html:
    """A table of the terminal."""
    return _table(sheet_of(shown), attributes)


def _table(sheet: Sheet, attributes: dict[str, str]) -> Html:
    head = tag("tr", *(_cell("th", text, number, scope="col") for text, number in _pairs(sheet, sheet.headings)))
    groups: list[list[Html]] = [[]]
    for row, end in zip(sheet.rows, sheet.ends, strict=True):
        first, *rest = (
            _cell("th" if k == 0 else "td", text, number, **({"scope": "row"} if k == 0 else {}))
            for k, (text, number) in enumerate(_pairs(sheet, row))
        )
        groups[-1].append(tag("tr", first, *rest))
        if end:
            groups.append([])
    bodies = [tag("tbody", *group) for group in groups if group]
    whole = tag("table", tag("caption", sheet.title), tag("thead", head), *bodies)
    attributes = {"class_": "scroll", "tabindex": "0", "role": "region", "aria_label": sheet.title} | attributes
    return tag("div", whole, **attributes)


def _pairs(sheet: Sheet, cells: Sequence[str]) -> list[tuple[str, bool]]:
    return list(zip(cells, sheet.numeric, strict=True))


def _cell(name: str, text: str, number: bool, **attributes: str) -> Html:
    return tag(name, text, **({"class_": "number"} if number else {}), **attributes)
