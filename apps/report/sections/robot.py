"""A robot: its description, its identified parameters and drive gains, and the motion that it predicts."""

import math
from collections.abc import Mapping, Sequence
from itertools import count
from pathlib import PurePath

import numpy as np
from msgspec import UnsetType

from ....estimation import GainsResult, RobotResult
from ....estimation.possible.payload import CONFLICT
from ....estimation.results.payload import array, numbers
from ....estimation.results.robot import MountingDocument, Rollout
from ....model import INERTIAL, PAPER, Robot, base_parameters
from ....model.drives import parameter_kind
from ....model.frames import frames_at
from ....model.friction import term_names
from ....model.robot import SOURCED
from ...numbers import joined, percent, with_sigma
from ...rollout import CONSTANT, GROWTH_TIME, IDENTIFIED
from ..blocks import Block, Drawing, Notes, OnPage, Report, Section, Table, Text
from ..figures import BLUE, GREY, ORANGE, log_scale, panels
from . import evidence

_HEADINGS = ("joint", "kind", "alpha", "d", "theta", "r", "from", "to", "speed", "accel.", "torque")
_MOST_NAMED = 8
_GOOD = "use these parameters. The model explains the torques."
_BAD = "do not use these parameters. The reasons say what is wrong."
_STYLES = ((BLUE, "-"), (ORANGE, "--"), (GREY, ":"), ("black", "-."))
_GROWS = 10.0  # an error of the start that grows by more in half a second hides what the parameters do
_WORDS = (
    "Open loop: from many moments of the recording, the identified robot is driven by the measured torques alone. "
    "Replay: a controller tracks the measured path, and its torque is compared with the measured one (slow rows "
    "left out). Friction is smoothed near rest, so joints creep where real ones stick."
)


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
    vectors = (flange.p, flange.R[:, 2], flange.R[:, 0], np.array(robot.gravity))
    place, along_z, along_x, gravity = (joined(vector + 0.0, ".5g") for vector in vectors)
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
    flange_text, links = "", robot.links
    if robot.flange_pose is not None:
        position = joined((1e3 * value for value in robot.flange_pose.origin), "g")
        turn = joined((math.degrees(angle) + 0.0 for angle in robot.flange_pose.rpy), "g")
        flange_text = f"The maker's flange is at ({position}) mm, rpy ({turn}) deg in the payload's frame."
    told = (
        f"Payloads are given in {robot.payload_frame}.",
        f"With all joints at zero, that frame is at ({place}) m from the base, z along ({along_z}), x along "
        f"({along_x}).",
        f"Gravity in frame 0: ({gravity}) m/s^2.",
        f"Drives: {known}{'; torque sensors on the link side' if drives.side == 'link' else ''}.",
        f"Rated payload: {robot.rated_payload:g} kg." if math.isfinite(robot.rated_payload) else "",
        f"Links of the file: {links.base}, {', '.join(links.names)}; {links.tip}." if links is not None else "",
        f"Mass of the arm, including its base: {robot.mass:g} kg." if robot.mass is not None else "",
        flange_text,
        *(f"Joint names in logs: {', '.join(names)}." for names in robot.joint_names),
        *(f"{names[0].upper()}{names[1:]}: {source}." for source, names in _grouped(sources).items()),
        *(f"Note: {note}" for note in robot.snapped),
    )
    title = f"{robot.title or robot.name}: modified DH (Khalil-Kleinfinger), degrees and m"
    return [Table(title, _HEADINGS, rows), Notes(told)]


def base_description(robot: Robot) -> list[Block]:
    """Base parameters, what is grouped in each, and standard parameters that no motion shows."""
    base = base_parameters(robot)
    rows = [tuple(line.split(" = ", 1)) for line in base.groupings()]
    counted = f"{len(base.columns)} base parameters of {len(base.standard)} standard ones"
    hidden = f"Without effect on any torque: {', '.join(base.unidentifiable)}." if base.unidentifiable else ""
    return [Table(f"{robot.title or robot.name}: {counted}", ("", "grouping"), rows), Notes([hidden])]


