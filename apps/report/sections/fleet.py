"""A fleet's recordings and nights, and recordings of one robot side by side."""

from collections.abc import Mapping
from pathlib import PurePath

import numpy as np

from ...fleet import Fleet
from ...fleet.comparing import CHANCE, Compared
from ...fleet.nights import CHANGED, FEWEST, Series
from ...fleet.reduction import ReducedDocument
from ..blocks import Banner, Block, Notes, Page, Screen, Section, Table, Text, columns
from ..figures.fleet import fleet_figures
from ..provenance import Provenance, report_page

_WORDS = (
    "z is the last night's value less the median of the nights before, over their spread (1.4826 median absolute "
    f"deviations) and the night's own error together; beyond {CHANGED:g} it is a change. {FEWEST} nights must come "
    "before. Friction also follows the temperature, which is part of the spread."
)

_MOST_SHOWN = 10
"""Parameters on the first screen."""
_LINES = 12
"""Recordings that have a column of their own."""


def reduced_screen(reduced: ReducedDocument) -> Screen:
    """Count the recordings in the store, and list what was refused, and why."""
    total, refused = reduced.new + reduced.known, [(bad.file, bad.reason) for bad in reduced.refused]
    lines = [
        f"{total} recordings in {reduced.store}: {reduced.new} reduced now, {reduced.known} there before.",
        f"{len(refused)} logs refused{':' if refused else '.'}",
    ]
    first: list[Block] = [
        Notes(lines),
        Notes([f"{PurePath(file).name}: {reason}" for file, reason in refused], optional=True),
    ]
    details: list[Block] = [Table("Refused", columns(("log",), (), ("why",)), refused)] if refused else []
    return Screen(first, details, "all that was refused")


def fleet_screen(fleet: Fleet, refused: Mapping[str, str]) -> Screen:
    """List the changes, the clearest first; then a line an arm."""
    first: list[Block] = [Notes(_head(fleet, refused))]
    if fleet.changed:
        first.append(_changed(fleet))
    first.append(Notes(_twins(fleet), optional=True))
    return Screen(first, [_arms(fleet)], "a line an arm")


def fleet_page(fleet: Fleet, refused: Mapping[str, str], provenance: Provenance) -> Page:
    """The report of a fleet: what changed last night on top, a line an arm, small multiples."""
    robot, nights = len(fleet.arms), sum(len(arm.days) for arm in fleet.arms)
    last = max(arm.days[-1] for arm in fleet.arms)
    banner = Banner("do_not_use" if fleet.changed else "use", _headline(fleet))
    lead: list[Block] = [banner, Notes(_head(fleet, refused))]
    if fleet.changed:
        lead.append(_changed(fleet))
    drawings: list[Block] = [
        *fleet_figures(fleet, "FS", "coulomb", "Coulomb friction"),
        *fleet_figures(fleet, "FV", "viscous", "Viscous friction"),
        *fleet_figures(fleet, "mass", "mass", "Payload less what the controller was told"),
        *fleet_figures(fleet, "scale", "scale", "Scale of each drive's torque"),
    ]
    bad: list[Block] = [Table("", columns(("log",), (), ("why",)), sorted(refused.items()), style="plain")]
    sections = [
        Section("arms", "Every arm", [_arms(fleet)]),
        Section("multiples", "Day by day", [Text(_WORDS), *drawings]),
        Section("twins", "Twins", [Notes(_twins(fleet))]),
        *([Section("refused", "Logs that were refused", bad)] if refused else []),
    ]
    subtitle = f"{robot} arms, {nights} recordings, {fleet.first} to {last}"
    return report_page("The fleet", subtitle, lead, sections, [], provenance)


def _headline(fleet: Fleet) -> str:
    return f"{len(fleet.changed)} changes last night" if fleet.changed else "nothing changed last night"


def _head(fleet: Fleet, refused: Mapping[str, str]) -> list[str]:
    lines = [f"{len(fleet.arms)} arms: {_headline(fleet)}."]
    few = [arm.name for arm in fleet.arms if len(arm.days) <= FEWEST]
    if few:
        lines.append(
            f"Too few nights to tell a change yet: {', '.join(few[:6])}{' and more' if len(few) > 6 else ''}."
        )
    if refused:
        lines.append(f"{len(refused)} logs were refused; see logs.parquet of the store.")
    return lines


