"""A robot's own parameters: what the terminal prints, and the report."""

from collections.abc import Sequence

import numpy as np

from ....estimation import Identification
from ....estimation.answers.system import TorquePrediction
from ....estimation.fit.least_squares import Excitation
from ....estimation.possible.prior import PriorRobot
from ....estimation.possible.result import CONFLICT
from ....estimation.possible.robot import PossibleRobot
from ....model import INERTIAL
from ....model.drives import parameter_kind
from ...numbers import percent
from ...rollout import Rollout
from ..blocks import (
    Banner,
    Block,
    Cell,
    Column,
    Notes,
    Page,
    Remarks,
    Screen,
    Section,
    Table,
    Text,
    columns,
    with_sigma,
)
from ..provenance import Provenance
from .data import report_page
from .essential import elimination_notes, essential_section
from .excitation import excitation_section
from .gain_errors import gain_error_notes
from .rollout import rollout_blocks, rollout_line
from .torques import residual_text, torques_section, worst_joint
from .verdict import MEND, VERDICTS, reason_lines, verdict_lines

Constrained = PossibleRobot | None
_MOST_NAMED = 8
_GOOD = "The model explains the torques: the parameters can be used."
_BAD = "Do not use these parameters: the model does not explain the torques."


def robot_screen(
    result: Identification, constrained: Constrained, rollouts: Sequence[Rollout] = (), document: str | None = None
) -> Screen:
    """How well the model explains the torques, joint by joint, and what to do with it; then every parameter."""
    lines = [*robot_notes(result), *elimination_notes(result.elimination, result.warnings)]
    against, known = result.verdict.reasons, [f"Note: {text}." for text in result.verdict.notes]
    first: list[Block] = [
        Notes([f"Verdict: {_BAD if against else _GOOD}"]),
        Remarks(reason_lines(result.verdict)),
        joint_table(result),
        Notes(_what_it_is(result, constrained, document)),
        Remarks([*map(rollout_line, rollouts), *known, *gain_error_notes(result.robot, result.gains)]),
    ]
    details: list[Block] = [*_tables(result, constrained), Notes([*lines, *constrained_notes(constrained)])]
    details += rollout_blocks(rollouts)
    return Screen(first, details, "every base parameter, residuals, what is essential")


def joint_table(result: Identification) -> Table:
    """What each joint's torque leaves unexplained, and its friction, as far as it was identified."""
    estimate = result.estimate
    held_out = result.validation
    residuals = [fit.relative_per_joint for fit in (estimate.fit, held_out) if fit is not None]
    rows = []
    for j, joint in enumerate(result.robot.joints, 1):
        unit = "N·m" if joint.revolute else "N"
        shares = [percent(float(relative[j - 1])) for relative in residuals]
        friction = {
            kind: with_sigma(float(estimate.values[k]), float(estimate.total_sigma[k]))
            for k, name in enumerate(result.base.columns)
            for kind in ("FS", "FV")
            if name == f"{kind}{j}"
        }
        rows.append((f"joint {j}", *shares, friction.get("FS", "-"), unit, friction.get("FV", "-"), f"{unit}·s"))
    fits = ("unexplained", *(["held out"] if held_out is not None else []))
    headings = (
        *columns(("",), (*fits, "Coulomb friction")),
        *columns(("",), ("viscous friction",)),
        *columns(("",)),
    )
    return Table(f"Torques of {result.robot.title or result.robot.name}", headings, rows, style="tight")


def _what_it_is(result: Identification, constrained: Constrained, document: str | None) -> list[str]:
    """The residual in words, what is known, and the next command."""
    after = f"'dynident payload --robot-parameters {document or 'robot.json'} --loaded LOG'"
    estimate, held_out = result.estimate, result.validation
    on_held_out = f"; {percent(held_out.relative)} on the recording held out" if held_out is not None else ""
    known = int((estimate.total_sigma <= 0.1 * np.abs(estimate.values)).sum())
    possible = "A robot that can exist has these parameters within their uncertainty."
    if constrained is not None and constrained.p_value < CONFLICT:
        possible = f"No robot that can exist comes near them (p {constrained.p_value:.2g})."
    return [
        f"The model leaves {percent(estimate.fit.relative)} of the torque unexplained{on_held_out}.",
        f"{len(result.base.columns)} base parameters, {known} of them known to 10 % (1 sigma), "
        f"{len(result.essential)} essential.",
        *([possible] if constrained is not None else []),
        MEND if result.verdict.reasons else f"Next: {'' if document else 'add --json robot.json, then '}{after}.",
    ]


