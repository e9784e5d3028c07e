"""A payload by several methods: tables, lines, and the report."""

from collections.abc import Sequence

import numpy as np

from ....estimation import PayloadAnswer, PayloadProblem
from ....estimation.answers.system import TorquePrediction
from ....estimation.fit.least_squares import Excitation
from ....estimation.payload.result import PayloadEstimate
from ....model import INERTIAL
from ...export.controllers.load import is_flange
from ...results import StoredPayload
from ..blocks import Block, Cell, Notes, Page, Pair, Section, Table, Text, columns, with_sigma
from ..figures.by_joints import joints_figure
from ..figures.flange import flange_figure
from ..figures.methods import methods_figure
from ..provenance import Provenance
from .controller import controller_blocks
from .data import report_page
from .essential import essential_section
from .excitation import excitation_section
from .joints import joints_section, mass_by_joints_note
from .quantities import quantities_table
from .recommended import ENDS, UNITS, agreement, centre_section, consistency_section, recommended_table
from .torques import residual_text, torques_section, worst_joint
from .verdict import VERDICTS, improvements, reason_blocks, verdict_banner

_FORMULA = "by (17)-(19): for white torque noise, the torques' scale taken as exact."


def payload_table(estimates: Sequence[PayloadEstimate]) -> Table:
    """Ten parameters by each method, with standard deviations, and what a controller asks for.

    Where an estimate has robust standard deviations too, each entry shows the larger of both.
    """
    rows: list[tuple[Cell, ...]] = []
    for k, kind in enumerate(INERTIAL):
        cells = [with_sigma(e.estimate.values[k], e.larger_sigma[k]) for e in estimates]
        rows.append((kind, UNITS[kind], *cells))
    for k, axis in enumerate("xyz"):
        cells = [with_sigma(e.body.com[k], e.larger_sigma_com[k]) for e in estimates]
        rows.append((f"com {axis}", "m", *cells))
    for i, j in zip(*np.triu_indices(3), strict=True):
        cells = [with_sigma(e.body.inertia_com[i, j], e.larger_sigma_inertia_com[i, j]) for e in estimates]
        rows.append((f"{'XYZ'[i]}{'XYZ'[j]} at com", "kg m²", *cells))
    rows.append(("can exist", "", *("yes" if e.body.physically_consistent else "no" for e in estimates)))
    title = f"Free estimates (least squares alone) in {estimates[0].frame}"
    return Table(title, columns(("", "unit"), [f"method {e.method}" for e in estimates]), rows, ENDS)


def payload_notes(answer: PayloadAnswer) -> list[str]:
    """Lines below the payload table."""
    lines = [*sigma_notes(answer.estimates), *data_notes(answer), mass_by_joints_note(answer.by_joints)]
    return [*lines, *_left_out(answer)]


def data_notes(answer: PayloadAnswer) -> list[str]:
    """Lines on equations, residuals and alignment."""
    problem, robot_fit, validation = answer.problem, answer.robot_fit, answer.validation
    lines = []
    if problem.unloaded is not None:
        raw, scaled = problem.unloaded.condition_numbers()
        lines.append(
            f"Without payload: {problem.unloaded.equations} equations, {len(problem.base.columns)} parameters; "
            f"condition number {raw:.4g} (SI units, unweighted), {scaled:.3g} with columns scaled."
        )
    if robot_fit is not None:
        lines.append(f"Relative residual of the robot's model: {residual_text(robot_fit)}")
    if validation is not None:
        lines.append(f"The same on the validation recording: {residual_text(validation)}")
    if problem.friction and any(estimate.method == 4 for estimate in answer.estimates):
        lines.append(
            "Method 4: friction under load may differ from the robot's own (--friction-change), which the "
            "intervals allow for."
        )
    return [*lines, _alignment(problem)] if problem.pairs else lines


def sigma_notes(estimates: Sequence[PayloadEstimate]) -> list[str]:
    """Where the standard deviations of the payload table come from, and what speaks against them."""
    both = [(e, e.estimate.robust) for e in estimates]
    ratios = [f"method {e.method} {r.sigma[-1] / e.estimate.sigma[-1]:.2f}" for e, r in both if r is not None]
    robust = [r for _, r in both if r is not None]
    if robust:
        by_blocks, by_memory = "the block jackknife's standard deviation", "that by the memory of the errors"
        blocks = f"{robust[0].blocks} blocks of {robust[0].block_length:.2g} s or more"
        how = "memory" if robust[0].by_memory else f"jackknife over {blocks}"
        lines = [
            f"± the larger of the formula's (17)-(19) and {by_memory if robust[0].by_memory else by_blocks}.",
            f"Mass, sigma_robust/sigma ({how} to formula): {', '.join(ratios)}.",
        ]
    else:
        lines = [f"± one standard deviation {_FORMULA}"]
    return [*lines, *sorted({r.warning for r in robust if r.warning}), *_formula_notes(estimates)]


