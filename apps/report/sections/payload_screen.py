"""A payload on the terminal: first what to use and what to type in, then what it rests on."""

import numpy as np

from ....common.arrays import Array
from ....estimation import PayloadAnswer
from ....estimation.diagnosis.joints import worst_joint
from ....estimation.payload.result import METHOD_NAMES
from ...export.controllers.load import is_flange
from ...numbers import interval_digits, with_interval
from ..blocks import Block, Column, Notes, Remarks, Screen, Table, columns
from .evidence import by_joints_table, elimination_notes
from .payload import payload_notes, payload_table
from .recommended import recommended_notes, recommended_table
from .verdict import MEND, VERDICTS, gain_error_notes, reason_lines
from .weighing import (
    agreement_notes,
    assumed_notes,
    detail_notes,
    moment,
    parameters_table,
    repeat_notes,
    scale_note,
    worst_note,
)

_QUANTITIES = ("mass", "centre of mass", "inertia")
_ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
_HOW = {
    1: "the loaded torques less those of the robot as it was identified",
    2: "the change of the robot's base parameters",
    3: "the difference of the torques on one trajectory",
    4: "robot and payload at once, from all recordings",
}
"""What each method solves, in words."""


def payload_screen(answer: PayloadAnswer, document: str | None = None, stand_in_unused: bool = False) -> Screen:
    """What ``payload`` and ``weigh`` print.

    Args:
        answer: of long recordings, or of a short motion.
        document: JSON file that it was written to.
        stand_in_unused: an assumed inertia was given and is not needed.
    """
    spare = ["--inertia is not needed: the inertia was measured well enough."] if stand_in_unused else []
    if answer.problem.short is not None:
        notes = [*first_notes(answer), *spare]
        details: list[Block] = [
            parameters_table(answer),
            by_joints_table(answer.by_joints),
            Notes(detail_notes(answer)),
        ]
        more = "parameters, joints, residuals"
    else:
        notes = [*(f"Note: {text}." for text in answer.verdict.notes), scale_note(answer)]
        notes += [worst_note(worst_joint(answer.by_joints, answer.mass))]
        notes += gain_error_notes(answer.problem.robot, answer.gains)
        details = _details(answer)
        more = "every method, all parameters, joints, residuals"
    first: list[Block] = [
        Notes([verdict_line(answer)]),
        Remarks(reason_lines(answer.verdict)),
        quantities(answer),
        Notes(_to_do(answer, document)),
        Remarks(notes),
    ]
    return Screen(first, details, more)


def verdict_line(answer: PayloadAnswer) -> str:
    """The verdict, and by which method."""
    level = VERDICTS[answer.verdict.level].weighing
    if answer.problem.short is not None:
        return f"Verdict: {level}."
    method = answer.free.method
    return f"Verdict: {level} (method {method}, {METHOD_NAMES[method]})."


def quantities(answer: PayloadAnswer) -> Table:
    """Value, 95 % interval and use of mass, centre of mass and inertia."""
    mass, com, inertia = uses(answer)
    rows = [_row("mass", "kg", answer.mass, answer.mass_interval, mass)]
    for k, axis in enumerate("xyz"):
        low, high = 1e3 * answer.com_interval[k]
        use = com if k == 0 or not np.isfinite(answer.com[k]) else ""
        rows.append(_row(f"centre of mass {axis}", "mm", 1e3 * answer.com[k], (low, high), use))
    for k, kind in enumerate(("XX", "YY", "ZZ")):
        use = inertia if k == 0 or answer.stand_in is not None else ""
        rows.append(_row(f"inertia {kind} at com", "kg m²", *moment(answer, k), use))
    headings = (*columns(("", "unit"), ("value", "95 % interval")), Column("", folds=True))
    return Table(f"Payload in {answer.problem.robot.payload_frame}", headings, rows, style="tight")


