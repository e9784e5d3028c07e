"""How much of the torques the models leave unexplained."""

import numpy as np

from ...fit.estimate import Fit
from .reasons import Evidence, Reason, against_all, against_inertia, by

RESIDUAL = 0.25
"""Relative residual of all joints above which the model does not describe the robot."""
JOINT_RESIDUAL = 0.5
"""The same for a single joint: on real and on noisy simulated robots good joints stay under 0.36."""
LOADED_RATIO = 3.0
"""Relative residual with payload over that without, above which the two recordings do not belong together."""
VALIDATION_RATIO = 2.0
"""Relative residual on held-out recordings over that of the fit above which the model does not carry over."""
VALIDATION_FLOOR = 0.06
"""Held-out residuals below this are good whatever the ratio."""


def fit_reasons(fit: Fit, subject: str) -> list[str]:
    """Why a fit is too bad for its parameters to be used; empty if it is not."""
    reasons = []
    if not fit.relative <= RESIDUAL:
        reasons.append(
            f"{subject} leaves {100 * fit.relative:.0f} % of the torque unexplained: check units, signs, order of "
            "joints and drive gains"
        )
    joints = [j for j, share in enumerate(fit.relative_per_joint, 1) if not share <= JOINT_RESIDUAL]
    if joints and not reasons:
        worst = np.max(fit.relative_per_joint)
        reasons.append(
            f"{subject} leaves up to {100 * worst:.0f} % of the torque of joint {', '.join(map(str, joints))} "
            "unexplained: check sign, unit and drive gain there, and whether the joint moved enough"
        )
    return reasons


def residual_reasons(evidence: Evidence) -> list[Reason]:
    """Level of the residual without and with payload, and on held-out recordings."""
    fit = evidence.robot_fit
    if fit is None:
        return []
    reasons = fit_reasons(fit, "the robot's model without payload")
    # Method 3 has no model of the robot: its residual is that of a torque difference.
    modelled = [e for e in evidence.estimates if e.method != 3]
    for estimate in modelled:
        if not reasons:
            reasons = fit_reasons(estimate.estimate.fit, f"method {estimate.method}")
    apart = [e for e in modelled if e.estimate.fit.relative > LOADED_RATIO * max(fit.relative, 0.01)]
    if apart:
        worst = max(e.estimate.fit.relative for e in apart)
        reasons.append(
            f"{by(apart)} leaves {100 * worst:.0f} % of the torque with payload unexplained, without payload it "
            f"is {100 * fit.relative:.1f} %: check signs, and that both recordings are of one robot"
        )
    return [*map(against_all, reasons), *_validation_reasons(fit, evidence.validation)]


def _validation_reasons(fit: Fit, validation: Fit | None) -> list[Reason]:
    if validation is None or validation.relative <= max(VALIDATION_FLOOR, VALIDATION_RATIO * fit.relative):
        return []
    text = (
        f"the robot's model leaves {100 * validation.relative:.0f} % of the torque of the validation recording "
        f"unexplained, {100 * fit.relative:.1f} % of its own: it does not carry over to other motions"
    )
    return [against_all(text) if validation.relative > RESIDUAL else against_inertia(text)]
