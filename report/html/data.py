"""The data and settings that were used, and how to repeat it."""

from collections.abc import Sequence

from .markup import bullets, joined
from .page import Section
from .provenance import Provenance, files_table, provenance_content


def data_section(notes: Sequence[str], provenance: Provenance) -> Section:
    """Notes on the data, files, settings, versions, the command."""
    content = joined(bullets(notes), files_table(provenance), provenance_content(provenance))
    return Section("data", "Data, settings and how to repeat it", content)
