"""Results as tables for a terminal."""

from collections.abc import Sequence

import numpy as np
from rich.table import Table

from ..estimation import Estimate, Fit, Identification, PayloadEstimate, PayloadProblem
from ..estimation.verdict import Verdict
from ..model import INERTIAL, InertialParameters
from .paper import PaperTables, Printed

_UNITS = dict.fromkeys(INERTIAL[:6], "kg m²") | dict.fromkeys(INERTIAL[6:9], "kg m") | {"M": "kg"}
_LEVELS = {
    "use": "use",
    "mass_and_com_only": "use mass and centre of mass only",
    "do_not_use": "do not use",
}


def payload_table(estimates: Sequence[PayloadEstimate]) -> Table:
    """Ten parameters by each method, with standard deviations, and what a controller asks for."""
    table = Table(title=f"Payload in {estimates[0].frame}", title_justify="left")
    table.add_column("parameter")
    table.add_column("unit")
    for estimate in estimates:
        table.add_column(f"method {estimate.method}", justify="right")
    for k, kind in enumerate(INERTIAL):
        cells = [_value(e.estimate.values[k], e.estimate.sigma[k]) for e in estimates]
        table.add_row(kind, _UNITS[kind], *cells, end_section=kind == "M")
    for k, axis in enumerate("xyz"):
        cells = [_value(e.body.com[k], e.sigma_com[k]) for e in estimates]
        table.add_row(f"com {axis}", "m", *cells, end_section=axis == "z")
    for row, column in zip(*np.triu_indices(3), strict=True):
        cells = [_value(e.body.inertia_com[row, column], e.sigma_inertia_com[row, column]) for e in estimates]
        table.add_row(f"I{'xyz'[row]}{'xyz'[column]} at com", "kg m²", *cells, end_section=row == 2)
    consistent = ["yes" if e.body.physically_consistent else "no" for e in estimates]
    table.add_row("such a body can exist", "", *consistent)
    return table


def payload_notes(
    problem: PayloadProblem, judged: Verdict, robot_fit: Fit | None, validation: Fit | None
) -> list[str]:
    """Lines below the payload table."""
    lines = ["± is one standard deviation by (17)-(19): white torque noise, drive gains taken as exact."]
    if problem.unloaded is not None:
        raw, scaled = problem.unloaded.condition_numbers()
        lines.append(
            f"Without payload: {problem.unloaded.equations} equations, {len(problem.base.columns)} parameters, "
            f"condition number {raw:.4g} (SI units, unweighted), {scaled:.3g} with columns scaled."
        )
    if robot_fit is not None:
        lines.append(f"Relative residual of the robot's model: {_residual(robot_fit)}")
    if validation is not None:
        lines.append(f"The same on the validation recording: {_residual(validation)}")
    for pair in problem.pairs:
        lines.append(
            f"Pair aligned by {pair.lag:.4f} s; positions then differ by at most {1e3 * pair.max_mismatch:.2f} "
            f"mrad (rms {1e3 * pair.rms_mismatch:.3f})."
        )
    if problem.without_difference:
        lines.append(f"Method 3 left out: {problem.without_difference}")
    lines.append(f"Verdict: {_LEVELS[judged.level]}." + "".join(f"\n  - {reason}" for reason in judged.reasons))
    return lines


def robot_table(result: Identification) -> Table:
    """Base parameters with standard deviations."""
    table = Table(title=f"Base parameters of {result.robot.title or result.robot.name}", title_justify="left")
    for heading in ("parameter", "value", "sigma", "%"):
        table.add_column(heading, justify="left" if heading == "parameter" else "right")
    table.add_column("essential")
    table.add_column("grouping", overflow="fold")
    for k, (name, grouping) in enumerate(zip(result.base.names, result.base.groupings(), strict=True)):
        estimate = result.estimate
        table.add_row(
            name,
            f"{estimate.values[k]:.4g}",
            f"{estimate.sigma[k]:.2g}",
            f"{estimate.relative_sigma_percent[k]:.3g}",
            "yes" if estimate.names[k] in result.essential else "",
            grouping.split(" = ", 1)[1] if name.endswith("R") else "",
        )
    return table


def robot_notes(result: Identification) -> list[str]:
    """Lines below the robot's table."""
    raw, scaled = result.problem.condition_numbers()
    lines = [
        f"{result.problem.equations} equations, {len(result.base.columns)} parameters, {len(result.essential)} "
        f"essential; condition number {raw:.4g} (SI units, unweighted), {scaled:.3g} with columns scaled.",
        f"Relative residual: {_residual(result.estimate.fit)}",
    ]
    if result.validation is not None:
        lines.append(f"On the validation recording: {_residual(result.validation)}")
    lines.append("sigma by (17)-(19): white torque noise, drive gains taken as exact.")
    return lines


def paper_payload_table(
    estimates: Sequence[PayloadEstimate], truth: InertialParameters, paper: PaperTables
) -> Table:
    """Simulated payload: truth, the four methods with two sigma, and the paper's Tables 1 and 2."""
    table = Table(
        title="Payload: simulated truth, four methods (± 2 sigma), the paper's tables", title_justify="left"
    )
    table.add_column("parameter")
    table.add_column("truth", justify="right")
    for estimate in estimates:
        table.add_column(f"method {estimate.method}", justify="right")
    table.add_column("paper, method 3", justify="right")
    table.add_column("paper, method 4", justify="right")
    for k, kind in enumerate(INERTIAL):
        cells = [_value(e.estimate.values[k], 2.0 * e.estimate.sigma[k]) for e in estimates]
        printed = [_printed(rows.get(kind)) for rows in (paper.table1, paper.table2)]
        table.add_row(f"{kind}_L", f"{truth.vector[k]:.3f}", *cells, *printed)
    return table


def paper_robot_table(estimate: Estimate, truth: dict[str, float], paper: PaperTables) -> Table:
    """The robot's rows of Table 2: truth of the simulation, identified, and as printed."""
    table = Table(title="Robot: the rows of Table 2 (± 2 sigma)", title_justify="left")
    for heading in ("parameter", "truth", "identified", "%", "paper", "paper %"):
        table.add_column(heading, justify="left" if heading == "parameter" else "right")
    for name, printed in paper.table2_robot.items():
        k = estimate.names.index(name)
        table.add_row(
            name,
            f"{truth[name]:.3f}",
            _value(estimate.values[k], 2.0 * estimate.sigma[k]),
            f"{estimate.relative_sigma_percent[k]:.3f}",
            _printed(printed),
            f"{printed.relative_sigma_percent:.3f}",
        )
    return table


def _value(value: float, sigma: float) -> str:
    """Two digits of sigma, the value to the same place."""
    if not np.isfinite(sigma) or sigma <= 0.0:
        return f"{value:.6g}"
    digits = min(max(0, 1 - int(np.floor(np.log10(sigma)))), 9)
    return f"{value:.{digits}f} ± {sigma:.{digits}f}"


def _printed(row: Printed | None) -> str:
    return f"{row.value:.3f} ± {row.two_sigma:.3f}" if row else ""


def _residual(fit: Fit) -> str:
    joints = " ".join(f"{100.0 * value:.1f}" for value in fit.relative_per_joint)
    return f"{100.0 * fit.relative:.2f} % (joints {joints} %)"
