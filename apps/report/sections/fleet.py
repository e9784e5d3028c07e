"""A fleet's recordings and nights, and recordings of one robot side by side."""

from collections.abc import Sequence
from datetime import datetime, timedelta
from functools import partial
from pathlib import PurePath

import numpy as np

from ...fleet.comparing import CHANCE, CHANGED, FEWEST, Arm, Compared, Drift, Fleet, farness
from ...fleet.reduction import ReducedDocument
from ...fleet.store import Log
from ..blocks import Block, Drawing, Notes, OnPage, Report, Section, Table, Text, lines
from ..figures import BLUE, GREY, ORANGE, Figure, panels

_WORDS = (
    "z is the last night's value minus the median of the nights before, divided by their spread (1.4826 median "
    f"absolute deviations) and that night's own error combined. Beyond {CHANGED:g} it counts as a change; {FEWEST} "
    "earlier nights are needed. Friction also follows temperature, which is part of the spread."
)
_QUANTITIES = {
    "FS": "Coulomb friction",
    "FV": "viscous friction",
    "FSM": "Coulomb friction of motor",
    "FVM": "viscous friction of motor",
    "OFF": "constant torque",
    "scale": "torque scale",
    "mass": "payload minus set value",
}
_DRAWN = (
    ("FS", "coulomb", "Coulomb friction"),
    ("FV", "viscous", "Viscous friction"),
    ("mass", "mass", "Payload minus the value set in the controller"),
    ("scale", "scale", "Scale of each drive's torque"),
)
"""Beginning of the quantities' names, name of the drawing, and its caption."""
_ARMS = 20  # in one drawing
_MOST_SHOWN = 10  # parameters on the first screen
_LINES = 12  # recordings that have a column of their own


def reduced_report(reduced: ReducedDocument) -> Report:
    """Count the recordings in the store, and list what was refused, and why."""
    total, refused = reduced.new + reduced.known, reduced.refused
    told = [
        f"{total} recordings in {reduced.store}: {reduced.new} new, {reduced.known} already there.",
        f"{len(refused)} logs refused{':' if refused else '.'}",
    ]
    first: list[Block] = [
        Notes(told),
        Notes([f"{PurePath(log.file).name}: {log.reason}" for log in refused], optional=True),
    ]
    return Report("The store", first, _refused(refused), "all that was refused")


def _refused(logs: Sequence[Log]) -> list[Section]:
    table = Table("Refused", ("log", "why"), [(log.file, log.reason) for log in logs])
    return [Section("refused", "Logs that were refused", [table])] if logs else []


def fleet_report(fleet: Fleet) -> Report:
    """Changes of the last night, the clearest first; then a line an arm, and small multiples."""
    arms: Sequence[Arm]
    twins: Compared | None
    (arms, twins), refused = fleet.working, fleet.refused
    few = [arm.name for arm in arms if len(arm.days) <= FEWEST]
    more = " and more" if len(few) > 6 else ""
    notes = lines(
        f"Too few nights to tell a change yet: {', '.join(few[:6])}{more}." if few else "",
        f"{len(refused)} logs were refused; see logs.parquet of the store." if refused else "",
    )
    rows = []
    for line in fleet.changed:
        drift: Drift = line.working
        amount = f"{drift.changes[-1]:+.3g} {'kg' if line.quantity == 'mass' else 'N·m or N'}"
        if drift.relative or line.quantity.startswith("scale"):
            amount = f"{100.0 * float(drift.changes[-1]):+.1f} %"
        kind = line.quantity.rstrip("0123456789")
        meaning = f"{_QUANTITIES[kind.strip()]} {line.quantity[len(kind) :]}".strip()
        rows.append((line.arm, meaning, amount, f"{line.z:+.1f}", str(line.nights)))
    # Arms that differ from the others of their type in what is no friction.
    odd = ["With fewer than three arms, no odd one out can be named."]
    if twins is not None:
        chi2 = dict(zip(twins.recordings, np.sum(twins.apart**2, axis=1), strict=True))
        odd = [
            f"{each.recording} differs from its twins in {each.parameter} by {each.sigmas:+.1f} sigma (chi2 of all "
            f"{len(twins.parameters)} parameters: {chi2[each.recording]:.0f})."
            for each in twins.odd
        ] or [f"No arm differs from its twins beyond {twins.bound:.1f} sigma (chance {CHANCE:g})."]
    headline = f"{len(rows)} changes last night" if rows else "nothing changed last night"
    first: list[Block] = [
        Text(f"{len(arms)} arms: {headline}.", level="do_not_use" if rows else "use"),
        Notes(notes),
        *([Table("What changed", ("arm", "quantity", "by", "z", "nights before"), rows)] if rows else []),
        Notes(odd, optional=True),
    ]
    drawings = list[Drawing]()
    for kind, name, text in _DRAWN:
        caption = (
            f"{text}: a line an arm, a panel a quantity, day by day, less the median of the nights before the "
            "last. The band is what varies anyway (2 sigma); orange is a change."
        )
        for k, start in enumerate(range(0, len(arms), _ARMS), 1):
            drawings.append(Drawing(f"{name}_{k}", caption, partial(_multiples, arms[start : start + _ARMS], kind)))
    sections = [
        Section("arms", "Every arm", [_arms_table(arms)]),
        Section("multiples", "Day by day", [OnPage(lambda: [Text(_WORDS), *drawings])]),
        *_refused(refused),
    ]
    nights, last = sum(len(arm.days) for arm in arms), max(arm.days[-1] for arm in arms)
    subtitle = f"{len(arms)} arms, {nights} recordings, {fleet.first_day} to {last}"
    return Report("The fleet", first, sections, "a line an arm", subtitle)