def assumed_notes(robot: Robot, *parts: str) -> list[str]:
    """Assumptions about a robot; ``parts``: of ``model.robot.SOURCED``, all of them by default."""
    grouped = _grouped(robot.assumed(*parts))
    return [f"Assumed, because not published: {names} ({rule})." for rule, names in grouped.items()]


def _grouped(parts: Mapping[str, str]) -> dict[str, str]:
    said: dict[str, list[str]] = {}
    for part in sorted(parts, key=list(SOURCED).index):
        said.setdefault(parts[part], []).append(SOURCED[part])
    return {text: ", ".join(names) for text, names in said.items()}


def robot_report(result: RobotResult, document: str | None = None) -> Report:
    """Verdict, residual and friction of each joint; every parameter, torques; ``document``: its JSON file."""
    # What was read from a file has no errors to draw.
    rolled = list(map(_rolled, [rollout for rollout in result.rollouts or () if rollout.working], count(1)))
    verdict, made, estimate, held_out = result.judged, result.working, result.estimate, result.validation
    after = f"'dynident payload --robot-parameters {document or 'robot.json'} --loaded LOG'"
    ask = "" if document or not made else "add --json robot.json, then "
    on_held_out = f"; {percent(float(array(held_out.relative)))} on the recording held out" if held_out else ""
    known = int((estimate.total_sigma <= 0.1 * np.abs(estimate.values)).sum())
    possible = ""
    if result.constrained is not None:
        possible = "They are physically consistent within their uncertainty."
        if (p_value := float(array(result.constrained.p_value))) < CONFLICT:
            possible = f"They are not physically consistent: no robot can have them (p {p_value:.2g})."
    told = (
        f"The model leaves {percent(estimate.fit.relative)} of the torque unexplained{on_held_out}.",
        f"{len(result.columns)} base parameters: {known} are known to 10 % (1 sigma), "
        f"{len(result.essential)} are essential.",
        possible,
        evidence.MEND if verdict.reasons else f"Next: {ask}{after}.",
    )
    notes = [f"Note: {text}." for text in verdict.notes]
    # What of each joint's torque is not explained, and its friction as far as it was identified.
    residuals = {"unexplained": estimate.fit.relative_per_joint}
    residuals |= {"held out": array(held_out.relative_per_joint, 0)} if held_out else {}
    rows, sigmas = list[tuple[str, ...]](), map(with_sigma, estimate.values, estimate.total_sigma)
    friction = dict(zip(estimate.names, sigmas, strict=True))
    for j, kind in enumerate(result.joints or ("revolute",) * len(estimate.fit.rows), 1):
        unit = "N·m" if kind == "revolute" else "N"
        ratios = [percent(float(relative[j - 1])) for relative in residuals.values()]
        coulomb, viscous = friction.get(f"FS{j}", "-"), friction.get(f"FV{j}", "-")
        rows.append((f"joint {j}", *ratios, coulomb, unit, viscous, f"{unit}·s"))
    headings = ("", *residuals, "Coulomb friction", "unit", "viscous friction", "unit")
    worst, *shown = evidence.explained(made, lambda: made.held_out or made.recordings)
    first = [
        Text(f"Verdict: {_BAD if verdict.reasons else _GOOD}", level="do_not_use" if verdict.reasons else "use"),
        *evidence.reason_blocks(verdict),
        Table(f"Torques of {result.title}", headings, rows),
        Notes(told),
        Notes([*(line for line, _ in rolled), *notes, *evidence.model_notes(result)], optional=True),
        worst,
    ]
    predicted = [Text(_WORDS), *(block for _, blocks in rolled for block in blocks)]
    sections = (
        robot_section(result),
        *([Section("rollout", "Predicted motion", predicted)] if rolled else []),
        *shown,
        evidence.essential_section(result.elimination or None, result.title),
    )
    robust = estimate.robust
    if robust is None:
        why_not = result.robust.unavailable if result.robust else None
        formula = f"± by the formula alone: {why_not}" if why_not else ""
        source = ["± one standard deviation by (17)-(19), for white torque noise.", formula]
    else:
        low, middle, high = np.quantile(robust.sigma / np.maximum(estimate.sigma, 1e-300), (0.0, 0.5, 1.0))
        blocks = f"jackknife over {robust.blocks} blocks of {robust.block_length:.2g} s or more"
        source = [
            "± and % by the larger of the formula's (17)-(19) and the block jackknife's standard deviation; what "
            "is essential goes by the formula's.",
            f"sigma_robust/sigma ({blocks} to formula): median {middle:.2f}, {low:.2f} to {high:.2f}; above 1 "
            "where errors of the torque last longer than a sample. chi2 and p by the jackknife's.",
            robust.warning,
        ]
    data = (
        evidence.conditioning(result.data.equations, len(result.columns), result),
        f"Relative residual: {evidence.residual_text(estimate.fit)}",
        f"On the validation recording: {evidence.residual_text(held_out)}" if held_out else "",
        *source,
    )
    title, more = f"Dynamic parameters of the {result.title}", "all base parameters, residuals, essential ones"
    return Report(title, first, sections, more, "Identified from recordings without payload", data)


