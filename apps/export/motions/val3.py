"""Via points as a VAL3 application of Staubli: joint variables, motion descriptors and a movej program.

A .pjx project, a .dtx database with ``jointRx`` [deg] and ``mdesc`` arrays, and the programs start and stop. accel,
vel and decel are percentages of the nominal values, blend is off or joint, with leave and reach [mm]. The
controller plans its own profile between the points: only its log shows what was run. Sources: VAL3 Reference
Manual (D28062804A), 9.5 mdesc type and 9.6 movement instructions; Beckhoff TF5130, T_Mdesc; the layout of the files
as in the public VAL3 applications of ros-industrial/staubli_val3_driver.
"""

import math
from typing import NamedTuple
from xml.sax.saxutils import escape

import numpy as np

from ....common.arrays import Array
from ....common.errors import InputError
from ....model import Robot, forward_kinematics
from ....trajectories import PointToPoint, Trapezoid, ViaPoints, plan_point_to_point
from ....trajectories.motions.point_to_point import plan_stops
from .written import WrittenMotion, require_six_turning

_BLEND = 1.0 / 3.0  # of the distance to the nearer neighbour: where a passing quintic's point is left and rejoined


class Descriptor(NamedTuple):
    """How one point is approached: percentages; it is left and reached again at ``leave`` [mm], 0 for a stop."""

    accel: int
    vel: int
    leave: float = 0.0


def val3_replay(written: WrittenMotion) -> PointToPoint:
    """What a controller does with these moves if its profiles are trapezoidal: an estimate to be scored.

    Raises:
        ValueError: if two neighbouring points are the same.
    """
    plan = written.plan
    assert isinstance(plan, ViaPoints)
    moves = descriptors_of(written, plan)
    speed = 0.01 * np.array([[move.vel] for move in moves])
    accel = 0.01 * np.array([[move.accel] for move in moves])
    if plan.rests:
        return plan_stops(written.described, plan.points, speed, accel)
    at_points = np.minimum(np.vstack([accel, accel[-1:]]), np.vstack([accel[:1], accel]))
    return plan_point_to_point(written.described, plan.points, speed, at_points)


class _Nominal(NamedTuple):
    """What percentages are of, each (n,), and the most of it that the design's limits allow, in percent."""

    speed: Array
    acceleration: Array
    most_speed: int
    most_acceleration: int


def _nominal(written: WrittenMotion) -> _Nominal:
    limits = [joint.limits for joint in written.described.joints]
    top = np.array([limit.speed for limit in limits])
    strong = np.array([limit.acceleration for limit in limits])
    most = min(float((written.bounds.acceleration / strong).min()), 1.0)
    return _Nominal(top, strong, _percent(float((written.bounds.speed / top).min())), _percent(most))


def descriptors_of(written: WrittenMotion, plan: ViaPoints) -> list[Descriptor]:
    """A descriptor for each move, into its second point.

    Acceleration of a move: of trapezoidal segments by the ramp, of quintic ones as large as the limits allow.

    Speeds so that a trapezoidal profile takes the segment's time. Whole percentages, those of trapezoidal segments
    rounded within the limits, the others rounded down.
    """
    nominal = _nominal(written)
    leave = np.zeros(len(plan.points)) if plan.rests else _leave(written, plan.points)
    descriptors = []
    for k, (T, step) in enumerate(zip(plan.durations, np.abs(np.diff(plan.points, axis=0)), strict=True)):
        # As the slowest joint has them; the others follow its law.
        by_speed, by_acceleration = float((step / nominal.speed).max()), float((step / nominal.acceleration).max())
        accel, rounding = nominal.most_acceleration, 0.0
        if isinstance(plan.segment, Trapezoid):
            percent, rounding = by_acceleration * plan.segment.peak_acceleration / T**2, 0.005
            accel = min(_percent(percent + rounding), accel)
        speed = _speed(by_speed, by_acceleration / (0.01 * accel), T) if plan.rests else by_speed / T
        vel = min(_percent(speed + rounding), nominal.most_speed)
        descriptors.append(Descriptor(accel, vel, leave[k + 1]))
    return descriptors


def _speed(by_speed: float, by_acceleration: float, T: float) -> float:
    """Fraction v of the nominal speed with which a trapezoid rests at both ends and takes T; 1 if none does.

    A joint that travels d takes d / (v V) + v V / A; d / V and d / A are given.
    """
    root = T * T - 4.0 * by_acceleration  # of a / v + v b / a = T
    if root < 0.0 or by_acceleration == 0.0:
        return 1.0
    fraction = (T - math.sqrt(root)) * by_speed / (2.0 * by_acceleration)
    return min(max(fraction, 0.01), 1.0)


def _leave(written: WrittenMotion, points: Array) -> Array:
    """Distance at which each inner point is left and rejoined [mm], shape (points,)."""
    gap = _apart(written, points[:-1], points[1:])
    nearer = np.concatenate([[0.0], np.minimum(gap[:-1], gap[1:]), [0.0]])
    return np.asarray(np.floor(_BLEND * nearer))


