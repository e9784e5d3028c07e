"""A robot's description."""

import math
from collections.abc import Iterable

from ....model import Limits, Robot
from ....model.drives import Drives
from ....model.frames import frames_at
from ....model.robot import SOURCED
from ..blocks import Block, Notes, Table, columns

_NUMBERS = ("alpha", "d", "theta", "r", "from", "to", "speed", "accel.", "torque")


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
    values = (
        *(scale * end for end in limits.position),
        scale * limits.speed,
        scale * limits.acceleration,
        limits.torque,
    )
    return tuple(f"{value:.5g}" if math.isfinite(value) else "" for value in values)


def _lines(robot: Robot) -> list[str]:
    flange = frames_at(robot, [0.0] * robot.n)[-1]
    return [
        f"Payloads are given in: {robot.payload_frame}",
        f"At the zero pose that frame stands at {_vector(flange.p.tolist())} m in the base, "
        f"z along {_vector(flange.R[:, 2].tolist())}, x along {_vector(flange.R[:, 0].tolist())}.",
        f"Gravity in frame 0: {_vector(list(robot.gravity))} m/s^2.",
        _drives(robot.drives),
        *_known_of(robot),
        *(f"Joints are also called {', '.join(names)}." for names in robot.joint_names),
        *_sources(robot),
        *(f"Note: {note}" for note in robot.snapped),
    ]


def _drives(drives: Drives) -> str:
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
    return f"Drives: {', '.join(known) or 'none of their parameters'}{on_link_side}."


def _known_of(robot: Robot) -> list[str]:
    """What only some descriptions tell."""
    lines = []
    if math.isfinite(robot.rated_payload):
        lines.append(f"Rated payload: {robot.rated_payload:g} kg.")
    if robot.links is not None:
        lines.append(f"Links of the file: {robot.links.base}, {', '.join(robot.links.names)}; {robot.links.tip}.")
    if robot.mass is not None:
        lines.append(f"Mass of the arm, base and all: {robot.mass:g} kg.")
    if robot.flange_pose is not None:
        x, y, z = (1e3 * value for value in robot.flange_pose.origin)
        turn = ", ".join(f"{math.degrees(angle) + 0.0:g}" for angle in robot.flange_pose.rpy)
        lines.append(
            f"The maker's flange stands at ({x:g}, {y:g}, {z:g}) mm, rpy ({turn}) deg in the payload's frame."
        )
    return lines


def _sources(robot: Robot) -> Iterable[str]:
    """Where the numbers come from, sources that are one told once."""
    by_source: dict[str, list[str]] = {}
    for name, words in SOURCED.items():
        if name in robot.sources:
            by_source.setdefault(robot.sources[name], []).append(words)
    return (f"{_sentence(', '.join(names))}: {source}." for source, names in by_source.items())


def assumed_notes(robot: Robot, *parts: str) -> list[str]:
    """What was assumed of a robot, and how; ``parts``: of ``model.robot.SOURCED``, all without."""
    by_assumption: dict[str, list[str]] = {}
    for name, how in robot.assumed(*parts).items():
        by_assumption.setdefault(how, []).append(SOURCED[name])
    return [f"Assumed, not published: {', '.join(names)} ({how})." for how, names in by_assumption.items()]


def _sentence(text: str) -> str:
    return text[0].upper() + text[1:]


def _vector(values: list[float]) -> str:
    return "(" + ", ".join(f"{value + 0.0:.5g}" for value in values) + ")"
