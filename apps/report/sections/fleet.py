"""What became of a fleet's recordings, and what its nights say."""

from collections.abc import Mapping
from pathlib import PurePath

import numpy as np

from ...fleet import Fleet
from ...fleet.alarms import Alarm
from ...fleet.comparing import CHANCE
from ...fleet.identity import Exchange
from ...fleet.reduction import Reduced
from ...fleet.series import FEWEST, LAST, Series
from ..blocks import Banner, Block, Notes, Page, Remarks, Screen, Section, Table, Text, columns
from ..figures.fleet import fleet_figures
from ..provenance import Provenance
from .data import report_page

_STEADY = 4.0
"""Sigmas from which a drift is listed."""


def reduced_screen(reduced: Reduced) -> Screen:
    """How many are in the store; what was refused, and why."""
    total, refused = reduced.new + reduced.known, sorted(reduced.refused.items())
    lines = [
        f"{total} recordings in {reduced.store.root}: {reduced.new} reduced now, {reduced.known} there before.",
        f"{len(refused)} logs refused{':' if refused else '.'}",
    ]
    first: list[Block] = [Notes(lines), Remarks([f"{PurePath(file).name}: {reason}" for file, reason in refused])]
    details: list[Block] = [Table("Refused", columns(("log",), (), ("why",)), refused)] if refused else []
    return Screen(first, details, "all that was refused")


def fleet_screen(fleet: Fleet, refused: Mapping[str, str]) -> Screen:
    """What changed, the new ones first; then a line an arm."""
    first: list[Block] = [Notes(_head(fleet, refused))]
    if fleet.alarms:
        first.append(_alarms(fleet))
    first.append(Remarks(_twins(fleet)))
    return Screen(
        first, [_arms(fleet), _scatter(fleet), *_drifts(fleet)], "a line an arm, what varies anyway, drifts"
    )


def fleet_page(fleet: Fleet, refused: Mapping[str, str], provenance: Provenance) -> Page:
    """The report of a fleet: what changed since yesterday on top, a line an arm, small multiples."""
    robot, nights = len(fleet.arms), sum(len(arm.nights) for arm in fleet.arms)
    last = max(night.day for arm in fleet.arms for night in arm.nights)
    fresh = [alarm for alarm in fleet.alarms if alarm.new]
    level = "do_not_use" if fresh else "mass_and_com_only" if fleet.alarms else "use"
    lead: list[Block] = [Banner(level, _headline(fleet)), Notes(_head(fleet, refused))]
    if fleet.alarms:
        lead.append(_alarms(fleet))
    drawings: list[Block] = [
        *fleet_figures(fleet, "FS", "coulomb", "Coulomb friction"),
        *fleet_figures(fleet, "FV", "viscous", "Viscous friction"),
        *fleet_figures(fleet, "mass", "mass", "Payload less what the controller was told"),
        *fleet_figures(fleet, "scale", "scale", "Scale of each drive's torque"),
    ]
    bad: list[Block] = [Table("", columns(("log",), (), ("why",)), sorted(refused.items()), style="plain")]
    sections = [
        Section("arms", "Every arm", [_arms(fleet)]),
        Section("multiples", "Day by day", drawings),
        Section("twins", "Twins", [Notes(_twins(fleet))]),
        Section("usual", "What varies anyway", [Text(_words(fleet)), _scatter(fleet), *_drifts(fleet)]),
        *([Section("refused", "Logs that were refused", bad)] if refused else []),
    ]
    subtitle = f"{robot} arms, {nights} recordings, {fleet.first} to {last}"
    return report_page("The fleet", subtitle, lead, sections, [], provenance)


def _headline(fleet: Fleet) -> str:
    fresh = sum(alarm.new for alarm in fleet.alarms)
    if fresh:
        return f"{fresh} of {len(fleet.alarms)} changes are new since yesterday"
    if fleet.alarms:
        return f"nothing new since yesterday; {len(fleet.alarms)} changes of the last {LAST} days"
    return "nothing changed"


def _head(fleet: Fleet, refused: Mapping[str, str]) -> list[str]:
    lines = [f"{len(fleet.arms)} arms: {_headline(fleet)}."]
    few = [arm.name for arm in fleet.arms if len(arm.nights) <= FEWEST]
    if few:
        lines.append(f"Too few nights for alarms yet: {', '.join(few[:6])}{' and more' if len(few) > 6 else ''}.")
    lines += [_exchanged(exchange) for exchange in fleet.exchanges]
    if refused:
        lines.append(f"{len(refused)} logs were refused; see refused.csv.")
    return lines


def _exchanged(exchange: Exchange) -> str:
    """What is said of recordings of another robot."""
    which = f"the recording of {exchange.day} is" if exchange.alone else f"recordings since {exchange.day} are"
    like = f", perhaps {exchange.like}" if exchange.like else ""
    why = f"chi2 {exchange.chi2:.0f} of {exchange.degrees}, payload and drives apart"
    return f"{exchange.arm}: {which} of another robot{like} ({why}): check its name."


