"""``dynident design`` and ``score``: the most informative motion a robot may make, and what a motion teaches."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Annotated, ClassVar, Literal

from cyclopts import Parameter

from ... import estimation, model, trajectories
from ...common.arrays import Array
from ...common.errors import InputError
from ...model.motion import Measurement
from .. import logs
from .. import view as views
from ..export.motion import WrittenMotion, design_head
from ..export.motions.val3 import val3_replay
from ..logs.map import read_log_map
from ..logs.read import read_recording
from ..report.documents import JudgedMotion, as_recorded, design_document, planned
from ..report.sections.motion import criterion_text, design_report
from . import motions, values
from .entry import MOTION, SEARCH, SETTING, Options, command
from .motions import GoalOptions, LimitOptions, MotionFiles, RehearsedRobotOptions, best_motion, in_si
from .options import PageOptions, ViewOptions
from .progress import note, status
from .values import Count, Positions, Reads, Seconds, Seed, number, numbers, positive_number, whole, word

_SEARCH = Parameter(group=SEARCH)
_REPLAY_RATE = 500.0  # Hz
_PLANNED_RATE = 250.0  # Hz: at which a planned motion is looked at, at least
_ZERO = 1e-9  # SI units: what standard parameters leave where they cancel

_Planned = Annotated[
    str, Reads("motion"), Parameter(metavar="LOG", help="A log, or a CSV of t, q and perhaps qd, qdd.")
]


class _Request(Options, group=MOTION):
    belongs: ClassVar = {"ramp": ("segments", ("trapezoid",))}
    instead: ClassVar = {"via_points": "fourier"}

    via_points: Annotated[int, word(partial(whole, least=3), "N")] = 14
    """Number of via points (default: 14)."""
    fourier: Annotated[Count | None, Parameter(metavar="H")] = None
    """Use a Fourier series of H harmonics instead of via points."""
    segments: Annotated[Literal["quintic", "trapezoid"], Parameter(show_choices=False)] = "quintic"
    """quintic (default), or trapezoid: as movej runs it, stopping at each point."""
    ramp: Annotated[float, word(number, "SHARE"), SETTING] = 0.25
    """Fraction of each move's time in either ramp of a trapezoid (default: 0.25)."""
    segment_durations: Annotated[tuple[float, ...] | None, word(numbers, "S|S1,S2,.."), SETTING] = None
    """Fixed times between points, one for all or one each (default: free)."""
    rest: bool = False
    """Stop at each via point instead of passing it."""
    duration: Seconds = 10.0
    """Period of --fourier (default: 10)."""
    max_duration: Seconds | None = None
    """Longest duration of a motion through via points."""
    start: Positions | None = None
    """Start pose [deg or m]."""
    seed: Annotated[Seed, _SEARCH] = 0
    """Seed of the random starts (default: 0)."""
    starts: Annotated[Count | None, Parameter(metavar="K"), _SEARCH] = None
    """Random starts (default: 6 by d and a, else 3)."""
    bound: Annotated[bool, SETTING] = False
    """Estimate the best value that any motion could reach, and the gap to it."""

    def check(self) -> None:
        """Refuse options of the other shape."""
        if self.fourier is None:
            self.refuse("duration", "is the period of --fourier: via points take --max-duration")
            if self.segment_durations is not None:
                self.refuse("max_duration", "has no effect: segment-durations fixes the duration, leave it out")
        else:
            for name in ("rest", "max_duration", "segments", "ramp", "segment_durations"):
                self.refuse(name, "belongs to --via-points: --fourier takes --duration")
        super().check()

    def shape(self, robot: model.Robot) -> trajectories.ViaPointShape | trajectories.FourierShape:
        """The shape of the motion."""
        start = tuple(in_si(self.start, robot).tolist()) if self.start else None
        for j, (joint, position) in enumerate(zip(robot.joints, start or (), strict=False), 1):
            low, high = joint.limits.position
            if not low <= position <= high:
                unit, size = ("deg", math.degrees(1.0)) if joint.revolute else ("m", 1.0)
                limits = f"{size * low:g} to {size * high:g} {unit}"
                raise InputError(f"--start: joint {j} at {size * position:g} {unit} is outside {limits}")
        if self.fourier is not None:
            return trajectories.FourierShape(self.fourier, self.duration, start=start)
        times, trapezoid = self.segment_durations, self.segments == "trapezoid"
        segment = trajectories.Trapezoid(self.ramp) if trapezoid else trajectories.Quintic()
        return trajectories.ViaPointShape(
            self.via_points,
            passing=segment.passes and not self.rest,
            fixed=times[0] if times is not None and len(times) == 1 else times,
            segment=segment,
            longest=self.max_duration,
            start=start,
        )


@command
def run(
    *,
    arm: RehearsedRobotOptions,
    request: _Request,
    goal: GoalOptions,
    limits: LimitOptions,
    files: MotionFiles,
    view: ViewOptions,
) -> None:
    """Run it."""
    robot = arm.load()
    problem, reference, labels = build_request(limits.of(robot), request.shape(robot), goal)
    robot, kind = problem.robot, problem.criterion.kind
    files.check_robot(robot, not request.fourier)

    def words(best: float | None) -> str:
        text = None if best is None else criterion_text(kind, best)
        return f"; best: {text or 'no motion within the limits yet'}"

    design = best_motion(problem, request.seed, request.starts, words)
    floor = floor_of(problem, design.score.value, request.seed) if request.bound else None
    judged = JudgedMotion.of(design)._replace(reference=reference, labels=labels, floor=floor)
    written = WrittenMotion(robot, design.plan, problem.bounds, design_head(design, judged.learnt))
    if files.val3:  # what a controller would make of the via points if its profiles are trapezoidal
        profile = val3_replay(files.asked(written)["val3"][1]).motion(_REPLAY_RATE)
        judged = judged._replace(replay=trajectories.score_motion(problem, profile))
    estimated = () if problem.payloads is not None else ("val3",)
    files.check_replays(limits.whole(problem), written, *estimated)
    files.give(design_report(judged), lambda: design_document(judged), {})
    files.write(written)
    view.write_view(lambda: views.view_of(robot, judged.motion, problem=problem))


