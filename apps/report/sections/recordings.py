"""Recordings: a look at one, at two around a payload's entry, at several side by side, and at a fleet's."""

import math
import re
from collections.abc import Sequence
from datetime import datetime, timedelta
from functools import partial
from itertools import islice, product
from pathlib import Path, PurePath

import numpy as np

from ....estimation.diagnosis.kinematics import PoseCheck, Readings
from ....model import Pose, Robot
from ...fleet.comparing import CHANCE, CHANGED, FEWEST, Arm, Compared, Drift, Fleet, farness
from ...fleet.reduction import Log, ReducedDocument
from ...logs.log_check import FollowingChange, LogReport, RobotFits
from ...numbers import joined, percent
from ..blocks import Block, Drawing, Notes, OnPage, Report, Section, Table, Text
from ..documents import Look
from ..figures import BLUE, GREY, ORANGE, panels, signals
from .robot import robot_description

_MARKS = {"error": "ERROR", "warning": "warning", "note": "note"}
_UNEVEN = 0.05  # of the mean time step: larger deviations are jitter
_MOST = 12  # columns that are listed
_SHOWN = 6  # readings that do as well which the screen names
_RANKED = 20
_LEVELS = {"fell": "use", "rose": "do_not_use", "no clear change": "mass_and_com_only"}  # the banner's colour
_MEANING = {
    "fell": "the payload entered helps",
    "rose": "the payload entered makes it worse: check the unit, frame and sign of what you entered",
    "no clear change": "the change is too small, compared with its uncertainty, to say whether it helps",
}
_UNITS = {"following error": ("mrad", 1e3), "unpredicted torque": ("N·m", 1.0), "torque": ("N·m", 1.0)}
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


def log_report(check: LogReport) -> Report:
    """Reading of a log, motion of its joints and findings; then steps of the signals and excitation."""
    (robot, recording), time = check.working, check.time
    kind, load, unit = "torques [N·m or N]", "torque", "N·m"
    if check.currents:
        kind, load, unit = "currents [A] of unknown gain", "current", "A"
    speeds = "measured speeds" if recording.qd is not None else "speeds computed from the positions"
    reading = [f"{recording.source}: joint positions [rad or m], {kind}, {speeds}"]
    if time is not None:
        even = max(time.steps[1] - 1.0 / time.rate, 1.0 / time.rate - time.steps[0]) < _UNEVEN / time.rate
        spacing = "even" if even else f"steps {1e3 * time.steps[0]:.3g} to {1e3 * time.steps[1]:.3g} ms"
        moving = f"moves from {time.moving[0]:.4g} to {time.moving[1]:.4g} s" if time.moving else "never moves"
        rate = f"{time.rate:.5g} Hz ({spacing}, jitter {100 * time.jitter:.1f} %)"
        reading.append(f"{time.samples} samples, {time.duration:.4g} s at {rate}; {moving}")
    if check.relative_residual is not None:
        reading.append(
            f"The robot's model leaves {100 * check.relative_residual:.2f} % of the torque unexplained; condition "
            f"number (columns scaled) {check.condition_number_scaled:.3g}"
        )
    worst = [one.text for one in check.findings if one.severity != "note"]
    found = [f"{_MARKS[one.severity]}: {one.text}" for one in check.findings if one.text not in worst[:1]]
    good = f"Good: nothing {'needs fixing' if check.findings else 'looks wrong'}."
    motion, steps = list[tuple[str, ...]](), list[tuple[str, ...]]()
    for j, (joint, facts) in enumerate(zip(robot.joints, check.joints, strict=False), 1):
        ratio = f"{100 * facts.speed / joint.limits.speed:.0f} %" if np.isfinite(joint.limits.speed) else ""
        position, torque = "{:.3f} to {:.3f}".format(*facts.position), "{:.4g} to {:.4g}".format(*facts.torque)
        motion.append((str(j), "yes" if facts.moves else "no", position, f"{facts.speed:.3g}", ratio, torque))
        sizes = (f"{step:.2g}" if step > 0.0 else "" for step in (facts.position_step, facts.torque_step))
        steps.append((str(j), *sizes, f"{100 * facts.saturated:.2f} %"))
    sigma = [(str(row.name), f"{row.relative_sigma_percent:.3g} %") for row in check.excitation]
    tables = (
        Table("Resolution of the signals", ("joint", "position", load, f"{load} at its extreme"), steps),
        Table("Excitation: each base parameter from this log", ("", "relative sigma"), sigma),
    )
    moved = Table("", ("joint", "moves", "position", "speed", "of limit", f"{load} {unit}"), motion)
    mend = Notes([f"Fix first: {worst[0]}." if worst else good])
    first: list[Block] = [Notes(reading), *([moved] if motion else []), Notes(found, optional=True), mend]
    sections = [Section("signals", "Signals", [table for table in tables if table.rows])]
    return Report(check.source, first, sections, "resolution of the signals, excitation of each parameter")


