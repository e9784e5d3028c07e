"""A robot's description as tables."""

import math

from rich import box
from rich.table import Table

from ..model import Limits, Robot
from ..model.frames import frames_at


def robot_description(robot: Robot) -> Table:
    """Modified DH table with limits, angles in degrees."""
    title = f"{robot.title or robot.name}: modified DH (Khalil-Kleinfinger), degrees and m"
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, padding=0)
    table.add_column("joint", no_wrap=True)
    table.add_column("kind", no_wrap=True)
    for heading in ("alpha", "d", "theta", "r", "from", "to", "speed", "torque"):
        table.add_column(heading, justify="right", no_wrap=True)
    for number, joint in enumerate(robot.joints, start=1):
        name = f"{number}" if robot.links is None else f"{number} {robot.links.joints[number - 1]}"
        angles = (f"{math.degrees(joint.alpha):.6g}", f"{joint.d:.6g}", f"{math.degrees(joint.theta):.6g}")
        table.add_row(name, joint.kind, *angles, f"{joint.r:.6g}", *_limits(joint.limits, joint.revolute))
    return table


def _limits(limits: Limits, revolute: bool) -> tuple[str, ...]:
    scale = math.degrees(1.0) if revolute else 1.0
    values = (*(scale * end for end in limits.position), scale * limits.speed, limits.torque)
    return tuple(f"{value:.5g}" if math.isfinite(value) else "" for value in values)


def robot_lines(robot: Robot) -> list[str]:
    """What else a user should know of a robot before using it."""
    flange = frames_at(robot, [0.0] * robot.n)[-1]
    drives = robot.drives
    seen = [
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
        f"Drives: {', '.join(seen) or 'none of their parameters'}{on_link_side}.",
    ]
    if math.isfinite(robot.rated_payload):
        lines.append(f"Rated payload: {robot.rated_payload:g} kg.")
    if robot.links is not None:
        lines.append(f"Links of the file: {robot.links.base}, {', '.join(robot.links.names)}; {robot.links.tip}.")
    return [*lines, *(f"Made exact: {note}" for note in robot.snapped)]


def _vector(values: list[float]) -> str:
    return "(" + ", ".join(f"{value + 0.0:.5g}" for value in values) + ")"
