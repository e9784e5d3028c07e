"""Whether numbers may be used, and why: the table of checks.

A check that is added to the table serves every command whose evidence shows what it looks at.
"""

import sys
from collections.abc import Callable

import numpy as np

from . import checks, quantities
from .causes import SUSPICIOUS, likely_causes, other_readings
from .evidence import Evidence
from .finding import Finding, Level, Verdict, verdict_of
from .hypotheses import HYPOTHESES, hypotheses
from .joints import joints
from .scales import motors_apart, off_scale, scale, sensitive
from .states import states_of

Check = Callable[[Evidence], list[Finding]]
CHECKS: tuple[Check, ...] = (
    hypotheses,
    checks.residual,
    checks.validation,
    checks.friction,
    checks.sign,
    checks.methods_apart,
    checks.measured,
    checks.unexplained,
    joints,
    scale,
    off_scale,
    sensitive,
    checks.new_zeros,
    other_readings,
    checks.arm_weight,
    checks.other_ways,
    checks.drift,
    checks.steadiness,
    checks.alignment,
    checks.condition,
    checks.weights_apart,
    checks.known_gains,
    motors_apart,
)
"""Checks of the recordings, in the order in which their findings are reported."""
BEFOREHAND: tuple[Check, ...] = (checks.rating, checks.conflicts)
"""Checks of what was known beforehand: reported after the causes, and no reason to search any."""


def judge(*evidence: Evidence) -> Verdict:
    """Judge numbers made from one set of recordings, or from several together."""
    findings = [finding for part in evidence for finding in _findings(part)]
    partly: Level = "mass_and_com_only" if evidence[0].gained is None else "identified_only"
    return verdict_of(findings, evidence[0].best is not None, partly)


def _findings(evidence: Evidence) -> list[Finding]:
    findings = [finding for check in CHECKS for finding in check(evidence)]
    found = causes(evidence, any(finding.severity == "error" for finding in findings))
    # What stands out already must be outdone.
    explained = max((finding.explains for finding in findings), default=0.0)
    findings += [finding for finding in found if finding.explains > explained]
    return findings + [finding for check in BEFOREHAND for finding in check(evidence)]


def causes(evidence: Evidence, contradicted: bool) -> list[Finding]:
    """What most likely went wrong, where something speaks against the recordings; suggested, never corrected.

    Args:
        evidence: with the recordings themselves.
        contradicted: whether some check spoils all; else causes are searched where a joint leaves over 10 %.
    """
    if evidence.source is None:
        return []
    fits = [estimate.estimate.fit for estimate in evidence.modelled]
    fits += [evidence.parameters.fit] if evidence.parameters is not None else []
    if not contradicted and not any(np.nanmax(checks.relative_per_joint(fit)) > SUSPICIOUS for fit in fits):
        return []
    return likely_causes(evidence.robot, states_of(evidence.source), contradicted, evidence.gained is not None)


def table() -> list[tuple[str, str]]:
    """Every check: what it looks at, and from where on it says what; the documentation prints it."""
    rows = []
    for check in (*CHECKS, *BEFOREHAND):
        if check is hypotheses:
            rows += [(row.name, row.limits) for row in HYPOTHESES]
            continue
        what, _, limits = str(check.__doc__).partition("\n\n")
        constants = vars(quantities) | vars(sys.modules[check.__module__])
        rows.append((what, " ".join(limits.split()).format(**constants)))
    return rows
