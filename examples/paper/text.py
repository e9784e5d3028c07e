"""The simulated experiment repeated: how far off each method is, and whether its intervals hold, in Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from dynident.examples.paper.printed import PaperTables
from dynident.model import InertialParameters

from .repetition import Outcome, Repetition

ROBOT = "robot"
"""Name of the robot's parameters among the answers: method 4, all base parameters."""
_DEMANDS = {"M": 0.01, "MZ": 0.02, "XX": 0.08, "YY": 0.08}
_SLOW_DEMANDS = {"M": 0.02, "MZ": 0.025}
_LOW = 0.85  # coverage below it is named
_ROWS = ("M", "MZ", "XX", "YY", "ZZ")
_TEXT = """\
# The simulated experiment

Written by `python -m dynident.examples.paper {count}{options}`; run it again to get the same numbers.

The paper's recordings are not public. This experiment simulates a robot with known parameters, so errors can be
compared with standard deviations: an RX90 (`model/robots/rx90.toml`) under a joint controller, which runs
{trajectories} trajectories of about 14 intermediate points without and with the payload of Table 1 (7.025 kg).
Seeds {first} to {last}; each has other trajectories, gears and noise.

Assumed, because the paper does not say: the law of the gravity spring (a known torque, as in the paper), the
acceleration limits, the controller's gains (the payload moves the joints by about 1e-3 rad, as in the paper), the
gear ripple (8 and 36 waves per turn), the drift of dry friction (12 %, 2 s) and the encoder resolution (1e-5 rad).
The noise level makes the standard deviations (17)-(19) those of Table 2; nothing is tuned to the payload.

| | this experiment | paper |
|---|---|---|
| equations without payload | {equations} | about 63000 |
| condition number (SI units, unweighted) | {condition} | 58 |
| relative residual, all joints | {residual} % | not stated |
| relative residual, joints 1 to 6 | {per_joint} % | not stated |
| rows of Table 2 whose 2 sigma is within a factor 1.5 | {rows} of 28 | |

With about 63000 equations, the standard deviations of Table 2 and a relative residual of 4 to 5 % cannot both be
true: by (17)-(19) the one follows from the other.
"""


@dataclass(frozen=True, eq=False)
class Scenario:
    """Results of several experiments of one kind: ``repetitions`` by estimator, and the single outcomes."""

    repetitions: Mapping[str, Repetition]
    outcomes: Sequence[Outcome]

    @staticmethod
    def of(outcomes: Sequence[Outcome]) -> Scenario:
        """Gather the answers of each estimator."""
        names = outcomes[0].answers
        return Scenario({who: Repetition.of([o.answers[who] for o in outcomes]) for who in names}, outcomes)

    @property
    def payload(self) -> dict[str, Repetition]:
        """The payload's estimators alone."""
        return {who: repetition for who, repetition in self.repetitions.items() if who != ROBOT}


def repeated_document(
    scenarios: Mapping[str, Scenario], paper: PaperTables, trajectories: int, seeds: range, gain_error: float
) -> str:
    """The whole text.

    Args:
        scenarios: "paper" (noise as the paper's robot), "slow" (noise that remembers) and "gains" (wrong gains).
        paper: Table 2.
        trajectories: for identification.
        seeds: of the experiments.
        gain_error: of the scenario "gains", relative.
    """
    plain = scenarios["paper"]
    text = _TEXT.format(
        count=len(seeds),
        options=f" --seed {seeds.start}" if seeds.start else "",
        trajectories=trajectories,
        first=seeds[0],
        last=seeds[-1],
        **_setting(plain, paper),
    )
    parts = [
        text,
        "## The robot's parameters\n",
        *_robot(plain, paper),
        "## The payload\n",
        *_payload(plain, "Noise as on the paper's robot"),
        *_demands(plain, _DEMANDS),
        "The paper's mass is off by +2.7 % (Table 1) and -4.6 % (Table 2).\n",
        *_payload(scenarios["slow"], "Slow noise: correlation time 0.8 s, residuals as large"),
        *_demands(scenarios["slow"], _SLOW_DEMANDS),
        *_payload(
            scenarios["gains"], f"Drive gains wrong by {100 * gain_error:g} % (standard deviation) per joint"
        ),
        "A wrong gain scales a joint's torque, and with it the parameters. No residual shows it, so no interval\n"
        "made from residuals covers it: `dynident payload --gain-sigma` adds the uncertainty of the gains.\n",
        "![Errors of the payload and coverage of its intervals](simulated_experiment.png)\n",
    ]
    return "\n".join(parts)


