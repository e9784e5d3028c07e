"""A robot: its description, and its identified parameters."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from msgspec import UnsetType

from ....common.schema import present
from ....estimation.possible.payload import CONFLICT
from ....estimation.results.parts import PossibleParameter
from ....estimation.results.payload import array
from ....estimation.results.robot import RobotResult
from ....model import INERTIAL, Robot
from ....model.drives import parameter_kind
from ....model.frames import frames_at
from ....model.friction import PAPER, term_names
from ....model.robot import SOURCED
from ...numbers import percent
from ...rollout import Rollout
from ..blocks import Banner, Block, Notes, Report, Section, Table, with_sigma
from .evidence import (
    MEND,
    conditioning,
    friction_notes,
    gain_error_notes,
    reason_blocks,
    residual_text,
    torques_section,
    verdict_notes,
    worst_torque,
)
from .parameters import essential_section, excitation_section
from .rollout import rollout_line, rollout_section

_HEADINGS = ("joint", "kind", "alpha", "d", "theta", "r", "from", "to", "speed", "accel.", "torque")
_MOST_NAMED = 8
_GOOD = "The model explains the torques: the parameters can be used."
_BAD = "Do not use these parameters: the model does not explain the torques."


def robot_description(robot: Robot) -> list[Block]:
    """Modified DH table with limits, angles in degrees; and what else a user should know before using it."""
    rows = []
    for number, joint in enumerate(robot.joints, start=1):
        name = f"{number}" if robot.links is None else f"{number} {robot.links.joints[number - 1]}"
        geometry = (math.degrees(joint.alpha), joint.d, math.degrees(joint.theta), joint.r)
        limits, scale = joint.limits, math.degrees(1.0) if joint.revolute else 1.0
        motion = (scale * x for x in (*limits.position, limits.speed, limits.acceleration))
        cells = (f"{x:.5g}" if math.isfinite(x) else "" for x in (*motion, limits.torque))
        rows.append((name, joint.kind, *(f"{value:.6g}" for value in geometry), *cells))
    flange, drives = frames_at(robot, [0.0] * robot.n)[-1], robot.drives
    sources = {part: source for part, source in robot.sources.items() if part in SOURCED}
    terms = "" if drives.friction == PAPER else f" ({', '.join(term_names(drives.friction))})"
    modelled = {
        "rotor inertia": drives.rotor_inertia,
        f"friction{terms}": drives.friction,
        "offsets": drives.offsets,
        "coupled drives": drives.coupling is not None,
        "a gravity spring": drives.spring is not None,
    }
    known = ", ".join(word for word, there in modelled.items() if there) or "none of their parameters"
    lines = [
        f"Payloads are given in: {robot.payload_frame}",
        f"At the zero pose that frame stands at {_vector(flange.p.tolist())} m in the base, "
        f"z along {_vector(flange.R[:, 2].tolist())}, x along {_vector(flange.R[:, 0].tolist())}.",
        f"Gravity in frame 0: {_vector(list(robot.gravity))} m/s^2.",
        f"Drives: {known}{'; torque sensors on the link side' if drives.side == 'link' else ''}.",
    ]
    if math.isfinite(robot.rated_payload):
        lines.append(f"Rated payload: {robot.rated_payload:g} kg.")
    if robot.links is not None:
        lines.append(f"Links of the file: {robot.links.base}, {', '.join(robot.links.names)}; {robot.links.tip}.")
    if robot.mass is not None:
        lines.append(f"Mass of the arm, base and all: {robot.mass:g} kg.")
    if robot.flange_pose is not None:
        position = ", ".join(f"{1e3 * value:g}" for value in robot.flange_pose.origin)
        turn = ", ".join(f"{math.degrees(angle) + 0.0:g}" for angle in robot.flange_pose.rpy)
        lines.append(f"The maker's flange stands at ({position}) mm, rpy ({turn}) deg in the payload's frame.")
    lines += [f"Joints are also called {', '.join(names)}." for names in robot.joint_names]
    lines += [f"{names[0].upper()}{names[1:]}: {source}." for source, names in _grouped(sources).items()]
    lines += [f"Note: {note}" for note in robot.snapped]
    title = f"{robot.title or robot.name}: modified DH (Khalil-Kleinfinger), degrees and m"
    return [Table(title, _HEADINGS, rows), Notes(lines)]


def assumed_notes(robot: Robot, *parts: str) -> list[str]:
    """Assumptions about a robot; ``parts``: of ``model.robot.SOURCED``, all of them by default."""
    grouped = _grouped(robot.assumed(*parts))
    return [f"Assumed, not published: {names} ({rule})." for rule, names in grouped.items()]


def _grouped(parts: Mapping[str, str]) -> dict[str, str]:
    said: dict[str, list[str]] = {}
    for part in sorted(parts, key=list(SOURCED).index):
        said.setdefault(parts[part], []).append(SOURCED[part])
    return {text: ", ".join(names) for text, names in said.items()}


def _vector(values: list[float]) -> str:
    return "(" + ", ".join(f"{value + 0.0:.5g}" for value in values) + ")"


def robot_report(result: RobotResult, rollouts: Sequence[Rollout] = (), document: str | None = None) -> Report:
    """Verdict, residual and friction of each joint; then every parameter, torques and excitation.

    ``rollouts`` are predicted motions of recordings, ``document`` the JSON file that it was written to.
    """
    verdict, made = result.judged, result.working
    after = f"'dynident payload --robot-parameters {document or 'robot.json'} --loaded LOG'"
    ask = "" if document or not made else "add --json robot.json, then "
    following = MEND if verdict.reasons else f"Next: {ask}{after}."
    labels = dict(zip(made.base.columns, made.base.names, strict=True)) if made else {}
    count = len(made.held_out or made.recordings) if made else 0
    notes = [
        *verdict_notes(verdict),
        *friction_notes(present(result.friction) or ()),
        *gain_error_notes(result.processing, result.gains),
    ]
    estimate, held_out, constrained = result.estimate, result.validation, result.constrained
    on_held_out = f"; {percent(float(array(held_out.relative)))} on the recording held out" if held_out else ""
    known = int((estimate.total_sigma <= 0.1 * np.abs(estimate.values)).sum())
    lines = [
        f"The model leaves {percent(estimate.fit.relative)} of the torque unexplained{on_held_out}.",
        f"{len(result.columns)} base parameters, {known} of them known to 10 % (1 sigma), "
        f"{len(result.essential)} essential.",
    ]
    if constrained is not None:
        p_value = float(array(constrained.p_value))
        contradicted = f"No robot that can exist comes near them (p {p_value:.2g})."
        possible = "A robot that can exist has these parameters within their uncertainty."
        lines.append(contradicted if p_value < CONFLICT else possible)
    first = [
        Banner("do_not_use" if verdict.reasons else "use", f"Verdict: {_BAD if verdict.reasons else _GOOD}"),
        *reason_blocks(verdict),
        joint_table(result),
        Notes([*lines, following]),
        Notes([*map(rollout_line, rollouts), *notes], optional=True),
        worst_torque(lambda: made.predictions),
    ]
    sections = (
        robot_section(result),
        *([rollout_section(rollouts)] if rollouts else []),
        torques_section(lambda: made.predictions, count),
        excitation_section(lambda: made.excitation, labels),
        essential_section(present(result.elimination), result.title),
    )
    data = [
        conditioning(result.data.equations, len(result.columns), result),
        f"Relative residual: {residual_text(estimate.fit)}",
        *([f"On the validation recording: {residual_text(held_out)}"] if held_out else []),
        *robot_sigma_notes(result),
    ]
    title, more = f"Dynamic parameters of the {result.title}", "every base parameter, residuals, what is essential"
    return Report(title, first, sections, more, "Identified from recordings without payload", data)


def joint_table(result: RobotResult) -> Table:
    """Tabulate each joint's unexplained torque, and its friction as far as it was identified."""
    estimate, held_out = result.estimate, result.validation or None
    residuals = [estimate.fit.relative_per_joint, *([array(held_out.relative_per_joint, 0)] if held_out else [])]
    sigma = dict(zip(estimate.names, estimate.total_sigma, strict=True))
    rows = []
    for j, kind in enumerate(present(result.joints) or ("revolute",) * len(estimate.fit.rows), 1):
        unit = "N·m" if kind == "revolute" else "N"
        shares = [percent(float(relative[j - 1])) for relative in residuals]
        coulomb, viscous = (
            with_sigma(estimate[name], float(sigma[name])) if name in sigma else "-"
            for name in (f"FS{j}", f"FV{j}")
        )
        rows.append((f"joint {j}", *shares, coulomb, unit, viscous, f"{unit}·s"))
    fits = ("unexplained", *(["held out"] if held_out is not None else []))
    headings = ("", *fits, "Coulomb friction", "unit", "viscous friction", "unit")
    return Table(f"Torques of {result.title}", headings, rows)


