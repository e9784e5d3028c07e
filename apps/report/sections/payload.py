"""A payload, by a long motion or a short one: one screen and one page, first what to use and what to type in."""

from collections.abc import Sequence

import numpy as np

from ....common.arrays import Array
from ....common.schema import present
from ....estimation.answers.system import TorquePrediction
from ....estimation.payload.result import METHOD_NAMES
from ....estimation.possible.result import CONFLICT
from ....estimation.results.payload import PayloadResult, array
from ...export.load import is_flange
from ...numbers import SIX, interval_digits, six, with_interval
from ..blocks import Banner, Block, Column, Notes, Page, Pair, Screen, Section, Table, Text, columns
from ..figures.payload import flange_figure, repeats_figure, seen
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

_HOW = {
    1: "the loaded torques less those of the robot as it was identified",
    2: "the change of the robot's base parameters",
    3: "the difference of the torques on one trajectory",
    4: "robot and payload at once, from all recordings",
}
"""Each method in words."""


def payload_screen(result: PayloadResult, document: str | None = None, stand_in_unused: bool = False) -> Screen:
    """Make the screen of ``payload`` and ``weigh``.

    Args:
        document: JSON file that it was written to.
        stand_in_unused: an assumed inertia was given and is not needed.
    """
    level, method = VERDICTS[result.verdict.level].words, result.method
    to_do = [MEND]
    if result.verdict.level != "do_not_use":
        export = f"'dynident export {document or 'P.json'} --to ur' (abb, kuka, fanuc, ..)"
        to_do = [
            f"For the controller: {controller_line(result)}",
            f"Next, its own format: {'' if document else 'add --json P.json, then '}{export}.",
        ]
    spare = ["--inertia is not needed: the inertia was measured well enough."] if stand_in_unused else []
    first: list[Block] = [
        Notes([f"Verdict: {level} (method {method}, {METHOD_NAMES[method]})."]),
        Notes(reason_lines(result.verdict), optional=True),
        quantities_table(result, 3),
        Notes(to_do),
        Notes([*answer_notes(result), *spare], optional=True),
    ]
    methods = sorted({estimate.method for estimate in result.free})
    eliminated = elimination_notes(present(result.essential), "Method 4: ")
    details: list[Block] = [
        Notes(["", *(f"Method {number}, {METHOD_NAMES[number]}: {_HOW[number]}." for number in methods)]),
        parameters_table(result),
        Notes([*method_notes(result), ""]),
        *consistency_blocks(result),
        Notes([""]),
        by_joints_table(present(result.mass_by_joints) or ()),
        Notes([*eliminated, *data_notes(result)]),
    ]
    return Screen(first, details, "every method, all parameters, joints, residuals")


