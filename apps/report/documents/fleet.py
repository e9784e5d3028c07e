"""Documents of ``fleet``."""

from collections.abc import Mapping

from ....common.schema import Document
from ...fleet import Fleet
from ...fleet.alarms import Alarm
from ...fleet.reduction import Reduced
from ...fleet.trends import Drift
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
    """A quantity of an arm on its last night, its standard deviation, and its usual value."""

    arm: str
    quantity: str
    day: str
    value: Number
    sigma: Number
    usual: Number


class ScatterDocument(Document, frozen=True):
    """How a quantity varies from day to day without any change; a step beyond ``bound`` sigmas is an alarm."""

    quantity: str
    sigma: float
    memory: float
    per_kelvin: float
    per_kelvin_sigma: float
    bound: float


class ExchangeDocument(Document, frozen=True):
    """Recordings of another robot than their arm: of a day ``alone``, or since it; ``like``: perhaps this arm's."""

    arm: str
    day: str
    alone: bool
    chi2: float
    degrees: int
    like: str


class FleetDocument(Document, frozen=True):
    """What a fleet's nights say."""

    arms: tuple[str, ...]
    first_day: str
    alarms: tuple[Alarm, ...]
    last: tuple[NightDocument, ...]
    scatter: tuple[ScatterDocument, ...]
    drifts: tuple[Drift, ...]
    odd: tuple[OddDocument, ...]
    exchanges: tuple[ExchangeDocument, ...]
    refused: tuple[RefusedDocument, ...]


def fleet_document(fleet: Fleet, refused: Mapping[str, str]) -> FleetDocument:
    """What ``dynident fleet report --json`` writes."""
    usual = {(series.arm, series.quantity): series.usual for series in fleet.series}
    return FleetDocument(
        arms=tuple(arm.name for arm in fleet.arms),
        first_day=fleet.first,
        alarms=fleet.alarms,
        last=tuple(
            NightDocument(arm.name, name, arm.nights[-1].day, *number, usual[arm.name, name])
            for arm in fleet.arms
            for name, number in arm.nights[-1].numbers.items()
        ),
        scatter=tuple(
            ScatterDocument.of(scatter, quantity=name, bound=fleet.bounds[name])
            for name, scatter in fleet.scatter.items()
        ),
        drifts=fleet.drifts,
        odd=tuple(OddDocument(*odd) for odd in fleet.twins.odd) if fleet.twins is not None else (),
        exchanges=tuple(map(ExchangeDocument.of, fleet.exchanges)),
        refused=_refused(refused),
    )