def uses(answer: PayloadAnswer) -> tuple[str, str, str]:
    """What to do with mass, centre of mass and inertia."""
    if answer.problem.short is None:
        return VERDICTS[answer.verdict.level].each
    mass, com, inertia = (answer.judged[name].use for name in _QUANTITIES)
    return mass, com, inertia


def _row(name: str, unit: str, value: float, interval: tuple[float, float], use: str) -> tuple[str, ...]:
    if not np.isfinite(value):
        return name, unit, "-", "-", use
    return name, unit, *with_interval(value, *interval), use


def first_notes(answer: PayloadAnswer) -> list[str]:
    """Notes of a weighing: other ways to the mass, the scale, the worst joint."""
    lines = [*assumed_notes(answer), *(f"Note: {text}." for text in answer.verdict.notes)]
    lines += [scale_note(answer), *agreement_notes(answer), *repeat_notes(answer)]
    lines.append(worst_note(worst_joint(answer.by_joints, answer.mass)))
    return [*lines, *gain_error_notes(answer.problem.robot, answer.gains)]


def _to_do(answer: PayloadAnswer, document: str | None) -> list[str]:
    """What to type in, and the next command."""
    if answer.verdict.level == "do_not_use":
        return [MEND]
    export = f"'dynident export {document or 'P.json'} --to ur' (abb, kuka, fanuc, ..)"
    return [
        f"For the controller: {controller_line(answer)}",
        f"Next, its own format: {'' if document else 'add --json P.json, then '}{export}.",
    ]


def controller_line(answer: PayloadAnswer) -> str:
    """Mass, centre of mass and, where it may be used, inertia, at the flange; digits as the intervals allow."""
    pose = answer.problem.robot.flange_pose
    turn, origin = (pose.R, pose.p) if pose is not None else (np.eye(3), np.zeros(3))
    where = "" if is_flange(answer.problem.robot.payload_frame) else f" in {answer.problem.robot.payload_frame}"
    where = " at the flange" if pose is not None else where
    mass = with_interval(answer.mass, *answer.mass_interval)[0]
    com = _numbers(1e3 * (turn.T @ (answer.com - origin)), 1e3 * answer.com_interval)
    line = f"mass {mass} kg, centre of mass ({com}) mm{where}"
    if answer.stand_in is not None:
        moved = turn.T @ answer.stand_in.inertia(answer.mass) @ turn
        return f"{line}, inertia there ({', '.join(f'{x:.4f}' for x in np.diag(moved))}) kg m², ASSUMED"
    if uses(answer)[2] == "use" and answer.possible is not None:
        moved = turn.T @ answer.possible.body.inertia_com @ turn
        entries = np.array([moved[at] for at in _ENTRIES])
        numbers = _numbers(entries, answer.possible.intervals.inertia_com.reshape(9, 2))
        return f"{line}, inertia there XX YY ZZ XY XZ YZ ({numbers}) kg m²"
    return f"{line}, inertia left at zero"


def _numbers(values: Array, intervals: Array) -> str:
    """Numbers with as many digits as the widest of their intervals allows; what is not known is said."""
    widths = np.diff(intervals, axis=1)
    digits = interval_digits(float(np.nanmax(widths, initial=0.0)))
    return ", ".join(
        f"{round(x, digits) + 0.0:.{digits}f}" if np.isfinite(x) else "unknown" for x in values.tolist()
    )


def _details(answer: PayloadAnswer) -> list[Block]:
    """Every method, the joints, the free estimates, and the lines below."""
    eliminated = elimination_notes(answer.elimination, answer.warnings, "Method 4: ")
    methods = [f"Method {number}, {name}: {_HOW[number]}." for number, name in METHOD_NAMES.items()]
    return [
        Notes(["", *methods]),
        recommended_table(answer),
        Notes([*recommended_notes(answer), ""]),
        by_joints_table(answer.by_joints),
        Notes([""]),
        payload_table(answer.estimates),
        Notes([*eliminated, *payload_notes(answer)]),
    ]