def fits_report(fits: RobotFits) -> Report:
    """The shipped robots that a log can be of; without one, its columns and what to mend first."""
    if fits.fault:
        more = len(fits.columns) - _MOST
        shown = ", ".join(fits.columns[:_MOST]) + (f" and {more} more" if more > 0 else "")
        return Report(fits.source, [Notes([f"{fits.source}: columns {shown}", f"Fix first: {fits.fault}"])])
    left = {fit.robot: "" if fit.residual is None else f" ({percent(fit.residual)})" for fit in fits.fitting}
    fitting, beyond = ", ".join(map("".join, left.items())), "(positions, speeds or torques exceed their limits)"
    told = (
        f"{fits.source}: no --robot given. Possible robots (with the torque left unexplained): {fitting}",
        f"Impossible: {', '.join(fits.others)} {beyond}" if fits.others else "",
        f"Checked as {fits.fitting[0].robot}; use --robot to name the right one:",
    )
    return Report(fits.source, [Notes(told)])


def check_report(looks: Sequence[Look]) -> Report:
    """Verdict on the logs, then each with its signals."""

    def draw(number: int, check: LogReport) -> list[Block]:
        (_, recording), loads = check.working, "currents [A]" if check.currents else "torques [N·m]"
        stem = re.sub(r"\W+", "_", check.source.replace("\\", "/").rstrip("/").rsplit("/", 1)[-1].split(".")[0])
        title, load = Path(recording.source).name, loads.split()[0]
        columns = {"positions [rad or m]": ({"": recording.q}, ()), loads: ({"": recording.torque}, ())}
        caption = f"Positions and {load} of {title} as they were understood, joint side."
        return [Drawing(f"{number:02d}_{stem}", caption, signals(recording.t, columns, title))]

    sections, unusable = list[Section](), list[str]()
    for number, (check, fits) in enumerate(looks, 1):
        reports = [*([fits_report(fits)] if fits else []), *([log_report(check)] if check else [])]
        path = reports[-1].title
        blocks = [block for report in reports for block in report.first]
        blocks += [block for report in reports for section in report.sections for block in section.blocks]
        if check:
            blocks.append(OnPage(partial(draw, number, check)))
        sections.append(Section(f"log_{number}", path, blocks))
        unusable += [] if check and check.usable else [path]
    text = f"Fix first: {', '.join(unusable)}." if unusable else "These logs can be used."
    return Report("A look at recordings", [Text(text, level="do_not_use" if unusable else "use")], sections)


