"""Documents of ``fleet report`` and ``compare``."""

from collections.abc import Mapping

from ....common.schema import Document, Matrix, Vector
from ....estimation.results.parts import Number
from ...fleet import Fleet
from ...fleet.comparing import OddDocument
from ...fleet.nights import CHANGED, Series
from ...fleet.store import RefusedDocument, refused_documents


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


class NightDocument(Document, frozen=True):
    """A quantity of an arm on its last night, its standard deviation, and what the ``nights`` before say.

    ``usual``: their median; ``z``: how far the last night is from it, null of too few nights.
    """

    arm: str
    quantity: str
    day: str
    value: Number
    sigma: Number
    usual: Number
    nights: int
    z: Number


class FleetDocument(Document, frozen=True):
    """What a fleet's nights say; ``changed``: those of ``last`` with z beyond ``threshold``."""

    arms: tuple[str, ...]
    first_day: str
    threshold: float
    changed: tuple[NightDocument, ...]
    last: tuple[NightDocument, ...]
    odd: tuple[OddDocument, ...]
    refused: tuple[RefusedDocument, ...]


def fleet_document(fleet: Fleet, refused: Mapping[str, str]) -> FleetDocument:
    """Make the document of ``dynident fleet report --json``."""

    def night(line: Series) -> NightDocument:
        before, value, sigma = len(line.values) - 1, float(line.values[-1]), float(line.sigma[-1])
        return NightDocument(line.arm, line.quantity, line.days[-1], value, sigma, line.usual, before, line.z)

    return FleetDocument(
        arms=tuple(arm.name for arm in fleet.arms),
        first_day=fleet.first,
        threshold=CHANGED,
        changed=tuple(map(night, fleet.changed)),
        last=tuple(map(night, fleet.series)),
        odd=fleet.twins.odd if fleet.twins is not None else (),
        refused=refused_documents(refused),
    )