def payload_page(
    result: PayloadResult,
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
    best, repeats = result.best, present(result.repeats)
    mass, interval = float(result.mass), tuple(result.mass.interval95.tolist())
    sections = [
        methods_section(result),
        joints_section(present(result.mass_by_joints) or (), mass, interval),
        *extra,
    ]
    if repeats is not None:
        drawn = repeats_figure(repeats, mass, interval)
        words = "Each recording was weighed alone too: the scatter tells what no single one does."
        blocks: list[Block] = [Text(words), *([drawn] if drawn is not None else [])]
        sections.insert(0, Section("repeats", "From recording to recording", blocks))
    if result.short:
        joints = present(result.joints) or ()
        origin = origin or f"Weighed by a motion of joint{'s' * (len(joints) > 1)} {', '.join(map(str, joints))}"
    else:
        origin, made = origin or "Identified from recordings of joint positions and torques", result.working
        labels = dict(zip(made.problem.base.columns, made.problem.base.names, strict=True)) if made else {}
        sections += [
            torques_section(predictions, others),
            excitation_section(made.excitation if made else None, labels),
            essential_section(present(result.essential), result.title),
        ]
    why: list[Block] = [
        *reason_blocks(result.verdict),
        *(Text(line, "note") for line in answer_notes(result)),
        *_improvements(result, predictions),
        *worst_torque(predictions),
    ]
    controller = controller_blocks(result, "this report", result.title)
    if best is not None:
        why = [Pair(why, [flange_figure(best, result.inertia.use == "use", is_flange(result.frame))])]
    lead: list[Block] = [
        Banner(result.verdict.level, VERDICTS[result.verdict.level].sentence),
        Pair([quantities_table(result)], [Text("What to type into the controller", "heading"), *controller]),
        *why,
    ]
    subtitle = f"{origin}, {provenance.day}"
    return report_page(f"Payload on the {result.title}", subtitle, lead, sections, data_notes(result), provenance)


def quantities_table(result: PayloadResult, entries: int = 6) -> Table:
    """Value, 95 % interval and use of mass, centre of mass and inertia there; ``entries``: of its matrix."""
    mass, com, inertia = result.mass, result.com, result.inertia
    numbers = [("mass", "kg", mass.value, mass.interval95, mass.use)]
    for k, (x, ends) in enumerate(zip(com.value, com.interval95, strict=True)):
        use = com.use if k == 0 or not np.isfinite(x) else ""
        numbers.append((f"centre of mass {'xyz'[k]}", "mm", 1e3 * x, 1e3 * ends, use))
    for i, j in SIX[:entries]:
        use = inertia.use if (i, j) == (0, 0) or result.assumed else ""
        name = f"inertia {'XYZ'[i]}{'XYZ'[j]} at com"
        numbers.append((name, "kg m²", inertia.value[i, j], inertia.interval95[i, j], use))
    rows = [
        (name, unit, *(with_interval(float(x), *ends.tolist()) if np.isfinite(x) else ("-", "-")), use)
        for name, unit, x, ends, use in numbers
    ]
    headings = (*columns(("", "unit"), ("value", "95 % interval")), Column("", folds=True))
    return Table(f"Payload in {result.frame}", headings, rows, ("mass", "centre of mass z"), "quantities")


def answer_notes(result: PayloadResult) -> list[str]:
    """Reason for the method, an assumed inertia, scale, other ways to the mass, repeats, worst joint, gains."""
    worst, chosen = result.joint_that_agrees_least, result.recommended
    return [
        *([f"Method {chosen.method}: {chosen.reason}."] if chosen is not None and chosen.reason else []),
        *([f"Inertia ASSUMED, not measured: {result.assumed.inertia}."] if result.assumed else []),
        *verdict_notes(result.verdict),
        *scale_notes(result),
        *(
            f"Another way, {way.name}: {array(way.mass):.4g} kg, centre of mass "
            f"({', '.join('-' if not np.isfinite(x) else f'{1e3 * x:.1f}' for x in way.com)}) mm."
            for way in present(result.agreement) or ()
        ),
        *_repeat_notes(result),
        f"Joint that agrees least: {worst}." if worst else "No joint can be compared with the others.",
        *gain_error_notes(result.settings, result.gains),
    ]


def scale_notes(result: PayloadResult) -> list[str]:
    """The mass from a scale or from CAD beside that by the torques."""
    if result.mass_from_scale and result.scale:
        mass, sigma = result.scale
        return [f"Mass: the scale's {mass:g} ± {sigma:g} kg; the torques of these joints do not contain it."]
    lines = [
        f"Scale {weighing.mass:g} ± {weighing.sigma:.2g} kg, torques {weighing.identified:.4g} ± "
        f"{weighing.identified_sigma:.2g} kg: {abs(array(weighing.z)):.1f} sigma apart, "
        f"{'which contradict each other' if array(weighing.p_value) < CONFLICT else 'in agreement'}."
        for weighing in present((result.best or result.best_free).weighed) or ()
    ]
    return lines or ["Not weighed: --mass KG+-KG compares with a scale, and sharpens the centre of mass."]


def _repeat_notes(result: PayloadResult) -> list[str]:
    """Spread and drift of several recordings."""
    repeats = present(result.repeats)
    if repeats is None:
        return []
    _, masses, sigmas = seen(repeats)
    each = ", ".join(f"{m:.4g} ± {s:.2g}" for m, s in zip(masses, sigmas, strict=True))
    lines = [f"{len(repeats.masses)} recordings, each alone [kg]: {each}; spread {array(repeats.spread):.2g} kg."]
    if repeats.drift_per_recording is not None:
        trend = "a drift" if repeats.drifts else "no clear drift"
        step, sigma = repeats.drift_per_recording, array(repeats.drift_sigma)
        lines.append(f"From one to the next {step:+.2g} ± {sigma:.2g} kg: {trend}.")
    if repeats.excess is not None and repeats.excess > 1.0:
        lines.append(
            f"They scatter {repeats.excess:.2g} times as much as each says: all intervals are widened by that."
        )
    return lines


def controller_line(result: PayloadResult) -> str:
    """Mass, centre of mass and, where it may be used, inertia, at the flange; digits as the intervals allow."""
    pose = result.flange
    turn, origin = (pose.R, pose.p) if pose is not None else (np.eye(3), np.zeros(3))
    where = "" if is_flange(result.frame) else f" in {result.frame}"
    where = " at the flange" if pose is not None else where
    com = _numbers(1e3 * (turn.T @ (result.com.value - origin)), 1e3 * result.com.interval95)
    mass = with_interval(float(result.mass), *result.mass.interval95.tolist())[0]
    line, inertia = f"mass {mass} kg, centre of mass ({com}) mm{where}", result.inertia
    moved = turn.T @ inertia.value @ turn
    if result.assumed:
        return f"{line}, inertia there ({', '.join(f'{x:.4f}' for x in np.diag(moved))}) kg m², ASSUMED"
    if inertia.use == "use" and result.best is not None:
        numbers = _numbers(six(moved), inertia.interval95.reshape(9, 2))
        return f"{line}, inertia there XX YY ZZ XY XZ YZ ({numbers}) kg m²"
    return f"{line}, inertia left at zero"


def _numbers(values: Array, intervals: Array) -> str:
    """Numbers with as many digits as the widest of their intervals allows; what is not known is said."""
    widths = np.diff(intervals, axis=1)
    digits = interval_digits(float(np.nanmax(widths, initial=0.0)))
    return ", ".join(
        f"{round(x, digits) + 0.0:.{digits}f}" if np.isfinite(x) else "unknown" for x in values.tolist()
    )


def _improvements(result: PayloadResult, predictions: Sequence[TorquePrediction]) -> list[Block]:
    """List what would improve the answer, beyond a scale and the gains, of which the notes tell."""
    lines, robust = list[str](), present(result.best_free.robust)
    if not result.short and not any(prediction.held_out for prediction in predictions):
        lines.append("Keep one recording without payload out of identification (--validate).")
    if robust and robust.unavailable:
        lines.append(f"Record longer: intervals rest on white noise, because {robust.unavailable}.")
    elif robust and robust.warning:
        lines.append(f"{robust.warning[:1].upper()}{robust.warning[1:]}.")
    return [Text("How to improve it", "heading"), Notes(lines)] if lines else []
