"""What was known beforehand against what the data say."""

from ...possible.constraints import PossibleBody
from .reasons import Evidence, Reason, against_all, against_inertia


def constraint_reasons(evidence: Evidence) -> list[Reason]:
    """Constraints and weighed masses that contradict the data, and bounds that hold the answer back; each once."""
    reasons: dict[str, Reason] = {}
    for payload in evidence.constrained:
        for one in payload.conflicts:
            text = f"the data of method {payload.method} contradict the constraint: {one.constraint.description}"
            reasons.setdefault(one.constraint.description, against_all(f"{text} (p {one.p_value:.1g})"))
        for weighing in payload.weighings:
            if weighing.conflict:
                text = f"method {payload.method} identifies {weighing.identified:.4g} kg, weighed were"
                apart = f"{weighing.mass:g} kg: {abs(weighing.z):.1f} sigma apart"
                reasons.setdefault(f"weighed {weighing.mass}", against_all(f"{text} {apart}"))
    together = [payload for payload in evidence.constrained if payload.conflict]
    if together and not reasons:
        worst = min(payload.p_value for payload in together)
        reasons[""] = against_all(f"the constraints together contradict the data (p {worst:.1g})")
    for one in evidence.recommended.tested if evidence.recommended is not None else ():
        # That the body must exist is no bound that someone set.
        if not isinstance(one.constraint, PossibleBody):
            text = f"the answer is held at a bound that was given: {one.constraint.description}"
            reasons.setdefault(one.constraint.description, against_inertia(text))
    return list(reasons.values())
