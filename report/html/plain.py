"""A report of tables, notes and figures, for answers that have no page of their own."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Table

from ..figures import Drawing
from .data import data_section
from .markup import Html, bullets, joined, paragraph, printed_table, tag
from .page import Page, Section
from .provenance import Provenance, files_table, foot


def plain_page(title: str, lead: Html, sections: Sequence[Section], provenance: Provenance) -> Page:
    """A page with a heading, what leads, sections, and what it was made from.

    Args:
        title: of the page.
        lead: the answer, before everything else.
        sections: in order.
        provenance: command, files, date.
    """
    head = joined(tag("h1", title), paragraph(provenance.day, class_="sub"), lead, files_table(provenance))
    return Page(title, head, (*sections, data_section((), provenance)), foot(provenance))


def plain_section(
    name: str, title: str, tables: Sequence[Table], notes: Sequence[str] = (), drawings: Sequence[Drawing] = ()
) -> Section:
    """Tables of the terminal, notes and figures.

    Args:
        name: identifier in the page.
        title: heading.
        tables: as the terminal prints them.
        notes: lines below them.
        drawings: figures.
    """
    return Section(name, title, joined(*map(printed_table, tables), bullets(notes)), tuple(drawings))
