"""A look at a log."""

from collections.abc import Sequence

import numpy as np

from ...logs.fits import RobotFits
from ...logs.log_check import LogCheck
from ..blocks import Banner, Block, Notes, Page, Remarks, Screen, Section, Table, columns
from ..documents.check import Look
from ..figures.signals import signals_figure
from ..provenance import Provenance
from .data import report_page

_MARKS = {"error": "ERROR", "warning": "warning", "note": "note"}
_A_ROW = 4  # parameters side by side
_MOST = 12  # columns that are listed


def check_screen(check: LogCheck) -> Screen:
    """What was understood, the joints, what looks wrong, what to mend; then steps and the excitation."""
    first: list[Block] = [Notes(_understood(check))]
    details: list[Block] = []
    if check.joints:
        first.append(_joints(check))
        details.append(_resolution(check))
    if check.excitation:
        details.append(_excitation(check))
    lines = [f"{_MARKS[finding.severity]}: {finding.text}" for finding in check.findings]
    return Screen(
        [*first, Remarks(lines), Notes([_last_line(check)])],
        details,
        "steps of the signals, each parameter's excitation",
    )


def fits_screen(path: str, fits: RobotFits) -> Screen:
    """Which shipped robots a log can be of; without one what is in it, and what to mend first."""
    if fits.fault:
        more = len(fits.columns) - _MOST
        shown = ", ".join(fits.columns[:_MOST]) + (f" and {more} more" if more > 0 else "")
        return Screen([Notes([f"{path}: columns {shown}", f"Mend first: {fits.fault}"])])
    fitting = [name if left is None else f"{name} ({100 * left:.3g} %)" for name, left in fits.fitting]
    lines = [f"{path}: no --robot is given. It can be of {', '.join(fitting)}: in brackets what the model leaves"]
    if fits.others:
        names = ", ".join(name for name, _ in fits.others)
        lines.append(f"Not of {names}: positions, speeds or torques are beyond them")
    return Screen([Notes([*lines, f"Looked at as {fits.fitting[0].robot}; name the right one by --robot:"])])


def check_page(looks: Sequence[Look], provenance: Provenance) -> Page:
    """Whether the logs can be used; then each with what was understood, what looks wrong, and its signals.

    Args:
        looks: one a log.
    """
    unusable = [look.path for look in looks if not (look.check and look.check.usable)]
    words = (
        f"To be mended first: {', '.join(unusable)}." if unusable else "Nothing speaks against using these logs."
    )
    lead = [Banner("do_not_use" if unusable else "use", words)]
    sections = [_section(number, look) for number, look in enumerate(looks, 1)]
    return report_page("A look at recordings", provenance.day, lead, sections, (), provenance)


def _section(number: int, look: Look) -> Section:
    """All that the terminal shows of a log, and its signals."""
    blocks = fits_screen(look.path, look.fits).blocks if look.fits else []
    stem = look.path.replace("\\", "/").rstrip("/").rsplit("/", 1)[-1].split(".")[0]
    if look.check:
        unit = "A" if look.check.currents else "N·m"
        blocks += check_screen(look.check).blocks
        blocks.append(signals_figure(look.check.recording, unit, f"{number:02d}_{stem}"))
    return Section(f"log_{number}", look.path, blocks)


def _understood(check: LogCheck) -> list[str]:
    """What the log was taken for, and how well the robot's model explains it."""
    recording, time = check.recording, check.time
    kind = "currents [A] of unknown gain" if check.currents else "torques [N·m or N]"
    speeds = "with speeds" if recording.qd is not None else "without speeds (taken from positions)"
    lines = [f"{recording.source}: positions [rad or m], {kind}, {speeds}, joint side"]
    if time is not None:
        steps = "even" if time.even else f"steps {1e3 * time.steps[0]:.3g} to {1e3 * time.steps[1]:.3g} ms"
        moving = f"moves from {time.moving[0]:.4g} to {time.moving[1]:.4g} s" if time.moving else "never moves"
        lines.append(
            f"{time.samples} samples, {time.duration:.4g} s at {time.rate:.5g} Hz ({steps}, jitter "
            f"{100 * time.jitter:.2g} %); {moving}"
        )
    if check.relative_residual is not None:
        lines.append(
            f"The robot's model leaves {100 * check.relative_residual:.2f} % unexplained; condition number with "
            f"columns scaled {check.condition_number_scaled:.3g}"
        )
    return lines


def _last_line(check: LogCheck) -> str:
    """Good, or what to mend first: the worst that was found."""
    for severity in ("error", "warning"):
        first = next((finding.text for finding in check.findings if finding.severity == severity), None)
        if first is not None:
            return f"Mend first: {first}."
    return "Good: nothing looks wrong." if not check.findings else "Good: nothing is to be mended."


def _joints(check: LogCheck) -> Table:
    """What each joint does."""
    rows = []
    for j, (joint, facts) in enumerate(zip(check.robot.joints, check.joints, strict=True), 1):
        share = f"{100 * facts.speed / joint.limits.speed:.0f} %" if np.isfinite(joint.limits.speed) else ""
        rows.append(
            (
                str(j),
                "yes" if facts.moves else "no",
                f"{facts.position[0]:.3f} to {facts.position[1]:.3f}",
                f"{facts.speed:.3g}",
                share,
                f"{facts.torque[0]:.4g} to {facts.torque[1]:.4g}",
            )
        )
    load = "current A" if check.currents else "torque N·m"
    return Table("", columns(("joint", "moves"), ("position", "speed", "of limit", load)), rows, style="tight")


def _resolution(check: LogCheck) -> Table:
    """Steps of the signals, and how often a torque stands at its extreme."""
    rows = [
        (str(j), _step(facts.position_step), _step(facts.torque_step), f"{100 * facts.saturated:.2f} %")
        for j, facts in enumerate(check.joints, 1)
    ]
    torque = "current" if check.currents else "torque"
    numbers = ("step of position", f"of {torque}", f"{torque} at extreme")
    return Table("Steps of the signals", columns(("joint",), numbers), rows, style="tight")


def _excitation(check: LogCheck) -> Table:
    """Some parameters a row."""
    cells = [(entry.name, f"{entry.relative_sigma_percent:.3g}") for entry in check.excitation]
    cells += [("", "")] * (-len(cells) % _A_ROW)
    rows = [
        tuple(text for pair in cells[start : start + _A_ROW] for text in pair)
        for start in range(0, len(cells), _A_ROW)
    ]
    title = "Excitation: relative sigma of each base parameter from this log, %"
    return Table(title, columns(("",), ("",)) * _A_ROW, rows, style="bare")


def _step(step: float) -> str:
    return f"{step:.2g}" if step > 0.0 else ""