def robot_table(result: RobotResult) -> Table:
    """Base parameters with standard deviations, beside those of a robot that can exist.

    Where the estimate has robust standard deviations too, each entry shows the larger of both; errors of the drive
    gains, where they are not taken as exact, are part of it, and stand by themselves in a column.
    """
    estimate, constrained = result.estimate, result.constrained and present(result.constrained.base_parameters)
    nearest = [parameter.value for parameter in constrained] if constrained else None
    further = [("by gains", estimate.sigma_by_gains, ".2g"), ("constrained", nearest, ".4g")]
    shown = [(heading, values, form) for heading, values, form in further if values is not None]
    rows: list[tuple[str, ...]] = []
    for k, parameter in enumerate(result.base_parameters):
        name, grouping = parameter.name or estimate.names[k], parameter.grouping or ""
        value, sigma = estimate.values[k], estimate.total_sigma[k]
        ratio = 100.0 * sigma / abs(value) if value != 0.0 else float("inf")
        grouped = grouping.split(" = ", 1)[1] if name.endswith("R") and " = " in grouping else ""
        more = (format(values[k], form) for _, values, form in shown)
        essential = "yes" if parameter.essential is True else ""
        rows.append((name, with_sigma(value, sigma), f"{ratio:.3g}", *more, essential, grouped))
    headings = ("", "value", "%", *(heading for heading, *_ in shown), "essential", "grouping")
    return Table(f"Base parameters of {result.title}, SI units", headings, rows)


