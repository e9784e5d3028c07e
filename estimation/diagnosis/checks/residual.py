"""How much of the torques the models leave unexplained."""

import numpy as np

from ...fit.estimate import Fit
from ..evidence import Evidence, by
from ..finding import Finding, error, warning

RESIDUAL = 0.25
"""Relative residual of all joints above which the model does not describe the robot."""
JOINT_RESIDUAL = 0.5
"""Relative residual of one joint: on real and on noisy simulated robots good joints stay under 0.36."""
LOADED_RATIO = 3.0
"""Relative residual with payload over that without, above which the two recordings do not belong together."""
VALIDATION_RATIO = 2.0
"""Relative residual on held-out recordings over that of the fit above which the model does not carry over."""
VALIDATION_FLOOR = 0.06
"""Held-out residuals below this are good whatever the ratio."""


def fit_findings(fit: Fit, subject: str) -> list[Finding]:
    """Why a fit is too bad for its parameters to be used; empty if it is not."""
    if not fit.relative <= RESIDUAL:
        return [
            error(
                f"{subject} leaves {100 * fit.relative:.0f} % of the torque unexplained: check units, signs, order "
                "of joints and drive gains"
            )
        ]
    joints = [str(j) for j, share in enumerate(fit.relative_per_joint, 1) if not share <= JOINT_RESIDUAL]
    if not joints:
        return []
    worst = np.max(fit.relative_per_joint)
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
