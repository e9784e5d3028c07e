"""Friction that drives a joint instead of braking it: a sign is wrong."""

import numpy as np

from ...fit.estimate import Estimate
from .reasons import Evidence, Reason, against_all

SIGMAS = 5.0
"""Standard deviations below zero at which friction counts as negative."""


def friction_reasons(evidence: Evidence) -> list[Reason]:
    """Joints whose Coulomb and viscous friction are both negative."""
    robot = evidence.robot
    if robot is None:
        return []
    joints = [j for j in range(1, evidence.problem.robot.n + 1) if _drives(robot, j)]
    if not joints:
        return []
    named = ", ".join(map(str, joints))
    return [
        against_all(
            f"the friction of joint {named} comes out negative, as if it drove the joint: the sign of its torque "
            "or of its position is wrong"
        )
    ]


def _drives(robot: Estimate, joint: int) -> bool:
    names = [name for name in (f"FS{joint}", f"FV{joint}") if name in robot.names]
    if not names:
        return False
    values, C = robot.select(tuple(names))
    return bool((values < -SIGMAS * np.sqrt(np.diag(C))).all())
