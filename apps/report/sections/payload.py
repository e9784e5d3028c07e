"""A payload, by a long motion or a short one: one screen and one page, first what to use and what to type in."""

from collections.abc import Sequence

import numpy as np

from ....common.arrays import Array
from ....estimation import LongMotion, PayloadAnswer
from ....estimation.answers.system import TorquePrediction
from ....estimation.diagnosis.joints import worst_joint
from ....estimation.payload.result import METHOD_NAMES
from ...export.controllers.load import is_flange
from ...numbers import interval_digits, with_interval
from ...results import StoredPayload
from ..blocks import Banner, Block, Column, Notes, Page, Pair, Screen, Section, Table, Text, columns
from ..figures.payload import flange_figure, repeats_figure
from ..provenance import Provenance, report_page
from .controller import controller_blocks
from .estimates import consistency_blocks, data_notes, method_notes, methods_section, parameters_table
from .evidence import (
    by_joints_table,
    elimination_notes,
    essential_section,
    excitation_section,
    joints_section,
    torques_section,
    worst_torque,
)
from .verdict import MEND, VERDICTS, gain_error_notes, reason_blocks, reason_lines, verdict_notes

_QUANTITIES = ("mass", "centre of mass", "inertia")
_ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Places of the inertia's entries, moments first."""
_HOW = {
    1: "the loaded torques less those of the robot as it was identified",
    2: "the change of the robot's base parameters",
    3: "the difference of the torques on one trajectory",
    4: "robot and payload at once, from all recordings",
}
"""Each method in words."""


def payload_screen(answer: PayloadAnswer, document: str | None = None, stand_in_unused: bool = False) -> Screen:
    """Make the screen of ``payload`` and ``weigh``.

    Args:
        answer: of long recordings, or of a short motion.
        document: JSON file that it was written to.
        stand_in_unused: an assumed inertia was given and is not needed.
    """
    level, method = VERDICTS[answer.verdict.level].words, answer.free.method
    to_do = [MEND]
    if answer.verdict.level != "do_not_use":
        export = f"'dynident export {document or 'P.json'} --to ur' (abb, kuka, fanuc, ..)"
        to_do = [
            f"For the controller: {controller_line(answer)}",
            f"Next, its own format: {'' if document else 'add --json P.json, then '}{export}.",
        ]
    spare = ["--inertia is not needed: the inertia was measured well enough."] if stand_in_unused else []
    first: list[Block] = [
        Notes([f"Verdict: {level} (method {method}, {METHOD_NAMES[method]})."]),
        Notes(reason_lines(answer.verdict), optional=True),
        quantities_table(answer, 3),
        Notes(to_do),
        Notes([*answer_notes(answer), *spare], optional=True),
    ]
    methods = sorted({estimate.method for estimate in answer.estimates})
    eliminated = elimination_notes(answer.elimination, answer.warnings, "Method 4: ")
    details: list[Block] = [
        Notes(["", *(f"Method {number}, {METHOD_NAMES[number]}: {_HOW[number]}." for number in methods)]),
        parameters_table(answer),
        Notes([*method_notes(answer), ""]),
        *consistency_blocks(answer),
        Notes([""]),
        by_joints_table(answer.by_joints),
        Notes([*eliminated, *data_notes(answer)]),
    ]
    return Screen(first, details, "every method, all parameters, joints, residuals")


def payload_page(
    answer: PayloadAnswer,
    document: StoredPayload,
    provenance: Provenance,
    predictions: Sequence[TorquePrediction] = (),
    others: int = 0,
    extra: Sequence[Section] = (),
    origin: str = "",
) -> Page:
    """First page for the one who types the number in, the rest for the one who asks why.

    Args:
        predictions: recordings to draw, held out or not.
        others: number of recordings that are not drawn.
        extra: sections to stand behind the payload's.
        origin: what kind of data it is, below the title; recordings by default.
    """
    robot, problem, best = answer.problem.robot, answer.problem, answer.possible
    title = robot.title or robot.name
    sections = [
        methods_section(answer),
        joints_section(answer.by_joints, answer.mass, answer.mass_interval),
        *extra,
    ]
    if answer.repeats is not None:
        drawn = repeats_figure(answer.repeats, answer.mass, answer.mass_interval)
        words = "Each recording was weighed alone too: the scatter tells what no single one does."
        blocks: list[Block] = [Text(words), *([drawn] if drawn is not None else [])]
        sections.insert(0, Section("repeats", "From recording to recording", blocks))
    if isinstance(problem, LongMotion):
        origin = origin or "Identified from recordings of joint positions and torques"
        labels = dict(zip(answer.problem.base.columns, answer.problem.base.names, strict=True))
        sections += [
            torques_section(predictions, others),
            excitation_section(answer.excitation, labels),
            essential_section(answer.elimination, answer.warnings, title, labels),
        ]
    else:
        joints = ", ".join(map(str, problem.joints))
        origin = origin or f"Weighed by a motion of joint{'s' * (len(problem.joints) > 1)} {joints}"
    why: list[Block] = [
        *reason_blocks(answer.verdict),
        *(Text(line, "note") for line in answer_notes(answer)),
        *_improvements(answer, predictions),
        *worst_torque(predictions),
    ]
    controller = controller_blocks(document, "this report", title)
    if best is not None:
        why = [Pair(why, [flange_figure(best, uses(answer)[2] == "use", is_flange(best.frame))])]
    lead: list[Block] = [
        Banner(answer.verdict.level, VERDICTS[answer.verdict.level].sentence),
        Pair([quantities_table(answer)], [Text("What to type into the controller", "heading"), *controller]),
        *why,
    ]
    subtitle = f"{origin}, {provenance.day}"
    return report_page(f"Payload on the {title}", subtitle, lead, sections, data_notes(answer), provenance)


