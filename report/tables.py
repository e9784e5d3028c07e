"""Results as tables for a terminal."""

from collections.abc import Sequence

import numpy as np
from rich import box
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table

from ..estimation import Identification, PayloadAnswer, PayloadProblem
from ..estimation.diagnosis import robot_verdict
from ..estimation.fit import Fit
from ..estimation.payload import PayloadEstimate
from ..model import INERTIAL
from .by_joints import mass_by_joints_note
from .gains import gain_error_notes

UNITS = dict.fromkeys(INERTIAL[:6], "kg m²") | dict.fromkeys(INERTIAL[6:9], "kg m") | {"M": "kg"}
_LEVELS = {
    "use": "use",
    "mass_and_com_only": "use mass and centre of mass only",
    "do_not_use": "do not use",
}
_FOLDS = 120
_FORMULA = "by (17)-(19): for white torque noise, the torques' scale taken as exact."


def payload_table(estimates: Sequence[PayloadEstimate]) -> Table:
    """Ten parameters by each method, with standard deviations, and what a controller asks for.

    Where an estimate has robust standard deviations too, each entry shows the larger of both.
    """
    headings = [f"method {estimate.method}" for estimate in estimates]
    table = empty_table(f"Free estimates (least squares alone) in {estimates[0].frame}", ("", "unit"), headings)
    for k, kind in enumerate(INERTIAL):
        cells = [_value(e.estimate.values[k], e.larger_sigma[k]) for e in estimates]
        table.add_row(kind, UNITS[kind], *cells, end_section=kind == "M")
    for k, axis in enumerate("xyz"):
        cells = [_value(e.body.com[k], e.larger_sigma_com[k]) for e in estimates]
        table.add_row(f"com {axis}", "m", *cells, end_section=axis == "z")
    for row, column in zip(*np.triu_indices(3), strict=True):
        sigmas = [e.larger_sigma_inertia_com[row, column] for e in estimates]
        cells = [_value(e.body.inertia_com[row, column], sigma) for e, sigma in zip(estimates, sigmas, strict=True)]
        name = f"{'XYZ'[row]}{'XYZ'[column]} at com"
        table.add_row(name, "kg m²", *cells, end_section=row == 2)
    table.add_row("can exist", "", *("yes" if e.body.physically_consistent else "no" for e in estimates))
    return table


def payload_notes(answer: PayloadAnswer) -> list[str]:
    """Lines below the payload table; the verdict comes last."""
    lines = [*sigma_notes(answer.estimates), *data_notes(answer), mass_by_joints_note(answer.by_joints)]
    lines += [f"Method {method} left out: {reason}" for method, reason in answer.left_out.items()]
    lines.append(f"Verdict: {_LEVELS[answer.verdict.level]}.")
    return [*lines, *(f"  - {reason}" for reason in answer.verdict.reasons)]


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
    return [*lines, _alignment(problem)] if problem.pairs else lines


def sigma_notes(estimates: Sequence[PayloadEstimate]) -> list[str]:
    """Where the standard deviations of the payload table come from, and what speaks against them."""
    both = [(e, e.estimate.robust) for e in estimates]
    ratios = [f"method {e.method} {r.sigma[-1] / e.estimate.sigma[-1]:.2f}" for e, r in both if r is not None]
    robust = [r for _, r in both if r is not None]
    if robust:
        blocks = f"{robust[0].blocks} blocks of {robust[0].block_length:.2g} s or more"
        lines = [
            "± the larger of the formula's (17)-(19) and the block jackknife's standard deviation.",
            f"Mass, sigma_robust/sigma (jackknife over {blocks} to formula): {', '.join(ratios)}.",
        ]
    else:
        lines = [f"± one standard deviation {_FORMULA}"]
    lines += sorted({r.warning for r in robust if r.warning})
    reasons = {
        e.without_robust: [o.method for o in estimates if o.without_robust == e.without_robust] for e in estimates
    }
    return lines + [
        f"± of method {', '.join(map(str, methods))} by the formula alone: {reason}"
        for reason, methods in reasons.items()
        if reason
    ]


