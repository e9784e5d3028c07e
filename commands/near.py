"""``dynident near``: a short motion about a pose, for ``dynident weigh``."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from .. import model, report, trajectories
from ..common.arrays import Array
from ..common.errors import InputError
from ..common.files import write_text
from . import ANSWERED
from .motion_pages import FIGURE_RATE
from .motion_search import best_motion
from .options import (
    LimitOptions,
    MotionFiles,
    NoiseOptions,
    Options,
    RehearsedRobotOptions,
    ViewOptions,
    add_command,
    in_si,
    option,
)
from .options.goals import RATE
from .options.limits import Known
from .options.reading import about
from .progress import note
from .values import gains_list, joint_list, positive, positive_number, whole

_NOISE = 0.007
"""Of the torque limit: standard deviation of a torque sample where none is given; real arms have 0.5 to 0.9 %."""
_NOISE_RATE, _PAPER_RATE = 10.0, 250.0  # Hz
_DURATION, _RANGE, _MASS = 30.0, 30.0, 3.0  # s, deg, kg
_REHEARSAL = 0.1  # of the speed
_RUN_RATE, _SLOW_RATE = 500.0, 50.0  # Hz: at which a whole run, and its rehearsal, are looked at
_ROUNDING = 1e-9  # of a limit
_BETWEEN = 0.02  # of a torque limit: what a search may miss between its samples


@dataclass(frozen=True)
class _Near(Options):
    """Where the robot stands, which joints move how far and how long, and what is known of the payload."""

    GROUP = "motion"

    pose: tuple[float, ...] = option(
        type=gains_list,
        required=True,
        metavar="Q1,Q2,..",
        help="where it stands [deg or m]; =-90,.. with minus",
    )
    second_pose: str | None = option(
        metavar="auto|Q1,Q2,..",
        help="do it again at another wrist pose, outside the range: one that helps, or this one",
    )
    joints: tuple[int, ...] = option(
        type=joint_list, required=True, metavar="J1,J2,..", help="joints that move, such as 2,3,5,6"
    )
    range: tuple[float, ...] | None = option(
        type=gains_list, metavar="R|R1,R2,..", help=f"to either side [deg or m] (default: {_RANGE:g})"
    )
    duration: float = option(type=positive_number, default=_DURATION, metavar="S", help=f"default: {_DURATION:g}")
    mass: float | None = option(group="payload", type=positive_number, metavar="KG", help="the payload was weighed")
    mass_sigma: float | None = option(
        group="payload", type=positive_number, metavar="KG", help="standard deviation of the scale"
    )
    expected_mass: float | None = option(
        group="payload",
        type=positive_number,
        metavar="KG",
        help=f"about its mass, not weighed (default: {_MASS:g})",
    )
    seed: int = option(group="search", type=whole, default=0, help="of the random starts (default: 0)")
    starts: int = option(group="search", type=positive, default=1, metavar="K", help="random starts (default: 1)")

    def check(self, robot: model.Robot) -> None:
        """Refuse what does not go together.

        Raises:
            InputError: one line.
        """
        if (self.mass is None) != (self.mass_sigma is None):
            raise InputError("--mass and --mass-sigma belong together: a scale errs too, by how much must be said")
        if self.mass is not None:
            self.refuse("expected_mass", "is for a payload that was not weighed: leave it out with --mass")
        if max(self.joints) > robot.n:
            raise InputError(
                f"--joints {max(self.joints)}: robot {robot.name!r} has {robot.n} joints: number them "
                f"from 1, at the base, to {robot.n}"
            )

    def ranges(self, robot: model.Robot) -> Array:
        """A range for each moving joint [rad or m]."""
        given, joints = self.range or (_RANGE,), self.joints
        if len(given) not in (1, len(joints)):
            raise InputError(
                f"--range has {len(given)} numbers for {len(joints)} joints: give one, or one for each"
            )
        turning = [robot.joints[joint - 1].revolute for joint in joints]
        if len(given) == 1 and not all(turning):
            raise InputError(
                "--range: give one number for each joint, in deg where it turns and in m where it slides"
            )
        each = given * len(joints) if len(given) == 1 else given
        return np.array([np.radians(x) if turns else x for x, turns in zip(each, turning, strict=True)])

    @property
    def expected(self) -> model.InertialParameters:
        """About what the payload is."""
        mass = self.mass or self.expected_mass or _MASS
        return model.InertialParameters.from_com(mass, [0.0, 0.0, 0.1], 0.003 * mass * np.eye(3))


@dataclass(frozen=True)
class _NearFiles(MotionFiles):
    """Formats of the motion, and the file of its rehearsal."""

    rehearsal: str | None = option(
        writes="file",
        metavar="F.csv",
        help="the same way once at a tenth of the speed (default: beside --samples)",
    )

    def write_all(self, result: report.NearResult, bounds: trajectories.JointBounds) -> None:
        """Write the motion, its rehearsal and the JSON."""
        robot, head = result.robot, report.near_head
        written = report.motions.WrittenMotion(robot, result.motion, bounds, head(result, 1.0))
        self.check_replays(result.design.problem, written)
        self.write(written)
        path = self.rehearsal
        if path is None and self.samples:
            beside = Path(self.samples)
            path = str(beside.with_name(f"{beside.stem}_rehearsal{beside.suffix}"))
        if path:
            slow = result.motion.slowed(_REHEARSAL)
            written = report.motions.WrittenMotion(robot, slow, bounds, head(result, _REHEARSAL))
            write_text(path, report.motions.csv_text(written, self.rate))
        if self.json:
            report.documents.write_json(
                self.json, report.documents.near_document(result.design, result.motion, *result[1:])
            )


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    add_command(
        commands, "near", run, RehearsedRobotOptions, _Near, NoiseOptions, LimitOptions, _NearFiles, ViewOptions
    )


def run(
    arm: RehearsedRobotOptions,
    options: _Near,
    noise: NoiseOptions,
    limits: LimitOptions,
    files: _NearFiles,
    view: ViewOptions,
) -> int:
    """Visibility first, then the design."""
    robot = arm.load()
    options.check(robot)
    if noise.torque_noise is None:
        noise.refuse("independent_rate", "has no effect without --torque-noise")
    files.check(robot, "rehearsal")
    view.check_view()
    known = limits.known(robot)
    robot, bounds = known.robot, limits.bounds(known.robot)
    goal = trajectories.NearGoal(*_noise(noise, robot, bounds), options.expected, options.mass_sigma)
    shape, hint = _shape(options, robot, goal, bounds, options.seed)
    visibility = shape.visibility(robot)
    try:
        trajectories.design.check_mass_visible(visibility, options.mass_sigma is not None, "near this pose")
    except InputError:
        files.show(report.Screen([report.visibility_table(visibility)]))
        raise
    limited, loads = _torques(known, bounds, limits, options.expected)
    scene = limits.read_scene()

    def within(share: float) -> trajectories.DesignProblem:
        lowered = replace(limited, torque=share * limited.torque)
        return trajectories.build_design(robot, shape, goal, bounds=lowered, loads=loads, scene=scene)

    trajectories.design.check_held(within(1.0), shape.poses)
    design = _kept(within, options.seed, options.starts)
    result = report.NearResult(design, shape, visibility, goal.predicted(robot, design.plan, shape.joints))
    hints = [report.second_pose_note(shape.poses[0], hint)] if hint is not None else []
    screen = report.near_screen(result, options.expected, hints)
    files.show(screen)
    files.write_all(result, bounds)
    samples = design.motion(FIGURE_RATE)
    files.write_page(lambda: report.near_page(result, samples, screen, files.provenance({}, limits, arm)))
    view.write_view(lambda: report.view.view_of(robot, samples, problem=design.problem))
    return ANSWERED


def _kept(within: Callable[[float], trajectories.DesignProblem], seed: int, starts: int) -> trajectories.Design:
    """A motion whose whole run keeps every limit.

    Between the samples of the search dry friction turns its sign: where the run misses a torque limit by what that
    takes, the search is made once more below it.

    Args:
        within: the problem with a share of the torque limits.
        seed, starts: of the search.

    Raises:
        InputError: if the run does not keep a limit; names it.
    """
    problem = within(1.0)
    design = best_motion(problem, seed, starts)
    missed = _missed(problem, design)
    if missed and all(limit.name.startswith("torque") and limit.relative < _BETWEEN for limit in missed):
        most = max(limit.relative for limit in missed)
        design = best_motion(within(1.0 - 1.5 * most), seed, starts)
        design = replace(design, problem=problem, score=design.score.judged_by(problem))
        missed = _missed(problem, design)
    if missed:
        raise InputError(
            f"the whole run, or its rehearsal, does not keep every limit ({missed[0]}): choose other poses"
        )
    return design


def _missed(
    problem: trajectories.DesignProblem, design: trajectories.Design
) -> list[trajectories.design.LimitCheck]:
    return [limit for limit in _whole_run(problem, design) if limit.relative > _ROUNDING]


def _whole_run(
    problem: trajectories.DesignProblem, design: trajectories.Design
) -> tuple[trajectories.design.LimitCheck, ...]:
    """Limits that count in the whole run, the ways between two poses included, and in its rehearsal."""
    assert isinstance(design.plan, trajectories.NearMotion)
    runs = design.plan.motion(_RUN_RATE), design.plan.slowed(_REHEARSAL).motion(_SLOW_RATE)
    return tuple(limit for run in runs for limit in trajectories.design.checks_of_run(problem, run))


def _shape(
    options: _Near,
    robot: model.Robot,
    goal: trajectories.NearGoal,
    bounds: trajectories.JointBounds,
    seed: int,
) -> tuple[trajectories.NearShape, Array | None]:
    """What is asked of the motion, and a second pose that would help where none was asked for."""
    ranges = options.ranges(robot)
    with about("--pose"):
        first = in_si(options.pose, robot)
        shape = trajectories.NearShape(first[None], options.joints, ranges, options.duration)
        shape.check(robot, bounds)
    if options.second_pose is None:
        visible = options.mass_sigma is not None or shape.visibility(robot).mass_visible
        return shape, trajectories.design.second_pose(robot, shape, goal, bounds, seed) if visible else None
    if options.second_pose == "auto":
        second = trajectories.design.second_pose(robot, shape, goal, bounds, seed)
        if second is None:
            note("no second pose would tell much more: there is one pose only")
            return shape, None
    else:
        try:
            second = in_si(gains_list(options.second_pose), robot)
        except argparse.ArgumentTypeError as error:
            raise InputError(f"--second-pose: {error}; or write auto") from None
    shape = replace(shape, poses=np.array([first, second]))
    shape.check(robot, bounds)
    return shape, None


def _noise(options: NoiseOptions, robot: model.Robot, bounds: trajectories.JointBounds) -> tuple[Array, float]:
    """Standard deviation of torque samples per joint [N·m or N], and how many are independent in a second."""
    noise = options.sigma(bounds)
    if noise is not None:
        if noise.shape != (robot.n,) or not (noise > 0.0).all():
            raise InputError(f"--torque-noise: robot {robot.name!r} needs {robot.n} positive numbers")
        return noise, options.independent_rate or RATE
    if robot.name == "rx90":
        note("no --torque-noise: that of the paper's RX90 is assumed")
        return np.array(trajectories.RX90_NOISE), _PAPER_RATE
    limits = np.array([joint.limits.torque for joint in robot.joints])
    if not np.isfinite(limits).all():
        raise InputError(
            f"robot {robot.name!r} has no torque limits from which a noise could be guessed: give "
            "--torque-noise, or --arm-mass KG for a stand-in"
        )
    note(f"no --torque-noise: {100 * _NOISE:g} % of the torque limits at {_NOISE_RATE:g} Hz assumed")
    return _NOISE * limits, _NOISE_RATE


def _torques(
    known: Known, bounds: trajectories.JointBounds, limits: LimitOptions, expected: model.InertialParameters
) -> tuple[trajectories.JointBounds, trajectories.Loads | None]:
    """Bounds that the motion keeps, and loads for torque limits; none where limits or parameters are unknown.

    Raises:
        InputError: if a payload was bounded that torque limits cannot be kept for.
    """
    robot, payload = known.robot, limits.payload(known.robot, bounds)
    if (known.values or robot.parameters) and np.isfinite(bounds.torque).any():
        return bounds, known.loads(payload or expected, limits.torque_margin)
    if payload is not None or limits.torque_margin is not None:
        option = "--heaviest-payload" if payload is not None else "--torque-margin"
        raise InputError(
            f"{option} counts in torque limits: give --torque-limits, and --robot-parameters or --arm-mass"
        )
    return replace(bounds, torque=np.full(robot.n, np.inf)), None
