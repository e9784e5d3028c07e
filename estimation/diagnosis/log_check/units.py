"""Positions that are no radians on the joint side."""

import numpy as np

from ....common.arrays import Array
from ....model import Recording, Robot
from .finding import Finding

_MARGIN = 0.1  # of the range
_MOVES = 1e-3  # rad


def position_findings(robot: Robot, recording: Recording) -> list[Finding]:
    """Degrees, turns of a motor, or another zero, where positions leave the robot's range."""
    revolute = [j for j, joint in enumerate(robot.joints) if joint.revolute]
    outside = [j for j in revolute if not _fits(robot, recording.q, j, 1.0)]
    if not outside:
        return []
    named = ", ".join(f"q{j + 1}" for j in outside)
    start = f"{named} leave the range of {robot.name}'s joints."
    moving = [j for j in revolute if np.ptp(recording.q[:, j]) > _MOVES]
    if 2 * len(outside) < len(moving):
        advice = "Another zero, sense or order of joints there: give zero_deg, sign or joints in a log map"
    elif all(_fits(robot, recording.q, j, np.pi / 180.0) for j in revolute):
        advice = "All positions fit it as degrees: --units q=deg; if they are a motor's, give [motor] gear_ratios"
    else:
        advice = "No joint turns so far: looks like the motor side; give [motor] gear_ratios and side in a log map"
    return [Finding("error", f"{start} {advice}")]


def _fits(robot: Robot, q: Array, j: int, factor: float) -> bool:
    low, high = robot.joints[j].limits.position
    low, high = max(low, -4 * np.pi), min(high, 4 * np.pi)
    margin = _MARGIN * (high - low)
    values = q[:, j] * factor
    return bool(values.min() >= low - margin and values.max() <= high + margin)
