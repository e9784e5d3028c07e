"""The document of ``compare``."""

from ....common.schema import Document, Matrix, Vector
from ...fleet.comparing import Compared


class OddDocument(Document, frozen=True):
    """A recording that differs from all others in a parameter, in standard deviations of the difference."""

    recording: str
    parameter: str
    sigmas: float


class ComparedDocument(Document, frozen=True):
    """Parameters by k recordings: values and standard deviations k x c, the rest c each."""

    recordings: tuple[str, ...]
    parameters: tuple[str, ...]
    values: Matrix
    sigma: Matrix
    pooled: Vector
    pooled_interval95: Matrix
    scatter: Vector
    odd: tuple[OddDocument, ...]


def compared_document(compared: Compared) -> ComparedDocument:
    """What ``dynident compare --json`` writes."""
    return ComparedDocument(
        compared.sources,
        compared.names,
        compared.values,
        compared.sigma,
        compared.pooled,
        compared.interval95,
        compared.scatter,
        tuple(OddDocument(*odd) for odd in compared.odd),
    )