def robot_table(result: Identification, constrained: Sequence[float] | None = None) -> Table:
    """Base parameters with standard deviations, beside those of a robot that can exist.

    Where the estimate has robust standard deviations too, each entry shows the larger of both; errors of the drive
    gains, where they are not taken as exact, are part of it, and stand by themselves in a column.
    """
    estimate = result.estimate
    by_gains = estimate.sigma_by_gains
    beside = [("by gains", by_gains, ".2g"), ("constrained", constrained, ".4g")]
    shown = [(heading, values, form) for heading, values, form in beside if values is not None]
    rows: list[tuple[Cell, ...]] = []
    for k, (name, grouping) in enumerate(zip(result.base.names, result.base.groupings(), strict=True)):
        value, sigma = estimate.values[k], estimate.total_sigma[k]
        share = 100.0 * sigma / abs(value) if value != 0.0 else float("inf")
        essential = "yes" if estimate.names[k] in result.essential else ""
        grouped = grouping.split(" = ", 1)[1] if name.endswith("R") else ""
        more = (format(values[k], form) for _, values, form in shown)
        rows.append((name, with_sigma(value, sigma), f"{share:.3g}", *more, essential, grouped))
    headings = columns(("",), ("value", "%", *(heading for heading, *_ in shown)), ("grouping",))
    headings = (*headings[:-1], Column("essential"), headings[-1])
    return Table(f"Base parameters of {result.robot.title or result.robot.name}, SI units", headings, rows)


def standard_table(result: PriorRobot, title: str) -> Table:
    """Standard parameters of the robot nearest to the prior, and who decides each."""
    priors = {
        f"{kind}{link}": value
        for link, body in enumerate(result.prior.bodies, start=1)
        for kind, value in body.named().items()
    }
    rows = [
        (
            name,
            f"{value:.4g}",
            f"{priors[name] + 0.0:.4g}" if name in priors else "",
            f"{100.0 * result.origins[name].share:.0f} %",
            result.origins[name].decided_by(),
        )
        for name, value in result.parameters.items()
    ]
    ends = [name for name in result.parameters if parameter_kind(name) == INERTIAL[-1]]
    headings = columns(("",), ("value", "prior", "data"), ("decided by",))
    return Table(f"Standard parameters of {title}, SI units", headings, rows, ends)


def robot_notes(result: Identification) -> list[str]:
    """Lines below the robot's table."""
    raw, scaled = result.problem.condition_numbers()
    lines = [
        f"{result.problem.equations} equations, {len(result.base.columns)} parameters; "
        f"condition number {raw:.4g} (SI units, unweighted), {scaled:.3g} with columns scaled.",
        f"Relative residual: {residual_text(result.estimate.fit)}",
    ]
    if result.validation is not None:
        lines.append(f"On the validation recording: {residual_text(result.validation)}")
    lines += robot_sigma_notes(result)
    lines += gain_error_notes(result.robot, result.gains, "±, % and chi2")
    verdict = result.verdict
    if verdict.reasons:
        return [*lines, *verdict_lines(VERDICTS["do_not_use"].payload, verdict)]
    return [*lines, *(f"Note: {text}." for text in verdict.notes)]


def robot_sigma_notes(result: Identification) -> list[str]:
    """Where the standard deviations of the robot's table come from, and what speaks against them."""
    estimate, robust = result.estimate, result.estimate.robust
    if robust is None:
        alone = [f"± by the formula alone: {result.without_robust}"] if result.without_robust else []
        return ["± one standard deviation by (17)-(19), for white torque noise.", *alone]
    low, middle, high = np.quantile(robust.sigma / np.maximum(estimate.sigma, 1e-300), (0.0, 0.5, 1.0))
    return [
        "± and % by the larger of the formula's (17)-(19) and the block jackknife's standard deviation; what is "
        "essential goes by the formula's.",
        f"sigma_robust/sigma (jackknife over {robust.blocks} blocks of {robust.block_length:.2g} s or more to "
        f"formula): median {middle:.2f}, {low:.2f} to {high:.2f}; above 1 where errors of the torque last "
        "longer than a sample. chi2 and p by the jackknife's.",
        *([robust.warning] if robust.warning else []),
    ]


