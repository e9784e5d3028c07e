"""``dynident identify``: the robot's own parameters."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from rich.console import Console

from .. import estimation, model, report
from ..common.errors import InputError
from . import COMMANDS
from .arguments import (
    ANSWERED,
    DO_NOT_USE,
    essential_arguments,
    essential_rule,
    processing_arguments,
    read_recordings,
    robot_argument,
    settings,
)
from .knowledge import gain_arguments, gain_errors_of
from .report import provenance, report_arguments, settings_in_words, write_page
from .results import result_arguments, write_results

if TYPE_CHECKING:
    from collections.abc import Sequence


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser("identify", help=COMMANDS["identify"])
    robot_argument(parser)
    parser.add_argument(
        "--data",
        action="append",
        required=True,
        metavar="LOG",
        help="recording without payload; repeatable: several are recordings of one identification",
    )
    parser.add_argument(
        "--validate", action="append", default=[], metavar="LOG", help="another one, held out; repeatable"
    )
    essential_arguments(parser)
    group = parser.add_argument_group("a robot that can exist", "beside the free estimate")
    group.add_argument(
        "--constrained",
        choices=("none", "base", "prior"),
        default="base",
        help="base parameters of the nearest robot that can exist (default), or all standard parameters, those "
        "that no data show by a prior",
    )
    group.add_argument(
        "--prior-mass", type=float, metavar="KG", help="prior: cylinders of this mass instead of the robot's file"
    )
    group.add_argument(
        "--prior-budget", type=float, metavar="CHI2", help="what the prior may cost in chi2 (default: 1)"
    )
    group.add_argument("--total-mass", nargs=2, type=float, metavar=("LOW", "HIGH"), help="of all links [kg]")
    gain_arguments(parser.add_argument_group("what is known beforehand"))
    processing_arguments(parser)
    result_arguments(parser)
    report_arguments(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run it."""
    robot, processing = settings(arguments)
    _check(arguments)
    told = set[str]()
    recordings = read_recordings(arguments.data, robot, arguments.drive_gains, told, arguments)
    held_out = read_recordings(arguments.validate, robot, arguments.drive_gains, told, arguments)
    gains = gain_errors_of(arguments, robot, [], recordings)
    with Console(stderr=True).status("reading") as status:
        rule = essential_rule(arguments)
        result = estimation.identify(robot, recordings, processing, held_out, status.update, True, rule, gains)
        constrained = _constrained(arguments, result)
        warnings = result.warnings
    screen = report.robot_screen(result, constrained, warnings)
    report.print_blocks(screen)
    if arguments.json:
        document = report.documents.identification_document(
            result, processing, arguments.drive_gains, constrained, warnings
        )
        report.documents.write_json(arguments.json, document)
    write_page(arguments, lambda: _page(arguments, result, constrained, recordings, held_out, processing, warnings))
    write_results(
        arguments, screen, lambda: estimation.answers.identification_system(result, recordings, processing)
    )
    return DO_NOT_USE if result.verdict.level == "do_not_use" else ANSWERED


def _check(arguments: argparse.Namespace) -> None:
    """Refuse options that would have no effect."""
    for option, gauges in (
        ("prior_mass", ("prior",)),
        ("prior_budget", ("prior",)),
        ("total_mass", ("base", "prior")),
    ):
        if getattr(arguments, option) is not None and arguments.constrained not in gauges:
            name = f"--{option.replace('_', '-')}"
            raise InputError(f"{name} belongs to --constrained {' or '.join(gauges)}, not {arguments.constrained}")


def _constrained(
    arguments: argparse.Namespace, result: estimation.Identification
) -> estimation.possible.PossibleRobot | None:
    """The robot that can exist, as asked for."""
    if arguments.constrained == "none":
        return None
    robot, base, estimate = result.robot, result.base, result.estimate
    mass = estimation.MassBounds(*arguments.total_mass) if arguments.total_mass else None
    try:
        if arguments.constrained == "base":
            return estimation.possible.solve_constrained_base(robot, base, estimate, mass)
        budget = estimation.possible.BUDGET if arguments.prior_budget is None else arguments.prior_budget
        prior = estimation.possible.robot_prior(robot, arguments.prior_mass)
        return estimation.possible.solve_constrained_prior(robot, base, estimate, prior, budget, mass)
    except estimation.SolverError as error:
        raise InputError(f"{error}; --constrained none leaves it out") from error


def _page(
    arguments: argparse.Namespace,
    result: estimation.Identification,
    constrained: estimation.possible.PossibleRobot | None,
    recordings: Sequence[model.Recording],
    held_out: Sequence[model.Recording],
    processing: model.Processing,
    warnings: Sequence[str],
) -> report.Page:
    """The report: what was held out is drawn, else what was fitted."""
    files = {"without payload": arguments.data, "held out": arguments.validate}
    return report.robot_page(
        result,
        constrained,
        result.predictions,
        result.excitation,
        provenance(arguments, files, settings_in_words(result.robot, processing, arguments.drive_gains)),
        warnings,
        others=len(held_out or recordings) - len(result.predictions),
    )
