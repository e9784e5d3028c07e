"""The report of a weighing: what to do next, then what it rests on."""

from __future__ import annotations

import numpy as np

from ...common.arrays import Array
from ...estimation import WeighAnswer
from ...estimation.diagnosis import worst_joint
from ...estimation.files import StoredWeighing
from ..controllers.payload_file import is_flange
from ..figures import flange_figure, joints_figure, repeats_figure
from ..gains import gain_error_notes
from ..numbers import with_interval
from ..weigh import agreement_notes, detail_notes, detail_tables, moment, repeat_notes, scale_note, worst_note
from .controller import controller_block
from .data import data_section
from .joints import by_joints_section
from .markup import Html, bullets, joined, paragraph, printed_table, tag
from .page import Page, Section
from .provenance import Provenance, files_table, foot
from .svg import figure_html
from .verdict import Row, grouped_table, pair, reasons, verdict_of


def weigh_page(answer: WeighAnswer, document: StoredWeighing, provenance: Provenance) -> Page:
    """First screen for the one who types the number in, the rest for the one who asks why.

    Args:
        answer: the payload.
        document: the same as ``weigh_document`` gives it.
        provenance: command, files, date.
    """
    robot = answer.problem.robot
    title = f"Payload on the {robot.title or robot.name}"
    joints = answer.problem.joints
    moved = f"joint{'s' * (len(joints) > 1)} {', '.join(map(str, joints))}"
    drawn = joints_figure(answer.by_joints, answer.mass, answer.mass_interval)
    first = (drawn,) if drawn else ()
    head = joined(
        tag("h1", title),
        paragraph(f"Weighed by a motion of {moved}, {provenance.day}", class_="sub"),
        verdict_of(answer.verdict),
        pair(_quantities(answer), _controller(answer, document)),
        tag("h3", "Each joint weighs"),
        paragraph(worst_note(worst_joint(answer.by_joints, answer.mass))),
        *map(figure_html, first),
    )
    sections = (
        *_repeats(answer),
        *_place(answer),
        by_joints_section(answer.by_joints),
        _details(answer),
        data_section(agreement_notes(answer), provenance),
    )
    return Page(title, joined(head, files_table(provenance)), sections, foot(provenance), first)


def _quantities(answer: WeighAnswer) -> Html:
    """Value, 95 % interval and use of each quantity; the scale; why."""
    told: list[str] = [answer.judged[name].use for name in ("mass", "centre of mass", "inertia")]
    if answer.stand_in is not None:
        told[2] = "ASSUMED, not measured"
    caption = f"In {answer.problem.robot.payload_frame}; inertia at the centre of mass"
    groups = (_mass(answer), _com(answer), _inertia(answer))
    assumed = Html()
    if answer.stand_in is not None:
        assumed = paragraph(f"Inertia ASSUMED, not measured: {answer.stand_in.description}.")
    gains = joined(
        *(paragraph(line, class_="note") for line in gain_error_notes(answer.problem.robot, answer.gains))
    )
    why = joined(tag("h3", "Reasons for the verdict"), reasons(answer.verdict))
    scale = paragraph(scale_note(answer))
    repeated = joined(*map(paragraph, repeat_notes(answer)))
    return joined(grouped_table(caption, groups, told), scale, assumed, repeated, gains, why)


def _mass(answer: WeighAnswer) -> list[Row]:
    return _rows(["mass"], np.array([answer.mass]), [answer.mass_interval], "kg")


def _com(answer: WeighAnswer) -> list[Row]:
    bounds = [(1e3 * float(low), 1e3 * float(high)) for low, high in answer.com_interval]
    return _rows(["centre of mass x", "y", "z"], 1e3 * answer.com, bounds, "mm")


def _inertia(answer: WeighAnswer) -> list[Row]:
    found = [moment(answer, k) for k in range(3)]
    values = np.array([value for value, _ in found])
    return _rows(["inertia XX", "YY", "ZZ"], values, [interval for _, interval in found], "kg m²")


def _rows(names: list[str], values: Array, bounds: list[tuple[float, float]], unit: str) -> list[Row]:
    rows = []
    for name, value, pair_ in zip(names, values, bounds, strict=True):
        if not np.isfinite(value):
            rows.append((name, "-", "-"))
            continue
        text, interval = with_interval(float(value), *pair_)
        rows.append((name, f"{text} {unit}", interval))
    return rows


def _controller(answer: WeighAnswer, document: StoredWeighing) -> Html:
    title = answer.problem.robot.title or answer.problem.robot.name
    return joined(tag("h3", "What to type into the controller"), controller_block(document, "this report", title))


def _repeats(answer: WeighAnswer) -> tuple[Section, ...]:
    """Spread and drift, with several recordings."""
    if answer.repeats is None:
        return ()
    drawn = repeats_figure(answer.repeats, answer.mass, answer.mass_interval)
    words = paragraph("Each recording was weighed alone too: the scatter tells what no single one does.")
    return (Section("repeats", "From recording to recording", words, (drawn,) if drawn else ()),)


def _place(answer: WeighAnswer) -> tuple[Section, ...]:
    """Where the centre of mass is, to scale."""
    best = answer.constrained
    if best is None:
        return ()
    measured = answer.judged["inertia"].use == "use"
    drawing = flange_figure(best, measured, is_flange(best.frame))
    return (Section("place", "Where the centre of mass is", Html(), (drawing,)),)


def _details(answer: WeighAnswer) -> Section:
    """Parameters, condition numbers, chi-squared."""
    parameters, *_ = detail_tables(answer)
    content = joined(printed_table(parameters), bullets(detail_notes(answer)))
    return Section("details", "Parameters and what they rest on", content)