def _arms_table(arms: Sequence[Arm]) -> Table:
    """A line an arm, by its drift: its last night, and the farthest z of friction, gains and payload."""
    rows = []
    for arm in sorted(arms, key=lambda arm: -max(map(farness, arm.series))):
        gains = [line for line in arm.series if line.quantity.startswith("scale")]
        (mass,) = payload = [line for line in arm.series if line.quantity == "mass"]
        kinds = [[line for line in arm.series if line.working.relative], gains, payload]
        drift = [
            f"{line.quantity.removeprefix('scale ').removeprefix('mass')} {line.z:+.1f}".strip() if line.z else "-"
            for line in (max(kind, key=farness) for kind in kinds)
        ]
        reported = f"{mass.value:+.2f}±{mass.sigma:.2g}"
        rows.append((arm.name, f"{len(arm.days)}", arm.days[-1], f"{arm.told[-1]:g}", reported, *drift))
    headings = ("arm", "nights", "last", "set [kg]", "minus set [kg]", "friction z", "gain z", "payload z")
    return Table("All arms, the largest drift first", headings, rows)


def _multiples(arms: Sequence[Arm], kind: str) -> Figure:
    rows = {arm.name: [line for line in arm.series if line.quantity.startswith(kind)] for arm in arms}
    columns = max(map(len, rows.values()))
    size = (0.5 + 0.08 * max(map(len, rows)) + 1.05 * columns, 0.55 + 0.48 * len(arms))
    figure, axes = panels(size, len(arms), columns, sharex=True, sharey="col")
    for line, (arm, row) in zip(axes, rows.items(), strict=True):
        for axis, series in zip(line, row, strict=False):
            drift: Drift = series.working
            unit = 100.0 if drift.relative else 1.0
            values, band = unit * drift.changes, 2.0 * unit * drift.spread
            dates = [datetime.fromisoformat(day).replace(tzinfo=None) for day in drift.days]
            days = [(date - datetime(2000, 1, 1)) / timedelta(days=1) for date in dates]
            axis.axhspan(-band, band, color="0.92", linewidth=0)
            axis.plot(days, values, color=GREY, linewidth=0.6)
            axis.plot(days, values, ".", color=BLUE, markersize=2)
            if farness(series) > CHANGED:
                axis.plot(days[-1:], values[-1:], "s", color=ORANGE, markersize=2.5)
            axis.set(xticks=[], yticks=[])
            axis.spines[:].set_visible(False)
        line[0].set_ylabel(arm, rotation=0, ha="right", va="center", fontsize=8)
    for axis, series in zip(axes[0], rows[arms[0].name], strict=False):
        axis.set_title(series.quantity, fontsize=8)
    return figure


def compared_report(compared: Compared) -> Report:
    """The parameters in which recordings differ most; then all of them."""
    odd = [
        f"{PurePath(each.recording).name} is the odd one in {each.parameter}: {each.sigmas:+.1f} sigma from the "
        "others."
        for each in compared.odd
    ]
    nothing = f"No recording differs from the others beyond {compared.bound:.1f} sigma (chance {CHANCE:g})."
    most = sorted(np.argsort(-compared.scatter, kind="stable")[:_MOST_SHOWN].tolist())
    first: list[Block] = [
        _compared_table(compared, "Where the recordings differ most (SI units)", most),
        Notes(odd or [nothing], optional=True),
    ]
    every = _compared_table(compared, "All parameters", range(len(compared.parameters)))
    return Report("Recordings side by side", first, [Section("all", "All parameters", [every])], "all parameters")


def _compared_table(compared: Compared, title: str, chosen: Sequence[int]) -> Table:
    shown = compared.recordings if len(compared.recordings) <= _LINES else ()
    labels = [PurePath(source.split(", ")[0]).name.split(".")[0][-12:] for source in shown]
    rows = []
    for k in chosen:
        low, high = compared.pooled_interval95[k]
        own, spread = np.sqrt(np.mean(compared.sigma[:, k] ** 2)), np.std(compared.values[:, k], ddof=1)
        values = [f"{compared.values[i, k]:.4g}" for i in range(len(shown))]
        pooled = (f"{compared.pooled[k]:.4g}", f"{low:.4g} to {high:.4g}")
        rows.append((compared.parameters[k], *values, f"{spread:.2g}", f"{own:.2g}", *pooled))
    headings = ["parameter", *labels, "spread", "own sigma", "pooled", "95 % interval"]
    return Table(title, headings, rows)
