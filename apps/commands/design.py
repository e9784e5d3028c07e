"""``dynident design``, ``near`` and ``score``: motions that teach most, and what a motion teaches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from cyclopts import Parameter

from ... import estimation, model, trajectories
from ...common.arrays import Array
from ...common.errors import InputError
from ...common.files import write_text
from ...model.motion import Measurement
from ...trajectories.motions.family import check_pose
from .. import logs, results, view
from ..export.motions import FORMATS, WrittenMotion, design_head, val3_replay
from ..report import documents
from ..report.blocks import Report
from ..report.sections import motion as sections
from . import values
from .entry import GOAL, MOTION, SEARCH, SETTING, about, note, shown, status
from .motions import LimitOptions, MotionFiles
from .options import in_si
from .values import Count, NewFile, Positions, Reads, Seconds, Seed, number, numbers, positive_number, whole, word

_REPLAY_RATE = 500.0  # Hz
_PLANNED_RATE = 250.0  # Hz: at which a planned motion is looked at, at least
_ZERO = 1e-9  # SI units: what standard parameters leave where they cancel

_APPROACH, _SLIDE = 3.0, 0.02  # deg, m
_LEFT = 1.25  # of the mass expected: what runs of the ladder leave possible, and the motion bears at full speed


class _Learning(LimitOptions, group=GOAL):
    criterion: Annotated[Literal["d", "a", "cond", "cond-scaled"], Parameter(show_choices=False)] = "d"
    """d: information (default); a: relative sigma; cond: condition number; cond-scaled: columns scaled."""
    columns: Annotated[tuple[str, ...] | None, word(values.names_list, "NAME,..|payload")] = None
    """Parameters to be identified: the robot's (base, default), or the payload's ten with a known robot."""
    parameters: Annotated[values.Names | None, SETTING] = None
    """Parameters that count in criteria d and a (default: all)."""
    data_from: tuple[Annotated[str, Reads("earlier data"), Parameter(metavar="F")], ...] = ()
    """Earlier data: --npz of identify or payload, or --json of identify (d and a); repeatable."""
    data_length: Annotated[Seconds | None, SETTING] = None
    """Length of the planned recording [s]."""
    bound: Annotated[bool, SETTING] = False
    """Estimate the best value that any motion could reach, and the gap to it."""

    def request(
        self, shape: trajectories.ViaPointShape | trajectories.FourierShape, stood: Sequence[Array] = ()
    ) -> tuple[trajectories.DesignProblem, dict[str, Any]]:
        """The problem, and what a ``JudgedMotion`` says of its parameters; ``stood``: poses of the arm seen."""
        robot, bounds, loads = self.limited
        payload, base, labels = loads.heaviest, model.base_parameters(robot), dict[str, str]()
        payload_only, identified = self.columns == ("payload",), loads.covariance is not None
        known = dict(loads.parameters) if identified else {}
        if payload_only:  # relative to the heaviest payload's parameters; a set has none
            known = payload.named(str(robot.n)) if isinstance(payload, model.InertialParameters) else {}
        else:
            labels = dict(zip(base.columns, base.names, strict=True))
            if not known and all(name in robot.parameters for name in base.standard):
                known = dict(zip(base.columns, base.value(robot.parameters).tolist(), strict=True))
        reference = {name: value for name, value in known.items() if abs(value) > _ZERO}
        any_limit = bool(np.isfinite(bounds.torque).any())
        if not any_limit and payload is not None and not payload_only:
            raise InputError("--heaviest-payload counts in torque limits: give --torque-limits")
        counting = any_limit and (identified or payload is not None or loads.margin > 0.0)
        length = self.data_length
        if self.data_from and length is None:
            length = shape.duration if isinstance(shape, trajectories.FourierShape) else shape.longest
            if isinstance(shape, trajectories.ViaPointShape) and shape.fixed is not None:
                length = float(np.broadcast_to(shape.fixed, shape.count - 1).sum())
            if length is None:
                raise InputError("--data-from needs data-length, a setting: how long will be recorded next?")
        sigma, rate, words = self.noise(earlier=next(iter(self.data_from), None))
        noise = sigma if self.criterion in ("d", "a") else None
        ten = model.regressors.payload_columns(robot) if payload_only else ()
        goal = trajectories.Goal(
            self.criterion,
            columns=None if payload_only else self.columns,
            payload_only=payload_only,
            interest=self.parameters,
            reference=reference if self.criterion == "a" else None,
            noise=sigma,
            rate=rate,
            noise_from=words,
            data_length=length,
            earlier=results.read_earlier(self.data_from, noise, ten) if self.data_from else None,
        )
        problem = self.problem(shape, goal, loads if counting else None, stood)
        return problem, {"reference": reference, "labels": labels}

    def judge(self, judged: documents.JudgedMotion, seed: int, write: Callable[[], None] = lambda: None) -> None:
        """Show a motion, with the floor under its criterion if asked for, ``write`` its files and its view."""
        problem = judged.score.problem
        if self.bound:
            try:
                with status("estimating the floor"):
                    floor = trajectories.floor_under(problem, judged.score.value, seed=seed)
                judged = judged._replace(floor=floor)
            except KeyboardInterrupt:  # it costs no motion
                note("interrupted: the floor is not known")
        write()
        self.give(sections.design_report(judged), lambda: documents.design_document(judged), {})
        self.write_view(lambda: view.view_of(problem.robot, judged.motion, problem=problem))


class _Design(MotionFiles, _Learning, group=MOTION):
    rules: ClassVar = {"ramp": {"segments": ("trapezoid",)}, "via_points": "fourier"}

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
    starts: Annotated[Count | None, Parameter(metavar="K", group=SEARCH)] = None
    """Random starts (default: 6 by d and a, else 3)."""

    def __call__(self) -> None:
        (robot, bounds, _), start = self.limited, None
        self.check_formats(robot, not self.fourier)
        if self.start:
            with about("--start"):
                pose = in_si(self.start, robot)
                check_pose(pose, robot, bounds)
            start = tuple(pose.tolist())
        times, trapezoid = self.segment_durations, self.segments == "trapezoid"
        segment = trajectories.Trapezoid(self.ramp) if trapezoid else trajectories.Quintic()
        shape: trajectories.ViaPointShape | trajectories.FourierShape = trajectories.ViaPointShape(
            self.via_points,
            passing=segment.passes and not self.rest,
            fixed=times[0] if times is not None and len(times) == 1 else times,
            segment=segment,
            longest=self.max_duration,
            start=start,
        )
        if self.fourier is not None:
            shape = trajectories.FourierShape(self.fourier, self.duration, start=start)
        problem, named = self.request(shape)
        design = self.best_motion(problem, self.starts, problem.criterion.kind)
        judged = documents.JudgedMotion.of(design)._replace(**named)
        written = WrittenMotion(problem.robot, design.plan, problem.bounds, design_head(design, judged.learnt))
        if self.val3:  # what a controller would make of the via points if its profiles are trapezoidal
            profile = val3_replay(self.asked(written)["val3"][1]).motion(_REPLAY_RATE)
            judged = judged._replace(replay=trajectories.score_motion(problem, profile))
        estimated = () if problem.payloads is not None else ("val3",)
        self.check_replays(problem, written, *estimated)
        self.judge(judged, self.seed, partial(self.write_motion, written))

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


class _Score(_Learning, group=MOTION):
    rules: ClassVar = {"seed": ("bound",)}

    data: Annotated[str, Reads("motion"), Parameter(metavar="LOG")] = field(kw_only=False)
    """A log, or a CSV of t, q and perhaps qd, qdd."""
    log_map: values.LogMapFile | None = None
    """Columns, units and signs of the log."""
    cutoff: Annotated[float | None, word(positive_number, "HZ")] = None
    """Cut-off frequency of the low-pass filter on positions."""
    max_duration: Seconds | None = None
    """Longest duration."""
    seed: Annotated[Seed, SETTING] = 0
    """Seed of the random states of bound (default: 0)."""

    def __call__(self) -> None:
        shape = trajectories.ViaPointShape(longest=self.max_duration)
        motion, recorded, stood = self.logged()
        problem, named = self.request(shape, stood)
        score, learnt = trajectories.score_motion(problem, motion), documents.as_recorded(problem, recorded)
        judged = documents.JudgedMotion(f"Motion of {self.data}", score, motion, learnt, **named, source=self.data)
        self.judge(judged, self.seed)

    def logged(self) -> tuple[model.Motion, Measurement, list[Array]]:
        """The motion of the file, planned where it has accelerations; as a recording shows it; poses recorded."""
        (robot, _, _), path, cutoff, measured_too = self.limited, self.data, self.cutoff, True
        if self.log_map:  # of currents the motion counts alone, whatever the gains
            mapped = logs.read_log_map(self.log_map)
            currents = logs.named(path, robot, mapped).holds_currents_only
            recording = logs.read_recording(path, robot, (1.0,) * robot.n if currents else None, mapped)
        else:
            t, q, qd, qdd = logs.read_trajectory(path, robot)
            if qd is not None and qdd is not None:
                if cutoff is not None:
                    raise InputError(f"{path}: has accelerations, so it is not filtered: omit --cutoff")
                motion = trajectories.joined(model.Motion(t, q, qd, qdd), _PLANNED_RATE)
                return motion, documents.planned(robot, motion, path), []
            measured_too = any(map(logs.named(path, robot, None).holds, ("torque", "current")))
            recording = model.Recording(t, q, 0.0 * q, qd, path)
        processing = robot.processing if cutoff is None else replace(robot.processing, cutoff=cutoff)
        measured = estimation.measurement(recording, processing)
        return measured.motion, measured, [measured.motion.q] * measured_too


class _Near(MotionFiles, group=MOTION):
    rules: ClassVar = {
        **dict.fromkeys(("poses", "hold", "approach"), ("static",)),
        **dict.fromkeys(("second_pose", "duration", "ladder"), "static"),
        "sample_rate": ("samples", "ros2", "rehearsal"),
    }

    pose: Positions
    """Pose of the arm [deg or m]."""
    second_pose: Annotated[tuple[float, ...] | str | None, values.numbers_or("auto", "auto|Q1,Q2,..")] = None
    """Repeat the motion at another wrist pose outside the range: auto, or this pose."""
    joints: values.Joints
    """Joints that move, such as 2,3,5,6."""
    range: Annotated[tuple[float, ...], word(numbers, "R|R1,R2,..")] = (30.0,)
    """Range to either side [deg or m] (default: 30; with --static the joint limits)."""
    duration: Seconds = 30.0
    """Duration of the motion [s] (default: 30)."""
    static: bool = False
    """Plan poses to stand still in, each reached from both sides."""
    poses: Count = 8
    """Number of poses with --static, 6 to 12 (default: 8)."""
    hold: Annotated[Seconds, SETTING] = 1.5
    """Rest after each approach with --static [s] (default: 1.5)."""
    approach: Annotated[tuple[float, ...] | None, word(numbers, "R|R1,R2,.."), SETTING] = None
    """Small move towards each pose with --static [deg or m] (default: 3, or 0.02 m for a sliding joint)."""
    mass: values.Weighed = (3.0, None)
    """Expected mass (default: 3), or the mass from a scale with its standard deviation: 2.5+-0.01."""
    ladder: bool = False
    """Add slower runs first, which bound the payload; the motion allows 1.25 times the expected mass."""
    starts: Annotated[Count | None, SETTING] = None
    """Random starts of the search (default: 1, with --static 6)."""
    rehearsal: Annotated[NewFile | None, SETTING] = None
    """File of the motion at a tenth of the speed; F_1.csv, .. with --ladder (default: beside --samples)."""

    def __call__(self) -> None:
        robot, bounds, known = self.limited
        self.check_formats(robot, self.static)
        payload = known.heaviest
        mass, scale = self.mass
        if isinstance(payload, trajectories.PayloadSet) and mass > payload.mass:
            if self.ladder or self.has("mass"):
                fault = f"{mass:g} kg are expected and --heaviest-payload allows {payload.mass:g}"
                raise InputError(f"{fault}: give another --mass, or a heavier payload")
            mass = payload.mass
        expected = model.InertialParameters.from_com(mass, [0.0, 0.0, 0.1], 0.003 * mass * np.eye(3))
        if self.static:
            self.refuse("rehearsal", "has no effect with --static: run it at a low speed override first")
        shape, goal, hint = self.shape(expected)
        visibility = shape.visibility(robot)
        try:
            trajectories.check_mass_visible(visibility, scale is not None, "near this pose")
        except InputError:  # what joints show is printed all the same
            self.show(Report("", [sections.visibility_table(visibility)]))
            raise
        borne = payload if self.ladder and isinstance(payload, trajectories.PayloadSet) else None
        if self.ladder and borne is None:
            raise InputError("--ladder needs --heaviest-payload and --within: what the first run must bear")
        heaviest, loads = payload if borne is None else borne.lighter(_LEFT * mass), None
        if known.parameters and np.isfinite(bounds.torque).any():
            loads = replace(known, heaviest=heaviest or expected)
        elif payload is not None or known.margin > 0.0:
            option = "--heaviest-payload" if payload is not None else "torque-margin"
            raise InputError(f"{option} needs --torque-limits, and --robot-parameters or --arm-mass")
        problem = self.problem(shape, goal, loads)
        trajectories.check_held(problem, shape.poses)
        design = self.best_motion(problem, self.starts or (None if self.static else 1))
        samples = design.motion(documents.FIGURE_RATE)
        if self.static:  # the search looks at poses on the way, not at the motion through them
            run = trajectories.score_motion(problem, samples)
            design = replace(design, score=replace(design.score, limits=run.limits, samples=run.samples))
        ladder: tuple[trajectories.Rung, ...] = ()
        if borne is not None and isinstance(design.plan, trajectories.Fourier):
            with status("looking for the speeds of the ladder"):
                ladder = trajectories.speed_ladder(
                    lambda payloads: self.problem(shape, goal, replace(known, heaviest=payloads)),
                    borne,
                    design.plan,
                    mass,
                    lambda run: goal.predicted(robot, run, self.joints).mass,
                )
        predicted = goal.predicted(robot, design.plan, shape.joints)
        result = documents.NearResult(design, shape, visibility, predicted, ladder)
        hints = list[str]()
        if hint is not None:
            turns = enumerate(np.degrees(hint - result.poses[0]), 1)
            joints = " and ".join(f"joint {j} by {turn:+.0f} deg" for j, turn in turns if abs(turn) > 1.0)
            text = f"A second wrist pose ({joints}) would improve this: add --second-pose auto"
            hints.append(f"{text} if the robot may go there.")
        written = WrittenMotion(robot, design.plan, bounds, sections.near_head(result, 1.0))
        self.check_replays(design.problem, written, "val3")
        report = sections.near_report(result, expected, hints, samples)
        self.give(report, lambda: documents.near_document(result), {})
        self.write_motion(written)
        if (self.rehearsal or self.samples) and isinstance(design.plan, trajectories.Fourier):
            beside = Path(self.samples or "none")
            path = Path(self.rehearsal or beside.with_name(f"{beside.stem}_rehearsal{beside.suffix}"))
            rungs = enumerate((rung.speed for rung in ladder if rung.speed < 1.0), 1)
            slower = {path.with_name(f"{path.stem}_{k}{path.suffix}"): speed for k, speed in rungs}
            for name, speed in slower.items() if ladder else [(path, trajectories.REHEARSAL)]:
                head, plan = sections.near_head(result, speed), design.plan.slowed(speed)
                slow = replace(written, plan=plan, head=head, rate=self.sample_rate)
                write_text(name, FORMATS["csv"].text(slow))
        self.write_view(lambda: view.view_of(robot, samples, problem=design.problem))

    def shape(
        self, expected: model.InertialParameters
    ) -> tuple[trajectories.NearShape | trajectories.StaticShape, trajectories.NearGoal, Array | None]:
        """Shape of the motion, its goal, and a second pose that would help where none was asked for."""
        (robot, bounds, _), joints, scale = self.limited, self.joints, self.mass[1]
        if self.static and self.torque_noise is not None and self.torque_noise[1] is not None:
            raise InputError("--torque-noise: at rest each approach is one sample: omit @HZ")
        sigma, rate, source = self.noise(trajectories.ASSUMED_STICTION if self.static else None)
        goal = trajectories.NearGoal(sigma, 1.0 / self.hold if self.static else rate, expected, scale, source)
        with about("--pose"):
            pose = in_si(self.pose, robot)
            check_pose(pose, robot, bounds)
        if self.static:  # within the range about the pose, or as far as the joints go
            moving = [joint - 1 for joint in joints]
            usual = (_SLIDE if j < robot.n and not robot.joints[j].revolute else _APPROACH for j in moving)
            approach = self.each("approach", self.approach or tuple(usual))
            low, high = bounds.low[moving], bounds.high[moving]
            if self.has("range"):
                ranges = self.each("range", self.range)
                low, high = np.maximum(low, pose[moving] - ranges), np.minimum(high, pose[moving] + ranges)
            return trajectories.StaticShape(pose, joints, low, high, approach, self.poses, self.hold), goal, None
        shape = trajectories.NearShape(pose[None], joints, self.each("range", self.range), self.duration)
        with about("--pose"):
            shape.check(robot, bounds)
        second = in_si(self.second_pose, robot) if isinstance(self.second_pose, tuple) else None
        if second is None and (self.second_pose or scale is not None or shape.visibility(robot).mass_visible):
            second = trajectories.second_pose(robot, shape, goal, bounds, self.seed)
        if self.second_pose is None:
            return shape, goal, second
        if second is None:
            note("a second pose would hardly help: only one is used")
            return shape, goal, None
        shape = replace(shape, poses=np.array([pose, second]))
        shape.check(robot, bounds)
        return shape, goal, None

    def each(self, option: str, given: tuple[float, ...]) -> Array:
        """Numbers of an option for each moving joint [rad or m], where one may stand for all."""
        robot, _, _ = self.limited
        if max(self.joints) > robot.n:
            fault = f"--joints {max(self.joints)}: robot {robot.name!r} has {robot.n} joints"
            raise InputError(f"{fault}: number them from 1, at the base, to {robot.n}")
        turning = [robot.joints[joint - 1].revolute for joint in self.joints]
        if len(given) == 1 and not all(turning):
            needed = "one number for each joint, in deg where it turns and in m where it slides"
            raise InputError(f"{shown(option)}: give {needed}")
        each = values.each_joint(given, len(turning), shown(option))
        return np.where(turning, np.radians(each), each)