def standard_table(parameters: Sequence[PossibleParameter], title: str) -> Table:
    """Standard parameters of the robot nearest to the prior, and who decides each."""
    rows = []
    for each in parameters:
        prior = "" if isinstance(each.prior, UnsetType) else f"{each.prior + 0.0:.4g}"
        ratio = f"{100.0 * array(each.share):.0f} %"
        rows.append((each.name, f"{each.value:.4g}", prior, ratio, each.decided_by or ""))
    ends = [parameter.name for parameter in parameters if parameter_kind(parameter.name) == INERTIAL[-1]]
    headings = ("", "value", "prior", "data", "decided by")
    return Table(f"Standard parameters of {title}, SI units", headings, rows, ends)


def robot_sigma_notes(result: RobotResult) -> list[str]:
    """Say where the standard deviations of the robot's table come from, and what speaks against them."""
    estimate, robust = result.estimate, result.estimate.robust
    if robust is None:
        why = result.robust.unavailable if result.robust else None
        formula = [f"± by the formula alone: {why}"] if why else []
        return ["± one standard deviation by (17)-(19), for white torque noise.", *formula]
    low, middle, high = np.quantile(robust.sigma / np.maximum(estimate.sigma, 1e-300), (0.0, 0.5, 1.0))
    return [
        "± and % by the larger of the formula's (17)-(19) and the block jackknife's standard deviation; what is "
        "essential goes by the formula's.",
        f"sigma_robust/sigma (jackknife over {robust.blocks} blocks of {robust.block_length:.2g} s or more to "
        f"formula): median {middle:.2f}, {low:.2f} to {high:.2f}; above 1 where errors of the torque last "
        "longer than a sample. chi2 and p by the jackknife's.",
        *([robust.warning] if robust.warning else []),
    ]


def constrained_notes(result: RobotResult) -> list[str]:
    """Lines on the robot that can exist; none where none was asked for."""
    nearest = result.constrained
    if nearest is None:
        return []
    p_value = f"p {array(nearest.p_value):.2g} for {len(result.columns)} parameters"
    smallest = min((present(nearest.min_eigenvalues) or {"": float("nan")}).values())
    lines = [
        f"Constrained: the nearest robot that can exist; chi2 rises by {nearest.chi2_rise:.3g} ({p_value}); "
        f"smallest eigenvalue of a link {smallest:.2g}; {nearest.status}."
    ]
    if nearest.prior:
        least = float(array(nearest.prior.nearest_chi2_rise))
        lines.append(
            f"Prior: {nearest.source}; chi2 {nearest.chi2_rise - least:.3g} above the constrained minimum of "
            f"{least:.3g}. What the prior decides is not identified."
        )
    active, hidden = present(nearest.active) or (), present(nearest.unidentifiable) or ()
    if active:
        named = [f"{holding.description} ({holding.multiplier:.2g})" for holding in active[:_MOST_NAMED]]
        more = len(active) - len(named)
        lines.append(f"Held back by (multiplier): {', '.join(named)}{f' and {more} more' if more else ''}.")
    single = [text for text in hidden if " " not in text]
    lines.append(
        f"No motion shows {', '.join(single)}{' and ' * bool(single)}{len(hidden) - len(single)} "
        "combinations of standard parameters (the JSON lists them)."
    )
    return lines


def robot_section(result: RobotResult) -> Section:
    """Base parameters with groupings and sigma, beside those of a robot that can exist."""
    tables, nearest = [robot_table(result)], result.constrained
    if nearest is not None and nearest.parameters:
        tables.append(standard_table(nearest.parameters, result.title))
    return Section("parameters", "Base parameters of the robot", [*tables, Notes(constrained_notes(result))])
