"""Motions as files of every format start from them, with the words at their head; and the formats of controllers.

JointTrajectory of ROS 2 as YAML: header (stamp, frame_id), joint_names, and points with positions, velocities,
accelerations, effort and time_from_start (sec, nanosec, counted from the start of the trajectory). Numbers carry a
decimal point and no exponent, which YAML 1.1 would take for text. Source:
docs.ros.org/en/jazzy/p/trajectory_msgs/msg/JointTrajectory and JointTrajectoryPoint;
builtin_interfaces/msg/Duration.

URScript: a servoj program with a sample each cycle of the controller. servoj(q, a, v, t, lookahead_time, gain)
blocks for t and leaves a and v unused; q in rad. The program refuses to start far from the first pose, goes there
slowly by movej, checks that it has arrived, and then streams; a cycle is 0.002 s on e-Series, 0.008 s on CB3.
Source: URScript manual, servoj, movej, get_actual_joint_positions, stopj, popup
(universal-robots.com/manuals/EN/HTML/SW5_20/Content/prod-scriptmanual/G5/servoj_qavt0-008lookahead_time.htm).

VAL3 application of Staubli: joint variables, motion descriptors and a movej program. A .pjx project, a .dtx
database with ``jointRx`` [deg] and ``mdesc`` arrays, and the programs start and stop. accel, vel and decel are
percentages of the nominal values, blend is off or joint, with leave and reach [mm]. The controller plans its own
profile between the points: only its log shows what was run. Sources: VAL3 Reference Manual (D28062804A), 9.5 mdesc
type and 9.6 movement instructions; Beckhoff TF5130, T_Mdesc; the layout of the files as in the public VAL3
applications of ros-industrial/staubli_val3_driver.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from xml.etree.ElementTree import Element

import numpy as np

from ... import __version__
from ...common import Array, InputError
from ...model import Motion, Robot, forward_kinematics
from ...model.robot import SOURCED
from ...trajectories import Design, DesignProblem, JointBounds, Plan, Trapezoid, ViaPoints
from ...trajectories.design.score import Learnt
from ...trajectories.motions.planned import PointToPoint, SampledTrajectory, plan_point_to_point
from ..numbers import joined
from ..recordings import csv_text
from .format import FIRST, Format, element, plain, xml_text

DIGITS = 9  # decimals of positions, speeds and accelerations: a nanoradian
DENSER = "write more of them a second, or leave more room by the setting torque-margin"
"""Advice where samples are too far apart."""
_NO_TIME = 1e-6  # s: a last step shorter than this is left out
_SECOND = 1_000_000_000
CONTROLLER_RATE = 500.0  # Hz: e-Series of Universal Robots. A CB3 has 125
_LOOKAHEAD, _GAIN = 0.1, 300  # the manual's example
_RAMP_SPEED, _RAMP_ACCELERATION = 0.25, 0.5  # rad/s, rad/s^2: to the first pose
_FAR, _THERE = 1.0, 0.01  # rad: farther than _FAR from the first pose nothing moves
_XSI = "http://www.w3.org/2001/XMLSchema-instance"
_SPACE = "http://www.staubli.com/robotics/VAL3"
_APPROACH = 10  # % of the speed, to the first point of a VAL3 application
_WARNING = (
    "The controller plans its own way between these points: torques and obstacles were checked for the designed",
    "motion, not for that. Run it slowly first, and score its log by dynident score.",
)
_BLEND = 1.0 / 3.0  # of the distance to the nearer neighbour: where a passing quintic's point is left and rejoined


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


motion_format = partial(Format[WrittenMotion], head=lambda form, motion: (*motion.head, *form.remarks))
"""Makes a function the format of a motion."""


@partial(
    motion_format,
    title="CSV",
    source="the columns' names",
    remarks=("Columns: t [s], positions [rad or m], speeds, accelerations.",),
)
def _csv(motion: WrittenMotion) -> str:
    samples = motion.sampled()
    return csv_text(samples.t, {"q": samples.q, "qd": samples.qd, "qdd": samples.qdd}, f"%.{DIGITS}f")


def _ros2_replay(motion: WrittenMotion) -> SampledTrajectory:
    # Quintics between points with speeds and accelerations (control.ros.org, Trajectory Representation).
    points = motion.sampled()
    return SampledTrajectory(points.t, points.q, points.qd, points.qdd, "--ros2")


@partial(
    motion_format,
    title="JointTrajectory of ROS 2",
    source="trajectory_msgs/msg/JointTrajectory",
    remarks=("trajectory_msgs/msg/JointTrajectory; be at the first point before it starts.",),
    replay=_ros2_replay,
    replayed=("ROS 2 joins the samples", DENSER),
)
def _ros2(motion: WrittenMotion) -> str:
    samples = motion.sampled()
    lines = ["header:", "  stamp: {sec: 0, nanosec: 0}", "  frame_id: ''", "joint_names:"]
    lines += [f"- '{name}'" for name in check_joint_names(motion.joint_names, motion.robot.n)]
    lines.append("points:")
    for t, q, qd, qdd in zip(samples.t, samples.q, samples.qd, samples.qdd, strict=True):
        sec, nanosec = divmod(round(float(t) * _SECOND), _SECOND)
        lines += [
            f"- positions: {listed(q)}",
            f"  velocities: {listed(qd)}",
            f"  accelerations: {listed(qdd)}",
            "  effort: []",
            f"  time_from_start: {{sec: {sec}, nanosec: {nanosec}}}",
        ]
    return "\n".join(lines)


def check_joint_names(names: Sequence[str], n: int) -> tuple[str, ...]:
    """The names, or joint_1 and so on if there are none; names that do not fit ``n`` joints are refused."""
    names = tuple(names) or tuple(f"joint_{j}" for j in range(1, n + 1))
    if not len({name for name in names if re.fullmatch(r"[A-Za-z0-9_/.-]+", name)}) == len(names) == n:
        raise InputError(f"joint names {', '.join(names)}: give {n} different ones of letters, digits and _ - / .")
    return names


def _servoj_replay(motion: WrittenMotion) -> SampledTrajectory:
    """servoj follows positions alone; they are joined by the smoothest curve that rests at both ends."""
    # It stands in the first pose before, and in the last one afterwards.
    t = np.arange(-1, len(motion.cycles()) + 1) / motion.rate
    return SampledTrajectory(t, motion.plan.at(t)[0], source="--urscript")


@partial(
    motion_format,
    title="URScript of Universal Robots",
    source="URScript manual, servoj",
    replay=_servoj_replay,
    replayed=("URScript joins the samples", DENSER),
)
def _urscript(motion: WrittenMotion) -> str:
    check_urscript(motion.robot, motion.rate)
    q = motion.cycles()
    lines = [
        f"# {len(q)} samples at {motion.rate:g} Hz. Try it with the speed slider low and a hand on the emergency "
        "stop.",
        "def dynident_motion():",
        f"  first = {listed(q[0])}",
        *_halt_beyond("present pose", _FAR, "too far from the first pose: jog nearer"),
        f"  movej(first, a={_RAMP_ACCELERATION}, v={_RAMP_SPEED})",
        *_halt_beyond("pose after the approach", _THERE, "not the first pose: nothing was run"),
        *(f"  servoj({listed(row)}, 0, 0, {1.0 / motion.rate:g}, {_LOOKAHEAD}, {_GAIN})" for row in q),
        "  stopj(2.0)",
        "end",
        "dynident_motion()",
    ]
    return "\n".join(lines)


def check_urscript(robot: Robot, rate: float) -> None:
    """Refuse, before any work is done, robots and rates that no controller runs."""
    require_six_turning(robot, "URScript")
    if rate not in (500.0, 125.0):
        raise InputError(f"a URScript controller runs at 500 Hz (e-Series) or 125 Hz (CB3), not at {rate:g} Hz")


def _halt_beyond(label: str, limit: float, message: str) -> list[str]:
    """Stop unless every joint is within ``limit`` [rad] of the first pose."""
    return [
        f"  # {label}",
        "  here = get_actual_joint_positions()",
        "  k = 0",
        "  while k < 6:",
        f"    if norm(here[k] - first[k]) > {limit:g}:",
        f'      popup("{message}", title="dynident", error=True, blocking=True)',
        "      halt",
        "    end",
        "    k = k + 1",
        "  end",
    ]


def _points(motion: WrittenMotion) -> tuple[ViaPoints, Array]:
    """Moves of a motion, none to where it stands; and the time for which each point is held [s], shape (K,)."""
    plan = motion.plan
    check_val3(motion.robot, isinstance(plan, ViaPoints), motion.name)
    assert isinstance(plan, ViaPoints)
    goes = np.diff(plan.points, axis=0).any(axis=1)
    held = np.bincount(np.cumsum(goes)[~goes], plan.durations[~goes], minlength=goes.sum() + 1).astype(float)
    moved = ViaPoints(plan.points[np.append(True, goes)], plan.durations[goes], segment=plan.segment)
    return plan if goes.all() else moved, held


def val3_replay(motion: WrittenMotion) -> PointToPoint:
    """Motion of a controller whose profiles are trapezoidal by these moves: an estimate to be scored."""
    plan, _ = _points(motion)
    accel, speed = (0.01 * percent[:, None] for percent in _moves(motion, plan)[:2])
    if plan.rests:
        return plan_point_to_point(motion.described, plan.points, speed, accel, blend=None)
    at_points = np.minimum(np.vstack([accel, accel[-1:]]), np.vstack([accel[:1], accel]))
    return plan_point_to_point(motion.described, plan.points, speed, at_points)


def _moves(motion: WrittenMotion, plan: ViaPoints) -> tuple[Array, Array, Array]:
    """Acceleration and speed of each move [%]; its second point is left and reached again at so many mm, 0: a stop.

    Acceleration: of trapezoidal segments by the ramp, of quintic ones as large as the limits allow. Speeds so that
    a trapezoidal profile takes the segment's time. Whole percentages of the nominal values, those of trapezoidal
    segments rounded within the limits, the others rounded down.
    """
    limits = [joint.limits for joint in motion.described.joints]
    nominal, strong = (np.array([getattr(limit, kind) for limit in limits]) for kind in ("speed", "acceleration"))
    T, steps = plan.durations, np.abs(np.diff(plan.points, axis=0))
    # As the slowest joint has them; the others follow its law.
    by_speed, by_acceleration = (steps / nominal).max(axis=1), (steps / strong).max(axis=1)
    most = _percent(np.minimum((motion.bounds.acceleration / strong).min(), 1.0))
    accel, rounding = np.full(len(steps), most), 0.0
    if isinstance(plan.segment, Trapezoid):
        rounding = 0.005
        accel = np.minimum(_percent(by_acceleration * plan.segment.peak_acceleration / T**2 + rounding), most)
    leave, speed = np.zeros(len(steps)), by_speed / T
    if plan.rests:
        # A joint that travels d takes d / (v V) + v V / A at the fraction v of its speed V: the smaller root of it,
        # all the speed where none takes T.
        ramp = by_acceleration / (0.01 * accel)
        root = np.sqrt(np.maximum(T**2 - 4.0 * ramp, 0.0))
        fraction = np.clip((T - root) * by_speed / np.maximum(2.0 * ramp, 1e-300), 0.01, 1.0)
        speed = np.where((4.0 * ramp > T**2) | (ramp == 0.0), 1.0, fraction)
    else:  # each inner point is left and rejoined
        kinematics = forward_kinematics(motion.robot)
        origins = np.array([kinematics(q)[1].full().ravel() for q in plan.points]).reshape(-1, 3)
        gap = 1000.0 * np.linalg.norm(np.diff(origins, axis=0), axis=1)
        leave[:-1] = np.floor(_BLEND * np.minimum(gap[:-1], gap[1:]))
    return accel, np.minimum(_percent(speed + rounding), _percent((motion.bounds.speed / nominal).min())), leave


def _percent(fraction: Array) -> Array:
    return np.maximum(np.floor(100.0 * fraction + 1e-9), 1.0)


def check_val3(robot: Robot, via_points: bool, name: str) -> None:
    """Refuse, before any work is done, a motion, a robot or a name that has no place in a VAL3 application."""
    require_six_turning(robot, "VAL3 jointRx")
    if not via_points:
        raise InputError("VAL3 needs via points, a Fourier motion has none: design --via-points or near --static")
    if not re.fullmatch(r"[A-Za-z]\w{0,14}", name, re.ASCII):
        raise InputError(
            f"{name!r} is not a VAL3 application name: use a letter, then letters, digits or _, at most 15"
        )


def _val3_files(motion: WrittenMotion) -> dict[str, str]:
    held = _points(motion)[1]
    count, hold = len(held), ["    waitEndMove()", "    delay(nHold[nIndex])"] * bool(held.any())
    start = [
        "begin",
        *(f"  // {plain(line)}".replace("]]>", "]] >") for line in (*motion.head, *_WARNING)),
        f"  // Slowly to the first point ({_APPROACH} % speed), then all {count} points.",
        "  movej(jPoint[0], tFlange, mMotion[0])",
        "  waitEndMove()",
        f"  for nIndex = 1 to {count - 1}",
        "    movej(jPoint[nIndex], tFlange, mMotion[nIndex])",
        *hold,
        "  endFor",
        "  waitEndMove()",
        "end",
    ]
    project = element(
        "Project", {"xmlns": f"{_SPACE}/Project/3"},
        element("Parameters", {"version": "s7.3.1", "stackSize": "5000", "millimeterUnit": "true"}),
        element("Programs", {}, *(element("Program", {"file": f"{name}.pgx"}) for name in ("start", "stop"))),
        element("Database", {}, element("Data", {"file": f"{motion.name}.dtx"})),
        element("Libraries"),
    )  # fmt: skip
    programs = {"start": ("public", start), "stop": ("private", ["begin", "  resetMotion()", "end"])}
    files = {f"{motion.name}.pjx": f"{FIRST}\n{xml_text(project)}\n"}
    for name, (access, code) in programs.items():
        text = "\n".join(code)
        files[f"{name}.pgx"] = f"""{FIRST}
