"""Whether a payload's numbers may be typed into a controller, and why."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from .estimate import Fit
from .payload.constrained import ConstrainedPayload
from .payload.result import PayloadEstimate

Level = Literal["use", "mass_and_com_only", "do_not_use"]

MASS_SIGMA = 0.05
"""Relative standard deviation of the mass above which nothing should be used."""
MASS_SPREAD = 0.05
"""Relative spread of the mass over the methods above which nothing should be used."""
INERTIA_SIGMA = 0.30
"""Relative standard deviation of the inertia at the centre of mass above which it should not be used."""
RESIDUAL = 0.25
"""Relative residual of all joints above which the model does not describe the robot."""
JOINT_RESIDUAL = 0.5
"""The same for a single joint: on real and on noisy simulated robots good joints stay under 0.36."""
LOADED_RATIO = 3.0
"""Relative residual with payload over that without, above which the two recordings do not belong together."""


@dataclass(frozen=True)
class Verdict:
    """A level and the reasons for it, in words."""

    level: Level
    reasons: tuple[str, ...]


def verdict(
    estimates: Sequence[PayloadEstimate], robot_fit: Fit | None, constrained: Sequence[ConstrainedPayload] = ()
) -> Verdict:
    """Judge the payload estimates of one pair of recordings.

    Args:
        estimates: one per method.
        robot_fit: fit of the robot's own parameters, where they were identified.
        constrained: the payloads that hold the constraints, one per method.
    """
    severe = _residual_reasons(robot_fit, estimates) + _mass_reasons(estimates) + _conflict_reasons(constrained)
    if severe:
        return Verdict("do_not_use", tuple(severe))
    partial = _inertia_reasons(estimates)
    return Verdict("mass_and_com_only", tuple(partial)) if partial else Verdict("use", ())


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


def _residual_reasons(fit: Fit | None, estimates: Sequence[PayloadEstimate]) -> list[str]:
    if fit is None:
        return []
    reasons = fit_reasons(fit, "the robot's model without payload")
    # Method 3 has no model of the robot: its residual is that of a torque difference.
    modelled = [e for e in estimates if e.method != 3]
    for estimate in modelled:
        if not reasons:
            reasons = fit_reasons(estimate.estimate.fit, f"method {estimate.method}")
    apart = [e for e in modelled if e.estimate.fit.relative > LOADED_RATIO * max(fit.relative, 0.01)]
    if apart:
        worst = max(e.estimate.fit.relative for e in apart)
        reasons.append(
            f"{_by(apart)} leaves {100 * worst:.0f} % of the torque with payload unexplained, without payload it "
            f"is {100 * fit.relative:.1f} %: check signs, and that both recordings are of one robot"
        )
    return reasons


def _mass_reasons(estimates: Sequence[PayloadEstimate]) -> list[str]:
    masses = np.array([estimate.mass for estimate in estimates])
    reasons = [
        f"{_by([e])} gives a mass of {e.mass:.3g} kg, not a positive one" for e in estimates if e.mass <= 0.0
    ]
    if np.ptp(masses) > MASS_SPREAD * abs(masses.mean()):
        reasons.append(f"the methods' masses spread from {masses.min():.3g} to {masses.max():.3g} kg")
    vague = [e for e in estimates if e.larger_sigma[9] > MASS_SIGMA * abs(e.mass)]
    if vague:
        worst = max(e.larger_sigma[9] / abs(e.mass) for e in vague)
        reasons.append(f"{_by(vague)} leaves the mass uncertain by {100 * worst:.0f} % (1 sigma)")
    return reasons


def _conflict_reasons(constrained: Sequence[ConstrainedPayload]) -> list[str]:
    """Constraints and weighed masses that contradict the data, each once."""
    reasons: dict[str, str] = {}
    for payload in constrained:
        for one in payload.conflicts:
            text = f"the data of method {payload.method} contradict the constraint: {one.constraint.description}"
            reasons.setdefault(one.constraint.description, f"{text} (p {one.p_value:.1g})")
        for weighing in payload.weighings:
            if weighing.conflict:
                text = f"method {payload.method} identifies {weighing.identified:.4g} kg, weighed were"
                apart = f"{weighing.mass:g} kg: {abs(weighing.z):.1f} sigma apart"
                reasons.setdefault(f"weighed {weighing.mass}", f"{text} {apart}")
    together = [payload for payload in constrained if payload.conflict]
    if together and not reasons:
        worst = min(payload.p_value for payload in together)
        reasons[""] = f"the constraints together contradict the data (p {worst:.1g})"
    return list(reasons.values())


def _inertia_reasons(estimates: Sequence[PayloadEstimate]) -> list[str]:
    impossible = [e for e in estimates if not e.body.physically_consistent]
    vague = [e for e in estimates if e.body.physically_consistent and _inertia_sigma(e) > INERTIA_SIGMA]
    reasons = []
    if impossible:
        worst = min(e.body.min_pseudo_inertia_eigenvalue for e in impossible)
        reasons.append(
            f"no body has the inertia that {_by(impossible)} gives (pseudo-inertia eigenvalue {worst:.2g})"
        )
    if vague:
        worst = max(_inertia_sigma(e) for e in vague)
        reasons.append(f"{_by(vague)} leaves the inertia at the centre of mass uncertain by {100 * worst:.0f} %")
    return reasons


def _inertia_sigma(estimate: PayloadEstimate) -> float:
    """Largest relative standard deviation of the moments of inertia at the centre of mass."""
    return float((np.diag(estimate.larger_sigma_inertia_com) / np.diag(estimate.body.inertia_com)).max())


def _by(estimates: Sequence[PayloadEstimate]) -> str:
    numbers = ", ".join(str(estimate.method) for estimate in estimates)
    return f"method {numbers}" if len(estimates) == 1 else f"each of methods {numbers}"