def _formula_notes(estimates: Sequence[PayloadEstimate]) -> list[str]:
    """Why standard deviations of some methods are the formula's alone."""
    by_formula: dict[str, list[str]] = {}
    for e in estimates:
        if e.without_robust:
            by_formula.setdefault(e.without_robust, []).append(str(e.method))
    return [f"± of method {', '.join(methods)} by the formula alone: {why}" for why, methods in by_formula.items()]


def payload_page(
    answer: PayloadAnswer,
    document: StoredPayload,
    predictions: Sequence[TorquePrediction],
    excitation: Excitation | None,
    provenance: Provenance,
    others: int = 0,
    extra: Sequence[Section] = (),
    origin: str = "Identified from recordings of joint positions and torques",
) -> Page:
    """First page for the one who types the number in, the rest for the one who asks why.

    Args:
        predictions: recordings to draw, held out or not.
        excitation: of robot and payload together.
        others: number of recordings that are not drawn.
        extra: sections to stand behind the payload's.
        origin: what kind of data it is, below the title.
    """
    robot, best = answer.problem.robot, answer.recommended
    title = robot.title or robot.name
    labels = dict(zip(answer.problem.base.columns, answer.problem.base.names, strict=True))
    low, high = best.intervals.parameters[9]
    drawn = joints_figure(answer.by_joints, best.mass, (float(low), float(high)))
    sections = (
        centre_section(answer),
        consistency_section(answer),
        methods_section(answer),
        joints_section(answer.by_joints, [drawn] if drawn else ()),
        *extra,
        torques_section(predictions, others),
        excitation_section(excitation, labels),
        essential_section(answer.elimination, answer.warnings, title, labels),
    )
    lead = _lead(answer, predictions, controller_blocks(document, "this report", title))
    subtitle = f"{origin}, {provenance.day}"
    return report_page(f"Payload on the {title}", subtitle, lead, sections, data_notes(answer), provenance)


def methods_section(answer: PayloadAnswer) -> Section:
    """Constrained and free estimates of every method."""
    words = (
        "Methods 3 and 4 on the same trajectories use the same equations: that they agree confirms nothing. "
        "Methods 1 and 2 go through the robot's own parameters."
    )
    tables = recommended_table(answer), payload_table(answer.estimates)
    notes = Notes([*sigma_notes(answer.estimates), *_left_out(answer)])
    return Section("methods", "The methods side by side", [Text(words), methods_figure(answer), *tables, notes])


def _lead(
    answer: PayloadAnswer, predictions: Sequence[TorquePrediction], controller: Sequence[Block]
) -> list[Block]:
    best, worst = answer.recommended, worst_joint(predictions)
    body, intervals = best.body, best.intervals
    quantities = quantities_table(
        best.frame,
        f"; method {best.method}",
        (best.mass, intervals.parameters[9]),
        (body.com, intervals.com),
        (body.inertia_com, intervals.inertia_com),
        VERDICTS[answer.verdict.level].each,
    )
    flange = flange_figure(best, answer.verdict.level == "use", is_flange(best.frame))
    improve = [Text("How to improve it", "heading"), improvements(answer, predictions)]
    shown: list[Block] = [Text("The worst joint", "heading"), worst] if worst else []
    return [
        verdict_banner(answer.verdict),
        Pair([quantities, *agreement(answer)], [Text("What to type into the controller", "heading"), *controller]),
        Pair([*reason_blocks(answer.verdict), *improve, *shown], [flange]),
    ]


def _left_out(answer: PayloadAnswer) -> list[str]:
    return [f"Method {method} left out: {reason}" for method, reason in answer.left_out.items()]


def _alignment(problem: PayloadProblem) -> str:
    lags = sorted(round(pair.lag, 4) + 0.0 for pair in problem.pairs)
    shift = f"{lags[0]:.4f}" if lags[0] == lags[-1] else f"{lags[0]:.4f} to {lags[-1]:.4f}"
    worst = max(problem.pairs, key=lambda pair: pair.max_mismatch)
    return (
        f"{len(lags)} pair{'s' * (len(lags) > 1)} aligned by {shift} s; positions then differ by at most "
        f"{1e3 * worst.max_mismatch:.2f} mrad (rms {1e3 * worst.rms_mismatch:.3f})."
    )
