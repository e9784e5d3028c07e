"""Whether the recordings are this robot's, its joints counted as described."""

import numpy as np

from ....model import Robot
from ..evidence import Evidence
from ..finding import Finding, error, note
from ..rivals import Rival

ROBOT, ROBOT_Z = 0.01, 2.0
"""Fraction by which chi2 falls with another robot, and Vuong's statistic, above which it is that robot's."""
ALIKE = 0.02
"""Fraction of chi2 within which two robots, or two joints turned round, are the same to the data."""
TURNED, TURNED_Z = 0.03, 3.0
"""The same of a joint that is counted the other way."""
BESIDE_PULL = 0.5
"""Share of what a pull at the flange takes off above which another robot, or a turned joint, is told beside it: of
a real pull others take off .06 at most, of another robot's recordings a pull takes off as much as that robot."""
LIGHT, HEAVY, WEIGHTLESS = 0.12, 0.40, 0.08
"""Weight that the torques show over the maker's: known arms lie from .19 to .31; below the last nothing is used."""


def other_robots(evidence: Evidence) -> list[Finding]:
    """The robot that explains the recordings best, if it is not the one described; else those that do as well."""
    robots = [rival for rival in evidence.rivals if rival.kind == "robot"]
    better = [rival for rival in robots if rival.fall > _least(evidence, ROBOT) and rival.z > ROBOT_Z]
    if better:
        best = max(better, key=lambda rival: rival.fall)
        return [_cause(f"it is a recording of robot {best.name!r}", best)]
    alike = [rival.name for rival in robots if rival.fall > -ALIKE]
    if not alike or evidence.pull is not None:
        return []
    names = " or ".join(map(repr, alike))
    return [
        note(f"the data do not tell {evidence.robot.name!r} from {names}: make sure that it is the right robot")
    ]


def turned_joints(evidence: Evidence) -> list[Finding]:
    """The joint that the recordings count the other way, or those of which it may be one."""
    least = _least(evidence, TURNED)
    turned = [
        rival for rival in evidence.rivals if rival.kind == "turned" and rival.fall > least and rival.z > TURNED_Z
    ]
    if not turned:
        return []
    turned.sort(key=lambda rival: -rival.fall)
    worst = turned[0]
    names = " or ".join(rival.name for rival in turned if rival.fall > worst.fall - ALIKE)
    return [_cause(f"joint {names} is counted the other way, in position and torque", worst)]


def _least(evidence: Evidence, fall: float) -> float:
    """Share of the squared residual that a rival must take off, beside a pull at the flange that stands out too."""
    return fall if evidence.pull is None else max(fall, BESIDE_PULL * evidence.pull.fall)


def _cause(words: str, rival: Rival) -> Finding:
    text = (
        f"the recordings look as if {words}: corrected for it, the squared residuals fall by "
        f"{100 * rival.fall:.0f} % ({rival.z:.1f} standard errors)"
    )
    return Finding("error", "everything", text, cause=True, explains=rival.fall)


def arm_weight(evidence: Evidence) -> list[Finding]:
    """The arm's weight by its torques against its mass by the maker: currents taken for torques show next to none.

    kappa = (h2 + h3) / (m L), h_j the first moment of link j and all that it carries about its axis, L the length
    of all links from joint 2 on; of seven axes h2 + h4 + h6. Not of arms whose springs carry them.
    """
    kappa = arm_weight_share(evidence)
    robot = evidence.robot
    if kappa is None or robot.mass is None:
        return []
    load = 0.0 if not np.isfinite(robot.rated_payload) else robot.rated_payload / robot.mass
    if LIGHT <= kappa <= HEAVY + load:
        return []
    source = " (assumed)" if robot.assumed("mass") else ""
    text = (
        f"the arm weighs {kappa:.2f} of its {robot.mass:g} kg{source} times the length of its links, .19 to .31 is "
        "usual: are the torques currents, motor-side or in another unit?"
    )
    return [error(text) if kappa < WEIGHTLESS else note(text)]


def arm_weight_share(evidence: Evidence) -> float | None:
    """kappa; None of other arms, or where their parameters are not known."""
    robot, parameters = evidence.robot, evidence.parameters
    if parameters is None or not robot.mass or robot.spring is not None or not _carries_itself(robot):
        return None
    names = [(f"MX{j}", f"MY{j}") for j in ((2, 3) if robot.n == 6 else (2, 4, 6))]
    if not {name for pair in names for name in pair} <= set(parameters.names):
        return None
    weight = sum(float(np.hypot(parameters[pair[0]], parameters[pair[1]])) for pair in names)
    return weight / (robot.mass * sum(float(np.hypot(joint.d, joint.r)) for joint in robot.joints[1:]))


def _carries_itself(robot: Robot) -> bool:
    """Whether it is an arm of six or seven axes that turn, under gravity."""
    return robot.n in (6, 7) and any(robot.gravity) and all(joint.revolute for joint in robot.joints)
