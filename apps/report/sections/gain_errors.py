"""What errors of the drive gains do to other answers."""

import numpy as np

from ....estimation import Gains
from ....model import Robot


def scales_in_words(robot: Robot) -> str:
    """What a robot's torques are to scale by: torque sensors on the link side have scales, motors have gains."""
    return "scales of the torque sensors" if robot.drives.side == "link" else "drive gains"


def gain_error_notes(robot: Robot, gains: Gains | None, subject: str = "Intervals") -> list[str]:
    """What ``subject`` hold of the gains' errors, and what else there is to know of them."""
    scales, each = scales_in_words(robot), "motor" if robot.coupling else "joint"
    if gains is None:
        return [f"{scales.capitalize()} are taken as exact: --gain-sigma 2% adds what no residual shows."]
    if gains.identified:
        sigmas = np.sqrt(np.diag(gains.covariance(len(gains.identified))))
        percents = ", ".join(f"{100.0 * sigma:.2g}" for sigma in sigmas)
        line = f"{subject} include errors of the drive gains as they were identified: {percents} % per {each}."
    else:
        percents = ", ".join(f"{100.0 * sigma:g}" for sigma in gains.per_joint)
        common = f" and {100.0 * gains.common:g} % common to all joints" if gains.common else ""
        line = f"{subject} include errors of the {scales}: {percents} % per {each}{common}."
    return [line, *gains.notes]
