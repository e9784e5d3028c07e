"""A whole robot as URDF: chain, limits and bodies, with what decided the parameters that no motion shows."""

import math
from collections.abc import Iterable, Iterator, Mapping
from xml.sax.saxutils import escape, quoteattr

from ..estimation.possible import RobotOrigins
from ..model import InertialParameters, Joint, Pose, Robot
from ..model.frames import bodies_in_link_frames, step
from .urdf_origins import origins_comment, origins_legend

_UNKNOWN = 1e6
"""URDF demands numbers for limits: this stands for none."""


def robot_urdf(
    robot: Robot,
    parameters: Mapping[str, float],
    gauge: str,
    payload: InertialParameters | None = None,
    origins: RobotOrigins | None = None,
) -> str:
    """URDF with the robot's bodies, in the link frames of its own file where it has one.

    Rotor inertias and offsets have no place in URDF: they are left out, and named in a comment.

    Args:
        robot: the robot.
        parameters: standard parameters by name, the ten of every link; friction where known.
        gauge: what decided the combinations of parameters that no motion shows; stands in a comment.
        payload: in the robot's payload frame; becomes a link fixed to the flange.
        origins: who decided each number; stands in comments beside the links.

    Raises:
        InputError: if a link's parameters are missing.
    """
    bodies = bodies_in_link_frames(robot, parameters)
    in_order = tuple(bodies.values())
    links = robot.links
    names = ("base_link", *bodies) if links is None else (links.base, *links.names)
    lines = [
        '<?xml version="1.0" encoding="utf-8"?>',
        *(f"<!-- {_comment(line)} -->" for line in _comments(robot, parameters, gauge, origins)),
        f"<robot name={quoteattr(robot.name)}>",
        f"  <link name={quoteattr(names[0])}/>",
    ]
    for j, joint in enumerate(robot.joints):
        name = f"joint{j + 1}" if links is None else links.joints[j]
        labels = origins_comment(origins, j) if origins else ()
        lines += _link(names[j + 1], in_order[j], labels)
        friction = [parameters.get(f"{kind}{j + 1}", 0.0) for kind in ("FV", "FS")]
        lines += _joint(joint, name, (names[j], names[j + 1]), _place(robot, j), _frame(robot, j + 1), friction)
    flange = "flange" if links is None else links.tip
    if flange not in names:
        lines += [f"  <link name={quoteattr(flange)}/>", *_fixed(names[-1], flange, _flange(robot))]
    if payload is not None:
        parent, pose = (flange, Pose()) if flange not in names else (names[-1], _flange(robot))
        lines += [*_link("payload", payload), *_fixed(parent, "payload", pose)]
    return "\n".join([*lines, "</robot>"]) + "\n"


def _comments(
    robot: Robot, parameters: Mapping[str, float], gauge: str, origins: RobotOrigins | None
) -> Iterator[str]:
    yield f"{robot.title or robot.name}. Not all parameters of a link can be identified: {gauge}"
    left_out = [
        name for name, value in parameters.items() if name.startswith(("IA", "OFF", "FVM", "FSM")) and value
    ]
    if left_out:
        yield f"No place in URDF for: {', '.join(f'{name} = {parameters[name]:.9g}' for name in left_out)}."
    if robot.spring is not None:
        yield f"No place in URDF for the gravity spring on joint {robot.spring.joint}."
    if origins is not None:
        yield from origins_legend(origins)


def _comment(text: str) -> str:
    return escape(" ".join(text.split()).replace("--", "- -"))


def _frame(robot: Robot, number: int) -> Pose:
    """The link's frame in frame ``number``; the base's in frame 0."""
    if number == 0:
        return robot.base
    return robot.links.poses[number - 1] if robot.links is not None else Pose()


def _place(robot: Robot, j: int) -> Pose:
    """Link j + 1 in the link before, at the zero position."""
    along_x, along_z = step(robot.joints[j], 0.0)
    return _frame(robot, j).inverse() @ along_x @ along_z @ _frame(robot, j + 1)


def _flange(robot: Robot) -> Pose:
    return _frame(robot, robot.n).inverse() @ robot.flange


def _link(name: str, body: InertialParameters, labels: Iterable[str] = ()) -> Iterator[str]:
    yield f"  <link name={quoteattr(name)}>"
    yield from labels
    if body.mass != 0.0:
        inertia = body.inertia_com
        entries = " ".join(
            f'i{"xyz"[i]}{"xyz"[k]}="{_number(float(inertia[i, k]))}"' for i in range(3) for k in range(i, 3)
        )
        yield "    <inertial>"
        yield f'      <origin xyz="{_numbers(body.com.tolist())}" rpy="0 0 0"/>'
        yield f'      <mass value="{_number(body.mass)}"/>'
        yield f"      <inertia {entries}/>"
        yield "    </inertial>"
    yield "  </link>"


def _joint(
    joint: Joint, name: str, links: tuple[str, str], place: Pose, frame: Pose, friction: list[float]
) -> Iterator[str]:
    limits = joint.limits
    bounded = all(math.isfinite(end) for end in limits.position)
    kind = "prismatic" if not joint.revolute else "revolute" if bounded else "continuous"
    low, high = limits.position if bounded else (-_UNKNOWN, _UNKNOWN)
    ends = "" if kind == "continuous" else f'lower="{_number(low)}" upper="{_number(high)}" '
    speed, torque = (min(value, _UNKNOWN) for value in (limits.speed, limits.torque))
    yield f"  <joint name={quoteattr(name)} type={quoteattr(kind)}>"
    yield f"    <parent link={quoteattr(links[0])}/>"
    yield f"    <child link={quoteattr(links[1])}/>"
    yield f"    {_origin(place)}"
    yield f'    <axis xyz="{_numbers(frame.R[2].tolist())}"/>'
    yield f'    <limit {ends}velocity="{_number(speed)}" effort="{_number(torque)}"/>'
    if any(friction):
        yield f'    <dynamics damping="{_number(friction[0])}" friction="{_number(friction[1])}"/>'
    yield "  </joint>"


def _fixed(parent: str, child: str, pose: Pose) -> Iterator[str]:
    yield f'  <joint name={quoteattr(f"{parent}-{child}")} type="fixed">'
    yield f"    <parent link={quoteattr(parent)}/>"
    yield f"    <child link={quoteattr(child)}/>"
    yield f"    {_origin(pose)}"
    yield "  </joint>"


def _origin(pose: Pose) -> str:
    return f'<origin xyz="{_numbers(list(pose.origin))}" rpy="{_numbers(list(pose.rpy))}"/>'


def _numbers(values: list[float]) -> str:
    return " ".join(_number(value) for value in values)


def _number(value: float) -> str:
    return repr(value + 0.0)
