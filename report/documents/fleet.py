"""Documents of ``fleet``."""

from ...common.schema import Document
from ...fleet.reduction import Reduced


class RefusedDocument(Document, frozen=True):
    """A log without a passport, and why."""

    file: str
    reason: str


class ReducedDocument(Document, frozen=True):
    """What a run of ``fleet reduce`` did: recordings reduced now, those that were there, and what was refused."""

    store: str
    new: int
    known: int
    refused: tuple[RefusedDocument, ...]
    workers_lost: int


def reduced_document(reduced: Reduced) -> ReducedDocument:
    """What ``dynident fleet reduce --json`` writes."""
    refused = tuple(RefusedDocument(file, reason) for file, reason in sorted(reduced.refused.items()))
    return ReducedDocument(str(reduced.store.root), reduced.new, reduced.known, refused, reduced.crashes)
