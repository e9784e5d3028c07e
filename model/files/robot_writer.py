"""Writes a robot as TOML, as ``load_robot`` reads it."""

import json
import math
from collections.abc import Iterator

from ..drives import Drives
from ..pose import Pose
from ..processing import Processing
from ..robot import Joint, Robot

_GRAVITY = (0.0, 0.0, -9.81)


def robot_toml(robot: Robot, source: str = "") -> str:
    """A robot's description as the text of a TOML file.

    Args:
        robot: the robot; frames of a URDF it came from are not kept.
        source: where its numbers come from.
    """
    lines = [
        f"# {robot.title or robot.name}. Lengths in m, angles in degrees.",
        f"name = {_text(robot.name)}",
        f"title = {_text(robot.title)}",
        f"payload_frame = {_text(robot.payload_frame)}",
        f"source = {_text(source)}",
    ]
    if robot.gravity != _GRAVITY:
        lines.append(f"gravity = {_list(robot.gravity)}")
    if math.isfinite(robot.rated_payload):
        lines.append(f"rated_payload_kg = {_number(robot.rated_payload)}")
    lines += [*_pose("flange", robot.flange), *_pose("base", robot.base)]
    lengths = dict(_lengths(robot))
    if lengths:
        lines += ["", "[lengths]", *(f"{name} = {_number(value)}" for name, value in lengths.items())]
    for number, joint in enumerate(robot.joints, start=1):
        lines += ["", "[[joints]]", *_joint(joint, number)]
    lines += [*_drives(robot.drives), *_processing(robot.processing)]
    if robot.parameters:
        lines += ["", "[parameters]", *(f"{name} = {value!r}" for name, value in robot.parameters.items())]
    return "\n".join(lines) + "\n"


def _names(joint: Joint, number: int) -> tuple[str, str]:
    return joint.names[0] or f"D{number}", joint.names[1] or f"R{number}"


def _lengths(robot: Robot) -> Iterator[tuple[str, float]]:
    for number, joint in enumerate(robot.joints, start=1):
        for name, value in zip(_names(joint, number), (joint.d, joint.r), strict=True):
            if value != 0.0:
                yield name, value


def _joint(joint: Joint, number: int) -> Iterator[str]:
    limits = joint.limits
    unit, shown = ("deg", _degrees) if joint.revolute else ("m", _number)
    if not joint.revolute:
        yield 'kind = "prismatic"'
    yield f"alpha_deg = {_degrees(joint.alpha)}"
    d_name, r_name = _names(joint, number)
    if joint.d != 0.0:
        yield f"d = {_text(d_name)}"
    if joint.theta != 0.0:
        yield f"theta_deg = {_degrees(joint.theta)}"
    if joint.r != 0.0:
        yield f"r = {_text(r_name)}"
    if all(math.isfinite(end) for end in limits.position):
        yield f"position_{unit} = [{shown(limits.position[0])}, {shown(limits.position[1])}]"
    if math.isfinite(limits.speed):
        yield f"speed_{unit}_s = {shown(limits.speed)}"
    if math.isfinite(limits.acceleration):
        yield f"acceleration_{unit}_s2 = {shown(limits.acceleration)}"
    if math.isfinite(limits.torque):
        yield f"torque = {_number(limits.torque)}"


def _pose(name: str, pose: Pose) -> list[str]:
    if pose.is_identity:
        return []
    lines = ["", f"[{name}]"]
    if any(pose.origin):
        lines.append(f"xyz = {_list(pose.origin)}")
    if any(pose.rpy):
        lines.append(f"rpy_deg = [{', '.join(_degrees(angle) for angle in pose.rpy)}]")
    return lines


def _drives(drives: Drives) -> list[str]:
    link = drives.side == "link"
    lines, usual = ['side = "link"'] * link, Drives.on_link_side() if link else Drives()
    for name in ("rotor_inertia", "friction", "offsets"):
        value = getattr(drives, name)
        if value != getattr(usual, name):
            lines.append(f"{name} = {str(value).lower()}")
    if lines:
        lines = ["", "[drives]", *lines]
    if drives.coupling:
        lines += ["", "[drives.coupling]", f"joints = {list(drives.coupling.joints)}"]
        lines.append(f"coulomb = {_text(drives.coupling.coulomb)}")
    spring = drives.spring
    if spring:
        lines += ["", "[drives.spring]", f"joint = {spring.joint}"]
        if spring.table:
            rows = ", ".join(f"[{_degrees(angle)}, {_number(torque)}]" for angle, torque in spring.table)
            lines.append(f"table = [{rows}]")
        else:
            lines += [f"stiffness = {_number(spring.stiffness)}", f"length = {_number(spring.length)}"]
            lines += [f"arms = {_list(spring.arms)}", f"zero_deg = {_degrees(spring.zero)}"]
    return lines


def _processing(processing: Processing) -> list[str]:
    keys = {
        "rate_hz": "rate",
        "cutoff_hz": "cutoff",
        "decimate": "decimate",
        "still_speed": "still_speed",
        "slow_fraction": "slow_fraction",
        "max_mismatch": "max_mismatch",
    }
    plain = Processing()
    given = {key: getattr(processing, name) for key, name in keys.items()}
    lines = [
        f"{key} = {_number(value)}"
        for key, value in given.items()
        if value is not None and value != getattr(plain, keys[key])
    ]
    return ["", "[processing]", *lines] if lines else []


def _text(value: str) -> str:
    # JSON's strings are TOML's too, but for the one control character JSON leaves as it is.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _list(values: tuple[float, ...]) -> str:
    return f"[{', '.join(_number(value) for value in values)}]"


def _number(value: float) -> str:
    return repr(int(value)) if value == int(value) else repr(float(value))


def _degrees(angle: float) -> str:
    """As few digits as give the angle back to 1e-14 rad."""
    degrees = math.degrees(angle)
    for digits in range(14):
        short = round(degrees, digits)
        if abs(math.radians(short) - angle) <= 1e-14 * max(1.0, abs(angle)):
            return _number(short + 0.0)
    return repr(degrees)