def robot_table(result: Identification, constrained: Sequence[float] | None = None) -> Table:
    """Base parameters with standard deviations, beside those of a robot that can exist.

    Where the estimate has robust standard deviations too, each entry shows the larger of both; errors of the drive
    gains, where they are not taken as exact, are part of it, and stand by themselves in a column.
    """
    title = f"Base parameters of {result.robot.title or result.robot.name}, SI units"
    beside = constrained is not None
    by_gains = result.estimate.sigma_by_gains
    right = ("value", "%", *(["by gains"] * (by_gains is not None)), *(["constrained"] * beside))
    table = empty_table(title, ("",), right)
    table.add_column("essential", no_wrap=True)
    table.add_column("grouping", overflow="fold")
    estimate = result.estimate
    for k, (name, grouping) in enumerate(zip(result.base.names, result.base.groupings(), strict=True)):
        table.add_row(
            name,
            _value(estimate.values[k], estimate.total_sigma[k]),
            f"{_percent(estimate.total_sigma[k], estimate.values[k]):.3g}",
            *([f"{by_gains[k]:.2g}"] if by_gains is not None else []),
            *([f"{constrained[k]:.4g}"] if constrained is not None else []),
            "yes" if estimate.names[k] in result.essential else "",
            grouping.split(" = ", 1)[1] if name.endswith("R") else "",
        )
    return table


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
    reasons = robot_verdict(result.estimate.fit).reasons
    return [*lines, *(["Verdict: do not use."] + [f"  - {reason}" for reason in reasons] if reasons else [])]


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


def console(*tables: Table) -> Console:
    """A terminal wide enough that no number of the tables is cut off."""
    terminal = Console()
    free = terminal.options.update(width=1000)
    widths = [Measurement.get(terminal, free, table).maximum for table in tables]
    # A wider table has a column of text that folds; its numbers need no more than this.
    return Console(width=max(terminal.width, *(width if width <= _FOLDS else 80 for width in widths)))


def empty_table(title: str, left: Sequence[str], right: Sequence[str]) -> Table:
    """An empty table that fits 80 columns with four methods."""
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, padding=0)
    for heading in left:
        table.add_column(heading, no_wrap=True)
    for heading in right:
        table.add_column(heading, justify="right", no_wrap=True)
    return table


def _percent(sigma: float, value: float) -> float:
    return 100.0 * sigma / abs(value) if value != 0.0 else float("inf")


def _value(value: float, sigma: float) -> str:
    """Two digits of sigma, the value to the same place."""
    if not np.isfinite(sigma) or sigma <= 0.0:
        return f"{value:.6g}"
    digits = min(max(0, 1 - int(np.floor(np.log10(sigma)))), 9)
    return f"{value:.{digits}f}±{sigma:.{digits}f}"


def _alignment(problem: PayloadProblem) -> str:
    lags = sorted(round(pair.lag, 4) + 0.0 for pair in problem.pairs)
    shift = f"{lags[0]:.4f}" if lags[0] == lags[-1] else f"{lags[0]:.4f} to {lags[-1]:.4f}"
    worst = max(problem.pairs, key=lambda pair: pair.max_mismatch)
    return (
        f"{len(lags)} pair{'s' * (len(lags) > 1)} aligned by {shift} s; positions then differ by at most "
        f"{1e3 * worst.max_mismatch:.2f} mrad (rms {1e3 * worst.rms_mismatch:.3f})."
    )


def residual_text(fit: Fit) -> str:
    """Relative residual in percent, of all joints and of each."""
    joints = " ".join(f"{100.0 * value:.1f}" for value in fit.relative_per_joint)
    return f"{100.0 * fit.relative:.2f} % (joints {joints} %)"