def quantities_table(answer: PayloadAnswer, entries: int = 6) -> Table:
    """Value, 95 % interval and use of mass, centre of mass and inertia there; ``entries``: of its matrix."""
    inertia, bounds = np.full((3, 3), np.nan), np.full((3, 3, 2), np.nan)
    if answer.stand_in is not None:
        inertia = answer.stand_in.inertia(answer.mass)
    elif answer.possible is not None:
        inertia, bounds = answer.possible.body.inertia_com, answer.possible.intervals.inertia_com
    mass, com, moments = uses(answer)
    numbers = [("mass", "kg", answer.mass, answer.mass_interval, mass)]
    for k, axis in enumerate("xyz"):
        low, high = 1e3 * answer.com_interval[k]
        use = com if k == 0 or not np.isfinite(answer.com[k]) else ""
        numbers.append((f"centre of mass {axis}", "mm", 1e3 * answer.com[k], (low, high), use))
    for i, j in _ENTRIES[:entries]:
        low, high = bounds[i, j]
        use = moments if (i, j) == (0, 0) or answer.stand_in is not None else ""
        numbers.append((f"inertia {'XYZ'[i]}{'XYZ'[j]} at com", "kg m²", inertia[i, j], (low, high), use))
    rows = [
        (name, unit, *(with_interval(value, *interval) if np.isfinite(value) else ("-", "-")), use)
        for name, unit, value, interval, use in numbers
    ]
    headings = (*columns(("", "unit"), ("value", "95 % interval")), Column("", folds=True))
    title = f"Payload in {answer.problem.robot.payload_frame}"
    return Table(title, headings, rows, ("mass", "centre of mass z"), "quantities")


def uses(answer: PayloadAnswer) -> tuple[str, str, str]:
    """Say what to do with mass, centre of mass, inertia: one by one after a short motion, else by the verdict."""
    if isinstance(answer.problem, LongMotion):
        return VERDICTS[answer.verdict.level].each
    mass, com, inertia = (answer.judged[name].use for name in _QUANTITIES)
    return mass, com, inertia


def answer_notes(answer: PayloadAnswer) -> list[str]:
    """Reason for the method, an assumed inertia, scale, other ways to the mass, repeats, worst joint, gains."""
    worst, (method, why) = worst_joint(answer.by_joints, answer.mass), answer.recommendation
    return [
        *([f"Method {method}: {why}."] if why else []),
        *([f"Inertia ASSUMED, not measured: {answer.stand_in.description}."] if answer.stand_in else []),
        *verdict_notes(answer.verdict),
        *scale_notes(answer),
        *(
            f"Another way, {way.name}: {way.mass:.4g} kg, centre of mass "
            f"({', '.join('-' if not np.isfinite(x) else f'{1e3 * x:.1f}' for x in way.com)}) mm."
            for way in answer.agreement
        ),
        *_repeat_notes(answer),
        f"Joint that agrees least: {worst.text}." if worst else "No joint can be compared with the others.",
        *gain_error_notes(answer.problem.robot, answer.gains),
    ]


def scale_notes(answer: PayloadAnswer) -> list[str]:
    """The mass from a scale or from CAD beside that by the torques."""
    if answer.free.from_scale and answer.scale is not None:
        return [
            f"Mass: the scale's {answer.scale.mass:g} ± {answer.scale.sigma:g} kg; the torques of these joints do "
            "not contain it."
        ]
    weighings = answer.possible.weighings if answer.possible is not None else (answer.weighing,)
    lines = [
        f"Scale {weighing.mass:g} ± {weighing.sigma:.2g} kg, torques {weighing.identified:.4g} ± "
        f"{weighing.identified_sigma:.2g} kg: {abs(weighing.z):.1f} sigma apart, "
        f"{'which contradict each other' if weighing.conflict else 'in agreement'}."
        for weighing in weighings
        if weighing is not None
    ]
    return lines or ["Not weighed: --mass KG+-KG compares with a scale, and sharpens the centre of mass."]


def _repeat_notes(answer: PayloadAnswer) -> list[str]:
    """Spread and drift of several recordings."""
    repeats = answer.repeats
    if repeats is None:
        return []
    _, masses, sigmas = repeats.seen
    each = ", ".join(f"{m:.4g} ± {s:.2g}" for m, s in zip(masses, sigmas, strict=True))
    lines = [f"{len(repeats.masses)} recordings, each alone [kg]: {each}; spread {repeats.spread:.2g} kg."]
    if repeats.drift is not None:
        step, sigma = repeats.drift
        trend = "a drift" if repeats.drifts else "no clear drift"
        lines.append(f"From one to the next {step:+.2g} ± {sigma:.2g} kg: {trend}.")
    if repeats.excess > 1.0:
        lines.append(
            f"They scatter {repeats.excess:.2g} times as much as each says: all intervals are widened by that."
        )
    return lines


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


def _improvements(answer: PayloadAnswer, predictions: Sequence[TorquePrediction]) -> list[Block]:
    """List what would improve the answer, beyond a scale and the gains, of which the notes tell."""
    lines, robust = list[str](), answer.free.estimate.robust
    held_out = any(prediction.held_out for prediction in predictions)
    if isinstance(answer.problem, LongMotion) and not held_out:
        lines.append("Keep one recording without payload out of identification (--validate).")
    if answer.free.without_robust:
        lines.append(f"Record longer: intervals rest on white noise, because {answer.free.without_robust}.")
    elif robust is not None and robust.warning:
        lines.append(f"{robust.warning[:1].upper()}{robust.warning[1:]}.")
    return [Text("How to improve it", "heading"), Notes(lines)] if lines else []