def constrained_notes(result: Constrained) -> list[str]:
    """Lines on the robot that can exist; none where none was asked for."""
    if result is None:
        return []
    p_value = f"p {result.p_value:.2g} for {len(result.free.names)} parameters"
    lines = [
        f"Constrained: the nearest robot that can exist; chi2 rises by {result.chi2_rise:.3g} ({p_value}); "
        f"smallest eigenvalue of a link {min(result.min_eigenvalues):.2g}; {result.status}."
    ]
    if isinstance(result, PriorRobot):
        lines.append(
            f"Prior: {result.prior.source}; chi2 {result.chi2_rise - result.nearest.chi2_rise:.3g} above the "
            f"constrained minimum of {result.nearest.chi2_rise:.3g}. What the prior decides is not identified."
        )
    if result.active:
        named = [f"{active.description} ({active.multiplier:.2g})" for active in result.active[:_MOST_NAMED]]
        more = len(result.active) - len(named)
        lines.append(f"Held back by (multiplier): {', '.join(named)}{f' and {more} more' if more else ''}.")
    alone = [text for text in result.unidentifiable if " " not in text]
    lines.append(
        f"No motion shows {', '.join(alone)}{' and ' * bool(alone)}{len(result.unidentifiable) - len(alone)} "
        "combinations of standard parameters (the JSON lists them)."
    )
    return lines


def robot_page(
    result: Identification,
    constrained: Constrained,
    predictions: Sequence[TorquePrediction],
    excitation: Excitation,
    provenance: Provenance,
    others: int = 0,
    extra: Sequence[Section] = (),
) -> Page:
    """Verdict and residuals first, then parameters, torques and excitation; arguments as for ``payload_page``."""
    title = result.robot.title or result.robot.name
    labels = dict(zip(result.base.columns, result.base.names, strict=True))
    against, worst = result.verdict.reasons, worst_joint(predictions)
    banner = Banner("do_not_use", _BAD) if against else Banner("use", _GOOD)
    lead: list[Block] = [banner, Notes(against), *_summary(result), *([worst] if worst else [])]
    sections = (
        robot_section(result, constrained),
        *extra,
        torques_section(predictions, others),
        excitation_section(excitation, labels),
        essential_section(result.elimination, result.warnings, title, labels),
    )
    subtitle = f"Identified from recordings without payload, {provenance.day}"
    head = f"Dynamic parameters of the {title}"
    return report_page(head, subtitle, lead, sections, robot_notes(result), provenance)


def robot_section(result: Identification, constrained: Constrained) -> Section:
    """Base parameters with groupings and sigma, beside those of a robot that can exist."""
    notes = Notes(constrained_notes(constrained))
    return Section("parameters", "Base parameters of the robot", [*_tables(result, constrained), notes])


def _tables(result: Identification, constrained: Constrained) -> list[Table]:
    tables = [robot_table(result, constrained.values.tolist() if constrained else None)]
    if isinstance(constrained, PriorRobot):
        tables.append(standard_table(constrained, result.robot.title or result.robot.name))
    return tables


def _summary(result: Identification) -> list[Block]:
    raw, scaled = result.problem.condition_numbers()
    fits = [("data that were fitted", result.estimate.fit)]
    if result.validation is not None:
        fits.append(("recording held out", result.validation))
    rows = [
        (name, percent(fit.relative), *(percent(float(share)) for share in fit.relative_per_joint))
        for name, fit in fits
    ]
    joints = (f"joint {j}" for j in range(1, result.robot.n + 1))
    words = (
        f"{result.problem.equations} equations, {len(result.base.columns)} base parameters, "
        f"{len(result.essential)} of them essential; condition number {raw:.3g} (SI units, unweighted), "
        f"{scaled:.3g} with columns scaled."
    )
    return [Text(words), Table("Relative residual", columns(("",), ("all", *joints)), rows)]
