"""Whether a payload's numbers may be typed into a controller, and why."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from .estimate import Fit
from .payload import PayloadEstimate

Level = Literal["use", "mass_and_com_only", "do_not_use"]

MASS_SIGMA = 0.05
"""Relative standard deviation of the mass above which nothing should be used."""
MASS_SPREAD = 0.05
"""Relative spread of the mass over the methods above which nothing should be used."""
INERTIA_SIGMA = 0.30
"""Relative standard deviation of the inertia at the centre of mass above which it should not be used."""
RESIDUAL = 0.25
"""Relative residual of the robot without payload above which the model does not describe the robot."""


@dataclass(frozen=True)
class Verdict:
    """A level and the reasons for it, in words."""

    level: Level
    reasons: tuple[str, ...]


def verdict(estimates: Sequence[PayloadEstimate], robot_fit: Fit | None) -> Verdict:
    """Judge the payload estimates of one pair of recordings.

    Args:
        estimates: one per method.
        robot_fit: fit of the robot's own parameters, where they were identified.
    """
    severe: list[str] = []
    partial: list[str] = []
    if robot_fit is not None and robot_fit.relative > RESIDUAL:
        severe.append(
            f"the robot's model leaves {100 * robot_fit.relative:.0f} % of the torque unexplained: check units, "
            "signs, order of joints and drive gains"
        )
    masses = np.array([estimate.mass for estimate in estimates])
    if np.ptp(masses) > MASS_SPREAD * abs(masses.mean()):
        severe.append(f"the methods' masses spread from {masses.min():.3g} to {masses.max():.3g} kg")
    for estimate in estimates:
        severe += _mass_reasons(estimate)
        partial += _inertia_reasons(estimate)
    if severe:
        return Verdict("do_not_use", tuple(severe))
    if partial:
        return Verdict("mass_and_com_only", tuple(partial))
    return Verdict("use", ())


def _mass_reasons(estimate: PayloadEstimate) -> list[str]:
    sigma = float(estimate.estimate.sigma[9])
    if estimate.mass <= 0.0:
        return [f"method {estimate.method}: the mass is not positive ({estimate.mass:.3g} kg)"]
    if sigma > MASS_SIGMA * estimate.mass:
        return [f"method {estimate.method}: the mass is uncertain by {100 * sigma / estimate.mass:.0f} % (1 sigma)"]
    return []


def _inertia_reasons(estimate: PayloadEstimate) -> list[str]:
    if not estimate.body.mass > 0.0:
        return []
    if not estimate.body.physically_consistent:
        return [
            f"method {estimate.method}: no body has this inertia (smallest pseudo-inertia eigenvalue "
            f"{estimate.body.min_pseudo_inertia_eigenvalue:.2g})"
        ]
    moments = np.diag(estimate.body.inertia_com)
    relative = float((np.diag(estimate.sigma_inertia_com) / moments).max())
    if relative > INERTIA_SIGMA:
        return [
            f"method {estimate.method}: the inertia at the centre of mass is uncertain by {100 * relative:.0f} % "
            "(1 sigma)"
        ]
    return []
