"""``dynident near``: a short motion about a pose, for ``dynident weigh``."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np

from ... import model, trajectories
from ...common.arrays import Array
from ...common.errors import InputError
from ...common.files import write_text
from ...trajectories.motions.family import check_pose
from .. import view as views
from ..export import motions
from ..export.motion import WrittenMotion
from ..report.blocks import Report
from ..report.documents import FIGURE_RATE, NearResult, near_document
from ..report.sections.motion import near_head, near_report, second_pose_note, visibility_table
from . import values
from .entry import MOTION, SETTING, Options, about, command
from .motions import Limited, LimitOptions, MotionFiles, NoiseOptions, RehearsedRobotOptions, best_motion, in_si
from .options import ViewOptions
from .progress import note, status
from .values import NewFile, numbers, numbers_or, word

if TYPE_CHECKING:
    from .motions import PayloadBounds

_Pose = Annotated[tuple[float, ...] | str, word(partial(numbers_or, "auto"), "auto|Q1,Q2,..")]
_APPROACH, _SLIDE = 3.0, 0.02  # deg, m
_LEFT = 1.25  # of the mass expected: what runs of the ladder leave possible, and the motion bears at full speed


class NearOptions(Options, group=MOTION):
    """Pose, moving joints, ranges and time, and knowledge of the payload."""

    needs: ClassVar = dict.fromkeys(("poses", "hold", "approach"), ("static",))
    instead: ClassVar = dict.fromkeys(("second_pose", "duration", "ladder"), "static")

    pose: values.Positions
    """Pose of the arm [deg or m]."""
    second_pose: _Pose | None = None
    """Repeat the motion at another wrist pose outside the range: auto, or this pose."""
    joints: values.Joints
    """Joints that move, such as 2,3,5,6."""
    range: Annotated[tuple[float, ...], word(numbers, "R|R1,R2,..")] = (30.0,)
    """Range to either side [deg or m] (default: 30; with --static the joint limits)."""
    duration: values.Seconds = 30.0
    """Duration of the motion [s] (default: 30)."""
    static: bool = False
    """Plan poses to stand still in, each reached from both sides."""
    poses: values.Count = 8
    """Number of poses with --static, 6 to 12 (default: 8)."""
    hold: Annotated[values.Seconds, SETTING] = 1.5
    """Rest after each approach with --static [s] (default: 1.5)."""
    approach: Annotated[tuple[float, ...] | None, word(numbers, "R|R1,R2,.."), SETTING] = None
    """Small move towards each pose with --static [deg or m] (default: 3, or 0.02 m for a sliding joint)."""
    mass: values.Weighed = (3.0, None)
    """Expected mass (default: 3), or the mass from a scale with its standard deviation: 2.5+-0.01."""
    ladder: bool = False
    """Add slower runs first, which bound the payload; the motion allows 1.25 times the expected mass."""
    seed: values.Seed = 0
    """Seed of the random starts (default: 0)."""
    starts: Annotated[values.Count | None, SETTING] = None
    """Random starts of the search (default: 1, with --static 6)."""

    def bounded_by(self, payload: PayloadBounds | None) -> NearOptions:
        """These options with an expected mass no heavier than every payload within bounds."""
        if not isinstance(payload, trajectories.PayloadSet) or self.mass[0] <= payload.mass:
            return self
        if not (self.ladder or self.has("mass")):
            return replace(self, mass=(payload.mass, None))
        raise InputError(
            f"{self.mass[0]:g} kg are expected and --heaviest-payload allows {payload.mass:g}: give another "
            "--mass, or a heavier payload"
        )

    def each(self, robot: model.Robot, option: str, given: tuple[float, ...]) -> Array:
        """Numbers of an option for each moving joint [rad or m], where one may stand for all."""
        shown = self.shown(option)
        if max(self.joints) > robot.n:
            raise InputError(
                f"--joints {max(self.joints)}: robot {robot.name!r} has {robot.n} joints: number them from 1, at "
                f"the base, to {robot.n}"
            )
        turning = [robot.joints[joint - 1].revolute for joint in self.joints]
        if len(given) == 1 and not all(turning):
            raise InputError(
                f"{shown}: give one number for each joint, in deg where it turns and in m where it slides"
            )
        each = values.each_joint(given, len(turning), shown)
        return np.array([np.radians(x) if turns else x for x, turns in zip(each, turning, strict=True)])

    @property
    def expected(self) -> model.InertialParameters:
        """About what the payload is."""
        return model.InertialParameters.from_com(self.mass[0], [0.0, 0.0, 0.1], 0.003 * self.mass[0] * np.eye(3))


class NearFiles(MotionFiles):
    """Formats of the motion, and the file of its rehearsal."""

    needs: ClassVar = {**MotionFiles.needs, "sample_rate": ("samples", "ros2", "rehearsal")}

    rehearsal: Annotated[NewFile | None, SETTING] = None
    """File of the motion at a tenth of the speed; F_1.csv, .. with --ladder (default: beside --samples)."""

    def write_rehearsals(self, result: NearResult, written: WrittenMotion) -> None:
        """Write slower runs of the motion: the rehearsal, or those of the ladder."""
        motion = result.design.plan
        if not (self.rehearsal or self.samples) or not isinstance(motion, trajectories.Fourier):
            return
        beside = Path(self.samples or "none")
        path = Path(self.rehearsal or beside.with_name(f"{beside.stem}_rehearsal{beside.suffix}"))
        speeds = {path: trajectories.REHEARSAL}
        if result.ladder:
            rungs = enumerate((rung.speed for rung in result.ladder if rung.speed < 1.0), 1)
            speeds = {path.with_name(f"{path.stem}_{k}{path.suffix}"): speed for k, speed in rungs}
        for name, speed in speeds.items():
            head = near_head(result, speed)
            slow = replace(written, plan=motion.slowed(speed), head=head, rate=self.sample_rate)
            write_text(name, motions.FORMATS["csv"].text(slow))


@command
def run(
    *,
    arm: RehearsedRobotOptions,
    options: NearOptions,
    noise: NoiseOptions,
    limits: LimitOptions,
    files: NearFiles,
    view: ViewOptions,
) -> None:
    """Visibility first, then the design."""
    robot = arm.load()
    files.check_robot(robot, options.static)
    limited = limits.of(robot)
    robot, bounds, payload = limited.robot, limited.bounds, limited.loads.heaviest
    options = options.bounded_by(payload)
    knowledge, hint = (options.expected, options.mass[1]), None
    if options.static:
        files.refuse("rehearsal", "has no effect with --static: run it at a low speed override first")
        if noise.torque_noise is not None and noise.torque_noise[1] is not None:
            raise InputError("--torque-noise: at rest each approach is one sample: omit @HZ")
        sigma, _, source = noise.noise(robot, bounds, trajectories.ASSUMED_STICTION)
        goal = trajectories.NearGoal(sigma, 1.0 / options.hold, *knowledge, source)
        shape: trajectories.NearShape | trajectories.StaticShape = _static_shape(options, robot, bounds)
    else:
        sigma, rate, source = noise.noise(robot, bounds)
        goal = trajectories.NearGoal(sigma, rate, *knowledge, source)
        shape, hint = _shape(options, robot, goal, bounds)
    visibility = shape.visibility(robot)
    try:
        trajectories.check_mass_visible(visibility, options.mass[1] is not None, "near this pose")
    except InputError:  # what joints show is printed all the same
        files.show(Report("", [visibility_table(visibility)]))
        raise
    loads = _loads(limited, options)
    if loads is None:  # torques cannot be computed
        limited = limited._replace(bounds=replace(bounds, torque=np.full(robot.n, np.inf)))
    problem = limited.problem(shape, goal, loads)
    trajectories.check_held(problem, shape.poses)
    design = best_motion(problem, options.seed, options.starts or (None if options.static else 1))
    samples = design.motion(FIGURE_RATE)
    if options.static:  # the search looks at poses on the way, not at the motion through them
        run = trajectories.score_motion(problem, samples)
        design = replace(design, score=replace(design.score, limits=run.limits, samples=run.samples))
    ladder: tuple[trajectories.Rung, ...] = ()
    if options.ladder:
        assert isinstance(design.plan, trajectories.Fourier)
        assert isinstance(payload, trajectories.PayloadSet)
        with status("looking for the speeds of the ladder"):
            ladder = trajectories.speed_ladder(
                lambda payloads: limited.problem(shape, goal, replace(limited.loads, heaviest=payloads)),
                payload,
                design.plan,
                options.mass[0],
                lambda run: goal.predicted(robot, run, options.joints).mass,
            )
    result = NearResult(design, shape, visibility, goal.predicted(robot, design.plan, shape.joints), ladder)
    hints = [second_pose_note(result.poses[0], hint)] if hint is not None else []
    written = WrittenMotion(robot, design.plan, bounds, near_head(result, 1.0))
    files.check_replays(limits.whole(design.problem), written, "val3")
    shown = near_report(result, options.expected, hints, samples)
    files.give(shown, lambda: near_document(result), {})
    files.write(written)
    files.write_rehearsals(result, written)
    view.write_view(lambda: views.view_of(robot, samples, problem=design.problem))


def _shape(
    options: NearOptions, robot: model.Robot, goal: trajectories.NearGoal, bounds: trajectories.JointBounds
) -> tuple[trajectories.NearShape, Array | None]:
    """Shape of the motion, and a second pose that would help where none was asked for."""
    ranges = options.each(robot, "range", options.range)
    with about("--pose"):
        first = in_si(options.pose, robot)
        shape = trajectories.NearShape(first[None], options.joints, ranges, options.duration)
        shape.check(robot, bounds)
    if options.second_pose is None:
        visible = options.mass[1] is not None or shape.visibility(robot).mass_visible
        return shape, trajectories.second_pose(robot, shape, goal, bounds, options.seed) if visible else None
    if isinstance(options.second_pose, str):
        second = trajectories.second_pose(robot, shape, goal, bounds, options.seed)
        if second is None:
            note("a second pose would hardly help: only one is used")
            return shape, None
    else:
        second = in_si(options.second_pose, robot)
    shape = replace(shape, poses=np.array([first, second]))
    shape.check(robot, bounds)
    return shape, None


def _static_shape(
    options: NearOptions, robot: model.Robot, bounds: trajectories.JointBounds
) -> trajectories.StaticShape:
    """Shape of a motion from rest to rest: within the range about the pose, or as far as the joints go."""
    joints, moving = options.joints, [joint - 1 for joint in options.joints]
    usual = (_SLIDE if joint <= robot.n and not robot.joints[joint - 1].revolute else _APPROACH for joint in joints)
    approach = options.each(robot, "approach", options.approach or tuple(usual))
    with about("--pose"):
        pose = in_si(options.pose, robot)
        check_pose(pose, robot, bounds)
    low, high = bounds.low[moving], bounds.high[moving]
    if options.has("range"):
        ranges = options.each(robot, "range", options.range)
        low, high = np.maximum(low, pose[moving] - ranges), np.minimum(high, pose[moving] + ranges)
    return trajectories.StaticShape(pose, joints, low, high, approach, options.poses, options.hold)


def _loads(limited: Limited, options: NearOptions) -> trajectories.Loads | None:
    """Loads for torque limits; None where limits or parameters are not known."""
    payload = limited.loads.heaviest
    if options.ladder:
        if not isinstance(payload, trajectories.PayloadSet):
            raise InputError("--ladder needs --heaviest-payload and --within: what the first run must bear")
        payload = payload.lighter(_LEFT * options.mass[0])
    if limited.loads.parameters and limited.has_torque_limits:
        return replace(limited.loads, heaviest=payload or options.expected)
    if payload is not None or limited.loads.margin > 0.0:
        option = "--heaviest-payload" if payload is not None else "torque-margin"
        raise InputError(f"{option} needs --torque-limits, and --robot-parameters or --arm-mass")
    return None