def _apart(written: WrittenMotion, points: Array, others: Array) -> Array:
    """Distance of the last frame's origin between two poses [mm], for each of (count, n)."""
    kinematics = forward_kinematics(written.robot)
    place, other_place = (
        np.array([kinematics(q)[1].full().ravel() for q in x]).reshape(-1, 3) for x in (points, others)
    )
    return np.asarray(1000.0 * np.linalg.norm(other_place - place, axis=1))


def _percent(fraction: float) -> int:
    """Rounded down, and at least 1."""
    return max(int(100.0 * fraction + 1e-9), 1)


_XSI = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
_SPACE = "http://www.staubli.com/robotics/VAL3"
_FIRST = '<?xml version="1.0" encoding="utf-8"?>'
_APPROACH = 10  # % of the speed, to the first point
_WARNING = (
    "The controller plans its own way between these points: torques and obstacles were checked for the designed",
    "motion, not for that. Run it slowly first, and score its log by dynident score.",
)


def val3_files(written: WrittenMotion, name: str) -> dict[str, str]:
    """File name -> text.

    Args:
        written: the motion; through via points.
        name: of the application.

    Raises:
        InputError: for a Fourier motion, a robot that is not of six turning joints, or a name that VAL3 refuses.
    """
    plan = written.plan
    check_val3(written.robot, isinstance(plan, ViaPoints), name)
    assert isinstance(plan, ViaPoints)
    descriptors = [Descriptor(_APPROACH, _APPROACH), *descriptors_of(written, plan)]
    head = (*written.head, *_WARNING)
    return {
        f"{name}.pjx": _project(name),
        f"{name}.dtx": _data(np.degrees(plan.points), descriptors, head),
        "start.pgx": _program("start", "public", _start(head, len(plan.points))),
        "stop.pgx": _program("stop", "private", ["begin", "  resetMotion()", "end"]),
    }


def check_val3(robot: Robot, via_points: bool, name: str) -> None:
    """Refuse what has no place in a VAL3 application, before any work is done.

    Raises:
        InputError: for a Fourier motion, a robot that is not of six turning joints, or a name that VAL3 refuses.
    """
    require_six_turning(robot, "VAL3 jointRx")
    if not via_points:
        raise InputError("VAL3 needs via points, a Fourier motion has none: design with --via-points")
    if not (name.isascii() and name.replace("_", "a").isalnum() and name[:1].isalpha() and len(name) <= 15):
        raise InputError(
            f"{name!r} is no VAL3 application's name: a letter, then letters, digits and _, 15 at most"
        )


def _project(name: str) -> str:
    return "\n".join(
        [
            _FIRST,
            f'<Project xmlns="{_SPACE}/Project/3">',
            '  <Parameters version="s7.3.1" stackSize="5000" millimeterUnit="true" />',
            "  <Programs>",
            '    <Program file="start.pgx" />',
            '    <Program file="stop.pgx" />',
            "  </Programs>",
            "  <Database>",
            f'    <Data file="{name}.dtx" />',
            "  </Database>",
            "  <Libraries />",
            "</Project>\n",
        ]
    )


def _data(degrees: Array, descriptors: list[Descriptor], head: tuple[str, ...]) -> str:
    joints = [" ".join(f'j{j + 1}="{angle:.6f}"' for j, angle in enumerate(row)) for row in degrees]
    motions = []
    for accel, vel, leave in descriptors:
        blend = f'blend="joint" leave="{leave:g}" reach="{leave:g}"' if leave else 'blend="off"'
        motions.append(f'accel="{accel}" vel="{vel}" decel="{accel}" tmax="99999" rmax="99999" {blend}')
    remarks = "\n".join(f"  {line}" for line in head).replace("--", "- -")
    return "\n".join(
        [
            _FIRST,
            f"<!--\n{escape(remarks)}\n-->",
            f'<Database {_XSI} xmlns="{_SPACE}/Data/2">',
            "  <Datas>",
            *_array("jPoint", "jointRx", joints),
            *_array("mMotion", "mdesc", motions),
            *_array("nIndex", "num", ['value="0"']),
            *_array("tFlange", "tool", ['fatherId="flange[0]"']),
            "  </Datas>",
            "</Database>\n",
        ]
    )


def _array(name: str, kind: str, values: list[str]) -> list[str]:
    return [
        f'    <Data name="{name}" access="private" xsi:type="array" type="{kind}" size="{len(values)}">',
        *(f'      <Value key="{k}" {value} />' for k, value in enumerate(values)),
        "    </Data>",
    ]


def _start(head: tuple[str, ...], count: int) -> list[str]:
    return [
        "begin",
        *(f"  // {line}".replace("]]>", "]] >") for line in head),
        f"  // Slowly to the first point ({_APPROACH} % speed), then all {count} points.",
        "  movej(jPoint[0], tFlange, mMotion[0])",
        "  waitEndMove()",
        f"  for nIndex = 1 to {count - 1}",
        "    movej(jPoint[nIndex], tFlange, mMotion[nIndex])",
        "  endFor",
        "  waitEndMove()",
        "end",
    ]


def _program(name: str, access: str, code: list[str]) -> str:
    return "\n".join(
        [
            _FIRST,
            f'<Programs {_XSI} xmlns="{_SPACE}/Program/2">',
            f'  <Program name="{name}" access="{access}">',
            "    <Code><![CDATA[" + "\n".join(code),
            "]]></Code>",
            "  </Program>",
            "</Programs>\n",
        ]
    )