def readings_report(robot: Robot, poses: Sequence[PoseCheck], readings: Readings | None) -> Report:
    """Verdict on a robot's description by tool poses and torques; every reading; the description."""

    def words(pose: Pose, axes: bool = True) -> str:
        turn = joined((math.degrees(angle) + 0.0 for angle in pose.rpy), ".2f")
        return f"({joined(pose.origin, '.4f')}) m{f', rpy ({turn}) deg' if axes else ', axes not logged'}"

    told, tables = list[str](), list[Block]()
    for check, ranked in [*((check, check.readings) for check in poses), (None, readings)]:
        if check:
            axes = "" if check.rms_angle is None else f", orientation {math.degrees(check.rms_angle):.3g} deg"
            verb = "reproduces" if check.reproduced else "does NOT reproduce"
            told += [
                f"{check.source}: forward kinematics {verb} the tool pose of {check.samples} samples: rms "
                f"{1e3 * check.rms:.3g} mm, at most {1e3 * check.largest:.3g} mm{axes}",
                f"  with base and tool at the origin {1e3 * check.as_is:.4g} mm; best-fitting base and tool:",
                f"  base of the robot in the log's frame: {words(check.base)}",
                f"  tool in the payload's frame: {words(check.tool, check.rms_angle is not None)}",
            ]
            if not check.determined:
                told.append("  The motion does not determine base and tool: these are one choice of many.")
            if check.wrong_unit:
                times = f"{check.scale:.3g} times as far as the flange"
                told.append(f"  The tool moves {times}: positions in {check.wrong_unit}?")
        elif not ranked:
            told.append("No torques or currents in the log: only the pose was compared.")
        if not ranked:
            continue
        residuals, best = ranked.residuals, ranked.suggested
        told.append(f"Residual: {ranked.as_recorded:.4g} ({ranked.unit}); {len(residuals)} other readings tried.")
        if best is None:
            told.append("No other order, sign or zero of the joints fits clearly better.")
        else:
            told.append(f"Suggested, not applied: {best.described()} (residual {residuals[best]:.4g}).")
            told.append("Check it at the robot, then change the log's columns or the robot's file.")
            for j, along in enumerate(best.along, 1):
                if along:
                    coupling = f"coupling = [{{ motor = {j}, joint = {j - 1}, ratio = {-along} }}]"
                    sides = 'side = "motor" of position and velocity'
                    told.append(f"In a log map: {sides}, all gear_ratios 1, {coupling}.")
        if others := [reading for reading in ranked.alike if reading.changes][:_SHOWN]:
            told.append("These fit equally well; the recording cannot tell them apart:")
            told += [f"  {residuals[reading]:.4g}  {reading.described()}" for reading in others]
        rows = [(one.described(), f"{left:.4g}") for one, left in islice(residuals.items(), _RANKED)]
        title = f"By {check.source if check else 'torques'}: the best of {len(residuals)} readings"
        tables.append(Table(title, ("reading", f"residual, {ranked.unit}"), rows))
    faithful = readings_agree(poses, readings)
    text = "agrees with the recordings" if faithful else "does NOT agree with the recordings as they are read"
    banner = Text(f"The robot's description {text}.", level="use" if faithful else "do_not_use")
    sections = [
        Section("readings", "Readings of the joint columns, best first", tables),
        Section("robot", "The robot as described", [OnPage(lambda: robot_description(robot))]),
    ]
    more = "the readings, best first" if tables else ""
    first: list[Block] = [banner, Notes(told, optional=True)]
    return Report(f"Kinematics of the {robot.title or robot.name}", first, sections, more)


def readings_agree(poses: Sequence[PoseCheck], readings: Readings | None) -> bool:
    """Tell whether every tool pose is reproduced and no other reading of the columns does clearly better."""
    return all(check.reproduced for check in poses) and not (readings and readings.suggested)


