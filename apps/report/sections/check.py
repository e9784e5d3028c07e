"""A look at recordings: at one log, at its joint columns beside the kinematics, at two around a payload's entry."""

import math
import re
from collections.abc import Sequence
from itertools import islice

import numpy as np

from ....estimation.diagnosis.kinematics import PoseCheck, Readings
from ....model import Pose, Robot
from ...logs.log_check import FollowingChange, LogReport, RobotFits
from ..blocks import Block, Drawing, Notes, OnPage, Report, Section, Table, Text
from ..documents import Look
from ..figures.canvas import BLUE, GREY, Figure, panels, plain
from ..figures.signals import signals_figure
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


def log_report(check: LogReport) -> Report:
    """Reading of a log, motion of its joints and findings; then steps of the signals and excitation."""
    (robot, recording), time = check.working, check.time
    kind = "currents [A] of unknown gain" if check.currents else "torques [N·m or N]"
    speeds = "measured speeds" if recording.qd is not None else "speeds computed from the positions"
    reading = [f"{recording.source}: joint positions [rad or m], {kind}, {speeds}"]
    if time is not None:
        even = max(time.steps[1] - 1.0 / time.rate, 1.0 / time.rate - time.steps[0]) < _UNEVEN / time.rate
        spacing = "even" if even else f"steps {1e3 * time.steps[0]:.3g} to {1e3 * time.steps[1]:.3g} ms"
        moving = f"moves from {time.moving[0]:.4g} to {time.moving[1]:.4g} s" if time.moving else "never moves"
        reading.append(
            f"{time.samples} samples, {time.duration:.4g} s at {time.rate:.5g} Hz ({spacing}, jitter "
            f"{100 * time.jitter:.1f} %); {moving}"
        )
    if check.relative_residual is not None:
        reading.append(
            f"The robot's model leaves {100 * check.relative_residual:.2f} % of the torque unexplained; condition "
            f"number (columns scaled) {check.condition_number_scaled:.3g}"
        )
    worst = [f.text for severity in ("error", "warning") for f in check.findings if f.severity == severity]
    lines = [f"{_MARKS[one.severity]}: {one.text}" for one in check.findings if one.text not in worst[:1]]
    last = "Good: nothing needs fixing." if check.findings else "Good: nothing looks wrong."
    mend = f"Fix first: {worst[0]}." if worst else last
    load, unit = ("current", "A") if check.currents else ("torque", "N·m")
    motion, steps = list[tuple[str, ...]](), list[tuple[str, ...]]()
    for j, (joint, facts) in enumerate(zip(robot.joints, check.joints, strict=False), 1):
        ratio = f"{100 * facts.speed / joint.limits.speed:.0f} %" if np.isfinite(joint.limits.speed) else ""
        position, torque = "{:.3f} to {:.3f}".format(*facts.position), "{:.4g} to {:.4g}".format(*facts.torque)
        motion.append((str(j), "yes" if facts.moves else "no", position, f"{facts.speed:.3g}", ratio, torque))
        sizes = (f"{step:.2g}" if step > 0.0 else "" for step in (facts.position_step, facts.torque_step))
        steps.append((str(j), *sizes, f"{100 * facts.saturated:.2f} %"))
    headings = ("joint", "moves", "position", "speed", "of limit", f"{load} {unit}")
    sigma = [(str(row.name), f"{row.relative_sigma_percent:.3g} %") for row in check.excitation]
    tables = (
        Table("Resolution of the signals", ("joint", "position", load, f"{load} at its extreme"), steps),
        Table("Excitation: each base parameter from this log", ("", "relative sigma"), sigma),
    )
    shown = [Table("", headings, motion)] if motion else []
    return Report(
        check.source,
        [Notes(reading), *shown, Notes(lines, optional=True), Notes([mend])],
        [Section("signals", "Signals", [table for table in tables if table.rows])],
        "resolution of the signals, excitation of each parameter",
    )


