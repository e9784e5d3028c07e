"""Documents of ``fleet``."""

from collections.abc import Mapping

from ...common.schema import Document
from ...estimation.files.parts import Number
from ...fleet import Fleet
from ...fleet.reduction import Reduced
from .passport import OddDocument


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


class NightDocument(Document, frozen=True):
    """A quantity of an arm on its last night, its standard deviation, and its usual value."""

    arm: str
    quantity: str
    day: str
    value: Number
    sigma: Number
    usual: Number


class AlarmDocument(Document, frozen=True):
    """A change: since so many days after the first night; step and sigma are shares where ``relative``."""

    arm: str
    quantity: str
    since: float
    step: float
    sigma: float
    sigmas: float
    new: bool
    relative: bool


class ScatterDocument(Document, frozen=True):
    """How a quantity varies from day to day without any change."""

    quantity: str
    sigma: float
    memory: float
    per_kelvin: float
    per_kelvin_sigma: float


class DriftDocument(Document, frozen=True):
    """A steady change per 30 days."""

    arm: str
    quantity: str
    per_month: float
    sigma: float


class FleetDocument(Document, frozen=True):
    """What a fleet's nights say."""

    arms: tuple[str, ...]
    first_day: str
    bound_sigmas: float
    alarms: tuple[AlarmDocument, ...]
    last: tuple[NightDocument, ...]
    scatter: tuple[ScatterDocument, ...]
    drifts: tuple[DriftDocument, ...]
    odd: tuple[OddDocument, ...]
    refused: tuple[RefusedDocument, ...]


def fleet_document(fleet: Fleet, refused: Mapping[str, str]) -> FleetDocument:
    """What ``dynident fleet report --json`` writes."""
    relative = {(one.arm, one.quantity): one.relative for one in fleet.series}
    usual = {(one.arm, one.quantity): one.usual for one in fleet.series}
    return FleetDocument(
        arms=tuple(arm.name for arm in fleet.arms),
        first_day=fleet.first,
        bound_sigmas=fleet.bound,
        alarms=tuple(AlarmDocument(*alarm, relative[alarm.arm, alarm.quantity]) for alarm in fleet.alarms),
        last=tuple(
            NightDocument(arm.name, name, arm.nights[-1].day, *number, usual[arm.name, name])
            for arm in fleet.arms
            for name, number in arm.nights[-1].numbers.items()
        ),
        scatter=tuple(ScatterDocument.of(scatter, quantity=name) for name, scatter in fleet.scatter.items()),
        drifts=tuple(DriftDocument(*drift) for drift in fleet.drifts),
        odd=tuple(OddDocument(*odd) for odd in fleet.twins.odd) if fleet.twins is not None else (),
        refused=tuple(RefusedDocument(file, reason) for file, reason in sorted(refused.items())),
    )
