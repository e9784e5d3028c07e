"""Whether recordings agree with a robot's kinematics: what the terminal prints, and the report."""

import math
from collections.abc import Sequence

from ....estimation.diagnosis.kinematics import KinematicsCheck
from ....model import Pose, Robot
from ..blocks import Banner, Block, Notes, Page, Remarks, Screen, Section, Table, columns
from ..documents.check import PoseLook
from ..provenance import Provenance
from .data import report_page
from .description import robot_description

_SHOWN = 6
"""Readings that do as well which the screen names."""
_RANKED = 20


def readings_screen(poses: Sequence[PoseLook], check: KinematicsCheck | None) -> Screen:
    """What forward kinematics and torques say of the columns; then every reading that was tried.

    Args:
        poses: each log with tool poses.
        check: readings ranked by torques; None without torques.
    """
    ranked = [_ranked(look.readings, look.source) for look in poses if look.readings]
    if check:
        ranked.append(_ranked(check, "torques"))
    details: list[Block] = [*ranked]
    return Screen([Remarks(_lines(poses, check))], details, "the readings, best first" if details else "")


def readings_page(
    robot: Robot, poses: Sequence[PoseLook], check: KinematicsCheck | None, provenance: Provenance
) -> Page:
    """Whether the description agrees with the recordings, the readings, and the description itself.

    Args:
        poses: each log with tool poses.
        check: readings ranked by torques; None without torques.
    """
    faithful = readings_agree(poses, check)
    words = "agrees with the recordings" if faithful else "does NOT agree with the recordings as they are read"
    lead: list[Block] = [
        Banner("use" if faithful else "do_not_use", f"The robot's description {words}."),
        Notes([line.strip() for line in _lines(poses, check)]),
    ]
    sections = [
        Section("readings", "Readings of the joint columns, best first", readings_screen(poses, check).details),
        Section("robot", "The robot as described", robot_description(robot)),
    ]
    title = f"Kinematics of the {robot.title or robot.name}"
    return report_page(title, provenance.day, lead, sections, (), provenance)


def readings_agree(poses: Sequence[PoseLook], check: KinematicsCheck | None) -> bool:
    """Whether every tool pose is reproduced, and no other reading of the columns does clearly better."""
    return all(look.check.reproduced for look in poses) and not (check and check.suggested)


def _lines(poses: Sequence[PoseLook], check: KinematicsCheck | None) -> list[str]:
    lines = []
    for look in poses:
        lines += _pose_lines(look)
        if look.readings:
            lines += _reading_lines(look.readings)
    return lines + (_reading_lines(check) if check else ["No torques or currents: the pose alone is compared."])


def _reading_lines(check: KinematicsCheck) -> list[str]:
    """The best reading in words; it is never applied."""
    lines = [f"As recorded: {check.as_recorded.residual:.4g} ({check.unit}); {len(check.ranked)} readings tried."]
    best = check.suggested
    if best is None:
        lines.append("No other reading of order, senses and zeros does clearly better.")
    else:
        lines.append(f"Suggested, not applied: {best.reading.described()}: {best.residual:.4g}.")
        lines.append("Check it at the robot, then change the recording's columns or the robot's file.")
    others = [ranked for ranked in check.alike if ranked.reading.changes][:_SHOWN]
    if others:
        lines.append("These do as well, so the recording cannot tell them apart:")
        lines += [f"  {ranked.residual:.4g}  {ranked.reading.described()}" for ranked in others]
    return lines


def _pose_lines(look: PoseLook) -> list[str]:
    """The comparison of tool poses in words."""
    check = look.check
    axes = "" if check.rms_angle is None else f", axes {math.degrees(check.rms_angle):.3g} deg"
    word = "reproduces" if check.reproduced else "does NOT reproduce"
    lines = [
        f"{look.source}: forward kinematics {word} the tool pose of {len(check.errors)} samples: rms "
        f"{1e3 * check.rms:.3g} mm, at most {1e3 * check.errors.max():.3g} mm{axes}",
        f"  without any base and tool {1e3 * check.as_is:.4g} mm; with the ones that fit best:",
        f"  base of the robot in the log's frame: {_in_words(check.base)}",
        f"  tool in the payload's frame: {_in_words(check.tool, check.angles is not None)}",
    ]
    if not check.determined:
        lines.append("  The motion does not tell base and tool apart: they are one choice of many.")
    if look.wrong_unit:
        lines.append(
            f"  The tool moves {check.scale:.3g} times as far as the flange: positions in {look.wrong_unit}?"
        )
    return lines


def _ranked(check: KinematicsCheck, source: str) -> Table:
    rows = [(ranked.reading.described(), f"{ranked.residual:.4g}") for ranked in check.ranked[:_RANKED]]
    headings = (columns((), (), ("reading",))[0], *columns((), (f"residual, {check.unit}",)))
    return Table(f"By {source}: the best of {len(check.ranked)} readings", headings, rows, style="tight")


def _in_words(pose: Pose, axes: bool = True) -> str:
    place = ", ".join(f"{value:.4f}" for value in pose.origin)
    turn = ", ".join(f"{math.degrees(angle) + 0.0:.2f}" for angle in pose.rpy)
    return f"({place}) m" + (f", rpy ({turn}) deg" if axes else ", axes not logged")