def following_report(change: FollowingChange, robot: Robot) -> Report:
    """Change of each joint's error when a payload was entered, and how both recordings were compared."""
    (unit, scale), total, joints = _UNITS[change.kind], change.total, (*change.joints, change.total)
    rows = []
    for joint in joints:
        before, after = (f"{scale * x:.3g}" for x in (joint.before, joint.after))
        low, high = (f"{100 * x:.1f}" for x in joint.interval)
        rows.append((joint.name, before, after, f"{100 * joint.fall:.1f}", f"{low} to {high}", joint.clear))
    title = f"Root mean square of the {change.kind} [{unit}; mm or N where a joint slides]"
    least, most = (100 * x for x in total.interval)
    level = _LEVELS[total.clear] if change.tells else "mass_and_com_only"
    direction, others = "fell" if total.fall >= 0.0 else "rose", list[str]()
    amount = f"{direction} by {100 * abs(total.fall):.1f} % (by {least:.1f} to {most:.1f} %)"
    text = f"The {change.kind} {amount}: {_MEANING[total.clear]}."
    if change.kind == "torque":
        text = (
            "The logs have neither qref1.. (commanded positions) nor tauref1.. (torque the controller expects), so "
            "only the torque itself was compared. That says nothing about the payload entered, because the same "
            "motion needs the same torque. Log one of them to verify."
        )
        others = [f"Torque changed by {-100 * total.fall:+.1f} % ({-most:+.1f} to {-least:+.1f} %)."]
    table = Table(title, ("", "before", "after", "fell by %", "95 % interval", "change"), rows)
    compared = [
        f"The second recording is shifted by {1e3 * change.lag:+.3g} ms, so that samples at the same point of the "
        "motion are compared.",
        "The 95 % intervals come from leaving out blocks of 1 s one at a time; a change is clear if its interval "
        "excludes 0.",
    ]

    def draw() -> list[Block]:
        (figure, ((axis,),)), places = panels((6.4, 3.2)), np.arange(len(joints))
        before, after = (scale * np.array([getattr(row, when) for row in joints]) for when in ("before", "after"))
        # The interval is that of the share by which it fell.
        ends = before * (1.0 - np.array([row.interval for row in joints])).T
        reach = np.nan_to_num(np.maximum([after - ends[1], ends[0] - after], 0.0))
        axis.bar(places - 0.2, before, 0.38, color=GREY, label="before")
        axis.bar(places + 0.2, after, 0.38, color=BLUE, hatch="//", label="after", yerr=reach, capsize=3)
        axis.set_xticks(places, [row.name for row in joints])
        axis.set_ylabel(f"root mean square [{unit}]")
        axis.legend(fontsize=9, frameon=False)
        caption = (
            f"Root mean square of the {change.kind} before and after the number was entered, with 95 % intervals."
        )
        return [Drawing("following", caption, figure)]

    sections = [Section("joints", "Joint by joint", [OnPage(draw), Notes(compared)])]
    first: list[Block] = [Text(text, level=level), Notes(others), table]
    name, more = robot.title or robot.name, "how both recordings were compared"
    return Report(f"Before and after a payload was entered: {name}", first, sections, more)


def reduced_report(reduced: ReducedDocument) -> Report:
    """Count the recordings in the store, and list what was refused, and why."""
    total, refused = reduced.new + reduced.known, reduced.refused
    told = [
        f"{total} recordings in {reduced.store}: {reduced.new} new, {reduced.known} already there.",
        f"{len(refused)} logs refused{':' if refused else '.'}",
    ]
    names = Notes([f"{PurePath(log.file).name}: {log.reason}" for log in refused], optional=True)
    return Report("The store", [Notes(told), names], _refused(refused), "all that was refused")


def _refused(logs: Sequence[Log]) -> list[Section]:
    table = Table("Refused", ("log", "why"), [(log.file, log.reason) for log in logs])
    return [Section("refused", "Logs that were refused", [table])] if logs else []


