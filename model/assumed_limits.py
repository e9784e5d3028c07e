"""Limits of joints where a description has none: assumed, and called so."""

from dataclasses import replace

import numpy as np

from .robot import ASSUMED, Limits, Robot

SPEED = {"revolute": np.pi / 3.0, "prismatic": 0.1}
"""Speed limit where a description has none [rad/s or m/s]: slower than every shipped arm."""
ACCELERATION = 10.0
"""Acceleration limit over the speed limit [1/s], where a description has none."""


def with_assumed_limits(robot: Robot) -> Robot:
    """The robot with limits of positions, speeds and accelerations where its description has none.

    Joints that turn are given half a turn to either side, joints the speed ``SPEED`` and ``ACCELERATION`` times
    their speed; sliding joints without a range stay without. What was assumed is in the robot's ``sources``.
    """
    sources = {
        name: f"{ASSUMED}: joint {', '.join(map(str, numbers))}: {words}"
        for name, words in _WORDS.items()
        if (numbers := _without(robot, name))
    }
    joints = tuple(replace(joint, limits=_filled(joint.limits, joint.kind)) for joint in robot.joints)
    return replace(robot, joints=joints, sources={**robot.sources, **sources}) if sources else robot


_WORDS = {
    "position": "half a turn to either side; compare with the arm before you run a motion on it",
    "speed": f"{np.degrees(SPEED['revolute']):.0f} deg/s or {SPEED['prismatic']:g} m/s",
    "acceleration": f"{ACCELERATION:g} times the speed per second",
}
"""What is assumed of each limit."""


def _without(robot: Robot, name: str) -> list[int]:
    """Numbers of the joints without a limit; of positions those that turn alone."""
    return [
        number
        for number, joint in enumerate(robot.joints, 1)
        if np.isinf(getattr(joint.limits, name)).any() and (joint.revolute or name != "position")
    ]


def _filled(limits: Limits, kind: str) -> Limits:
    """Limits of one joint, those that are missing assumed."""
    low, high = limits.position
    if kind == "revolute" and np.isinf([low, high]).all():
        low, high = -np.pi, np.pi
    speed = SPEED[kind] if np.isinf(limits.speed) else limits.speed
    acceleration = ACCELERATION * speed if np.isinf(limits.acceleration) else limits.acceleration
    return replace(limits, position=(low, high), speed=speed, acceleration=acceleration)
