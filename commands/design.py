"""``dynident design``: the most informative motion a robot may make."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console

from .. import report, trajectories
from ..common.errors import InputError
from . import COMMANDS
from .arguments import ANSWERED, robot_argument
from .design_arguments import goal_arguments, limit_arguments, search_arguments, shape_arguments
from .design_log import logged_motion
from .design_near import check_near, near_arguments, run_near
from .design_outputs import (
    check_formats,
    check_outputs,
    figure_motion,
    output_arguments,
    replayed,
    write_design_report,
    write_motion,
    write_plots,
)
from .design_problem import Request, build_request
from .design_shape import known_length

if TYPE_CHECKING:
    from rich.table import Table


_SHAPED = ("via_points", "fourier", "duration", "segments", "ramp", "segment_durations", "rest", "starts", "solver")
"""Options of the motion to be designed, and of the search for it."""


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser("design", help=COMMANDS["design"])
    robot_argument(parser)
    shape_arguments(parser)
    goal_arguments(parser)
    limit_arguments(parser)
    near_arguments(parser)
    search_arguments(parser)
    output_arguments(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run it."""
    check_near(arguments)
    _check(arguments)
    check_outputs(arguments)
    if arguments.near is not None:
        return run_near(arguments)
    request = build_request(arguments)
    check_formats(arguments, request.problem.robot)
    if arguments.evaluate:
        return _evaluate(arguments, request)
    return _design(arguments, request)


def _check(arguments: argparse.Namespace) -> None:
    """Refuse options that would have no effect."""
    for option in ("cutoff", "log_map"):
        if arguments.evaluate is None and getattr(arguments, option) is not None:
            raise InputError(f"--{option.replace('_', '-')} has no effect without --evaluate")
    for option in _SHAPED if arguments.evaluate else ():
        if getattr(arguments, option) not in (None, False):
            raise InputError(f"--{option.replace('_', '-')} has no effect with --evaluate: nothing is designed")
    if arguments.data_from and arguments.data_length is None and known_length(arguments) is None:
        raise InputError("--data-from needs --data-length: how long will be recorded next?")


def _design(arguments: argparse.Namespace, request: Request) -> int:

    design = _solved(arguments, request)
    floor = _floor(arguments, request, design.score) if arguments.bound else None
    replay = replayed(design) if arguments.val3 else None
    title = f"Motion of {request.problem.robot.title or request.problem.robot.name}"
    told = _print(request, design.score, title, floor, replay)
    write_motion(arguments, design)
    _write_json(arguments, request, design.score, floor, design, replay)
    if arguments.plots:
        write_plots(Path(arguments.plots), request, design.score, design, figure_motion(design))
    write_design_report(arguments, request, design.score, design, figure_motion(design), told)
    return ANSWERED


def _solved(arguments: argparse.Namespace, request: Request) -> trajectories.Design:
    """The best motion that keeps every limit.

    Raises:
        InputError: if there is none; says which limit is missed and by how much.
    """
    kind = request.problem.criterion.kind
    with Console(stderr=True).status("building") as status:

        def show(step: trajectories.design.Step) -> None:
            best = (
                "no motion within the limits yet"
                if step.best is None
                else report.design_results.criterion_text(kind, step.best)
            )
            status.update(f"{step.text}, {step.evaluations} evaluations; best: {best}")

        design = trajectories.solve_design(
            request.problem,
            seed=arguments.seed,
            starts=arguments.starts,
            progress=show,
            solver=arguments.solver or "auto",
        )
    stopped = "interrupted: " if design.interrupted else ""
    if not design.feasible:
        missed = "; ".join(design.score.violations)
        raise InputError(f"{stopped}no motion was found that keeps every limit, the nearest has: {missed}")
    if design.interrupted:
        print("dynident: note: interrupted: this is the best motion so far; it keeps every limit", file=sys.stderr)
    return design


def _evaluate(arguments: argparse.Namespace, request: Request) -> int:

    motion = logged_motion(arguments, request.problem.robot)
    score = trajectories.score_motion(request.problem, motion)
    floor = _floor(arguments, request, score) if arguments.bound else None
    told = _print(request, score, f"Motion of {arguments.evaluate}", floor)
    _write_json(arguments, request, score, floor)
    if arguments.plots:
        write_plots(Path(arguments.plots), request, score, None, motion)
    write_design_report(arguments, request, score, None, motion, told)
    return ANSWERED


def _floor(
    arguments: argparse.Namespace, request: Request, score: trajectories.Score
) -> trajectories.design.Floor | None:
    """The floor; None if it was interrupted, which costs no motion."""
    try:
        with Console(stderr=True).status("estimating the floor"):
            return trajectories.floor_under(request.problem, score.value, seed=arguments.seed)
    except KeyboardInterrupt:
        print("dynident: note: interrupted: the floor is not known", file=sys.stderr)
        return None


def _print(
    request: Request,
    score: trajectories.Score,
    title: str,
    floor: trajectories.design.Floor | None,
    replay: trajectories.Score | None = None,
) -> tuple[list[Table], list[str]]:
    """Print the result; returns its tables and lines."""
    sigmas = report.design_results.sigma_table(score, request.reference, request.labels)
    tables = [
        report.design_results.score_table(request.problem, score, title),
        *([sigmas] if sigmas is not None else []),
    ]
    terminal = report.tables.console(*tables)
    terminal.print(*tables)
    kind = request.problem.criterion.kind
    lines = [f"Criterion {report.design_results.criterion_text(kind, score.value)}."]
    if floor is not None:
        lines.append(report.design_results.floor_note(kind, floor))
    if replay is not None:
        lines.append(report.design_results.replay_note(kind, replay))
    for line in lines:
        terminal.print(line, markup=False, highlight=False)
    return tables, lines


def _write_json(
    arguments: argparse.Namespace,
    request: Request,
    score: trajectories.Score,
    floor: trajectories.design.Floor | None,
    design: trajectories.Design | None = None,
    replay: trajectories.Score | None = None,
) -> None:
    if not arguments.json:
        return

    evaluated = arguments.evaluate
    document = report.design_results.design_document(
        request.problem, score, request.reference, design=design, floor=floor, evaluated=evaluated, replay=replay
    )
    report.documents.write_json(arguments.json, document)