def fits_report(fits: RobotFits) -> Report:
    """The shipped robots that a log can be of; without one, its columns and what to mend first."""
    if fits.fault:
        more = len(fits.columns) - _MOST
        shown = ", ".join(fits.columns[:_MOST]) + (f" and {more} more" if more > 0 else "")
        return Report(fits.source, [Notes([f"{fits.source}: columns {shown}", f"Fix first: {fits.fault}"])])
    fitting = ", ".join(
        fit.robot + (f" ({100 * fit.residual:.3g} %)" if fit.residual is not None else "") for fit in fits.fitting
    )
    lines = [f"{fits.source}: no --robot given. Possible robots (with the torque left unexplained): {fitting}"]
    if fits.others:
        lines.append(f"Impossible: {', '.join(fits.others)} (positions, speeds or torques exceed their limits)")
    lines.append(f"Checked as {fits.fitting[0].robot}; use --robot to name the right one:")
    return Report(fits.source, [Notes(lines)])


def check_report(looks: Sequence[Look]) -> Report:
    """Verdict on the logs, then each with its signals."""
    sections, unusable = list[Section](), list[str]()
    for number, (check, fits) in enumerate(looks, 1):
        reports = [*([fits_report(fits)] if fits else []), *([log_report(check)] if check else [])]
        path = reports[-1].title
        blocks = [block for report in reports for block in report.first]
        blocks += [block for report in reports for section in report.sections for block in section.blocks]
        if check:
            stem = re.sub(r"\W+", "_", path.replace("\\", "/").rstrip("/").rsplit("/", 1)[-1].split(".")[0])
            unit = "A" if check.currents else "N·m"
            blocks.append(signals_figure(check.working[1], unit, f"{number:02d}_{stem}"))
        sections.append(Section(f"log_{number}", path, blocks))
        unusable += [] if check and check.usable else [path]
    text = f"Fix first: {', '.join(unusable)}." if unusable else "These logs can be used."
    return Report("A look at recordings", [Text(text, level="do_not_use" if unusable else "use")], sections)


def readings_report(robot: Robot, poses: Sequence[PoseCheck], readings: Readings | None) -> Report:
    """Verdict on a robot's description by tool poses and torques; every reading; the description."""
    faithful = readings_agree(poses, readings)
    text = "agrees with the recordings" if faithful else "does NOT agree with the recordings as they are read"
    first: list[Block] = [
        Text(f"The robot's description {text}.", level="use" if faithful else "do_not_use"),
        Notes(_kinematics_lines(poses, readings), optional=True),
    ]
    tables: list[Block] = []
    for source, ranked in [*((check.source, check.readings) for check in poses), ("torques", readings)]:
        if ranked:
            rows = [(one.described(), f"{left:.4g}") for one, left in islice(ranked.residuals.items(), _RANKED)]
            headings = ("reading", f"residual, {ranked.unit}")
            tables.append(Table(f"By {source}: the best of {len(ranked.residuals)} readings", headings, rows))
    sections = [
        Section("readings", "Readings of the joint columns, best first", tables),
        Section("robot", "The robot as described", [OnPage(lambda: robot_description(robot))]),
    ]
    more = "the readings, best first" if tables else ""
    return Report(f"Kinematics of the {robot.title or robot.name}", first, sections, more)


def readings_agree(poses: Sequence[PoseCheck], readings: Readings | None) -> bool:
    """Tell whether every tool pose is reproduced and no other reading of the columns does clearly better."""
    return all(check.reproduced for check in poses) and not (readings and readings.suggested)


