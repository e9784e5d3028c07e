"""Whether numbers may be used, and why: the table of checks, and what passes through it.

Each check is a function from the evidence to its findings, its thresholds beside it. A check that is added to the
table serves every command whose evidence shows what it looks at.
"""

from collections.abc import Callable

from ..fit.estimate import Fit
from .checks.joints import joints
from .checks.payload import (
    condition,
    conflicts,
    contradictions,
    drift,
    inertia,
    judged_com_and_inertia,
    judged_mass,
    methods_apart,
    other_ways,
    sign,
    uncertain,
    weighed_sign,
)
from .checks.recordings import (
    alignment,
    causes,
    fit_findings,
    friction,
    residual,
    steadiness,
    unexplained,
    validation,
)
from .evidence import Evidence
from .finding import Finding, Verdict, verdict_of

Check = Callable[[Evidence], list[Finding]]
CHECKS: tuple[Check, ...] = (
    residual,
    validation,
    friction,
    judged_mass,
    sign,
    weighed_sign,
    methods_apart,
    uncertain,
    unexplained,
    joints,
    contradictions,
    other_ways,
    drift,
    judged_com_and_inertia,
    steadiness,
    alignment,
    condition,
    inertia,
)
"""Checks of the recordings, in the order in which their findings are told."""
BEFOREHAND: tuple[Check, ...] = (conflicts,)
"""Checks of what was known beforehand: told after the causes, and no reason to look for any."""


def judge(evidence: Evidence) -> Verdict:
    """The verdict on numbers made from one set of recordings."""
    findings = [finding for check in CHECKS for finding in check(evidence)]
    findings += causes(evidence, findings)
    findings += [finding for check in BEFOREHAND for finding in check(evidence)]
    return verdict_of(findings, brief=evidence.weighed is None)


def robot_verdict(fit: Fit) -> Verdict:
    """The verdict on a robot's identified parameters."""
    return verdict_of(fit_findings(fit, "the model"))
