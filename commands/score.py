"""``dynident score``: what a motion teaches, and whether it keeps the limits: one run, or planned elsewhere."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

import numpy as np

from .. import estimation, model, trajectories
from ..common.errors import InputError
from . import COMMANDS
from .arguments import ANSWERED, chosen_robot, robot_argument
from .motion_pages import Judged, show
from .motion_request import Asked, build_request
from .motion_search import floor_of
from .options import GoalOptions, LimitOptions, ResultFiles
from .values import positive_number, whole


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parser = commands.add_parser("score", help=COMMANDS["score"])
    parser.add_argument("log", metavar="LOG", help="a log, or a CSV of t, q and perhaps qd, qdd")
    robot_argument(parser)
    group = parser.add_argument_group("motion")
    group.add_argument("--log-map", metavar="TOML", help="columns, units and signs of the log")
    group.add_argument("--cutoff", type=positive_number, metavar="HZ", help="low-pass on positions")
    group.add_argument("--max-duration", type=positive_number, metavar="S", help="how long it may take")
    GoalOptions.declare(parser)
    LimitOptions.declare(parser)
    group = parser.add_argument_group("floor")
    group.add_argument("--bound", action="store_true", help="estimate the floor over all motions, and the gap")
    group.add_argument("--seed", type=whole, metavar="SEED", help="of the random states of --bound (default: 0)")
    ResultFiles.add_to(parser.add_argument_group("files"))
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run it."""
    if arguments.seed is not None and not arguments.bound:
        raise InputError("--seed has no effect without --bound: nothing is designed")
    goal, limits, files = GoalOptions.of(arguments), LimitOptions.of(arguments), ResultFiles.of(arguments)
    asked = Asked(length=arguments.max_duration, longest=arguments.max_duration)
    request = build_request(chosen_robot(arguments), asked, goal, limits, arguments.heaviest_payload)
    motion = _logged_motion(arguments.log, request.problem.robot, arguments.log_map, arguments.cutoff)
    score = trajectories.score_motion(request.problem, motion)
    floor = floor_of(request.problem, score, arguments.seed or 0) if arguments.bound else None
    judged = Judged(f"Motion of {arguments.log}", score, motion, floor=floor, source=arguments.log)
    show(arguments, files, request, judged)
    return ANSWERED


def _logged_motion(path: str, robot: model.Robot, log_map: str | None, cutoff: float | None) -> model.Motion:
    """The motion of a file: as planned where it has accelerations, else filtered like a recording."""
    if log_map:
        recording = _mapped(path, robot, log_map)
    else:
        table = estimation.recordings.read_trajectory(path, robot)
        if table.qd is not None and table.qdd is not None:
            if cutoff is not None:
                raise InputError(f"{path}: has accelerations and is not filtered: leave --cutoff out")
            return model.Motion(table.t, table.q, table.qd, table.qdd)
        recording = model.Recording(table.t, table.q, np.zeros_like(table.q), table.qd, path)
    processing = robot.processing if cutoff is None else replace(robot.processing, cutoff=cutoff)
    return estimation.signals.measurement(recording, processing).motion


def _mapped(path: str, robot: model.Robot, map_path: str) -> model.Recording:
    """A log as its map says; of currents the motion counts alone, whatever the gains."""
    log_map = estimation.read_log_map(map_path)
    currents = estimation.recordings.holds_currents_only(path, robot, log_map)
    return estimation.read_recording(path, robot, (1.0,) * robot.n if currents else None, log_map)