def _kinematics_lines(poses: Sequence[PoseCheck], readings: Readings | None) -> list[str]:
    """Tool poses compared, and the best reading, which is never applied."""

    def words(pose: Pose, axes: bool = True) -> str:
        position = ", ".join(f"{value:.4f}" for value in pose.origin)
        turn = ", ".join(f"{math.degrees(angle) + 0.0:.2f}" for angle in pose.rpy)
        return f"({position}) m" + (f", rpy ({turn}) deg" if axes else ", axes not logged")

    lines = []
    for check in poses:
        axes = "" if check.rms_angle is None else f", orientation {math.degrees(check.rms_angle):.3g} deg"
        verb = "reproduces" if check.reproduced else "does NOT reproduce"
        lines += [
            f"{check.source}: forward kinematics {verb} the tool pose of {check.samples} samples: rms "
            f"{1e3 * check.rms:.3g} mm, at most {1e3 * check.largest:.3g} mm{axes}",
            f"  with base and tool at the origin {1e3 * check.as_is:.4g} mm; best-fitting base and tool:",
            f"  base of the robot in the log's frame: {words(check.base)}",
            f"  tool in the payload's frame: {words(check.tool, check.rms_angle is not None)}",
        ]
        if not check.determined:
            lines.append("  The motion does not determine base and tool: these are one choice of many.")
        if check.wrong_unit:
            farther = f"The tool moves {check.scale:.3g} times as far as the flange"
            lines.append(f"  {farther}: positions in {check.wrong_unit}?")
        if check.readings:
            lines += _reading_lines(check.readings)
    alone = ["No torques or currents in the log: only the pose was compared."]
    return lines + (_reading_lines(readings) if readings else alone)


def _reading_lines(readings: Readings) -> list[str]:
    residuals, best = readings.residuals, readings.suggested
    lines = [f"Residual: {readings.as_recorded:.4g} ({readings.unit}); {len(residuals)} other readings tried."]
    if best is None:
        lines.append("No other order, sign or zero of the joints fits clearly better.")
    else:
        lines.append(f"Suggested, not applied: {best.described()} (residual {residuals[best]:.4g}).")
        lines.append("Check it at the robot, then change the log's columns or the robot's file.")
        for j, along in enumerate(best.along, 1):
            if along:
                coupling = f"coupling = [{{ motor = {j}, joint = {j - 1}, ratio = {-along} }}]"
                sides = 'side = "motor" of position and velocity'
                lines.append(f"In a log map: {sides}, all gear_ratios 1, {coupling}.")
    others = [reading for reading in readings.alike if reading.changes][:_SHOWN]
    if others:
        lines.append("These fit equally well; the recording cannot tell them apart:")
        lines += [f"  {residuals[reading]:.4g}  {reading.described()}" for reading in others]
    return lines


def following_report(change: FollowingChange, robot: Robot) -> Report:
    """Change of each joint's error when a payload was entered, and how both recordings were compared."""
    (unit, scale), total, joints = _UNITS[change.kind], change.total, (*change.joints, change.total)
    rows = []
    for joint in joints:
        before, after = (f"{scale * x:.3g}" for x in (joint.before, joint.after))
        low, high = (f"{100 * x:.1f}" for x in joint.interval)
        rows.append((joint.name, before, after, f"{100 * joint.fall:.1f}", f"{low} to {high}", joint.clear))
    headings = ("", "before", "after", "fell by %", "95 % interval", "change")
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
    compared = [
        f"The second recording is shifted by {1e3 * change.lag:+.3g} ms, so that samples at the same point of the "
        "motion are compared.",
        "The 95 % intervals come from leaving out blocks of 1 s one at a time; a change is clear if its interval "
        "excludes 0.",
    ]

    def draw() -> Figure:
        figure, axes = panels((6.4, 3.2))
        axis, places = axes[0, 0], np.arange(len(joints))
        before, after = (scale * np.array([getattr(row, when) for row in joints]) for when in ("before", "after"))
        # The interval is that of the share by which it fell.
        ends = before * (1.0 - np.array([row.interval for row in joints])).T
        reach = np.nan_to_num(np.maximum([after - ends[1], ends[0] - after], 0.0))
        axis.bar(places - 0.2, before, 0.38, color=GREY, label="before")
        axis.bar(places + 0.2, after, 0.38, color=BLUE, hatch="//", label="after", yerr=reach, capsize=3)
        axis.set_xticks(places, [row.name for row in joints])
        axis.set_ylabel(f"root mean square [{unit}]")
        axis.legend(fontsize=9, frameon=False)
        plain(axis)
        return figure

    caption = f"Root mean square of the {change.kind} before and after the number was entered, with 95 % intervals."
    return Report(
        f"Before and after a payload was entered: {robot.title or robot.name}",
        [Text(text, level=level), Notes(others), Table(title, headings, rows)],
        [Section("joints", "Joint by joint", [Drawing("following", caption, draw), Notes(compared)])],
        "how both recordings were compared",
    )