def build_request(
    limited: motions.Limited,
    shape: trajectories.ViaPointShape | trajectories.FourierShape,
    goal: GoalOptions,
    stood: Sequence[Array] = (),
) -> tuple[trajectories.DesignProblem, dict[str, float], dict[str, str]]:
    """Read all files and build the problem; ``stood``: poses in which the arm was seen, k x n each.

    Returns:
        The problem; by the names of parameters, values that standard deviations are relative to, and how to call
        them ("ZZ1R").
    """
    robot, loads, payload = limited.robot, limited.loads, limited.loads.heaviest
    base, labels = model.base_parameters(robot), dict[str, str]()
    known = dict(loads.parameters) if limited.identified else {}
    if goal.payload_only:  # relative to the heaviest payload's parameters; a set has none
        known = payload.named(str(robot.n)) if isinstance(payload, model.InertialParameters) else {}
    else:
        labels = dict(zip(base.columns, base.names, strict=True))
        if not known and all(name in robot.parameters for name in base.standard):
            known = dict(zip(base.columns, base.value(robot.parameters).tolist(), strict=True))
    reference = {name: value for name, value in known.items() if abs(value) > _ZERO}
    if not limited.has_torque_limits and payload is not None and not goal.payload_only:
        raise InputError("--heaviest-payload counts in torque limits: give --torque-limits")
    counting = limited.has_torque_limits and (limited.identified or payload is not None or loads.margin > 0.0)
    if isinstance(shape, trajectories.FourierShape):
        length: float | None = shape.duration
    elif shape.fixed is None:
        length = shape.longest
    else:
        length = sum(shape.fixed) if isinstance(shape.fixed, tuple) else (shape.count - 1) * shape.fixed
    wanted = goal.goal(robot, limited.bounds, reference, length)
    return limited.problem(shape, wanted, loads if counting else None, stood), reference, labels


def floor_of(problem: trajectories.DesignProblem, score: float, seed: int) -> trajectories.Floor | None:
    """The floor under a motion's criterion; None if it was interrupted, which costs no motion."""
    try:
        with status("estimating the floor"):
            return trajectories.floor_under(problem, score, seed=seed)
    except KeyboardInterrupt:
        note("interrupted: the floor is not known")
        return None


class _Scored(Options, group=MOTION):
    needs: ClassVar = {"seed": ("bound",)}

    log_map: values.LogMapFile | None = None
    """Columns, units and signs of the log."""
    cutoff: Annotated[float | None, word(positive_number, "HZ")] = None
    """Cut-off frequency of the low-pass filter on positions."""
    max_duration: Seconds | None = None
    """Longest duration."""
    bound: Annotated[bool, SETTING] = False
    """Estimate the best value that any motion could reach, and the gap to it."""
    seed: Annotated[Seed, SETTING] = 0
    """Seed of the random states of bound (default: 0)."""


@command
def run_score(
    data: _Planned,
    *,
    arm: RehearsedRobotOptions,
    scored: _Scored,
    goal: GoalOptions,
    limits: LimitOptions,
    files: PageOptions,
    view: ViewOptions,
) -> None:
    """Run ``score``."""
    shape = trajectories.ViaPointShape(longest=scored.max_duration)
    limited = limits.of(arm.load())
    motion, recorded, stood = _logged_motion(data, limited.robot, scored.log_map, scored.cutoff)
    problem, reference, labels = build_request(limited, shape, goal, stood)
    learnt = as_recorded(problem, recorded)
    score = trajectories.score_motion(problem, motion)
    floor = floor_of(problem, score.value, scored.seed) if scored.bound else None
    judged = JudgedMotion(f"Motion of {data}", score, motion, learnt, reference, labels, floor=floor, source=data)
    files.give(design_report(judged), lambda: design_document(judged), {})
    view.write_view(lambda: views.view_of(problem.robot, motion, problem=problem))


def _logged_motion(
    path: str, robot: model.Robot, log_map: str | None, cutoff: float | None
) -> tuple[model.Motion, Measurement, list[Array]]:
    """The motion of a file: as planned where it has accelerations, else filtered like a recording; and filtered.

    Planned samples are joined by quintics, so that limits count between them too. Last: poses that were recorded.
    """
    measured_too = True
    if log_map:  # of currents the motion counts alone, whatever the gains
        mapped = read_log_map(log_map)
        currents = logs.named(path, robot, mapped).holds_currents_only
        recording = read_recording(path, robot, (1.0,) * robot.n if currents else None, mapped)
    else:
        t, q, qd, qdd = logs.read_trajectory(path, robot)
        if qd is not None and qdd is not None:
            if cutoff is not None:
                raise InputError(f"{path}: has accelerations, so it is not filtered: omit --cutoff")
            motion = trajectories.joined(model.Motion(t, q, qd, qdd), _PLANNED_RATE)
            return motion, planned(robot, motion, path), []
        measured_too = any(map(logs.named(path, robot, None).holds, ("torque", "current")))
        recording = model.Recording(t, q, 0.0 * q, qd, path)
    processing = robot.processing if cutoff is None else replace(robot.processing, cutoff=cutoff)
    measured = estimation.measurement(recording, processing)
    return measured.motion, measured, [measured.motion.q] * measured_too
