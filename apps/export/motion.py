"""A motion as files of every format start from it: with its robot and the words at its head."""

from dataclasses import dataclass, replace

import numpy as np

from ... import __version__
from ...common import Array, InputError
from ...model import Motion, Robot
from ...model.robot import SOURCED
from ...trajectories import Design, DesignProblem, JointBounds, Plan, Trapezoid, ViaPoints
from ...trajectories.design.score import Learnt
from ..numbers import joined

DIGITS = 9  # decimals of positions, speeds and accelerations: a nanoradian
DENSER = "write more of them a second, or leave more room by the setting torque-margin"
"""Advice where samples are too far apart."""
_NO_TIME = 1e-6  # s: a last step shorter than this is left out


@dataclass(frozen=True)
class WrittenMotion:
    """A motion within bounds of the joints, and what its file says about it."""

    robot: Robot
    plan: Plan
    bounds: JointBounds
    head: tuple[str, ...]
    rate: float = 250.0  # samples or cycles a second in files [Hz]
    joint_names: tuple[str, ...] = ()  # as the controller calls them; none for names of our own
    name: str = ""  # of a VAL3 application

    @property
    def described(self) -> Robot:
        """The robot with an acceleration limit for every joint: the description's, else that of the design."""
        joints = []
        for joint, most in zip(self.robot.joints, self.bounds.acceleration.tolist(), strict=True):
            finite = np.isfinite(joint.limits.acceleration)
            joints.append(joint if finite else replace(joint, limits=replace(joint.limits, acceleration=most)))
        return replace(self.robot, joints=tuple(joints))

    def sampled(self) -> Motion:
        """Samples, and one at the very end, where the robot rests."""
        duration = self.plan.duration
        t = np.arange(int(duration * self.rate + 1e-9) + 1) / self.rate
        if duration - t[-1] > _NO_TIME:
            t = np.append(t, duration)
        return Motion(t, *self.plan.at(t))

    def cycles(self) -> Array:
        """Positions in each cycle of a controller, the last one at rest where the motion ends."""
        return self.plan.at(np.arange(int(np.ceil(self.plan.duration * self.rate - 1e-9)) + 1) / self.rate)[0]


def listed(values: Array) -> str:
    """Numbers in brackets with ``DIGITS`` decimals."""
    return f"[{joined(values, f'.{DIGITS}f')}]"


def require_six_turning(robot: Robot, form: str) -> None:
    """Refuse a robot unless it has six joints, all of which turn; ``form`` has no place for another."""
    if robot.n != 6 or not all(joint.revolute for joint in robot.joints):
        raise InputError(f"{form} is for six joints that turn; robot {robot.name!r} has others")


def design_head(design: Design, learnt: Learnt) -> tuple[str, ...]:
    """Robot, limits, duration, criterion, seed and version of a design."""
    problem, bounds = design.problem, design.problem.bounds
    earlier = f", with {len(problem.earlier)} rows of earlier recordings" if len(problem.earlier) else ""
    shape, plan = "Fourier series", design.plan
    if isinstance(plan, ViaPoints):
        shape = f"{len(plan.points)} via points, {'at rest in each' if plan.rests else 'passing'}"
        if isinstance(plan.segment, Trapezoid):
            shape += f", trapezoids of speed with ramps of {plan.segment.ramp:g} of each move's time"
    return (
        f"Exciting motion of {problem.robot.title or problem.robot.name} by dynident {__version__}.",
        f"Duration {plan.duration:.6g} s; {shape}.",
        f"Criterion {problem.criterion.kind} for {len(problem.names)} parameters{earlier}; seed {design.seed}, "
        f"{design.starts} starts{', interrupted' if design.interrupted else ''}.",
        f"Condition number {learnt.condition_number:.4g}, columns scaled {learnt.condition_number_scaled:.4g}, "
        f"log det {learnt.log_det:.4g}.",
        f"Position limits [rad or m]: {joined(bounds.low, '.5g')} to {joined(bounds.high, '.5g')}.",
        f"Speed limits [per s]: {joined(bounds.speed, '.5g')}.",
        f"Acceleration limits [per s^2]: {joined(bounds.acceleration, '.5g')}.",
        *[f"Torque limits [N m or N]: {joined(bounds.torque, '.5g')}."] * bool(np.isfinite(bounds.torque).any()),
        *(f"Nearest to its limit: {limit}." for limit in design.score.limits),
        *assumed_line(problem),
    )


def assumed_line(problem: DesignProblem) -> list[str]:
    """Assumptions on the robot that the motion rests on; no line without one."""
    assumed = problem.robot.assumed(*rests_on(problem))
    return [f"Assumed, not published: {', '.join(SOURCED[name] for name in assumed)}."] if assumed else []


def rests_on(problem: DesignProblem) -> tuple[str, ...]:
    """Names of ``model.robot.SOURCED`` that a motion rests on."""
    return ("position", "speed", "acceleration", *(("torque", "parameters") if problem.torque_limited else ()))