def robot_section(result: RobotResult) -> Section:
    """Base parameters with the larger sigma, beside those of a robot that can exist; friction that was tried."""
    estimate, nearest = result.estimate, result.constrained
    moved = [each.value for each in nearest.base_parameters] if nearest and nearest.base_parameters else None
    further = [("by gains", estimate.sigma_by_gains, ".2g"), ("constrained", moved, ".4g")]
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
    tables = [Table(f"Base parameters of {result.title}, SI units", headings, rows)]
    if nearest is not None and nearest.parameters:
        rows = []
        for each in nearest.parameters:
            prior = "" if isinstance(each.prior, UnsetType) else f"{each.prior + 0.0:.4g}"
            ratio = f"{100.0 * array(each.share):.0f} %"
            rows.append((each.name, f"{each.value:.4g}", prior, ratio, each.decided_by or ""))
        ends = [each.name for each in nearest.parameters if parameter_kind(each.name) == INERTIAL[-1]]
        title = f"Standard parameters of {result.title}, SI units"
        tables.append(Table(title, ("", "value", "prior", "data", "decided by"), rows, ends))
    if terms := result.friction:
        rows = []
        for term in terms:
            falls, error = (f"{100 * array(x):.1f}" for x in (term.fall, term.error))
            rows.append((term.name, falls, error, "kept" if term.kept else term.why_not or ""))
        headings = ("", "error falls by, %", "its standard error, %", "")
        tables.append(Table("Terms of friction, on blocks of time that were held out", headings, rows))
    notes: Sequence[str] = ()
    if nearest is not None:
        p_value = f"p {array(nearest.p_value):.2g} for {len(result.columns)} parameters"
        smallest = min((nearest.min_eigenvalues or {"": float("nan")}).values())
        active, hidden = nearest.active or (), nearest.unidentifiable or ()
        held = [f"{holding.description} ({holding.multiplier:.2g})" for holding in active[:_MOST_NAMED]]
        unnamed = f" and {len(active) - len(held)} more" if len(active) > len(held) else ""
        single = [text for text in hidden if " " not in text]
        prior = ""
        if nearest.prior:
            least = float(array(nearest.prior.nearest_chi2_rise))
            prior = (
                f"Prior: {nearest.prior.source}; chi2 {nearest.chi2_rise - least:.3g} above the constrained "
                f"minimum of {least:.3g}. What the prior decides is not identified."
            )
        notes = (
            f"Constrained: the nearest robot that can exist; chi2 rises by {nearest.chi2_rise:.3g} ({p_value}); "
            f"smallest eigenvalue of a link {smallest:.2g}; {nearest.status}.",
            prior,
            f"Held back by (multiplier): {', '.join(held)}{unnamed}." if held else "",
            f"No motion shows {', '.join(single)}{' and ' * bool(single)}{len(hidden) - len(single)} "
            "combinations of standard parameters (the JSON lists them).",
        )
    return Section("parameters", "Base parameters of the robot", [*tables, Notes(notes)])


