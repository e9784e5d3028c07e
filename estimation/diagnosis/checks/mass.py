"""Sign, uncertainty and agreement of the mass, and of the centre of mass."""

from itertools import combinations

import numpy as np

from ..evidence import Evidence, by
from ..finding import Finding, error, warning
from ..quantities import MASS_SIGMA, com_allowed

MASS_SPREAD = 0.05
"""Relative spread of the mass over the methods above which nothing should be used."""
APART = 0.02
"""Relative difference of two methods' masses that matters, if it also exceeds their intervals."""
SIGMAS = 4.0
"""Standard deviations beyond which a difference is none by chance."""
OTHER_WAY = 0.05
"""Relative difference of a weighing's mass by another way that speaks against all numbers."""


def sign(evidence: Evidence) -> list[Finding]:
    """A mass that is negative, or none at all."""
    negative = [e for e in evidence.estimates if e.mass < -SIGMAS * e.larger_sigma[9]]
    if negative:
        masses = ", ".join(f"{e.mass:.3g}" for e in negative)
        text = (
            f"{by(negative)} gives a negative mass ({masses} kg): the recordings with and without payload look "
            "swapped, or the signs of torques or of gravity are wrong"
        )
        return [error(text, "mass")]
    nothing = [e for e in evidence.estimates if e.mass <= SIGMAS * e.larger_sigma[9]]
    if not nothing:
        return []
    texts = ", ".join(f"{e.mass:.3g} ± {e.larger_sigma[9]:.2g}" for e in nothing)
    text = (
        f"{by(nothing)} gives a mass that does not differ from zero ({texts} kg): is the same load on the robot in "
        "both recordings?"
    )
    return [error(text, "mass")]


def weighed_sign(evidence: Evidence) -> list[Finding]:
    """A short weighing: a mass that is negative, or none at all."""
    weighed = evidence.weighed
    if weighed is None or weighed.from_scale or weighed.mass > SIGMAS * weighed.sigma:
        return []
    if weighed.mass < -SIGMAS * weighed.sigma:
        text = (
            f"the mass is negative ({weighed.mass:.3g} kg): the recordings with and without payload look swapped, "
            "or the signs of torques or of gravity are wrong"
        )
        return [error(text, "mass")]
    told = f"{weighed.mass:.3g} ± {weighed.sigma:.2g} kg"
    return [error(f"the mass does not differ from zero ({told}): is the payload on?", "mass")]


def methods_apart(evidence: Evidence) -> list[Finding]:
    """Masses of the methods that do not go together."""
    if not evidence.estimates:
        return []
    masses = np.array([e.mass for e in evidence.estimates])
    if np.ptp(masses) > MASS_SPREAD * abs(masses.mean()):
        return [error(f"the methods' masses spread from {masses.min():.3g} to {masses.max():.3g} kg", "mass")]
    for a, b in combinations(evidence.estimates, 2):
        sigma = float(np.hypot(a.larger_sigma[9], b.larger_sigma[9]))
        if abs(a.mass - b.mass) > max(APART * abs(masses.mean()), SIGMAS * sigma):
            text = (
                f"methods {a.method} and {b.method} disagree beyond their intervals: {a.mass:.4g} and "
                f"{b.mass:.4g} kg"
            )
            return [error(text, "mass")]
    return []


def uncertain(evidence: Evidence) -> list[Finding]:
    """Mass and centre of mass of the payload that is to be used, not measured well enough."""
    free = evidence.best
    if free is None:
        return []
    share = float(free.larger_sigma[9] / max(abs(free.mass), 1e-300))
    if not share <= MASS_SIGMA:
        text = (
            f"method {free.method} leaves the mass uncertain by {100 * share:.0f} % (1 sigma): move the arm's "
            "joints faster, farther or longer"
        )
        return [error(text, "mass")]
    if evidence.recommended is None:
        return []
    size, allowed = com_allowed(evidence.recommended.body.vector)
    axis = int(np.argmax(free.larger_sigma_com))
    sigma = float(free.larger_sigma_com[axis])
    if sigma <= allowed:
        return []
    text = (
        f"method {free.method} leaves the centre of mass uncertain by {1e3 * sigma:.0f} mm along {'xyz'[axis]} (1 "
        f"sigma), the payload being {1e3 * size:.0f} mm large: turn the wrist farther"
    )
    return [error(text, "centre of mass")]


def judged_mass(evidence: Evidence) -> list[Finding]:
    """A short weighing: the mass, not measured well enough."""
    if evidence.weighed is None or evidence.weighed.judged["mass"].use != "not measured well enough":
        return []
    return [error(f"mass: {evidence.weighed.judged['mass'].why}", "mass")]


def judged_com_and_inertia(evidence: Evidence) -> list[Finding]:
    """A short weighing: the other quantities that may not be used."""
    if evidence.weighed is None:
        return []
    findings = []
    for quantity, against in (("centre of mass", error), ("inertia", warning)):
        judged = evidence.weighed.judged[quantity]
        if judged.use != "use":
            findings.append(against(f"{quantity}: {judged.use}; {judged.why}", quantity))
    return findings


def other_ways(evidence: Evidence) -> list[Finding]:
    """A short weighing: the mass by other ways."""
    if evidence.weighed is None:
        return []
    mass = evidence.weighed.mass
    off = [way for way in evidence.weighed.agreement if way.counts and abs(way.mass - mass) > OTHER_WAY * abs(mass)]
    return [error(f"by the {way.name} the mass is {way.mass:.4g} kg, not {mass:.4g} kg", "mass") for way in off]


def drift(evidence: Evidence) -> list[Finding]:
    """A mass that changes steadily from recording to recording."""
    repeats = evidence.weighed.repeats if evidence.weighed is not None else None
    if repeats is None or not repeats.drifts or repeats.drift is None:
        return []
    step, sigma = repeats.drift
    text = f"the mass drifts by {step:+.3g} ± {sigma:.2g} kg from recording to recording: warm the robot up first"
    return [warning(text, "mass")]
