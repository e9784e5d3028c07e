"""Whether recordings are what they are taken for: one motion, one payload, the right signs."""

from collections.abc import Sequence

import numpy as np

from ...fit.estimate import Estimate
from ..evidence import Evidence
from ..finding import Finding, error, warning
from ..search import likely_causes

MISMATCH = 0.005
"""rad or m, rms: positions of a pair that differ by more are not one motion; real pairs lie below 2e-4."""
CHANGE = 0.10
"""Change of the mass, or of a first moment in units of the payload's M l, above which it is not one payload."""
CHANGE_SIGMAS = 20.0
"""Standard deviations by the formula that the change must exceed as well: on real data they are up to 4 times too
small, and the jackknife's hold the change itself."""
DRIVEN_SIGMAS = 5.0
"""Standard deviations below zero at which friction counts as negative."""
SUSPICIOUS = 0.1
"""Relative residual of some joint above which wrong assumptions are tried, even if all else looks well."""


def alignment(evidence: Evidence) -> list[Finding]:
    """Pairs that method 3 takes, although their positions differ."""
    worst = max(evidence.pairs, key=lambda pair: pair.rms_mismatch, default=None)
    if worst is None or worst.rms_mismatch <= MISMATCH:
        return []
    text = (
        f"{worst.unloaded.source} and {worst.loaded.source} differ by {1e3 * worst.rms_mismatch:.1f} mrad (rms) "
        "after alignment: method 3 takes them for one motion"
    )
    return [warning(text)]


def friction(evidence: Evidence) -> list[Finding]:
    """Joints whose Coulomb and viscous friction are both negative, as if it drove them instead of braking."""
    parameters = evidence.parameters
    if parameters is None:
        return []
    joints = [str(j) for j in range(1, evidence.robot.n + 1) if _drives(parameters, j)]
    if not joints:
        return []
    text = (
        f"the friction of joint {', '.join(joints)} comes out negative, as if it drove the joint: the sign of its "
        "torque or of its position is wrong"
    )
    return [error(text)]


def _drives(parameters: Estimate, joint: int) -> bool:
    names = tuple(name for name in (f"FS{joint}", f"FV{joint}") if name in parameters.names)
    if not names:
        return False
    values, C = parameters.select(names)
    return bool((values < -DRIVEN_SIGMAS * np.sqrt(np.diag(C))).all())


def steadiness(evidence: Evidence) -> list[Finding]:
    """A payload that changed, slipped, or torques that drifted while it was weighed."""
    stretches, free = evidence.stretches, evidence.best
    if len(stretches) < 2 or free is None:
        return []
    values = np.array([stretch.values for stretch in stretches])[:, 6:]
    sigma = np.array([np.sqrt(np.diag(stretch.covariance)) for stretch in stretches])[:, 6:]
    mass = float(np.median(values[:, 3]))
    length = float(np.sqrt(np.abs(free.estimate.values[[0, 3, 5]]).sum() / 2.0 / max(abs(mass), 1e-300)))
    size = abs(mass) * np.array([length, length, length, 1.0])
    low, high = values.argmin(axis=0), values.argmax(axis=0)
    change = np.ptp(values, axis=0)
    k = np.arange(4)
    noise = np.hypot(sigma[low, k], sigma[high, k])
    moved = change > np.maximum(CHANGE * size, CHANGE_SIGMAS * noise)
    if moved[3]:
        masses = ", ".join(f"{value:.3g}" for value in values[:, 3])
        text = (
            f"the mass changes during the loaded recording ({masses} kg, in the order of time): was the payload "
            "taken up or put down, or does a torque drift?"
        )
        return [error(text, "mass")]
    if moved[:3].any():
        axis = int(np.argmax(change[:3] / size[:3]))
        places = ", ".join(f"{1e3 * value:.0f}" for value in values[:, axis] / values[:, 3])
        text = (
            f"the centre of mass moves during the loaded recording ({'xyz'[axis]} at {places} mm, in the order of "
            "time): did the payload slip, or does a torque drift?"
        )
        return [error(text, "centre of mass")]
    return []


def causes(evidence: Evidence, findings: Sequence[Finding]) -> list[Finding]:
    """What most likely went wrong, where the recordings contradict the model; suggested, never corrected.

    Args:
        evidence: what was computed.
        findings: what the checks have found.
    """
    if evidence.source is None:
        return []
    contradicted = any(finding.severity == "error" for finding in findings)
    fits = [estimate.estimate.fit for estimate in evidence.modelled]
    fits += [evidence.robot_fit] if evidence.robot_fit is not None else []
    if not contradicted and not any(np.nanmax(fit.relative_per_joint) > SUSPICIOUS for fit in fits):
        return []
    return [cause.finding(cause.source) for cause in likely_causes(evidence.robot, evidence.source, contradicted)]
