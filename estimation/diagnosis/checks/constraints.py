"""What was known beforehand against what the data say."""

from collections.abc import Iterator

from ...payload.constrained import ConstrainedPayload
from ...possible.constraints import PossibleBody
from ..evidence import Evidence
from ..finding import Finding, error, warning


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
            text = f"method {payload.method} identifies {weighing.identified:.4g} kg, weighed were"
            apart = f"{weighing.mass:g} kg: {abs(weighing.z):.1f} sigma apart"
            yield f"weighed {weighing.mass}", error(f"{text} {apart}", "mass")


def _holding(payload: ConstrainedPayload) -> Iterator[tuple[str, Finding]]:
    """Active constraints; that the body must exist is no bound that someone set."""
    for test in payload.tested:
        if not isinstance(test.constraint, PossibleBody):
            description = test.constraint.description
            yield description, warning(f"the answer is held at a bound that was given: {description}")