def gains_report(gains: GainsResult, document: str | None = None) -> Report:
    """Gains and verdict, the weight as each joint sees it, the torques; ``document``: the JSON file."""
    level, made, load, robust = gains.judged.level, gains.working, gains.load, gains.robust
    mounted, drives, residual = bool(load and load.mountings), gains.drive_gains, gains.relative_residual
    ask = "" if document or not made else "add --json gains.json, then "
    after = f"Next: {ask}give --drive-gains {document or 'gains.json'} to 'dynident payload'."
    sigma, n = np.sqrt(np.diag(drives.relative_covariance)), len(drives.values)
    unexplained = array(residual.relative_per_joint if residual else None, n)
    parts = zip(drives.values, sigma, unexplained, drives.rests_on or ("",) * n, strict=True)
    rows = [
        (str(j), f"{value:.3f}", f"{value * ratio:.2g}", f"{100 * ratio:.2g}", f"{100 * left:.1f}", word)
        for j, (value, ratio, left, word) in enumerate(parts, start=1)
    ]
    worst, torques, _ = evidence.explained(made)
    first = [
        Text(f"Verdict: {'use every gain' if level == 'use' else evidence.VERDICTS[level]}.", level=level),
        Table(f"Drive gains of {gains.robot}", ("motor", "N·m/A", "sigma", "%", "residual %", "rests on"), rows),
        Notes([after if level != "do_not_use" else evidence.MEND]),
        *evidence.reason_blocks(gains.judged),
        Notes([f"Note: {text}." for text in gains.judged.notes], optional=True),
        worst,
    ]
    sections = []
    for name, known, by_joints in zip(made.mountings, made.loads, made.by_joints, strict=True) if made else ():
        section = evidence.joints_section(by_joints.masses, (known.mass,) * 3, f"_{name}")
        title = f"The known weight as each joint sees it{f', mounting {name}' if mounted else ''}"
        sections.append(section._replace(title=title))
    notes = list[str]()
    if load:
        given, error = load.known or {}, float(array(load.mass_sigma))
        for k, mounting in enumerate(load.mountings or (MountingDocument(1, load.identified or {}),), start=1):
            number, ten = str(k) if k > 1 else "", numbers(mounting.identified)
            notes.append(
                f"Payload{f', mounting {mounting.mounting}' if mounted else ''}: "
                f"{given.get(f'M_L{number}', np.nan):.4g} kg as given (sigma {error:.2g} kg), centre of mass "
                f"{joined(ten[6:9] / ten[9], '.4f', ' ')} m, "
                f"{'as given' if f'MX_L{number}' in given else 'estimated'}."
            )
    unconstrained = joined(array(drives.without_constraints, 0), ".3f", " ")
    widened = gains.disagreement or 1.0
    source = f"sigma comes from the formula for white noise: {(robust and robust.unavailable) or ''}"
    if robust and robust.blocks is not None:
        blocks = f"{robust.blocks} blocks of {float(array(robust.block_length)):.2g} s or more"
        source = f"sigma: the larger of the formula's and that of a jackknife over {blocks}."
    notes += [
        "Every gain scales with the mass given: an error of 1 % in it is 1 % in each gain, and shows nowhere"
        + (" unless weights differ." if mounted else "."),
        f"Relative residual of the currents: {100 * array(residual.relative if residual else None):.2f} %.",
        f"Without the constraint that robot and payload can exist: {unconstrained}.",
        *([f"Every sigma is {widened:.2g} times larger because the joints disagree."] if widened > 1.0 else []),
        source,
        *([robust.warning] if robust and robust.warning and robust.blocks is not None else []),
    ]
    title = f"Drive gains of the {gains.robot_title or gains.robot}"
    subtitle = "Identified from recordings of motor currents with a known weight"
    return Report(title, first, [*sections, torques], "the payload, residuals, origin of sigma", subtitle, notes)


