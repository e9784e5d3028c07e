"""Mass, centre of mass and inertia: sign, uncertainty, agreement, and what was known beforehand."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from ....model import INERTIAL
from ...payload.constrained import ConstrainedPayload
from ...possible.constraints import PossibleBody
from ..evidence import Evidence, by
from ..finding import Finding, error, note, warning
from ..quantities import MASS_SIGMA, com_allowed, vague_moments

MASS_SPREAD = 0.05
"""Relative spread of the mass over the methods above which nothing should be used."""
APART = 0.02
"""Relative difference of two methods' masses that matters, if it also exceeds their intervals."""
SIGMAS = 4.0
"""Standard deviations beyond which a difference is none by chance."""
TOLD = 1.96
"""Standard deviations to either end of a 95 % interval."""
_ROUNDED = 0.02
"""Share by which a mass may pass the rated payload: data sheets round, and a given mass may be the rated one."""
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
    mass = f"{weighed.mass:.3g} ± {weighed.sigma:.2g} kg"
    return [error(f"the mass does not differ from zero ({mass}): is the payload on?", "mass")]


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
    free, spread = evidence.best, evidence.spread
    if free is None or spread is None:
        return []
    share = spread.mass / max(abs(free.mass), 1e-300)
    if not share <= MASS_SIGMA:
        text = (
            f"method {free.method} leaves the mass uncertain by {100 * share:.0f} % (1 sigma): move the arm's "
            "joints faster, farther or longer"
        )
        return [error(text, "mass")]
    if evidence.recommended is None:
        return []
    size, allowed = com_allowed(evidence.recommended.body.vector)
    axis = int(np.argmax(spread.com))
    sigma = float(spread.com[axis])
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
    across = abs(step) * (len(repeats.masses) - 1)
    if evidence.spread is not None and across <= 2.0 * 1.96 * evidence.spread.mass:
        return [note(f"{text}; the interval of the mass allows for it", "mass")]
    return [error(text, "mass")]


OWN_SIZE = 0.3
"""Standard deviation, in units of the payload's own M l^2, above which the motion does not show a parameter."""
CONDITION = 500.0
"""Condition number with columns scaled above which small errors spoil the answer; good motions have 10."""


def inertia(evidence: Evidence) -> list[Finding]:
    """Against the inertia, judged on the payload that is to be used."""
    payload, spread = evidence.recommended, evidence.spread
    if payload is None or spread is None:
        return []
    moments = np.diag(payload.body.inertia_com)
    moments = np.maximum(moments, 1e-12 * max(float(moments.max()), 1e-300))
    vague = vague_moments(moments, spread.moments)
    if not vague:
        return []
    shares = ", ".join(f"{name} by {_percent(share)}" for name, share in vague)
    text = f"the inertia at the centre of mass is not determined (method {payload.method}, 1 sigma: {shares})"
    hidden = _unseen(payload)
    if hidden:
        text += f"; in units of the payload's own size the motion hardly shows {', '.join(hidden)}"
    return [warning(f"{text}: use mass and centre of mass, or move the wrist faster")]


def _unseen(payload: ConstrainedPayload) -> list[str]:
    """Inertia parameters whose deviation is large against M l^2, l the payload's own radius of gyration."""
    size = max(float(np.trace(payload.body.inertia_com)) / 2.0, 1e-300)
    sigmas = payload.free.larger_sigma[:6]
    return [kind for kind, sigma in zip(INERTIAL, sigmas, strict=False) if sigma > OWN_SIZE * size]


def condition(evidence: Evidence) -> list[Finding]:
    """Nearly dependent equations."""
    if evidence.condition is None or evidence.condition <= CONDITION:
        return []
    text = (
        f"the equations are nearly dependent (condition number {evidence.condition:.0f} with columns scaled): move "
        "more joints at once, over a wider range"
    )
    return [warning(text)]


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share < 10.0 else "more than its size tenfold"


def rating(evidence: Evidence) -> list[Finding]:
    """A mass that lies beyond what the arm carries, with all of its interval and by more than data sheets round."""
    rated, sigma = evidence.robot.rated_payload, evidence.spread.mass if evidence.spread is not None else 0.0
    if not evidence.mass - TOLD * sigma > (1.0 + _ROUNDED) * rated:
        return []
    source = "as is assumed" if evidence.robot.assumed("rated_payload") else "by its data sheet"
    text = (
        f"a mass of {evidence.mass:.4g} kg is more than the {rated:g} kg that this arm carries {source}: "
        "are the torques, the drive gains and the robot's description right?"
    )
    return [error(text, "mass")]


def conflicts(evidence: Evidence) -> list[Finding]:
    """Constraints and weighed masses that contradict the data, and bounds that hold the answer back; each once."""
    if evidence.weighed is not None:
        return []
    findings: dict[str, Finding] = {}
    for payload in evidence.constrained:
        for key, finding in _against(payload):
            findings.setdefault(key, finding)
    together = [payload for payload in evidence.constrained if payload.conflict]
    if together and not findings:
        worst = min(payload.p_value for payload in together)
        findings[""] = error(f"the constraints together contradict the data (p {worst:.1g})")
    if evidence.recommended is not None:
        for key, finding in _holding(evidence.recommended):
            findings.setdefault(key, finding)
    return list(findings.values())


def contradictions(evidence: Evidence) -> list[Finding]:
    """A short weighing: the scale and what else was known beforehand against the torques."""
    if evidence.weighed is None or not evidence.constrained:
        return []
    (payload,) = evidence.constrained
    findings = [
        error(
            f"the torques show {weighing.identified:.4g} ± {weighing.identified_sigma:.2g} kg, the scale "
            f"{weighing.mass:g} ± {weighing.sigma:g} kg: {abs(weighing.z):.1f} sigma apart; check the drive gains "
            "and the scale"
        )
        for weighing in payload.weighings
        if weighing.conflict
    ]
    contradicted = [test.constraint.description for test in payload.conflicts]
    findings += [error(f"the torques contradict: {description}") for description in contradicted]
    if not findings and payload.conflict:
        findings.append(error(f"what is known beforehand contradicts the torques (p {payload.p_value:.1g})"))
    return findings + [finding for key, finding in _holding(payload) if key not in contradicted]


def _against(payload: ConstrainedPayload) -> Iterator[tuple[str, Finding]]:
    """What contradicts the data of one method, and by what it is known again with the next."""
    for test in payload.conflicts:
        description = test.constraint.description
        text = f"the data of method {payload.method} contradict the constraint: {description}"
        yield description, error(f"{text} (p {test.p_value:.1g})")
    for weighing in payload.weighings:
        if weighing.conflict:
            text = f"method {payload.method} identifies {weighing.identified:.4g} kg, the scale shows"
            apart = f"{weighing.mass:g} kg: {abs(weighing.z):.1f} sigma apart"
            yield f"weighed {weighing.mass}", error(f"{text} {apart}", "mass")


def _holding(payload: ConstrainedPayload) -> Iterator[tuple[str, Finding]]:
    """Active constraints; that the body must exist is no bound that someone set."""
    for test in payload.tested:
        if not isinstance(test.constraint, PossibleBody):
            description = test.constraint.description
            yield description, warning(f"the answer is held at a bound that was given: {description}")
