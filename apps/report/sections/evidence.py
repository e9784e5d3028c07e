"""Parts that several reports share: verdict, errors of the gains, torques, joints, and how well parameters show."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import cycle
from typing import Any

import numpy as np
from msgspec import UnsetType

from .... import estimation
from ....common.schema import present
from ....estimation.fit.covariance import NORMAL95
from ....estimation.fit.estimate import Fit
from ....estimation.fit.linear_problem import Excitation
from ....estimation.payload.by_joints import JointsMass
from ....estimation.results.parts import EliminationDocument, ProcessingDocument, ResidualDocument
from ....estimation.results.payload import PayloadData, TorquePrediction, array
from ....model import Recording
from ...numbers import joined, percent, with_interval, with_sigma
from .. import figures
from ..blocks import Block, Drawing, Notes, OnPage, Section, Table, Text
from ..figures import BLUE, GREY, LAG, ORANGE, Axes

_ROWS = 2000  # of a joint's torques that are drawn, at most
_GAP = 2.5  # steps: a longer one is drawn as a gap
_CURVES = ((BLUE, "--", 1.3), (ORANGE, ":", 1.3), ("black", "-.", 1.0))
_GOOD = 10.0  # ten times the noise: 10 % relative sigma
_LEAST, _MOST = 1e-2, 1e9
_MOST_RATIO = 1.15
"""Above this ratio steps cancel what carries the arm; two of them are shown beyond where elimination ended."""
_MOST_SHOWN = 1e12  # larger numbers are left out
MEND = "Next: fix what the reasons name, run 'dynident check' on the logs, and record again."
"""It follows an answer that is not to be used."""
VERDICTS = {
    "use": "use mass, centre of mass and inertia",
    "mass_and_com_only": "use mass and centre of mass, not the inertia",
    "identified_only": "use only the gains that were identified",
    "do_not_use": "do not use these numbers",
}
"""Each level in words, after "Verdict:"."""


def reason_blocks(verdict: estimation.Verdict) -> list[Block]:
    """The reasons for the verdict."""
    reasons = [f"  - {reason}" for reason in verdict.reasons] or ["All checks passed."]
    return [Text("Reasons for the verdict", heading=True), Notes(reasons, optional=True)]


def model_notes(result: estimation.PayloadResult | estimation.RobotResult) -> list[str]:
    """Lines on friction beside Coulomb and viscous, and on errors of the drive gains that intervals allow for."""
    kept, told, gains = list[str](), "", result.gains
    for term in result.friction or ():
        if term.fall is None:
            told = f"Load-dependent and root-of-speed friction were not tried: {present(term.why_not)}."
        elif term.kept:
            kept.append(f"{term.name} ({100 * term.fall:.0f} ± {100 * array(term.error):.0f} %)")
    if kept:
        falls = "in brackets, how much each lowers the squared error on held-out data (--friction)"
        told = f"Friction terms beyond Coulomb and viscous: {', '.join(kept)}; {falls}."
    # Torque sensors on the link side have scales, motors have gains.
    processing = present(result.processing) or ProcessingDocument()
    scales = "scales of the torque sensors" if processing.torque_side == "link" else "drive gains"
    each = "motor" if processing.coulomb else "joint"
    if gains is None or not (gains.identified or any((*gains.per_joint, gains.common))):
        return [told, f"{scales.capitalize()} are taken as exact; errors in them would not show in any residual."]
    if gains.identified:
        percents = joined(100.0 * np.sqrt(np.diag(gains.covariance(len(gains.identified)))), ".2g")
        line = f"The intervals allow for the errors of the identified drive gains: {percents} % per {each}."
    else:
        percents = joined((100.0 * sigma for sigma in gains.per_joint), "g")
        common = f" and {100.0 * gains.common:g} % common to all joints" if gains.common else ""
        source = ", the default (--gain-sigma changes it)" if gains.assumed else ""
        line = f"The intervals allow for errors of the {scales}: {percents} % per {each}{common}{source}."
    return [told, line, *gains.notes]


def residual_text(fit: Fit | ResidualDocument) -> str:
    """Relative residual in percent, of all joints and of each."""
    joints = joined(100.0 * array(fit.relative_per_joint, 0), ".1f", " ")
    return f"{100.0 * float(array(fit.relative)):.2f} % (joints {joints} %)"


def conditioning(
    equations: int | UnsetType, parameters: int | UnsetType, of: PayloadData | estimation.RobotResult
) -> str:
    """Number of equations and parameters, and the condition number."""
    raw, scaled = array(of.condition_number), array(of.condition_number_scaled)
    size = f"{equations} equations{f', {parameters} parameters' if present(parameters) else ''}"
    return f"{size}; condition number {raw:.4g} (SI units, unweighted), {scaled:.3g} with columns scaled."


def explained(made: Any, used: Callable[[], Sequence[Recording]] = tuple) -> tuple[OnPage, Section, Section]:
    """The worst joint's torque for the first page; all torques of some recordings ``used``; the excitation."""

    def in_words(shown: TorquePrediction) -> str:
        load = "with payload" if shown.loaded else "without payload"
        fitted = "held out of identification" if shown.held_out else "the data that were fitted, not held out"
        return f"{shown.source}{'' if load in shown.source else f' {load}'} ({fitted})"

    def draw(shown: TorquePrediction, row: Sequence[Axes], j: int) -> None:
        above, below, *lagged = row
        # Of long curves every so many points, with gaps where rows are missing.
        every, left = -(-len(shown.t[j]) // _ROWS) or 1, shown.residual(j)
        own = np.array([shown.t[j], shown.measured[j], left, *(curve[j] for curve in shown.curves.values())])
        own = own[:, ::every]
        gaps = np.flatnonzero(np.diff(own[0]) > _GAP * every * shown.step) + 1
        t, measured, residual, *predicted = np.insert(own, gaps, np.nan, axis=1)
        above.plot(t, measured, "-", label="measured", color=GREY, linewidth=2.6)
        for label, values, (colour, line, width) in zip(shown.curves, predicted, cycle(_CURVES), strict=False):
            above.plot(t, values, line, label=label, color=colour, linewidth=width)
        largest = 1.15 * float(np.abs(left).max(initial=0.0)) or 1.0
        below.set_ylim(-largest, largest)
        below.axhline(0.0, color="0.4", linewidth=0.6)
        below.plot(t, residual, color="black", linewidth=0.8)
        for axis in lagged:
            at: dict[str, Any] = {"xycoords": "axes fraction", "ha": "right", "va": "top", "fontsize": 8}
            below.annotate(f"{100.0 * shown.relative_per_joint[j]:.1f} %", (0.99, 0.95), **at)
            axis.plot(*shown.autocorrelation(j), color="black", linewidth=1.0)
            axis.axhline(0.0, color="0.4", linewidth=0.6)
            for level in np.array([-NORMAL95, NORMAL95]) / np.sqrt(max(len(shown.t[j]), 1)):
                axis.axhline(level, color="0.4", linestyle="--", linewidth=0.8)

    def worst() -> list[Block]:
        # Held out before fitted, with payload before without.
        shown = min(made.predictions, key=lambda each: (not each.held_out, not each.loaded), default=None)
        if shown is None:
            return []
        j = int(np.argmax(np.nan_to_num(shown.relative_per_joint, nan=-1.0)))
        figure, ((above,), (below,)) = figures.panels((5.8, 3.2), 2, sharex=True, height_ratios=(2, 1))
        draw(shown, (above, below), j)
        above.set_ylabel(f"joint {j + 1} [N·m]")
        below.set(xlabel="time [s]", ylabel="residual")
        figures.legend(figure, [above])
        caption = (
            f"Joint {j + 1}, the one that the model explains worst: residual "
            f"{100.0 * shown.relative_per_joint[j]:.1f} % of its torque, on {in_words(shown)}. Pauses and slow "
            "rows are left out."
        )
        return [Text("The worst joint", heading=True), Drawing("worst_joint", caption, figure)]

    def torques() -> list[Block]:
        predictions: Sequence[TorquePrediction] = made.predictions
        text = (
            "Residual: measured minus predicted torque. A residual that repeats or persists shows up in the "
            "autocorrelation and is an error of the model; white noise would stay within the dashed lines."
        )
        if not any(shown.held_out for shown in predictions):
            fitted = "so this is the fit itself; new data would fit less well."
            text += f" No recording was held out (--validate), {fitted}"
        if (left_out := len(used()) - len(predictions)) > 0:
            text += f" {left_out} more recordings were used but are not drawn."
        rows, drawings = list[tuple[str, ...]](), list[Drawing]()
        for k, shown in enumerate(predictions, 1):
            rows.append((in_words(shown), *map(percent, shown.relative_per_joint.tolist())))
            caption = (
                f"Every joint on {in_words(shown)}: torque, residual, and the residual's autocorrelation; the "
                "dashed lines hold 95 % of it if the noise were white."
            )
            told = (
                f"Relative residuals of the joints in percent: {joined(100.0 * shown.relative_per_joint, '.1f')}."
            )
            columns = ("torque [N·m]", "residual [N·m]", LAG)
            figure = figures.by_joint(len(shown.t), columns, partial(draw, shown), width_ratios=(5, 3, 2))
            drawings.append(Drawing(f"torques_{k}", caption, figure, f"{caption} {told}"))
        joints = [f"joint {j}" for j in range(1, len(rows[0]))] if rows else []
        headings = ("norm of the residual over norm of the torque", *joints)
        return [Text(text), Table("Relative residual", headings, rows), *drawings]

    def excitation() -> list[Block]:
        excited: Excitation | None = made.excitation
        if excited is None:
            text = (
                "The robot's parameters were read from a file, without their equations. The report of that "
                "identification shows what its motion excited."
            )
            return [Text(text)]
        base = getattr(made, "base", None) or made.problem.base
        labels = dict(zip(base.columns, base.names, strict=True))
        names, weak = [labels.get(name, name) for name in excited.names], list[str]()
        rows = list[tuple[str, ...]]()
        for name, signal, own, ratio in zip(names, excited.signal, excited.independent, excited.share, strict=True):
            relative = percent(1.0 / float(own) if own else float("inf"))
            rows.append((name, f"{signal:.3g}", f"{own:.3g}", percent(float(ratio)), relative))
            weak += [name] if own < _GOOD else []
        figure, (axis,) = figures.named_panels([names])
        whole, alone = (np.clip(x, _LEAST, _MOST) for x in (excited.signal, excited.independent))
        places = np.arange(len(names))
        axis.vlines(places, alone, whole, color="0.6", linewidth=1.0)
        axis.plot(places, whole, "_", color="black", markersize=8, label="its torque")
        axis.plot(places, alone, "o", color=BLUE, markersize=4, label="what no other parameter imitates")
        _limit(axis, _GOOD, "relative sigma 10 %")
        axis.set_ylabel("torque over noise")
        figures.log_scale(axis)
        figures.legend(figure, [axis])
        text = (
            "A parameter is well determined where its torque is large compared with the noise and no combination "
            "of others can imitate it. Sigmas here are the formula's, for white noise; they are relative, so a "
            "small parameter has a large one."
        )
        caption = (
            "Norm of each parameter's torque over all equations, in units of the noise: whole (dash) and without "
            "what other parameters can imitate (dot). One over the dot is the relative standard deviation by (20), "
            "(21)."
        )
        known = f"Relative sigma above 10 %: {', '.join(weak)}." if weak else "All relative sigmas are below 10 %."
        headings = ("", "torque over noise", "its own part", "share", "relative sigma")
        numbers = OnPage(lambda: [Table("Excitation", headings, rows)], "Numbers")
        return [Text(text), Drawing("excitation", caption, figure, f"{caption} {known}"), numbers]

    measured = Section("torques", "Measured and predicted torques", [OnPage(torques)])
    return OnPage(worst), measured, Section("excitation", "Excitation of each parameter", [OnPage(excitation)])


def joints_section(masses: Sequence[JointsMass], agreed: Sequence[float], name: str = "") -> Section:
    """Mass by joints and their shares; ``agreed``: by all, with its interval [kg]; ``name``: of a known weight."""
    known = np.array([(group.mass, *(group.interval95 or (None, None))) for group in masses], dtype=float)
    ratios = np.array([[array(of) for of in (group.share, group.share_sigma)] for group in masses])
    rows, told, single = list[tuple[str, ...]](), list[str](), [len(group.joints) == 1 for group in masses]
    for group, own, ratio in zip(masses, known.tolist(), ratios.tolist(), strict=True):
        visible, determined = group.mass is not None, present(group.share) is not None
        cells = with_interval(*own) if visible else ("not visible", "-")
        told.append(f"{group.name} {f'{group.mass:.4g} kg' if visible else 'does not see it'}")
        rows.append((group.name, "kg", *cells, with_sigma(*ratio) if determined else "-"))
    caption = (
        "Left: the mass by the torques of some joints alone, with 95 % intervals; the dashed line and the band are "
        "the recommended mass. Right: the torque of each joint over what the payload seen by all others demands "
        "there, with two standard deviations; 1 where drive gain and friction are right."
    )

    def draw() -> list[Block]:
        figure, ((left, right),) = figures.panels((9.0, 0.32 * len(masses) + 1.2), 1, 2, width_ratios=(3, 2))
        names, mass = np.array([group.name for group in masses]), agreed[0]
        figures.interval_rows(left, names.tolist(), known, agreed, "not visible")
        reaches = np.abs(known[:, 1:] - mass).max(axis=1)
        reaches = reaches[np.isfinite(reaches)]
        # One joint that hardly sees the mass must not squeeze the others to a line.
        reach = 1.1 * min(float(reaches.max()), max(6.0 * float(np.median(reaches)), 0.1 * abs(mass)))
        left.set_xlim(mass - reach, mass + reach)
        shares, sigmas = ratios[single].T
        ends = np.column_stack([shares, shares - 2.0 * sigmas, shares + 2.0 * sigmas])
        figures.interval_rows(right, names[single].tolist(), ends, (1.0, np.nan, np.nan), "not determined")
        right.set_ylim(left.get_ylim())
        left.set_title("mass [kg]", fontsize=10)
        right.set_title("ratio to the others' payload", fontsize=10)
        return [Drawing(f"by_joints{name}", caption, figure, f"{caption} {'; '.join(told)}.")]

    text = (
        "Each joint weighs the payload with its own torque. Where they differ, a drive gain, the friction model or "
        "the robot's description is wrong. Ratio: the joint's payload torque over what the other joints predict."
    )
    table = Table("Mass by joints", ("", "unit", "mass", "95 % interval", "ratio"), rows)
    drawn = [OnPage(draw)] if any(group.mass is not None for group in masses) else []
    return Section(f"joints{name}", "The payload as each joint sees it", [Text(text), table, *drawn])


def essential_section(elimination: EliminationDocument | None, title: str) -> Section:
    """The path of the elimination as a figure, the parameters by name, and what speaks against them."""
    heading = "Essential parameters"
    if elimination is None:
        text = "Parameters are eliminated in method 4 only, for robot and payload together; it was not used here."
        return Section("essential", heading, [OnPage(lambda: [Text(text)])])
    path, limit = elimination.path, present(elimination.limit)
    essential, count = elimination.essential, len(path) - 1
    text = (
        f"{essential} of {count} parameters are essential ({elimination.description}): error's sigma "
        f"{elimination.sigma_ratio:.4f} times, largest relative sigma "
        f"{elimination.largest_relative_sigma_percent:.3g} %."
    )

    def draw() -> list[Block]:
        gone = count - essential
        ratios = np.array([step.sigma_ratio for step in path], dtype=float)
        percents = np.array([step.largest_relative_sigma_percent for step in path], dtype=float)
        shown = min(max(int(np.sum(ratios <= _MOST_RATIO)), gone + 2), count)
        names = ["none", *(str(step.eliminated) for step in path[1:shown])]
        figure, (above, below) = figures.named_panels([names] * 2, sharex=True)
        for axis, values, label, rule, scale, unit in (
            (above, ratios[:shown], "error sigma, ratio\nto all parameters", "ratio", 1.0, ""),
            (below, percents[:shown], "largest relative\nsigma [%]", "sigma", 100.0, " %"),
        ):
            # Data without noise reach any number: what no axis can show is left out.
            finite = np.where((values > 0.0) & (values < _MOST_SHOWN), values, np.nan)
            visible, steps = finite[np.isfinite(finite)], np.arange(len(values))
            if len(visible) and np.ptp(visible) == 0.0:
                axis.set_ylim(0.5 * visible[0], 2.0 * visible[0])
            axis.plot(steps, finite, color="0.5", linewidth=1.0)
            # Filled markers and open ones: legible without colour.
            for part, taken, face in (
                (slice(gone + 1), "taken", "black"),
                (slice(gone + 1, None), "not taken", "w"),
            ):
                look: dict[str, Any] = {"label": taken, "color": "black", "markerfacecolor": face}
                axis.plot(steps[part], finite[part], "o", markersize=4, **look)
            axis.axvline(gone + 0.5, color="black", linestyle=":", linewidth=1.2)
            axis.set_ylabel(label)
            if limit is not None and elimination.rule == rule:
                _limit(axis, scale * limit, f"limit {scale * limit:g}{unit}")
        above.legend(loc="upper left")
        figures.log_scale(below)
        below.set_xlabel("eliminated, in this order")
        figure.suptitle(f"{title}: {essential} of {count} parameters essential")
        caption = (
            "Parameters are eliminated from left to right, each time the one with the largest relative standard "
            "deviation. Filled marks are steps that were taken."
        )
        return [Drawing("essential_path", caption, figure, text)]

    lines = [
        text,
        f"Essential: {', '.join(str(parameter.name) for parameter in elimination.parameters)}.",
        "Setting the others to zero biases these values, so the intervals above come from the full model.",
        *(f"  - {warning}" for warning in elimination.warnings),
    ]
    return Section("essential", heading, [Notes(lines), OnPage(draw)])


def _limit(axis: Axes, value: float, label: str) -> None:
    axis.axhline(value, color="black", linestyle="--", linewidth=1.0)
    look: dict[str, Any] = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points", "fontsize": 8}
    axis.annotate(label, (1.0, value), xytext=(-4, 3), ha="right", **look)