<Programs xmlns:xsi="{_XSI}" xmlns="{_SPACE}/Program/2">
  <Program name="{name}" access="{access}">
    <Code><![CDATA[{text}
]]></Code>
  </Program>
</Programs>
"""
    return files


@partial(
    motion_format,
    title="VAL3 application of Staubli",
    source="VAL3 Reference Manual (D28062804A)",
    remarks=_WARNING,
    first_line=FIRST,
    beside=_val3_files,
    replay=val3_replay,
    replayed=(
        "VAL3 may move from point to point",
        "design with --segments trapezoid, or leave more room by the setting torque-margin",
    ),
)
def _val3(motion: WrittenMotion) -> Element:
    plan, held = _points(motion)
    angles, motions = np.degrees(plan.points).tolist(), []
    for accel, vel, leave in [(_APPROACH, _APPROACH, 0.0), *zip(*_moves(motion, plan), strict=True)]:
        ramp, near = f"{accel:g}", f"{leave:g}"
        profile = {"accel": ramp, "vel": f"{vel:g}", "decel": ramp, "tmax": "99999", "rmax": "99999"}
        motions.append(profile | ({"blend": "joint", "leave": near, "reach": near} if leave else {"blend": "off"}))
    variables = {
        ("jPoint", "jointRx"): [{f"j{j}": f"{angle:.6f}" for j, angle in enumerate(row, 1)} for row in angles],
        ("mMotion", "mdesc"): motions,
        ("nIndex", "num"): [{"value": "0"}],
        **({("nHold", "num"): [{"value": f"{time:g}"} for time in held]} if held.any() else {}),
        ("tFlange", "tool"): [{"fatherId": "flange[0]"}],
    }
    data = element("Datas")
    for (name, kind), values in variables.items():
        about = {"name": name, "access": "private", "xsi:type": "array", "type": kind, "size": f"{len(values)}"}
        entries = (element("Value", {"key": f"{k}"} | value) for k, value in enumerate(values))
        data.append(element("Data", about, *entries))
    return element("Database", {"xmlns:xsi": _XSI, "xmlns": f"{_SPACE}/Data/2"}, data)


FORMATS: dict[str, Format[WrittenMotion]] = {"csv": _csv, "ros2": _ros2, "urscript": _urscript, "val3": _val3}
"""Every format by its name."""
