"""``dynident score``: what a motion teaches, and whether it keeps the limits: one run, or planned elsewhere."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

from ... import estimation, model, trajectories
from ...common.errors import InputError
from .. import logs, report
from .. import view as views
from ..logs.map import read_log_map
from ..logs.read import read_recording
from . import ANSWERED
from .entry import MOTION, SETTING, command, options
from .motion import build_request, floor_of
from .options import Options, RehearsedRobotOptions, ViewedPageOptions
from .options.motions import GoalOptions, LimitOptions
from .values import LOG, LogMapFile, Reads, Seconds, Seed, positive_number, word

_PLANNED_RATE = 250.0  # Hz: at which a planned motion is looked at, at least


@options(MOTION)
class _Scored(Options):
    """The motion, and the floor it is compared with."""

    log_map: LogMapFile | None = None
    """Columns, units and signs of the log."""
    cutoff: Annotated[float | None, word(positive_number, "HZ")] = None
    """Low-pass on positions."""
    max_duration: Seconds | None = None
    """Longest time that it may take."""
    bound: bool = False
    """Estimate the floor over all motions, and the gap."""
    seed: Annotated[Seed | None, SETTING] = None
    """Seed of the random states of --bound (default: 0)."""


@command
def run(
    data: Annotated[str, Reads("motion"), LOG],
    *,
    arm: RehearsedRobotOptions,
    scored: _Scored,
    goal: GoalOptions,
    limits: LimitOptions,
    files: ViewedPageOptions,
) -> int:
    """Run it.

    Args:
        data: A log, or a CSV of t, q and perhaps qd, qdd.
    """
    files.check_view()
    if not scored.bound:
        scored.refuse("seed", "has no effect without --bound: nothing is designed")
    shape = trajectories.ViaPointShape(longest=scored.max_duration)
    problem, reference, labels = build_request(arm.load(), shape, goal, limits)
    motion = _logged_motion(data, problem.robot, scored.log_map, scored.cutoff)
    score = trajectories.score_motion(problem, motion)
    floor = floor_of(problem, score, scored.seed or 0) if scored.bound else None
    judged = report.documents.JudgedMotion(
        f"Motion of {data}", score, motion, reference, labels, floor=floor, source=data
    )
    files.give(report.design_report(judged), lambda: report.documents.design_document(judged), {})
    files.write_view(lambda: views.view_of(problem.robot, motion, problem=problem))
    return ANSWERED


def _logged_motion(path: str, robot: model.Robot, log_map: str | None, cutoff: float | None) -> model.Motion:
    """The motion of a file: as planned where it has accelerations, else filtered like a recording.

    Planned samples are joined by quintics, so that limits are looked at between them too.
    """
    if log_map:  # of currents the motion counts alone, whatever the gains
        mapped = read_log_map(log_map)
        currents = logs.named(path, robot, mapped).holds_currents_only
        recording = read_recording(path, robot, (1.0,) * robot.n if currents else None, mapped)
    else:
        t, q, qd, qdd = logs.read_trajectory(path, robot)
        if qd is not None and qdd is not None:
            if cutoff is not None:
                raise InputError(f"{path}: has accelerations and is not filtered: leave --cutoff out")
            return trajectories.joined(model.Motion(t, q, qd, qdd), _PLANNED_RATE)
        recording = model.Recording(t, q, 0.0 * q, qd, path)
    processing = robot.processing if cutoff is None else replace(robot.processing, cutoff=cutoff)
    return estimation.measurement(recording, processing).motion
