"""Whether the recordings are this robot's, its joints counted as described."""

from ..evidence import Evidence
from ..finding import Finding, note
from ..rivals import Rival

ROBOT, ROBOT_Z = 0.01, 2.0
"""Fraction by which chi2 falls with another robot, and Vuong's statistic, above which it is that robot's."""
ALIKE = 0.02
"""Fraction of chi2 within which two robots cannot be told apart."""
TURNED, TURNED_Z = 0.03, 3.0
"""The same of a joint that is counted the other way."""


def other_robots(evidence: Evidence) -> list[Finding]:
    """The robot that explains the recordings best, if it is not the one described; else those that do as well."""
    robots = [rival for rival in evidence.rivals if rival.kind == "robot"]
    better = [rival for rival in robots if rival.fall > ROBOT and rival.z > ROBOT_Z]
    if better:
        best = max(better, key=lambda rival: rival.fall)
        return [_cause(f"it is a recording of robot {best.name!r}", best)]
    alike = [rival.name for rival in robots if rival.fall > -ALIKE]
    if not alike:
        return []
    names = " or ".join(map(repr, alike))
    return [
        note(f"the data do not tell {evidence.robot.name!r} from {names}: make sure that it is the right robot")
    ]


def turned_joints(evidence: Evidence) -> list[Finding]:
    """The joint that the recordings count the other way."""
    turned = [
        rival for rival in evidence.rivals if rival.kind == "turned" and rival.fall > TURNED and rival.z > TURNED_Z
    ]
    if not turned:
        return []
    worst = max(turned, key=lambda rival: rival.fall)
    return [_cause(f"joint {worst.name} is counted the other way, in position and torque", worst)]


def _cause(words: str, rival: Rival) -> Finding:
    text = (
        f"the recordings look as if {words}: with that undone the squared residuals fall by {100 * rival.fall:.0f} "
        f"% ({rival.z:.1f} standard errors)"
    )
    return Finding("error", "everything", text, cause=True)
