"""``dynident design``: the most informative motion a robot may make."""

from __future__ import annotations

import argparse
import sys
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
    output_arguments,
    replayed,
    write_design_page,
    write_motion,
)
from .design_problem import Request, build_request
from .design_shape import known_length

if TYPE_CHECKING:
    pass


_FIGURE_RATE = 100.0  # Hz
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
    screen = _shown(request, design.score, title, floor, replay)
    write_motion(arguments, design)
    _write_json(arguments, request, design.score, floor, design, replay)
    write_design_page(arguments, request, design.score, design, design.motion(_FIGURE_RATE), screen)
    return ANSWERED


def _solved(arguments: argparse.Namespace, request: Request) -> trajectories.Design:
    """The best motion that keeps every limit.

    Raises:
        InputError: if there is none; says which limit is missed and by how much.
    """
    kind = request.problem.criterion.kind
    with Console(stderr=True).status("building") as status:

        def show(step: trajectories.Step) -> None:
            best = (
                "no motion within the limits yet" if step.best is None else report.criterion_text(kind, step.best)
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
    screen = _shown(request, score, f"Motion of {arguments.evaluate}", floor)
    _write_json(arguments, request, score, floor)
    write_design_page(arguments, request, score, None, motion, screen)
    return ANSWERED


def _floor(arguments: argparse.Namespace, request: Request, score: trajectories.Score) -> trajectories.Floor | None:
    """The floor; None if it was interrupted, which costs no motion."""
    try:
        with Console(stderr=True).status("estimating the floor"):
            return trajectories.floor_under(request.problem, score.value, seed=arguments.seed)
    except KeyboardInterrupt:
        print("dynident: note: interrupted: the floor is not known", file=sys.stderr)
        return None


def _shown(
    request: Request,
    score: trajectories.Score,
    title: str,
    floor: trajectories.Floor | None,
    replay: trajectories.Score | None = None,
) -> list[report.Block]:
    """Print the result; returns what was printed."""
    screen = report.design_screen(request.problem, score, title, request.reference, request.labels, floor, replay)
    report.print_blocks(screen)
    return screen


def _write_json(
    arguments: argparse.Namespace,
    request: Request,
    score: trajectories.Score,
    floor: trajectories.Floor | None,
    design: trajectories.Design | None = None,
    replay: trajectories.Score | None = None,
) -> None:
    if not arguments.json:
        return

    evaluated = arguments.evaluate
    document = report.documents.design_document(
        request.problem, score, request.reference, design=design, floor=floor, evaluated=evaluated, replay=replay
    )
    report.documents.write_json(arguments.json, document)
