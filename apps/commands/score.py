"""``dynident score``: what a motion teaches, and whether it keeps the limits: one run, or planned elsewhere."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ... import estimation, model, trajectories
from ...common.errors import InputError
from .. import logs, report
from .. import view as views
from ..logs.map import read_log_map
from ..logs.read import read_recording
from . import ANSWERED
from .motion import Asked, build_request, floor_of, show
from .options import GoalOptions, LimitOptions, Options, PageOptions, RehearsedRobotOptions, ViewOptions, option
from .values import positive_number, whole

_PLANNED_RATE = 250.0  # Hz: at which a planned motion is looked at, at least


@dataclass(frozen=True)
class _Scored(Options):
    """The motion, and the floor it is compared with."""

    GROUP = "motion"

    log: str = option("log", reads="motion", metavar="LOG", help="a log, or a CSV of t, q and perhaps qd, qdd")
    log_map: str | None = option(reads="log map", metavar="TOML", help="columns, units and signs of the log")
    cutoff: float | None = option(type=positive_number, metavar="HZ", help="low-pass on positions")
    max_duration: float | None = option(type=positive_number, metavar="S", help="how long it may take")
    bound: bool = option(
        group="floor", action="store_true", help="estimate the floor over all motions, and the gap"
    )
    seed: int | None = option(
        group="floor", type=whole, metavar="SEED", help="of the random states of --bound (default: 0)"
    )


def run(
    arm: RehearsedRobotOptions,
    scored: _Scored,
    goal: GoalOptions,
    limits: LimitOptions,
    files: PageOptions,
    view: ViewOptions,
) -> int:
    """Run it."""
    view.check_view()
    if not scored.bound:
        scored.refuse("seed", "has no effect without --bound: nothing is designed")
    lengths = Asked(length=scored.max_duration, longest=scored.max_duration)
    request = build_request(arm.load(), lengths, goal, limits)
    motion = _logged_motion(scored.log, request.problem.robot, scored.log_map, scored.cutoff)
    score = trajectories.score_motion(request.problem, motion)
    floor = floor_of(request.problem, score, scored.seed or 0) if scored.bound else None
    judged = report.documents.JudgedMotion(
        f"Motion of {scored.log}", score, motion, request.reference, request.labels, floor=floor, source=scored.log
    )
    show(files, judged, scored, limits, goal, arm)
    problem = request.problem
    view.write_view(lambda: views.view_of(problem.robot, motion, problem=problem))
    return ANSWERED


def _logged_motion(path: str, robot: model.Robot, log_map: str | None, cutoff: float | None) -> model.Motion:
    """The motion of a file: as planned where it has accelerations, else filtered like a recording.

    Planned samples are joined by quintics, so that limits are looked at between them too.
    """
    if log_map:  # of currents the motion counts alone, whatever the gains
        mapped = read_log_map(log_map)
        currents = logs.holds_currents_only(path, robot, mapped)
        recording = read_recording(path, robot, (1.0,) * robot.n if currents else None, mapped)
    else:
        table = logs.read_trajectory(path, robot)
        if table.qd is not None and table.qdd is not None:
            if cutoff is not None:
                raise InputError(f"{path}: has accelerations and is not filtered: leave --cutoff out")
            planned = model.Motion(table.t, table.q, table.qd, table.qdd)
            return trajectories.joined(planned, _PLANNED_RATE)
        recording = model.Recording(table.t, table.q, np.zeros_like(table.q), table.qd, path)
    processing = robot.processing if cutoff is None else replace(robot.processing, cutoff=cutoff)
    return estimation.measurement(recording, processing).motion
