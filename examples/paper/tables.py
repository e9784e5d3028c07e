"""The simulated experiment's tables beside the paper's.

Run: ``python -m dynident.examples.paper.tables``.
"""

import argparse
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import pairwise

import numpy as np
from dynident.apps.commands.entry import status
from dynident.apps.commands.simulate import (
    PAYLOAD,
    TRAJECTORIES,
    levels,
    paper_robot,
    reduced_experiment,
    simulate_paper,
)
from dynident.apps.commands.values import share, whole
from dynident.apps.report.blocks import Notes, Report, Table, print_report
from dynident.apps.report.sections.evidence import residual_text
from dynident.common.progress import Progress
from dynident.estimation import PAYLOAD as TEN
from dynident.estimation import Estimate, Identification, PayloadAnswer, Settings, answer_payload, identify
from dynident.estimation.fit.estimate import Fit, fit
from dynident.estimation.fit.own_equations import payload_observer
from dynident.estimation.payload.long_motion import long_motion
from dynident.estimation.payload.methods import PayloadEstimate
from dynident.estimation.signals.filtering import measurement
from dynident.model import INERTIAL, PAPER
from dynident.trajectories import Experiment

from .analysis import essential_joint, robust_joint, true_values
from .printed import PaperTables, Printed, paper_tables

_OWN = ("truth", "identified", "2 sigma", "%", "robust sigma")
_PAPER = ("paper", "2 sigma", "%")


def table1(answer: PayloadAnswer, paper: PaperTables) -> list[Table]:
    """Table 1: the payload by method 3; none where it could not be used."""
    return [_table1(each.estimate, paper) for each in answer.estimates if each.method == 3]


def _table1(estimate: Estimate, paper: PaperTables) -> Table:
    rows = [
        (kind, *_own(estimate, k, PAYLOAD.vector[k]), *_printed(paper.table1.get(kind)))
        for k, kind in enumerate(INERTIAL)
    ]
    title = "Table 1: payload by method 3, simulated and as printed (SI units)"
    return Table(title, ("", *_OWN, *_PAPER), rows)


def table2(joint: Estimate, essential: Estimate, truth: Mapping[str, float], paper: PaperTables) -> Table:
    """Table 2: robot and payload by method 4, essential parameters of both experiments.

    Args:
        joint: of all parameters.
        essential: of the essential parameters.
        truth: by name.
    """
    printed = paper.table2_robot | {f"{kind}_L": row for kind, row in paper.table2.items()}
    names = [name for name in joint.names if name in essential.names or name in printed]
    rows = []
    for name in names:
        identified: Sequence[str] = (_number(truth[name]), "eliminated", "", "", "")
        if name in essential.names:
            identified = _own(essential, essential.names.index(name), truth[name])
        value = _number(joint.values[joint.names.index(name)])
        rows.append((name, *identified, value, *_printed(printed.get(name))))
    last_of_robot = [name for name, after in pairwise(names) if name not in TEN and after in TEN]
    largest = essential.relative_sigma_percent.max()
    title = f"Table 2: essential parameters (relative sigma up to {largest:.1f} %) by method 4, and as printed (SI)"
    return Table(title, ("", *_OWN, "all parameters", *_PAPER), rows, last_of_robot)


def paper_payload_table(estimates: Sequence[PayloadEstimate], paper: PaperTables) -> Table:
    """Simulated payload: truth, the methods with two sigma, and the paper's Tables 1 and 2."""
    rows: list[tuple[str, ...]] = []
    for k, kind in enumerate(INERTIAL):
        cells = [short_value(e.estimate.values[k], 2.0 * e.estimate.sigma[k]) for e in estimates]
        printed = [paper.table1.get(kind), paper.table2.get(kind)]
        cells += [short_value(row.value, row.two_sigma) if row else "" for row in printed]
        rows.append((kind, f"{PAYLOAD.vector[k]:.3f}", *cells))
    headings = ["truth", *(f"method {e.method}" for e in estimates), "Table 1", "Table 2"]
    title = "Payload: simulated truth, identified ± 2 sigma, the paper's tables (SI)"
    return Table(title, ("", *headings), rows)


def constrained_table(answer: PayloadAnswer) -> Table:
    """The payload that can exist, by each method: value ± half its 95 % interval."""
    rows: list[tuple[str, ...]] = []
    for k, kind in enumerate(INERTIAL):
        halves = [0.5 * float(np.ptp(bounded.intervals.parameters[k])) for bounded in answer.constrained]
        cells = [
            short_value(bounded.body.vector[k], half if np.isfinite(half) else 0.0)
            for bounded, half in zip(answer.constrained, halves, strict=True)
        ]
        rows.append((kind, f"{PAYLOAD.vector[k]:.3f}", *cells))
    headings = ["truth", *(f"method {bounded.method}" for bounded in answer.constrained)]
    title = "Payload that can exist (constrained): value ± half the 95 % interval (SI units)"
    return Table(title, ("", *headings), rows)


def experiment_notes(
    experiment: Experiment, robot: Identification, joint: Estimate, held_out: Fit, paper: PaperTables
) -> list[str]:
    """Lines below the tables: what kind of data it was, and how it compares.

    Args:
        robot: identified from the runs without payload.
        joint: method 4, all parameters.
        held_out: fit of ``joint`` on the held-out trajectory with payload.
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
        gains = " ".join(f"{100.0 * (gain - 1.0):+.1f}" for gain in experiment.gains)
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


def main() -> None:
    """Simulate the experiment, identify robot and payload as the paper does, and print the tables."""
    parser = argparse.ArgumentParser(prog="python -m dynident.examples.paper.tables", description=__doc__)
    parser.add_argument("--seed", type=whole, default=0, help="of the trajectories and the noise (default: 0)")
    parser.add_argument("--trajectories", type=whole, default=TRAJECTORIES, metavar="N", help="default: 18")
    parser.add_argument("--noise", choices=("paper", "slow", "none"), default="paper")
    parser.add_argument("--gain-error", type=share, default=0.0, metavar="SHARE", help="default: 0")
    arguments = parser.parse_args()
    robot = paper_robot()
    noise = levels(robot, arguments.noise, arguments.gain_error)
    with status("simulating") as progress:
        told = partial(progress, "simulating")
        experiment = simulate_paper(robot, noise, arguments.seed, arguments.trajectories, told)
    with status("reducing") as progress:
        blocks = compared(experiment, progress)
    print_report(Report("", blocks), details=True)


def compared(experiment: Experiment, progress: Progress) -> list[Table | Notes]:
    """Tables of what is identified from an experiment, its last trajectory held out, and notes."""
    robot, paper, problem = experiment.robot, paper_tables(), reduced_experiment(experiment, progress)
    bare, loaded = (run.recording for run in experiment.runs[-2:])
    used = [run.recording for run in experiment.runs[:-2:2]]
    alone = identify(robot, used, Settings(friction=PAPER, progress=progress), validation=[bare])
    answer = answer_payload(problem, held_out=[bare])
    joint, essential = robust_joint(problem), essential_joint(problem)
    measured = measurement(loaded, robot.processing)
    rows = long_motion(
        payload_observer(robot), [measured], settings=Settings(robot.processing, robust=False)
    ).loaded
    return [
        *table1(answer, paper),
        table2(joint, essential, true_values(experiment, problem), paper),
        paper_payload_table(answer.estimates, paper),
        constrained_table(answer),
        Notes(experiment_notes(experiment, alone, joint, fit(rows, joint.values), paper)),
    ]


if __name__ == "__main__":
    main()
