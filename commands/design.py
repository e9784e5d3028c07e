"""``dynident design``: the most informative motion a robot may make."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .arguments import ANSWERED, gains_list, names_list, number, positive, positive_number, robot_argument, whole
from .design_near import check_near, near_arguments, run_near
from .design_outputs import output_arguments
from .design_problem import acceleration_limit, noise_level, torque_list

if TYPE_CHECKING:
    from rich.table import Table

    from ..model import Motion, Recording, Robot
    from ..trajectories import Design, Floor, Score
    from .design_problem import Request

_CRITERIA = ("d", "a", "cond", "cond-scaled")


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser("design", help="the most informative motion within the robot's limits")
    robot_argument(parser)
    _shape_arguments(parser)
    _goal_arguments(parser)
    _limit_arguments(parser)
    near_arguments(parser)
    group = parser.add_argument_group("search")
    group.add_argument("--seed", type=whole, default=0, help="of the random starts (default: 0)")
    group.add_argument(
        "--starts", type=positive, metavar="K", help="random starts (default: 6 by d and a, else 3; 1 with --near)"
    )
    group.add_argument("--bound", action="store_true", help="estimate the floor over all motions, and the gap")
    group.add_argument(
        "--evaluate", metavar="LOG", help="judge the motion of a log or of a CSV instead of designing one"
    )
    group.add_argument("--log-map", metavar="TOML", help="of --evaluate: columns, units and signs of the log")
    group.add_argument("--cutoff", type=positive_number, metavar="HZ", help="of --evaluate: low-pass on positions")
    output_arguments(parser)
    parser.set_defaults(run=run)


def _shape_arguments(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("motion")
    either = group.add_mutually_exclusive_group()
    either.add_argument("--via-points", type=positive, metavar="N", help="number of points (default: 14)")
    either.add_argument("--fourier", type=positive, metavar="H", help="a Fourier series of H harmonics instead")
    shapes, text = ("quintic", "trapezoid"), "default: quintic; trapezoid: as movej runs it, at rest in each point"
    group.add_argument("--segments", choices=shapes, help=text)
    group.add_argument(
        "--ramp", type=number, metavar="SHARE", help="of each move's time, in either ramp of a trapezoid (0.25)"
    )
    group.add_argument(
        "--segment-durations",
        type=gains_list,
        metavar="S|S1,S2,..",
        help="fixed times from point to point, one for all or one each (default: free)",
    )
    group.add_argument("--rest", action="store_true", help="rest in each via point instead of passing it")
    group.add_argument(
        "--duration", type=positive_number, metavar="S", help="period of --fourier (default: 10), or of --near (30)"
    )
    group.add_argument("--max-duration", type=positive_number, metavar="S", help="longest time through via points")
    group.add_argument("--start", type=gains_list, metavar="Q1,Q2,..", help="where it starts [deg or m]")


def _goal_arguments(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("what to learn")
    group.add_argument(
        "--criterion",
        choices=_CRITERIA,
        default="d",
        help="d: information (default); a: relative sigma; cond: condition number; cond-scaled: columns scaled",
    )
    group.add_argument(
        "--columns", type=names_list, metavar="NAME,..", help="parameters to be estimated (default: base)"
    )
    group.add_argument(
        "--parameters", type=names_list, metavar="NAME,..", help="those that count, for d and a (default: all)"
    )
    group.add_argument("--payload-only", action="store_true", help="the payload's ten, the robot being known")
    group.add_argument(
        "--data-from",
        action="append",
        metavar="F",
        help="what was learnt before: --npz of identify or payload, or --json of identify (d and a); repeatable",
    )
    group.add_argument("--data-length", type=positive_number, metavar="S", help="of the recording to come")
    group.add_argument(
        "--torque-noise",
        type=noise_level,
        metavar="S1,S2,..",
        help="sigma per joint [N·m or N], or 10%% of the limits",
    )
    group.add_argument(
        "--independent-rate",
        type=positive_number,
        default=100.0,
        metavar="HZ",
        help="independent samples a second (default: 100)",
    )


def _limit_arguments(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("limits", "positions and speeds stand in the robot's file")
    group.add_argument(
        "--speed-override", type=number, default=1.0, metavar="SHARE", help="of the speed (default: 1)"
    )
    group.add_argument(
        "--acceleration",
        type=acceleration_limit,
        metavar="A1,A2,..",
        help="[deg/s² or m/s²], or 3x: three times the speed limit per second",
    )
    group.add_argument(
        "--torque-limits",
        type=torque_list,
        metavar="T1,T2,..",
        help="[N·m or N], or none: not even those of the robot's file",
    )
    group.add_argument("--robot-parameters", metavar="JSON", help="of identify: for torques and relative sigma")
    group.add_argument(
        "--heaviest-payload", metavar="KG[@X,Y,Z]|TOML", help="torque limits hold without it and with it"
    )
    group.add_argument("--scene", metavar="TOML", help="floor, walls, and bodies that keep clear of each other")


def run(arguments: argparse.Namespace) -> int:
    """Run it."""
    from .design_outputs import check_formats, check_outputs
    from .design_problem import build_request

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
    from ..model import InputError

    for option in ("cutoff", "log_map"):
        if arguments.evaluate is None and getattr(arguments, option) is not None:
            raise InputError(f"--{option.replace('_', '-')} has no effect without --evaluate")
    if arguments.data_length is None and arguments.data_from and not (arguments.fourier or arguments.max_duration):
        raise InputError("--data-from needs --data-length: how long will be recorded next?")


def _design(arguments: argparse.Namespace, request: Request) -> int:
    from .design_outputs import figure_motion, replayed, write_design_report, write_motion, write_plots

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


def _solved(arguments: argparse.Namespace, request: Request) -> Design:
    """The best motion that keeps every limit.

    Raises:
        InputError: if there is none; says which limit is missed and by how much.
    """
    from rich.console import Console

    from ..model import InputError
    from ..report.design_results import criterion_text
    from ..trajectories import Step, solve_design

    kind = request.problem.criterion.kind
    with Console(stderr=True).status("building") as status:

        def show(step: Step) -> None:
            best = "no motion within the limits yet" if step.best is None else criterion_text(kind, step.best)
            status.update(f"{step.text}, {step.evaluations} evaluations; best: {best}")

        design = solve_design(request.problem, seed=arguments.seed, starts=arguments.starts, progress=show)
    stopped = "interrupted: " if design.interrupted else ""
    if not design.feasible:
        missed = "; ".join(design.score.violations)
        raise InputError(f"{stopped}no motion was found that keeps every limit, the nearest has: {missed}")
    if design.interrupted:
        print("dynident: note: interrupted: this is the best motion so far; it keeps every limit", file=sys.stderr)
    return design


def _evaluate(arguments: argparse.Namespace, request: Request) -> int:
    from ..trajectories import score_motion
    from .design_outputs import write_design_report, write_plots

    motion = _logged(arguments, request.problem.robot)
    score = score_motion(request.problem, motion)
    floor = _floor(arguments, request, score) if arguments.bound else None
    told = _print(request, score, f"Motion of {arguments.evaluate}", floor)
    _write_json(arguments, request, score, floor)
    if arguments.plots:
        write_plots(Path(arguments.plots), request, score, None, motion)
    write_design_report(arguments, request, score, None, motion, told)
    return ANSWERED


def _logged(arguments: argparse.Namespace, robot: Robot) -> Motion:
    """The motion of a file: as planned where it has accelerations, else filtered like a recording."""
    from dataclasses import replace

    import numpy as np

    from ..estimation import measurement, read_trajectory
    from ..model import InputError, Motion, Recording

    if arguments.log_map:
        recording = _mapped(arguments, robot)
    else:
        table = read_trajectory(arguments.evaluate, robot)
        if table.qd is not None and table.qdd is not None:
            if arguments.cutoff is not None:
                raise InputError(f"{arguments.evaluate}: has accelerations and is not filtered: leave --cutoff out")
            return Motion(table.t, table.q, table.qd, table.qdd)
        recording = Recording(table.t, table.q, np.zeros_like(table.q), table.qd, arguments.evaluate)
    processing = robot.processing
    if arguments.cutoff is not None:
        processing = replace(processing, cutoff=arguments.cutoff)
    return measurement(recording, processing).motion


def _mapped(arguments: argparse.Namespace, robot: Robot) -> Recording:
    """A log as its map says; of currents the motion counts alone, whatever the gains."""
    from ..estimation import read_log_map, read_recording
    from ..estimation.logs import holds_currents_only

    log_map = read_log_map(arguments.log_map)
    currents = holds_currents_only(arguments.evaluate, robot, log_map)
    return read_recording(arguments.evaluate, robot, (1.0,) * robot.n if currents else None, log_map)


def _floor(arguments: argparse.Namespace, request: Request, score: Score) -> Floor | None:
    """The floor; None if it was interrupted, which costs no motion."""
    from rich.console import Console

    from ..trajectories import floor_under

    try:
        with Console(stderr=True).status("estimating the floor"):
            return floor_under(request.problem, score.value, seed=arguments.seed)
    except KeyboardInterrupt:
        print("dynident: note: interrupted: the floor is not known", file=sys.stderr)
        return None


def _print(
    request: Request, score: Score, title: str, floor: Floor | None, replay: Score | None = None
) -> tuple[list[Table], list[str]]:
    """Print the result; returns its tables and lines."""
    from ..report.design_results import criterion_text, floor_note, replay_note, score_table, sigma_table
    from ..report.tables import console

    sigmas = sigma_table(score, request.reference, request.labels)
    tables = [score_table(request.problem, score, title), *([sigmas] if sigmas is not None else [])]
    terminal = console(*tables)
    terminal.print(*tables)
    kind = request.problem.criterion.kind
    lines = [f"Criterion {criterion_text(kind, score.value)}."]
    if floor is not None:
        lines.append(floor_note(kind, floor))
    if replay is not None:
        lines.append(replay_note(kind, replay))
    for line in lines:
        terminal.print(line, markup=False, highlight=False)
    return tables, lines


def _write_json(
    arguments: argparse.Namespace,
    request: Request,
    score: Score,
    floor: Floor | None,
    design: Design | None = None,
    replay: Score | None = None,
) -> None:
    if not arguments.json:
        return
    from ..report.design_results import design_document
    from ..report.documents import write_json

    evaluated = arguments.evaluate
    document = design_document(
        request.problem, score, request.reference, design=design, floor=floor, evaluated=evaluated, replay=replay
    )
    write_json(arguments.json, document)
