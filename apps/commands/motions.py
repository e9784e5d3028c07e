"""Options of motions: what they teach, through which noise, the limits they keep, their files; and their search."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np
from cyclopts import Parameter
from numpy.typing import NDArray

from ... import model, trajectories
from ...common.arrays import Array
from ...common.errors import InputError
from ...common.files import made_folder, write_text
from .. import results
from ..export import motions
from ..export.motions import CONTROLLER_RATE, WrittenMotion, check_joint_names, check_urscript, check_val3
from ..report.sections.motion import criterion_text
from . import values
from .entry import FILES, GENERAL, GOAL, LIMITS, SEARCH, SETTING, note, status
from .options import PageOptions, RobotOptions, ViewOptions, in_si
from .values import Names, NewFile, Reads, Seed, Share, checked, number, numbers, positive_number, share, word

_GOAL = Parameter(group=GOAL)
_REPLAY_RATE = 1000.0  # Hz: at which controllers' own curves are looked at, and at their turns


def _noise(text: str) -> tuple[float | tuple[float, ...] | None, float | None]:
    """Sigma of torques, a share of the limits ("10%") or a number per joint, and independent samples a second."""
    sigma, mark, rate = text.partition("@")
    checked(text, bool(sigma or mark), text, "a noise such as 10%, 1,2,3,4,5,6 or 10%@50")
    level = None if not sigma else share(sigma) if sigma.endswith("%") else numbers(sigma)
    return level, positive_number(rate) if mark else None


def _acceleration(text: str) -> float | tuple[float, ...]:
    """Times the speed limit per second, "3x" (a float); or a number per joint (a tuple)."""
    if not text.lower().endswith("x"):
        return numbers(text)
    try:
        factor = number(text[:-1])
    except ValueError:
        factor = -1.0
    return checked(factor, 0.0 < factor < 1e6, text, "a factor such as 3x")


def _region(text: str) -> tuple[tuple[float, ...], bool]:
    """Radius or three half axes [m], and whether they are half edges of a box."""
    half = numbers(text.removeprefix("box:"))
    good = len(half) in (1, 3) and min(half) > 0.0
    return checked(half, good, text, "R, A,B,C or box:A,B,C, each above 0 m"), text.startswith("box:")


_NOISE = word(_noise, "S|S1,S2,..[@HZ]")
_Level = float | tuple[float, ...]
_Rate = Annotated[float, word(positive_number, "HZ")]


class LimitOptions(ViewOptions, PageOptions, RobotOptions, group=LIMITS):
    """Limits of the joints, the robot's parameters for its torques, the scene; and the noise of a recording."""

    # A scene names its own floor.
    rules: ClassVar = {"within": ("heaviest_payload",), "no_floor": "scene", "like": "torque_noise"}

    arm_mass: Annotated[values.ArmMass | None, Parameter(group=GENERAL)] = None
    speed_override: Annotated[float, word(number, "SHARE")] = 1.0
    """Fraction of the speed limits to use (default: 1)."""
    acceleration: Annotated[_Level | None, word(_acceleration, "A|A1,A2,.."), SETTING] = None
    """Acceleration limits [deg/s² or m/s²], or 3x: three times the speed limit per second."""
    torque_limits: Annotated[tuple[float, ...] | str | None, values.numbers_or("none", "T|T1,T2,..")] = None
    """Torque limits [N·m or N], or none to ignore even those of the robot's file."""
    robot_parameters: values.RobotParametersFile | None = None
    """The --json file of 'dynident identify', for torques and relative sigma."""
    heaviest_payload: Annotated[str | None, Reads("heaviest payload"), Parameter(metavar="KG[@X,Y,Z]|TOML")] = None
    """Keep the torque limits without this payload and with it."""
    within: Annotated[tuple[tuple[float, ...], bool] | None, word(_region, "R|A,B,C|box:A,B,C")] = None
    """Keep them for every payload up to --heaviest-payload within this ball, ellipsoid or box [m]."""
    torque_margin: Annotated[Share, SETTING] = 0.0
    """Fraction of the torque limits to leave free, such as 10%."""
    scene: Annotated[str | None, Reads("scene"), Parameter(metavar="TOML"), SETTING] = None
    """File of floor, walls and bodies to keep clear of each other, instead of those assumed."""
    no_floor: bool = False
    """Ignore the floor at the height of the base (or the wall or ceiling it is mounted on)."""
    torque_noise: Annotated[tuple[_Level | None, float | None] | None, _NOISE, _GOAL] = None
    """Torque noise, 1 sigma per joint [N·m or N], or 10% of the limits; @HZ: independent samples a second
    (default: 10)."""
    like: Annotated[str | None, Reads("like"), Parameter(metavar="JSON"), _GOAL] = None
    """Take the torque noise from an earlier recording: the --json file of identify or payload."""

    def noise(
        self, assumed: tuple[float, str] | None = None, earlier: str | None = None
    ) -> tuple[Array, float, str]:
        """Sigma [N·m or N], independent samples a second, source: told, ``earlier``, or ``assumed`` over limits."""
        (robot, bounds, _), (level, rate) = self.limited, self.torque_noise or (None, None)
        like = earlier if self.like is None and self.torque_noise is None else self.like
        if like is not None:
            sigma, rate, source = *results.shown_noise(like), f"as {like} shows"
        elif level is None:
            ratio, source = assumed or (trajectories.ASSUMED_RATIO, trajectories.ASSUMED_NOISE)
            sigma = trajectories.assumed_noise(robot, ratio)
            if not np.isfinite(sigma).all():
                fault = f"robot {robot.name!r} has no torque limits to estimate a noise from"
                raise InputError(f"{fault}: give --torque-noise, or --arm-mass KG for a stand-in")
        elif isinstance(level, float):
            sigma, source = level * bounds.torque, f"as given, {100 * level:g} % of the torque limits"
            if not np.isfinite(sigma).all():
                raise InputError("--torque-noise in percent needs a torque limit of every joint: --torque-limits")
        else:
            sigma, source = np.array(values.each_joint(level, robot.n, "--torque-noise")), "as given"
        if sigma.shape != (robot.n,) or not (sigma > 0.0).all():
            option = "--torque-noise" if like is None else like
            raise InputError(f"{option}: robot {robot.name!r} needs {robot.n} positive numbers")
        return np.asarray(sigma), rate or trajectories.INDEPENDENT, source

    @cached_property
    def limited(self) -> tuple[model.Robot, trajectories.JointBounds, trajectories.Loads]:
        """The robot, its limits, and what torques are computed from, by ``--robot-parameters`` or a stand-in."""
        robot, covariance, acceleration = self.load(), None, None
        if self.robot_parameters:
            robot = model.stand_in.with_assumed_limits(robot)
            stored = results.read_stored_robot(self.robot_parameters)
            known = dict(zip(stored.estimate.names, stored.estimate.values.tolist(), strict=True))
            robot, covariance = stored.applied_to(robot), stored.estimate.covariance
        else:
            robot = model.stand_in.rehearsed(robot)
            known = dict(robot.parameters)
        if isinstance(self.acceleration, float):
            acceleration = [self.acceleration * joint.limits.speed for joint in robot.joints]
        elif self.acceleration is not None:
            acceleration = in_si(values.each_joint(self.acceleration, robot.n, "acceleration"), robot).tolist()
        torque = (math.inf,) if isinstance(self.torque_limits, str) else self.torque_limits
        torque = torque and values.each_joint(torque, robot.n, "--torque-limits")
        override = self.speed_override
        bounds = trajectories.JointBounds.of(robot, override=override, acceleration=acceleration, torque=torque)
        payload = self._payload(robot, np.isfinite(bounds.torque))
        if self.scene:  # a wrong one is refused before any work
            trajectories.read_scene(self.scene)
        return robot, bounds, trajectories.Loads(known, payload, covariance, self.torque_margin)

    def problem(
        self,
        shape: trajectories.Shape,
        goal: trajectories.Goal | trajectories.NearGoal,
        loads: trajectories.Loads | None,
        stood: Sequence[Array] = (),
    ) -> trajectories.DesignProblem:
        """The design of a motion within these limits; ``stood``: poses seen."""
        robot, bounds, _ = self.limited
        if loads is None and isinstance(goal, trajectories.NearGoal):  # torques cannot be computed
            bounds = replace(bounds, torque=np.full(robot.n, np.inf))
        poses = shape.poses if isinstance(shape, trajectories.NearShape) else shape.start
        # Unless a file tells: the arm itself, and with the floor what it is bolted to.
        there = np.vstack([np.reshape([] if poses is None else poses, (-1, robot.n)), *stood])
        usual = None if self.scene else trajectories.usual_scene(robot, there, not self.no_floor)
        scene = trajectories.read_scene(self.scene) if self.scene else usual
        return trajectories.build_design(robot, shape, goal, bounds=bounds, loads=loads, scene=scene)

    def _payload(
        self, robot: model.Robot, limited: NDArray[np.bool_]
    ) -> model.InertialParameters | trajectories.PayloadSet | None:
        """The heaviest payload, or every one up to it ``within``, in the last link's frame."""
        if not limited.any():
            self.refuse("torque_margin", "has no effect without torque limits: give --torque-limits")
        text, flange = self.heaviest_payload, robot.flange
        if text is None:
            return None
        if self.within is not None and not limited.all():
            joints = ", ".join(map(str, np.flatnonzero(~limited) + 1))
            raise InputError(f"--within needs a torque limit of every joint, {joints} without: --torque-limits")
        if Path(text).suffix.lower() == ".toml":
            if self.within is not None:
                raise InputError(f"--within bounds payloads that are not known, {text} is one: give KG[@X,Y,Z]")
            return model.read_payload(text).moved(flange.R, flange.p)
        mass, _, place = text.partition("@")
        try:
            kilograms = positive_number(mass)
            centre = list(numbers(place, 3)) if place else [0.0, 0.0, 0.0]
        except ValueError:
            raise InputError(f"--heaviest-payload {text!r}: give kg, kg@x,y,z (m), or a TOML file") from None
        if self.within is not None:
            half, box = self.within
            half = half if len(half) == 3 else half * 3
            return trajectories.PayloadSet.within(kilograms, half, centre, box).seen_from(flange)
        if not place:
            taken = f"--heaviest-payload {text} is taken as a point at the origin of the payload's frame"
            advice = "give kg@x,y,z or a TOML file to put it where it hangs, or --within for every payload about it"
            note(f"{taken}: {advice}")
        return model.InertialParameters.from_com(kilograms, centre, [[0.0] * 3] * 3).moved(flange.R, flange.p)