def fleet_report(fleet: Fleet) -> Report:
    """Changes of the last night, the clearest first; then a line an arm, and small multiples."""
    (arms, twins), refused = fleet.working, fleet.refused
    few = [arm.name for arm in arms if len(arm.days) <= FEWEST]
    notes = (
        f"Too few nights to tell a change yet: {', '.join(few[:6])}{' and more' * (len(few) > 6)}." if few else "",
        f"{len(refused)} logs were refused; see logs.parquet of the store." if refused else "",
    )
    rows = []
    for line in fleet.changed:
        change = float(line.working.changes[-1])
        amount = f"{change:+.3g} {'kg' if line.quantity == 'mass' else 'N·m or N'}"
        if line.working.relative or line.quantity.startswith("scale"):
            amount = f"{100.0 * change:+.1f} %"
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
    # Each arm by its drift: its last night, and the farthest z of friction, gains and payload.
    of_arms = []
    for arm in sorted(arms, key=lambda arm: -max(map(farness, arm.series))):
        gains = [line for line in arm.series if line.quantity.startswith("scale")]
        (mass,) = payload = [line for line in arm.series if line.quantity == "mass"]
        kinds = [[line for line in arm.series if line.working.relative], gains, payload]
        drift = [
            f"{line.quantity.removeprefix('scale ').removeprefix('mass')} {line.z:+.1f}".strip() if line.z else "-"
            for line in (max(kind, key=farness) for kind in kinds)
        ]
        reported = f"{mass.value:+.2f}±{mass.sigma:.2g}"
        of_arms.append((arm.name, f"{len(arm.days)}", arm.days[-1], f"{arm.told[-1]:g}", reported, *drift))
    headings = ("arm", "nights", "last", "set [kg]", "minus set [kg]", "friction z", "gain z", "payload z")
    sections = [
        Section("arms", "Every arm", [Table("All arms, the largest drift first", headings, of_arms)]),
        Section("multiples", "Day by day", [OnPage(partial(_multiples, arms))]),
        *_refused(refused),
    ]
    nights, last = sum(len(arm.days) for arm in arms), max(arm.days[-1] for arm in arms)
    subtitle = f"{len(arms)} arms, {nights} recordings, {fleet.first_day} to {last}"
    return Report("The fleet", first, sections, "a line an arm", subtitle)


def _multiples(arms: Sequence[Arm]) -> list[Block]:
    """Small multiples of each quantity that is drawn, of some arms a figure."""
    blocks: list[Block] = [Text(_WORDS)]
    for (kind, name, text), start in product(_DRAWN, range(0, len(arms), _ARMS)):
        some = arms[start : start + _ARMS]
        rows = [[line for line in arm.series if line.quantity.startswith(kind)] for arm in some]
        columns = max(map(len, rows))
        size = (0.5 + 0.08 * max(len(arm.name) for arm in some) + 1.05 * columns, 0.55 + 0.48 * len(some))
        figure, axes = panels(size, len(some), columns, framed=True, sharex=True, sharey="col")
        for line, arm, row in zip(axes, some, rows, strict=True):
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
            line[0].set_ylabel(arm.name, rotation=0, ha="right", va="center", fontsize=8)
        for axis, series in zip(axes[0], rows[0], strict=False):
            axis.set_title(series.quantity, fontsize=8)
        caption = (
            f"{text}: a line an arm, a panel a quantity, day by day, less the median of the nights before the "
            "last. The band is what varies anyway (2 sigma); orange is a change."
        )
        blocks.append(Drawing(f"{name}_{start // _ARMS + 1}", caption, figure))
    return blocks


def compared_report(compared: Compared) -> Report:
    """The parameters in which recordings differ most; then all of them."""
    odd = [
        f"{PurePath(each.recording).name} is the odd one in {each.parameter}: {each.sigmas:+.1f} sigma from the "
        "others."
        for each in compared.odd
    ]
    nothing = f"No recording differs from the others beyond {compared.bound:.1f} sigma (chance {CHANCE:g})."
    shown = compared.recordings if len(compared.recordings) <= _LINES else ()
    labels = [PurePath(source.split(", ")[0]).name.split(".")[0][-12:] for source in shown]
    rows = []
    for k, name in enumerate(compared.parameters):
        low, high = compared.pooled_interval95[k]
        own, spread = np.sqrt(np.mean(compared.sigma[:, k] ** 2)), np.std(compared.values[:, k], ddof=1)
        values = [f"{compared.values[i, k]:.4g}" for i in range(len(shown))]
        pooled = (f"{compared.pooled[k]:.4g}", f"{low:.4g} to {high:.4g}")
        rows.append((name, *values, f"{spread:.2g}", f"{own:.2g}", *pooled))
    headings = ["parameter", *labels, "spread", "own sigma", "pooled", "95 % interval"]
    most = sorted(np.argsort(-compared.scatter, kind="stable")[:_MOST_SHOWN].tolist())
    apart = Table("Where the recordings differ most (SI units)", headings, [rows[k] for k in most])
    section = Section("all", "All parameters", [Table("All parameters", headings, rows)])
    first: list[Block] = [apart, Notes(odd or [nothing], optional=True)]
    return Report("Recordings side by side", first, [section], "all parameters")
