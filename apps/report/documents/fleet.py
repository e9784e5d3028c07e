"""Documents of ``fleet``."""

from collections.abc import Mapping

from ....common.schema import Document
from ...fleet import Fleet
from ...fleet.reduction import Reduced
from ...fleet.trends import CHANGED, Series
from ...results.parts import Number
from .compare import OddDocument


class RefusedDocument(Document, frozen=True):
    """A log that is not in the store, and why."""

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
    refused = _refused(reduced.refused)
    return ReducedDocument(str(reduced.store.root), reduced.new, reduced.known, refused, reduced.crashes)


def _refused(refused: Mapping[str, str]) -> tuple[RefusedDocument, ...]:
    return tuple(RefusedDocument(file, reason) for file, reason in sorted(refused.items()))


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


class ExchangeDocument(Document, frozen=True):
    """Recordings of another robot than their arm: of a day ``alone``, or since it; ``like``: perhaps this arm's."""

    arm: str
    day: str
    alone: bool
    chi2: float
    degrees: int
    like: str


class FleetDocument(Document, frozen=True):
    """What a fleet's nights say; ``changed``: those of ``last`` with z beyond ``threshold``."""

    arms: tuple[str, ...]
    first_day: str
    threshold: float
    changed: tuple[NightDocument, ...]
    last: tuple[NightDocument, ...]
    odd: tuple[OddDocument, ...]
    exchanges: tuple[ExchangeDocument, ...]
    refused: tuple[RefusedDocument, ...]


def fleet_document(fleet: Fleet, refused: Mapping[str, str]) -> FleetDocument:
    """What ``dynident fleet report --json`` writes."""
    latest = {arm.name: arm.nights[-1] for arm in fleet.arms}

    def night(series: Series) -> NightDocument:
        last, name = latest[series.arm], series.quantity
        before = len(series.values) - 1
        return NightDocument(series.arm, name, last.day, *last.numbers[name], series.usual, before, series.z)

    return FleetDocument(
        arms=tuple(latest),
        first_day=fleet.first,
        threshold=CHANGED,
        changed=tuple(map(night, fleet.changed)),
        last=tuple(map(night, fleet.series)),
        odd=tuple(OddDocument(*odd) for odd in fleet.twins.odd) if fleet.twins is not None else (),
        exchanges=tuple(map(ExchangeDocument.of, fleet.exchanges)),
        refused=_refused(refused),
    )