def _alarms(fleet: Fleet) -> Table:
    ordered = sorted(fleet.alarms, key=lambda alarm: (not alarm.new, -abs(alarm.sigmas)))
    rows = [
        (alarm.arm, meaning(alarm.quantity), "new" if alarm.new else "", _step(fleet, alarm),
         f"{alarm.sigmas:+.1f}", f"{_today(fleet, alarm.arm) - alarm.since + 1.0:.0f}")
        for alarm in ordered
    ]  # fmt: skip
    return Table("What changed", columns(("arm", "quantity", ""), ("by", "sigmas", "nights")), rows, style="tight")


def _today(fleet: Fleet, arm: str) -> float:
    return float(max(line.days[-1] for line in fleet.series if line.arm == arm))


def _step(fleet: Fleet, alarm: Alarm) -> str:
    series = next(line for line in fleet.series if (line.arm, line.quantity) == (alarm.arm, alarm.quantity))
    return _amount(series, alarm.step)


def _amount(series: Series, value: float) -> str:
    if series.relative or series.quantity.startswith("scale"):
        return f"{100.0 * value:+.1f} %"
    return f"{value:+.3g} {'kg' if series.quantity == 'mass' else 'N·m or N'}"


def meaning(quantity: str) -> str:
    """A quantity in words."""
    kind, number = quantity.rstrip("0123456789").strip(), quantity[len(quantity.rstrip("0123456789")) :]
    words = {
        "FS": "Coulomb friction",
        "FV": "viscous friction",
        "FSM": "Coulomb friction of motor",
        "FVM": "viscous friction of motor",
        "OFF": "constant torque",
        "scale": "torque scale",
        "mass": "payload less what was told",
    }
    return f"{words[kind]} {number}".strip()


def _arms(fleet: Fleet) -> Table:
    """A line an arm: its last night, payload, and the friction that is farthest from usual."""
    rows = []
    for arm in fleet.arms:
        night = arm.nights[-1]
        own_series = [line for line in fleet.series if line.arm == arm.name and line.relative]
        farthest = max(own_series, key=lambda line: abs(line.values[-1]) / max(float(line.sigma[-1]), 1e-12))
        count = sum(alarm.arm == arm.name for alarm in fleet.alarms)
        mass = night.numbers["mass"]
        rows.append(
            (arm.name, f"{len(arm.nights)}", night.day, f"{night.told:g}", f"{mass.value:+.2f}±{mass.sigma:.2g}",
             farthest.quantity, _amount(farthest, float(farthest.values[-1])), str(count or ""))
        )  # fmt: skip
    headings = ("nights", "last", "told [kg]", "less told [kg]", "friction", "by", "alarms")
    return Table("Every arm", columns(("arm",), headings), rows, style="tight")


def _words(fleet: Fleet) -> str:
    return (
        f"A step on one of the last {LAST} days is an alarm beyond the quantity's bound: of {len(fleet.series)} "
        "series together one alarm a month (or as --false-alarms says) where nothing changed and scatter is normal."
        " Sigma holds each night's own error and the scatter from day to day with its memory, measured by medians "
        "over all arms."
    )


def _scatter(fleet: Fleet) -> Table:
    rows = []
    for name, scatter in fleet.scatter.items():
        unit = 100.0 if next(line.relative for line in fleet.series if line.quantity == name) else 1.0
        slope = f"{unit * scatter.per_kelvin:+.2g}±{unit * scatter.per_kelvin_sigma:.1g}"
        rows.append(
            (
                meaning(name),
                f"{unit * scatter.sigma:.2g}",
                f"{scatter.memory:.2f}",
                slope,
                f"{fleet.bounds[name]:.2f}",
            )
        )
    headings = ("scatter", "memory", "per K", "bound [sigma]")
    return Table("From day to day [% or unit]", columns(("quantity",), headings), rows, style="tight")


def _drifts(fleet: Fleet) -> list[Block]:
    steady = [drift for drift in fleet.drifts if abs(drift.per_month) > _STEADY * drift.sigma]
    steady.sort(key=lambda drift: -abs(drift.per_month / drift.sigma))
    by_name = {(line.arm, line.quantity): line for line in fleet.series}
    rows = [
        (drift.arm, meaning(drift.quantity), _amount(by_name[drift.arm, drift.quantity], drift.per_month),
         f"{drift.per_month / drift.sigma:+.1f}")
        for drift in steady
    ]  # fmt: skip
    headings = columns(("arm", "quantity"), ("in 30 days", "sigmas"))
    return [Table("Steady changes", headings, rows, style="tight")] if rows else []


def _twins(fleet: Fleet) -> list[str]:
    """Arms that differ from the others of their type in what is no friction."""
    twins = fleet.twins
    if twins is None:
        return ["Fewer than three arms: none can be told to be the odd one."]
    chi2 = np.sum(twins.apart**2, axis=1)
    odd = [
        f"{arm} differs from its twins in {name} by {sigmas:+.1f} sigma (chi2 of all {len(twins.names)} "
        f"parameters: {chi2[twins.sources.index(arm)]:.0f})."
        for arm, name, sigmas in twins.odd
    ]
    return odd or [f"No arm differs from its twins beyond {twins.bound:.1f} sigma (chance {CHANCE:g})."]
