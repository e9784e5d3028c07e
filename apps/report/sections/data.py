"""What a report was made from, and the page around it."""

from collections.abc import Sequence

from ..blocks import Block, Code, Notes, Page, Section, Table, Text, columns
from ..provenance import Provenance


def report_page(
    title: str,
    subtitle: str,
    lead: Sequence[Block],
    sections: Sequence[Section],
    notes: Sequence[str],
    provenance: Provenance,
) -> Page:
    """A page with what leads, sections, and what it was made from.

    Args:
        lead: the answer, before everything else.
        notes: on the data.
    """
    files = _files(provenance)
    data: list[Block] = [Notes(notes), *files]
    for name, heading, words in (
        ("Settings", "value", provenance.settings),
        ("Versions", "version", provenance.versions),
    ):
        if words:
            data.append(Table(name, columns(("",), (heading,)), list(words.items()), style="plain"))
    data += [Text("Command that repeats it", "heading"), Code("command", provenance.command)]
    last = Section("data", "Data, settings and how to repeat it", data)
    return Page(title, subtitle, lead, [*sections, last], provenance.foot)


def _files(provenance: Provenance) -> list[Block]:
    """Names and whole checksums of the files that were read; nothing without any."""
    if not provenance.files:
        return []
    rows = [tuple(file) for file in provenance.files]
    return [Table("Files that were read", columns(("",), ("file", "SHA-256")), rows, style="plain")]
