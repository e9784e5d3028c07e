"""A robot's description."""

import math

from ...model import Limits, Robot
from ...model.frames import frames_at
from ..blocks import Block, Notes, Table, columns

_NUMBERS = ("alpha", "d", "theta", "r", "from", "to", "speed", "torque")


def robot_description(robot: Robot) -> list[Block]:
    """Modified DH table with limits, angles in degrees; and what else a user should know before using it."""
    rows = []
    for number, joint in enumerate(robot.joints, start=1):
        name = f"{number}" if robot.links is None else f"{number} {robot.links.joints[number - 1]}"
        geometry = (math.degrees(joint.alpha), joint.d, math.degrees(joint.theta), joint.r)
        limits = _limits(joint.limits, joint.revolute)
        rows.append((name, joint.kind, *(f"{value:.6g}" for value in geometry), *limits))
    title = f"{robot.title or robot.name}: modified DH (Khalil-Kleinfinger), degrees and m"
    return [Table(title, columns(("joint", "kind"), _NUMBERS), rows), Notes(_lines(robot))]


def _limits(limits: Limits, revolute: bool) -> tuple[str, ...]:
    scale = math.degrees(1.0) if revolute else 1.0
    values = (*(scale * end for end in limits.position), scale * limits.speed, limits.torque)
    return tuple(f"{value:.5g}" if math.isfinite(value) else "" for value in values)


def _lines(robot: Robot) -> list[str]:
    flange = frames_at(robot, [0.0] * robot.n)[-1]
    drives = robot.drives
    known = [
        word
        for word, there in (
            ("rotor inertia", drives.rotor_inertia),
            ("friction", drives.friction),
            ("offsets", drives.offsets),
            ("coupled drives", drives.coupling is not None),
            ("a gravity spring", drives.spring is not None),
        )
        if there
    ]
    on_link_side = "; torque sensors on the link side" if drives.side == "link" else ""
    lines = [
        f"Payloads are given in: {robot.payload_frame}",
        f"At the zero pose that frame stands at {_vector(flange.p.tolist())} m in the base, "
        f"z along {_vector(flange.R[:, 2].tolist())}, x along {_vector(flange.R[:, 0].tolist())}.",
        f"Gravity in frame 0: {_vector(list(robot.gravity))} m/s^2.",
        f"Drives: {', '.join(known) or 'none of their parameters'}{on_link_side}.",
    ]
    if math.isfinite(robot.rated_payload):
        lines.append(f"Rated payload: {robot.rated_payload:g} kg.")
    if robot.links is not None:
        lines.append(f"Links of the file: {robot.links.base}, {', '.join(robot.links.names)}; {robot.links.tip}.")
    return [*lines, *(f"Note: {note}" for note in robot.snapped)]


def _vector(values: list[float]) -> str:
    return "(" + ", ".join(f"{value + 0.0:.5g}" for value in values) + ")"