def repeated_numbers(scenarios: Mapping[str, Scenario]) -> dict[str, Any]:
    """Repeated numbers as a document: per scenario, estimator and parameter."""
    return {
        name: {
            who: {
                parameter: {
                    "truth": repetition.truth[:, k].mean(),
                    "bias": repetition.bias[k],
                    "spread": repetition.spread[k],
                    "rms": repetition.rms[k],
                    "coverage": repetition.coverage[k],
                    "errors": repetition.error[:, k],
                }
                for k, parameter in enumerate(repetition.names)
            }
            for who, repetition in scenario.repetitions.items()
        }
        for name, scenario in scenarios.items()
    }


def _setting(scenario: Scenario, paper: PaperTables) -> dict[str, str]:
    outcomes = scenario.outcomes
    joints = zip(*(o.per_joint for o in outcomes), strict=True)
    return {
        "equations": _range([o.equations for o in outcomes], 0),
        "condition": _range([o.condition_number for o in outcomes], 0),
        "residual": _range([100.0 * o.relative_residual for o in outcomes], 1),
        "per_joint": ", ".join(f"{100.0 * np.mean(values):.0f}" for values in joints),
        "rows": _range([rows_within(o, paper) for o in outcomes], 0),
    }


def rows_within(outcome: Outcome, paper: PaperTables, factor: float = 1.5) -> int:
    """Number of Table 2's robot rows with a standard deviation within a factor of the printed one."""
    robot = outcome.answers[ROBOT]
    count = 0
    for name, printed in paper.table2_robot.items():
        ratio = 2.0 * robot.sigma[robot.names.index(name)] / printed.two_sigma
        count += bool(1.0 / factor <= ratio <= factor)
    return count


def _robot(scenario: Scenario, paper: PaperTables) -> list[str]:
    robot = scenario.repetitions[ROBOT]
    places = [robot.column(name) for name in paper.table2_robot]
    share = robot.covered[:, places].mean()
    rows = [(robot.names[k], robot.coverage[k]) for k in places]
    low = ", ".join(f"{name} ({100 * c:.0f} %)" for name, c in rows if c < _LOW) or "none"
    lines = [
        f"Robust 95 % intervals (method 4, {len(robot.names)} parameters) contain the truth in\n"
        f"{100 * share:.1f} % of all rows of Table 2 and seeds, and in {100 * robot.covered.mean():.1f} % of all\n"
        "parameters and seeds.\n"
        "For dry friction the truth is its level averaged over the recorded motion.",
        "",
        f"Rows with less than {100 * _LOW:.0f} %: {low}. Ripple repeats in every trajectory, so no block of\n"
        "time reveals it.",
        "",
        "| | truth | bias | spread | robust 95 % covers | sigma here / Table 2 |",
        "|---|---|---|---|---|---|",
    ]
    for name, printed in paper.table2_robot.items():
        k = robot.column(name)
        ratio = 2.0 * robot.sigma[:, k].mean() / printed.two_sigma
        lines.append(
            f"| {name} | {robot.truth[:, k].mean():.3f} | {robot.bias[k]:+.4f} | {robot.spread[k]:.4f} "
            f"| {100 * robot.coverage[k]:.0f} % | {ratio:.2f} |"
        )
    return [*lines, ""]


def _payload(scenario: Scenario, title: str) -> list[str]:
    heads = "".join(f" {name} rms |" for name in _ROWS)
    head = f"| |{heads} 95 % covers all ten | M | physical |"
    lines = [f"### {title}\n", head, "|---|" + "---|" * (len(_ROWS) + 3)]
    for who, repetition in scenario.payload.items():
        cells = []
        for name in _ROWS:
            k = repetition.column(f"{name}_L")
            cells.append(f" {100 * repetition.rms[k] / abs(repetition.truth[0, k]):.2f} % |")
        mass = repetition.coverage[repetition.column("M_L")]
        there = np.mean([InertialParameters(values).physically_consistent for values in repetition.values])
        cells.append(f" {100 * repetition.covered.mean():.1f} % | {100 * mass:.0f} % | {100 * there:.0f} % |")
        lines.append(f"| {who} |{''.join(cells)}")
    return [*lines, ""]


def _demands(scenario: Scenario, demands: Mapping[str, float]) -> list[str]:
    heads = "".join(f" {name} within {100 * share:g} % |" for name, share in demands.items())
    lines = [f"| fraction of the seeds with |{heads}", "|---|" + "---|" * len(demands)]
    for who, repetition in scenario.payload.items():
        cells = (f" {100 * repetition.within(f'{name}_L', share):.0f} % |" for name, share in demands.items())
        lines.append(f"| {who} |{''.join(cells)}")
    return [*lines, ""]


def _range(values: Sequence[float], digits: int) -> str:
    low, high = (f"{value:.{digits}f}" for value in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"
