"""The simulated experiment's tables beside the paper's."""

from collections.abc import Mapping, Sequence

import numpy as np
from rich.table import Table

from ...estimation import PAYLOAD, Estimate, Identification, PayloadAnswer
from ...estimation.fit import Fit
from ...estimation.payload import PayloadEstimate
from ...model import INERTIAL, InertialParameters
from ...report.tables import empty_table, residual_text
from ...trajectories import Experiment
from .paper import PaperTables, Printed

_OWN = ("truth", "identified", "2 sigma", "%", "robust sigma")
_PAPER = ("paper", "2 sigma", "%")


def table1(answer: PayloadAnswer, paper: PaperTables) -> Table | None:
    """Table 1: the payload by method 3, where it could be used."""
    found = [estimate for estimate in answer.estimates if estimate.method == 3]
    if not found:
        return None
    table = empty_table(
        "Table 1: payload by method 3, simulated and as printed (SI units)", ("",), (*_OWN, *_PAPER)
    )
    for k, kind in enumerate(INERTIAL):
        own = _own(found[0].estimate, k, paper.payload.vector[k])
        table.add_row(kind, *own, *_printed(paper.table1.get(kind)))
    return table


def table2(joint: Estimate, essential: Estimate, truth: Mapping[str, float], paper: PaperTables) -> Table:
    """Table 2: robot and payload by method 4, essential parameters of both experiments.

    Args:
        joint: of all parameters.
        essential: of the essential parameters.
        truth: by name.
        paper: the paper's tables.
    """
    largest = essential.relative_sigma_percent.max()
    title = f"Table 2: essential parameters (relative sigma up to {largest:.1f} %) by method 4, and as printed (SI)"
    table = empty_table(title, ("",), (*_OWN, "all parameters", *_PAPER))
    printed = paper.table2_robot | {f"{kind}_L": row for kind, row in paper.table2.items()}
    names = [name for name in joint.names if name in essential.names or name in printed]
    for name in names:
        k = joint.names.index(name)
        own: Sequence[str] = (_number(truth[name]), "eliminated", "", "", "")
        if name in essential.names:
            own = _own(essential, essential.names.index(name), truth[name])
        last = (
            name not in PAYLOAD and names[names.index(name) + 1 :][:1] and names[names.index(name) + 1] in PAYLOAD
        )
        table.add_row(name, *own, _number(joint.values[k]), *_printed(printed.get(name)), end_section=bool(last))
    return table


def paper_payload_table(
    estimates: Sequence[PayloadEstimate], truth: InertialParameters, paper: PaperTables
) -> Table:
    """Simulated payload: truth, the methods with two sigma, and the paper's Tables 1 and 2."""
    headings = ["truth", *(f"method {e.method}" for e in estimates), "Table 1", "Table 2"]
    table = empty_table("Payload: simulated truth, identified ± 2 sigma, the paper's tables (SI)", ("",), headings)
    for k, kind in enumerate(INERTIAL):
        cells = [short_value(e.estimate.values[k], 2.0 * e.estimate.sigma[k]) for e in estimates]
        rows = [paper.table1.get(kind), paper.table2.get(kind)]
        cells += [short_value(row.value, row.two_sigma) if row else "" for row in rows]
        table.add_row(kind, f"{truth.vector[k]:.3f}", *cells)
    return table


def constrained_table(answer: PayloadAnswer, truth: InertialParameters) -> Table:
    """The payload that can exist, by each method: value ± half its 95 % interval."""
    headings = ["truth", *(f"method {payload.method}" for payload in answer.constrained)]
    title = "Payload that can exist (constrained): value ± half the 95 % interval (SI units)"
    table = empty_table(title, ("",), headings)
    for k, kind in enumerate(INERTIAL):
        cells = []
        for payload in answer.constrained:
            low, high = payload.intervals.parameters[k]
            half = 0.5 * (high - low)
            cells.append(short_value(payload.body.vector[k], half if np.isfinite(half) else 0.0))
        table.add_row(kind, f"{truth.vector[k]:.3f}", *cells)
    return table


def experiment_notes(
    experiment: Experiment, robot: Identification, joint: Estimate, held_out: Fit, paper: PaperTables
) -> list[str]:
    """Lines below the tables: what kind of data it was, and how it compares.

    Args:
        experiment: the experiment.
        robot: identified from the runs without payload.
        joint: method 4, all parameters.
        held_out: fit of ``joint`` on the held-out trajectory with payload.
        paper: the paper's tables.
    """
    raw, scaled = robot.problem.condition_numbers()
    shift = [
        np.abs(loaded.exact.motion.q - bare.exact.motion.q).max()
        for bare, loaded in zip(experiment.runs[::2], experiment.runs[1::2], strict=True)
    ]
    near = [
        1.0 / 1.5 <= 2.0 * joint.sigma[joint.names.index(name)] / row.two_sigma <= 1.5
        for name, row in paper.table2_robot.items()
    ]
    lines = [
        f"Without payload: {robot.problem.equations} equations (paper: about 63000), condition number {raw:.3g} "
        f"(SI units, unweighted; paper: 58), {scaled:.2g} with columns scaled.",
        f"The payload moves the joints by at most {1e3 * max(shift):.2f} mrad (paper: 1 mrad).",
        f"2 sigma with all parameters is within a factor 1.5 of Table 2's in {sum(near)} of {len(near)} rows.",
        f"The robot alone: {len(robot.essential)} essential parameters by the rule of 1.02 (paper: 28).",
        f"Relative residual of the robot's model: {residual_text(robot.estimate.fit)}",
    ]
    if robot.validation is not None:
        lines.append(f"On the held-out trajectory without payload: {residual_text(robot.validation)}")
    lines.append(f"On the held-out trajectory with payload (method 4): {residual_text(held_out)}")
    if experiment.disturbances.gain_error:
        gains = " ".join(f"{100.0 * (gain - 1.0):+.1f}" for gain in experiment.errors.gains)
        lines.append(
            f"Drive gains are off by {gains} %: no residual shows it, only the payload's errors do; "
            "'dynident payload --gain-sigma' widens the intervals accordingly."
        )
    return lines


def short_value(value: float, spread: float) -> str:
    """Three decimals, as the paper prints; a spread that they do not show is left out."""
    text = f"{round(value, 3) + 0.0:.3f}"
    if spread < 0.0005:
        return text
    parts = (text, f"{spread:.3f}")
    return "±".join(part.replace("0.", ".", 1) if part.lstrip("-").startswith("0.") else part for part in parts)


def _own(estimate: Estimate, k: int, truth: float) -> tuple[str, ...]:
    robust = estimate.sigma_robust
    return (
        _number(truth),
        _number(estimate.values[k]),
        _number(2.0 * estimate.sigma[k]),
        f"{estimate.relative_sigma_percent[k]:.2f}",
        _number(robust[k]) if robust is not None else "",
    )


def _printed(row: Printed | None) -> tuple[str, str, str]:
    if row is None:
        return "", "", ""
    return f"{row.value:.3f}", f"{row.two_sigma:.3f}", f"{row.relative_sigma_percent:.2f}"


def _number(value: float) -> str:
    return f"{round(value, 4) + 0.0:.4f}"