def _changed(fleet: Fleet) -> Table:
    rows = [
        (line.arm, meaning(line.quantity), _amount(line), f"{line.z:+.1f}",
         f"{len(line.values) - 1}")
        for line in fleet.changed
    ]  # fmt: skip
    return Table("What changed", columns(("arm", "quantity"), ("by", "z", "nights before")), rows, style="tight")


def _amount(series: Series) -> str:
    value = float(series.changes[-1])
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
    """A line an arm, by its drift: its last night, and the farthest z of friction, gains and payload."""
    rows = []
    for arm in sorted(fleet.arms, key=lambda arm: -max(abs(line.z or 0.0) for line in arm.series)):
        gains = [line for line in arm.series if line.quantity.startswith("scale")]
        (mass,) = payload = [line for line in arm.series if line.quantity == "mass"]
        kinds = [[line for line in arm.series if line.relative], gains, payload]
        farthest = [max(kind, key=lambda line: abs(line.z or 0.0)) for kind in kinds]
        drift = [
            f"{line.quantity.removeprefix('scale ').removeprefix('mass')} {line.z:+.1f}".strip() if line.z else "-"
            for line in farthest
        ]
        told = f"{mass.values[-1]:+.2f}±{mass.sigma[-1]:.2g}"
        rows.append((arm.name, f"{len(arm.days)}", arm.days[-1], f"{arm.told[-1]:g}", told, *drift))
    headings = ("nights", "last", "told [kg]", "less told [kg]", "friction z", "gain z", "payload z")
    return Table("Every arm, by its drift", columns(("arm",), headings), rows, style="tight")


def _twins(fleet: Fleet) -> list[str]:
    """Arms that differ from the others of their type in what is no friction."""
    twins = fleet.twins
    if twins is None:
        return ["Fewer than three arms: none can be told to be the odd one."]
    chi2 = np.sum(twins.apart**2, axis=1)
    lines = [
        f"{odd.recording} differs from its twins in {odd.parameter} by {odd.sigmas:+.1f} sigma (chi2 of all "
        f"{len(twins.parameters)} parameters: {chi2[twins.recordings.index(odd.recording)]:.0f})."
        for odd in twins.odd
    ]
    return lines or [f"No arm differs from its twins beyond {twins.bound:.1f} sigma (chance {CHANCE:g})."]


def compared_screen(compared: Compared) -> Screen:
    """The parameters in which recordings differ most; then all of them."""
    order = np.argsort(-compared.scatter, kind="stable")
    details: list[Block] = [_compared_table(compared, "All parameters", range(len(compared.parameters)))]
    first: list[Block] = [
        _compared_table(
            compared, "Where the recordings differ most (SI units)", sorted(order[:_MOST_SHOWN].tolist())
        ),
        Notes(odd_lines(compared), optional=True),
    ]
    return Screen(first, details, "all parameters")


def odd_lines(compared: Compared) -> list[str]:
    """Name the recordings that are odd, and the parameters in which they are."""
    odd = compared.odd
    if not odd:
        return [f"No recording differs from the others beyond {compared.bound:.1f} sigma (chance {CHANCE:g})."]
    return [
        f"{PurePath(one.recording).name} is the odd one in {one.parameter}: {one.sigmas:+.1f} sigma from the "
        "others."
        for one in odd
    ]


def _compared_table(compared: Compared, title: str, chosen: "range | list[int]") -> Table:
    shown = compared.recordings if len(compared.recordings) <= _LINES else ()
    labels = [_short(source) for source in shown]
    rows = []
    for k in chosen:
        low, high = compared.pooled_interval95[k]
        own = float(np.sqrt(np.mean(compared.sigma[:, k] ** 2)))
        spread = float(np.std(compared.values[:, k], ddof=1))
        values = [f"{compared.values[i, k]:.4g}" for i in range(len(shown))]
        rows.append(
            (compared.parameters[k], *values, f"{spread:.2g}", f"{own:.2g}", f"{compared.pooled[k]:.4g}",
             f"{low:.4g}", f"{high:.4g}")
        )  # fmt: skip
    headings = [*labels, "spread", "own sigma", "pooled", "95 % from", "to"]
    return Table(title, columns(("parameter",), headings), rows, style="tight")


def _short(source: str) -> str:
    return PurePath(source.split(", ")[0]).name.split(".")[0][-12:]
