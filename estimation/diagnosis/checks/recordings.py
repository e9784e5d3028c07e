"""Whether recordings are what they are taken for: of this robot, one motion, one payload, the right signs."""

from collections.abc import Sequence

import numpy as np

from ....common.arrays import Array
from ...fit.estimate import Estimate, Fit
from ..evidence import Evidence, by
from ..finding import Finding, error, warning
from ..search import likely_causes

RESIDUAL = 0.25
"""Relative residual of all joints above which the model does not describe the robot."""
JOINT_RESIDUAL = 0.5
"""Relative residual of one joint: on real and on noisy simulated robots good joints stay under 0.36."""
NOISE = 0.01
"""Of the largest joint torque's rms: what noise may be in any joint (real ones: 0.5 to 0.9 % of limits)."""
LOADED_RATIO = 3.0
"""Relative residual with payload over that without, above which the two recordings do not belong together."""
VALIDATION_RATIO = 2.0
"""Relative residual on held-out recordings over that of the fit above which the model does not carry over."""
VALIDATION_FLOOR = 0.06
"""Held-out residuals below this are good whatever the ratio."""


def told_per_joint(fit: Fit) -> Array:
    """Relative residual of each joint, shape (n,); 0 where what is left is no more than a torque's noise.

    A joint that carries next to no torque, such as the last one of an arm with sensors on the link side, leaves
    nearly all of it unexplained by noise alone: its own norm cannot judge it.
    """
    rows = np.maximum(np.array(fit.rows), 1)
    noise = NOISE * np.max(fit.torque_norms / np.sqrt(rows))
    return np.asarray(np.where(fit.error_norms / np.sqrt(rows) <= noise, 0.0, fit.relative_per_joint))


def fit_findings(fit: Fit, subject: str) -> list[Finding]:
    """Why a fit is too bad for its parameters to be used; empty if it is not."""
    if not fit.relative <= RESIDUAL:
        return [
            error(
                f"{subject} leaves {100 * fit.relative:.0f} % of the torque unexplained: check units, signs, order "
                "of joints and drive gains"
            )
        ]
    shares = told_per_joint(fit)
    joints = [str(j) for j, share in enumerate(shares, 1) if not share <= JOINT_RESIDUAL]
    if not joints:
        return []
    worst = np.max(shares)
    return [
        error(
            f"{subject} leaves up to {100 * worst:.0f} % of the torque of joint {', '.join(joints)} unexplained: "
            "check sign, unit and drive gain there, and whether the joint moved enough"
        )
    ]


def residual(evidence: Evidence) -> list[Finding]:
    """Level of the residual without payload, and with it."""
    fit = evidence.robot_fit
    if fit is None:
        return []
    findings = fit_findings(fit, "the robot's model without payload")
    for estimate in evidence.modelled:
        findings = findings or fit_findings(estimate.estimate.fit, f"method {estimate.method}")
    apart = [e for e in evidence.modelled if e.estimate.fit.relative > LOADED_RATIO * max(fit.relative, 0.01)]
    if apart:
        worst = max(e.estimate.fit.relative for e in apart)
        text = (
            f"{by(apart)} leaves {100 * worst:.0f} % of the torque with payload unexplained, without payload it "
            f"is {100 * fit.relative:.1f} %: check signs, and that both recordings are of one robot"
        )
        findings.append(error(text))
    return findings


def validation(evidence: Evidence) -> list[Finding]:
    """Residual of the robot's model on held-out recordings."""
    fit, held_out = evidence.robot_fit, evidence.validation
    if fit is None or held_out is None:
        return []
    if held_out.relative <= max(VALIDATION_FLOOR, VALIDATION_RATIO * fit.relative):
        return []
    text = (
        f"the robot's model leaves {100 * held_out.relative:.0f} % of the torque of the validation recording "
        f"unexplained, {100 * fit.relative:.1f} % of its own: it does not carry over to other motions"
    )
    return [error(text) if held_out.relative > RESIDUAL else warning(text)]


def unexplained(evidence: Evidence) -> list[Finding]:
    """A short weighing: torque that neither payload, friction nor the recording without payload explain."""
    if evidence.weighed is None:
        return []
    shares = evidence.weighed.unexplained
    joints = [str(j) for j, share in enumerate(shares, 1) if share > JOINT_RESIDUAL]
    if not joints:
        return []
    return [
        error(
            f"up to {100 * np.nanmax(shares):.0f} % of the torque of joint {', '.join(joints)} is not explained: "
            "check its sign, unit and drive gain, and that both recordings are of one motion"
        )
    ]


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
    if evidence.sampled is not None:
        return list(evidence.sampled.alignment)
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
        findings: what the checks have found.
    """
    if evidence.sampled is not None:
        return list(evidence.sampled.causes)
    if evidence.source is None:
        return []
    contradicted = any(finding.severity == "error" for finding in findings)
    fits = [estimate.estimate.fit for estimate in evidence.modelled]
    fits += [evidence.robot_fit] if evidence.robot_fit is not None else []
    if not contradicted and not any(np.nanmax(told_per_joint(fit)) > SUSPICIOUS for fit in fits):
        return []
    likely = likely_causes(evidence.robot, evidence.source, contradicted, evidence.gained is not None)
    return [cause.finding(cause.source) for cause in likely]