def rollout_report(rollouts: Sequence[Rollout], robot: str) -> Report:
    """Errors by horizon and the replay of the first recording, a line of each other; then all of them."""
    (_, (table, *more, notes)), *others = map(_rolled, rollouts, count(1))
    blocks = [Text(_WORDS), *more, *(block for _, parts in others for block in parts)]
    first = [table, notes, Notes([line for line, _ in others], optional=True)]
    section, details = Section("rollout", "Predicted motion", blocks), "every recording, starts at rest"
    title, subtitle = f"Predicted motion of the {robot}", "Of recordings that were not fitted"
    return Report(title, first, [section], details, subtitle)


def _rolled(rollout: Rollout, number: int) -> tuple[str, list[Block]]:
    """Error after the longest horizon and the replay in one line; errors by horizon, a figure and the replay."""
    errors, moving, resting = rollout.working, rollout.starts_in_motion, rollout.starts_at_rest
    unit, size = ("deg", math.pi / 180.0) if errors.turning else ("rad or m", 1.0)
    last, name, replayed = rollout.horizons[-1], PurePath(rollout.source).name, 100.0 * rollout.replay_relative
    longest = last.in_motion or last.at_rest or {}
    ours, constant = (f"{longest[by][0] / size:.2g}" for by in (IDENTIFIED, CONSTANT))
    replay = f"replayed, torques {replayed:.2g} % off."
    line = f"Motion of {name}: {ours} {unit} off after {last.seconds:g} s (constant speed {constant}); {replay}"

    def draw() -> list[Block]:
        figure, ((axis,),) = panels((5.8, 3.2))
        for by, (colour, style) in zip(errors.by, _STYLES, strict=False):
            spreads = (errors.spreads(seconds, not moving)[by] for seconds in errors.times)
            low, high = np.array(list(spreads)).T / size
            axis.plot(errors.times, low, color=colour, linestyle=style, label=by)
            axis.fill_between(errors.times, low, high, color=colour, alpha=0.2, linewidth=0)
        log_scale(axis)
        axis.set(xlabel="time after the start [s]", ylabel=f"error [{unit}]")
        axis.legend(fontsize=9, frameon=False)
        caption = (
            f"Distance of predicted from measured motion on {rollout.source}, root mean square over the joints: "
            "median of the starts, shaded up to 90 %."
        )
        return [Drawing(f"rollout_{number}", caption, figure)]

    headings = ("after", *(heading for by in errors.by for heading in (by, f"{by}, 90 %")))
    blocks: list[Block] = []
    for how, starts in (("in motion", moving), ("at rest", resting)):
        rows = []
        for horizon in rollout.horizons:
            spreads = (horizon.at_rest if how == "at rest" else horizon.in_motion) or {}
            cells = (f"{error / size:.3g}" for spread in spreads.values() for error in spread)
            rows.append((f"{horizon.seconds:g} s", *cells))
        title = f"{name}: error [{unit}], median and 90 % of {starts} starts {how}"
        blocks += [Table(title, headings, rows)] if starts else []
    joints = joined(100.0 * np.array(rollout.replay_joints), ".1f", " ")
    hides = ": open loop says nothing here, whatever the parameters; go by the replay" * (rollout.growth > _GROWS)
    grows = f"An error of the start grows {rollout.growth:.2g}-fold within {GROWTH_TIME:g} s{hides}."
    diverged = f"{rollout.diverged} of {moving + resting} starts of the identified robot diverged."
    told = (
        f"Replay: torque {replayed:.2g} % from the measured one (joints {joints} %), path kept to "
        f"{rollout.replay_strayed / size:.2g} {unit}.",
        grows if rollout.growth == rollout.growth else "",
        diverged if rollout.diverged else "",
    )
    return line, [*blocks, OnPage(draw), Notes(told, optional=True)]
