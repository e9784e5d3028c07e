"""Via points as a VAL3 application of Staubli: joint variables, motion descriptors and a movej program.

A .pjx project, a .dtx database with ``jointRx`` [deg] and ``mdesc`` arrays, and the programs start and stop. accel,
vel and decel are percentages of the nominal values, blend is off or joint, with leave and reach [mm]. The
controller plans its own profile between the points: only its log shows what was run. Sources: VAL3 Reference
Manual (D28062804A), 9.5 mdesc type and 9.6 movement instructions; Beckhoff TF5130, T_Mdesc; the layout of the files
as in the public VAL3 applications of ros-industrial/staubli_val3_driver.
"""

import re
from functools import partial
from xml.etree.ElementTree import Element

import numpy as np

from ....common import Array, InputError
from ....model import Robot, forward_kinematics
from ....trajectories import PointToPoint, Trapezoid, ViaPoints, plan_point_to_point
from ..format import FIRST, Format, element, plain, xml_text
from ..motion import WrittenMotion, require_six_turning

_XSI = "http://www.w3.org/2001/XMLSchema-instance"
_SPACE = "http://www.staubli.com/robotics/VAL3"
_APPROACH = 10  # % of the speed, to the first point
_WARNING = (
    "The controller plans its own way between these points: torques and obstacles were checked for the designed",
    "motion, not for that. Run it slowly first, and score its log by dynident score.",
)
_BLEND = 1.0 / 3.0  # of the distance to the nearer neighbour: where a passing quintic's point is left and rejoined


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


def _beside(motion: WrittenMotion) -> dict[str, str]:
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
    Format,
    title="VAL3 application of Staubli",
    source="VAL3 Reference Manual (D28062804A)",
    remarks=_WARNING,
    first_line=FIRST,
    beside=_beside,
    replay=val3_replay,
    replayed=(
        "VAL3 may move from point to point",
        "design with --segments trapezoid, or leave more room by the setting torque-margin",
    ),
)
def _write(motion: WrittenMotion) -> Element:
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
