"""``dynident design``: the most informative motion a robot may make."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from ... import model, trajectories
from ...common.errors import InputError
from ...common.files import made_folder
from .. import export, report
from .. import view as views
from . import ANSWERED
from .entry import FILES, MOTION, SEARCH, SETTING, command, options
from .motion import FIGURE_RATE, MotionFiles, best_motion, build_request, floor_of
from .options import Options, RehearsedRobotOptions
from .options.motions import GoalOptions, LimitOptions, in_si
from .values import Count, NewFolder, Positions, Seconds, Seed, number, numbers, word

_FEWEST = 3
_OF_VIA_POINTS = ("rest", "max_duration", "segments", "ramp", "segment_durations")
_REPLAY_RATE = 500.0  # Hz


@options(MOTION)
class _Shape(Options):
    """Via points or a Fourier series, how it goes between points, times, and where it starts."""

    via_points: Count | None = None
    """Number of points (default: 14)."""
    fourier: Annotated[Count | None, Parameter(metavar="H")] = None
    """A Fourier series of H harmonics instead."""
    segments: Annotated[Literal["quintic", "trapezoid"] | None, Parameter(show_choices=False)] = None
    """quintic (default), or trapezoid: as movej runs it, at rest in each point."""
    ramp: Annotated[float | None, word(number, "SHARE"), SETTING] = None
    """Share of each move's time in either ramp of a trapezoid (default: 0.25)."""
    segment_durations: Annotated[tuple[float, ...] | None, word(numbers, "S|S1,S2,.."), SETTING] = None
    """Fixed times from point to point, one for all or one each (default: free)."""
    rest: bool = False
    """Rest in each via point instead of passing it."""
    duration: Seconds | None = None
    """Period of --fourier (default: 10)."""
    max_duration: Seconds | None = None
    """Longest time through via points."""
    start: Positions | None = None
    """Pose at the start [deg or m]."""

    def shape(self, robot: model.Robot) -> trajectories.ViaPointShape | trajectories.FourierShape:
        """The shape of the motion."""
        if self.fourier is None:
            self.refuse("duration", "is the period of --fourier: via points take --max-duration")
            return self._through_points(self._start(robot))
        self.refuse("via_points", "and --fourier: give one of them")
        for name in _OF_VIA_POINTS:
            self.refuse(name, "belongs to --via-points: --fourier takes --duration")
        period = trajectories.FourierShape().duration if self.duration is None else self.duration
        return trajectories.FourierShape(self.fourier, period, start=self._start(robot))

    def _start(self, robot: model.Robot) -> tuple[float, ...] | None:
        """The pose where the motion begins, checked in the units it was given in."""
        if not self.start:
            return None
        pose = in_si(self.start, robot)
        for j, (joint, value, position) in enumerate(zip(robot.joints, self.start, pose, strict=True), 1):
            low, high = joint.limits.position
            if not low <= position <= high:
                unit = "deg" if joint.revolute else "m"
                shown = [math.degrees(limit) if joint.revolute else limit for limit in (low, high)]
                raise InputError(
                    f"--start: joint {j} at {value:g} {unit} is outside {shown[0]:g} to {shown[1]:g} {unit}"
                )
        return tuple(pose.tolist())

    def _through_points(self, start: tuple[float, ...] | None) -> trajectories.ViaPointShape:
        count = self.via_points or trajectories.ViaPointShape().count
        if count < _FEWEST:
            raise InputError(f"--via-points {count}: give at least {_FEWEST}")
        if self.segments != "trapezoid":
            self.refuse("ramp", "has no effect without --segments trapezoid")
        times = self.segment_durations
        if times is not None and self.max_duration is not None:
            raise InputError("segment-durations fixes the whole duration: leave --max-duration out")
        fixed = times[0] if times is not None and len(times) == 1 else times
        segment: trajectories.Segment = trajectories.Quintic()
        if self.segments == "trapezoid":
            segment = trajectories.Trapezoid() if self.ramp is None else trajectories.Trapezoid(self.ramp)
        passing = segment.passes and not self.rest
        return trajectories.ViaPointShape(
            count, passing=passing, fixed=fixed, segment=segment, longest=self.max_duration, start=start
        )


@options(SEARCH)
class _Search(Options):
    """Random starts of the search, and the floor."""

    seed: Seed = 0
    """Seed of the random starts (default: 0)."""
    starts: Annotated[Count | None, Parameter(metavar="K")] = None
    """Random starts (default: 6 by d and a, else 3)."""
    bound: bool = False
    """Estimate the floor over all motions, and the gap."""


@options(FILES)
class _DesignFiles(MotionFiles):
    """Formats of the motion, and the folder of a VAL3 application."""

    val3: NewFolder | None = None
    """VAL3 application of via points, best with --segments trapezoid; made if missing."""

    def asked(self, written: export.WrittenMotion) -> dict[str, tuple[str, export.WrittenMotion]]:
        """The formats asked for by name, with the application's database, which the rest of it stands beside."""
        database = {"val3": (str(Path(self.val3) / f"{written.name}.dtx"), written)} if self.val3 else {}
        return super().asked(written) | database

    def write(self, written: export.WrittenMotion) -> None:
        """Write a motion with its head in the formats asked for."""
        if self.val3:
            made_folder(self.val3)
        super().write(written)


@command
def run(
    *,
    arm: RehearsedRobotOptions,
    shape: _Shape,
    goal: GoalOptions,
    limits: LimitOptions,
    search: _Search,
    files: _DesignFiles,
) -> int:
    """Run it."""
    files.check_view()
    robot = arm.load()
    problem, reference, labels = build_request(robot, shape.shape(robot), goal, limits)
    robot, kind = problem.robot, problem.criterion.kind
    files.check(robot)
    if files.val3:
        export.check_val3(robot, not shape.fourier, Path(files.val3).name)

    def words(best: float | None) -> str:
        text = None if best is None else report.criterion_text(kind, best)
        return f"; best: {text or 'no motion within the limits yet'}"

    design = best_motion(problem, search.seed, search.starts, words)
    floor = floor_of(problem, design.score, search.seed) if search.bound else None
    title, samples = f"Motion of {robot.title or robot.name}", design.motion(FIGURE_RATE)
    head, name = export.design_head(design), Path(files.val3 or "").name
    written = export.WrittenMotion(robot, design.plan, problem.bounds, head, name=name)
    replay = None
    if files.val3:  # what a controller would make of the via points if its profiles are trapezoidal
        profile = export.val3_replay(written).motion(_REPLAY_RATE)
        replay = trajectories.score_motion(problem, profile)
    judged = report.documents.JudgedMotion(title, design.score, samples, reference, labels, design, floor, replay)
    estimated = () if problem.payloads is not None else ("val3",)
    files.check_replays(limits.whole(problem), written, *estimated)
    files.give(report.design_report(judged), lambda: report.documents.design_document(judged), {})
    files.write(written)
    files.write_view(lambda: views.view_of(robot, samples, problem=problem))
    return ANSWERED
