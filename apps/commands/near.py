"""``dynident near``: a short motion about a pose, for ``dynident weigh``."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ... import model, trajectories
from ...common.arrays import Array
from ...common.errors import InputError
from .. import report
from .. import view as views
from . import ANSWERED
from .motion_pages import FIGURE_RATE
from .motion_search import best_motion
from .near_options import NearFiles, NearOptions
from .options import LimitOptions, NoiseOptions, RehearsedRobotOptions, ViewOptions, in_si
from .options.goals import RATE
from .options.limits import Known
from .options.reading import about
from .progress import note, status
from .values import gains_list

if TYPE_CHECKING:
    from ...model.visibility import PayloadVisibility

_NOISE = 0.007
"""Of the torque limit: standard deviation of a torque sample where none is given; real arms have 0.5 to 0.9 %."""
_NOISE_RATE, _PAPER_RATE = 10.0, 250.0  # Hz
_LEFT = 1.25  # of the mass expected: what runs of the ladder leave possible, and the motion bears at full speed


def run(
    arm: RehearsedRobotOptions,
    options: NearOptions,
    noise: NoiseOptions,
    limits: LimitOptions,
    files: NearFiles,
    view: ViewOptions,
) -> int:
    """Visibility first, then the design."""
    robot = arm.load()
    options.check(robot)
    files.check(robot, "rehearsal")
    view.check_view()
    known = limits.known(robot)
    robot, bounds = known.robot, limits.bounds(known.robot)
    payload = limits.payload(robot, bounds)
    options = options.bounded_by(payload)
    goal = trajectories.NearGoal(*_noise(noise, robot, bounds), options.expected, options.mass_sigma)
    shape, hint = _shape(options, robot, goal, bounds, options.seed)
    visibility = _checked(shape.visibility(robot), options, files)
    limited, loads = _torques(known, bounds, limits, options, payload)
    scene = limits.read_scene()
    problem = trajectories.build_design(robot, shape, goal, bounds=limited, loads=loads, scene=scene)
    trajectories.check_held(problem, shape.poses)
    design = best_motion(problem, options.seed, options.starts)

    def bearing(payloads: trajectories.PayloadSet) -> trajectories.DesignProblem:
        heavier = known.loads(payloads, limits.torque_margin)
        return trajectories.build_design(robot, shape, goal, bounds=limited, loads=heavier, scene=scene)

    ladder = _ladder(options, payload, design, goal, bearing)
    result = report.NearResult(design, shape, visibility, goal.predicted(robot, design.plan, shape.joints), ladder)
    hints = [report.second_pose_note(shape.poses[0], hint)] if hint is not None else []
    screen = report.near_screen(result, options.expected, hints)
    written = files.written(result, limits.whole(design.problem), bounds)
    files.show(screen)
    files.write_all(result, written)
    samples = design.motion(FIGURE_RATE)
    files.write_page(lambda: report.near_page(result, samples, screen, files.provenance({}, limits, arm)))
    view.write_view(lambda: views.view_of(robot, samples, problem=design.problem))
    return ANSWERED


def _checked(visibility: PayloadVisibility, options: NearOptions, files: NearFiles) -> PayloadVisibility:
    """What joints show; refused, and what they show printed, where the mass is not in it."""
    try:
        trajectories.check_mass_visible(visibility, options.mass_sigma is not None, "near this pose")
    except InputError:
        files.show(report.Screen([report.visibility_table(visibility)]))
        raise
    return visibility


def _ladder(
    options: NearOptions,
    payloads: model.InertialParameters | trajectories.PayloadSet | None,
    design: trajectories.Design,
    goal: trajectories.NearGoal,
    bearing: Callable[[trajectories.PayloadSet], trajectories.DesignProblem],
) -> tuple[trajectories.Rung, ...]:
    """Runs before the one at full speed where a ladder was asked for."""
    plan, robot = design.plan, design.problem.robot
    if not options.ladder:
        return ()
    assert isinstance(plan, trajectories.NearMotion)
    assert isinstance(payloads, trajectories.PayloadSet)
    with status("looking for the speeds of the ladder"):
        return trajectories.speed_ladder(
            bearing,
            payloads,
            plan,
            options.expected.mass,
            lambda run: goal.predicted(robot, run, options.joints).mass,
        )


def _shape(
    options: NearOptions,
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
        return shape, trajectories.second_pose(robot, shape, goal, bounds, seed) if visible else None
    if options.second_pose == "auto":
        second = trajectories.second_pose(robot, shape, goal, bounds, seed)
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
    if options.torque_noise is None:
        options.refuse("independent_rate", "has no effect without --torque-noise")
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
    known: Known,
    bounds: trajectories.JointBounds,
    limits: LimitOptions,
    options: NearOptions,
    payload: model.InertialParameters | trajectories.PayloadSet | None,
) -> tuple[trajectories.JointBounds, trajectories.Loads | None]:
    """Bounds that the motion keeps, and loads for torque limits; none where limits or parameters are unknown.

    Raises:
        InputError: if a payload was bounded that torque limits cannot be kept for.
    """
    robot, expected = known.robot, options.expected
    if options.ladder:
        if not isinstance(payload, trajectories.PayloadSet):
            raise InputError("--ladder needs --heaviest-payload and --within: what the first run must bear")
        payload = payload.lighter(_LEFT * expected.mass)
    if (known.values or robot.parameters) and np.isfinite(bounds.torque).any():
        return bounds, known.loads(payload or expected, limits.torque_margin)
    if payload is not None or limits.torque_margin is not None:
        option = "--heaviest-payload" if payload is not None else "--torque-margin"
        raise InputError(
            f"{option} counts in torque limits: give --torque-limits, and --robot-parameters or --arm-mass"
        )
    return replace(bounds, torque=np.full(robot.n, np.inf)), None