class MotionFiles(LimitOptions, group=FILES):
    """Formats of the motion itself, beside the result."""

    rules: ClassVar = {
        "joint_names": ("ros2",),
        "controller_rate": ("urscript",),
        "sample_rate": ("samples", "ros2"),
    }

    seed: Annotated[Seed, Parameter(group=SEARCH)] = 0
    """Seed of the random starts (default: 0)."""
    samples: Annotated[NewFile | None, Parameter(metavar="F.csv")] = None
    """Write samples of the motion: t, q, qd, qdd."""
    ros2: Annotated[NewFile | None, Parameter(metavar="F.yaml")] = None
    """Write a ROS 2 JointTrajectory."""
    joint_names: Annotated[Names, SETTING] = ()
    """Names of the joints for --ros2 (default: joint_1, ..)."""
    urscript: NewFile | None = None
    """Write a servoj program for Universal Robots."""
    controller_rate: Annotated[_Rate, SETTING] = CONTROLLER_RATE
    """Rate of the controller for --urscript [Hz]: 500 (default) or 125."""
    sample_rate: Annotated[_Rate, SETTING] = 250.0
    """Samples a second in files [Hz] (default: 250)."""
    val3: values.NewFolder | None = None
    """Write a VAL3 application with the via points, best with --segments trapezoid; created if missing."""

    def asked(self, written: WrittenMotion) -> dict[str, tuple[str, WrittenMotion]]:
        """The formats asked for by name: where each is to be written, and the motion at its rate."""
        name = Path(self.val3 or "").name
        sampled = replace(written, rate=self.sample_rate, joint_names=self.joint_names)
        files = {
            "csv": (self.samples, sampled),
            "ros2": (self.ros2, sampled),
            "urscript": (self.urscript, replace(written, rate=self.controller_rate)),
            # The application's database, which the rest of it stands beside.
            "val3": (self.val3 and str(Path(self.val3) / f"{name}.dtx"), replace(written, name=name)),
        }
        return {name: (path, motion) for name, (path, motion) in files.items() if path}

    def check_formats(self, robot: model.Robot, via_points: bool) -> None:
        """Refuse what a format has no place for, before any search."""
        if self.ros2:
            check_joint_names(self.joint_names, robot.n)
        if self.urscript:
            check_urscript(robot, self.controller_rate)
        if self.val3:
            check_val3(robot, via_points, Path(self.val3).name)

    def best_motion(
        self, problem: trajectories.DesignProblem, starts: int | None, kind: str = ""
    ) -> trajectories.Design:
        """The best motion that keeps every limit; the best criterion so far is told if its ``kind`` is given."""
        with status("building") as progress:

            def show(text: str, best: float | None, evaluations: int) -> None:
                reached = "no motion within the limits yet" if best is None else criterion_text(kind, best)
                progress(f"{text}, {evaluations} evaluations{f'; best: {reached}' if kind else ''}")

            design = trajectories.solve_design(problem, seed=self.seed, starts=starts, progress=show)
        if design.missed:
            fault = f"the whole run, or its rehearsal, does not keep every limit ({design.missed[0]})"
            raise InputError(f"{fault}: choose other poses, or another --seed")
        stopped = f"stopped after {design.cpu_s:.0f} s of processor time"
        if not design.feasible:
            missed, cut = "; ".join(design.score.violations), f"{stopped}: " if design.interrupted else ""
            raise InputError(f"{cut}no motion was found that keeps every limit, the nearest has: {missed}")
        if design.interrupted:
            best = "this is the best motion so far; it keeps every limit"
            note(f"{stopped} and {design.starts} starts: {best}; fewer via points or starts end by themselves")
        return design

    def check_replays(self, problem: trajectories.DesignProblem, written: WrittenMotion, *estimated: str) -> None:
        """Refuse files whose controllers break a limit or touch something; some are only ``estimated``."""
        # Whole limits count: what a design leaves free of the torques is for this.
        problem = problem.with_torque_share(1.0 / (1.0 - self.torque_margin))
        for name, (_, motion) in self.asked(written).items():
            form = motions.FORMATS[name]
            if name in estimated or form.replay is None:
                continue
            for limit in trajectories.missed_on_run(problem, form.replay(motion), _REPLAY_RATE, states=True):
                does, advice = form.replayed
                raise InputError(f"as {does} the motion does not keep its limits ({limit}): {advice}")

    def write_motion(self, written: WrittenMotion) -> None:
        """Write a motion with its head in the formats asked for."""
        if self.val3:
            made_folder(self.val3)
        for name, (path, motion) in self.asked(written).items():
            form = motions.FORMATS[name]
            write_text(path, form.text(motion))
            for beside, text in form.beside(motion).items():
                write_text(Path(path).parent / beside, text)
