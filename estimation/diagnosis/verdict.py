"""Whether numbers may be used, and why: the table of checks, and what passes through it.

Each check is a function from the evidence to its findings, its thresholds beside it. A check that is added to the
table serves every command whose evidence shows what it looks at.
"""

from collections.abc import Callable

from ..equations.equations import Equations
from .checks.gains import known_gains, motors_apart, weights_apart
from .checks.joints import joints, shares_together
from .checks.loaded import burst, scale, sensitive
from .checks.nuisances import OF_ROBOT, late, mixtures, pulled, slipped, tilted, zeros_apart
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
    rating,
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
from .checks.robot import arm_weight, other_robots, turned_joints
from .evidence import Evidence, Sampled
from .finding import Finding, Level, Verdict, verdict_of

Check = Callable[[Evidence], list[Finding]]
CHECKS: tuple[Check, ...] = (
    pulled,
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
    shares_together,
    scale,
    sensitive,
    burst,
    zeros_apart,
    slipped,
    late,
    tilted,
    other_robots,
    turned_joints,
    arm_weight,
    contradictions,
    other_ways,
    drift,
    judged_com_and_inertia,
    steadiness,
    alignment,
    condition,
    inertia,
    weights_apart,
    known_gains,
    motors_apart,
)
"""Checks of the recordings, in the order in which their findings are reported."""
BEFOREHAND: tuple[Check, ...] = (rating, conflicts)
"""Checks of what was known beforehand: told after the causes, and no reason to look for any."""


def judge(evidence: Evidence, *more: Evidence) -> Verdict:
    """The verdict on numbers made from one set of recordings, or from several together."""
    findings = [finding for part in (evidence, *more) for finding in _findings(part)]
    partly: Level = "mass_and_com_only" if evidence.gained is None else "identified_only"
    return verdict_of(findings, evidence.weighed is None, partly)


def _findings(evidence: Evidence) -> list[Finding]:
    by_check = {check.__name__: check(evidence) for check in CHECKS}
    findings = [finding for own in by_check.values() for finding in own]
    raised = [name for name, own in by_check.items() if any(finding.severity != "note" for finding in own)]
    findings += [*mixtures(evidence, raised), *causes(evidence, findings)]
    return findings + [finding for check in BEFOREHAND for finding in check(evidence)]


def sampled(evidence: Evidence, verdict: Verdict, held_out: Equations | None) -> Sampled:
    """What the samples behind a verdict showed: all that equations cannot show again.

    Args:
        evidence: what the verdict looked at.
        verdict: causes are named in it whatever its level is.
        held_out: equations of recordings that were not fitted.
    """
    by_rivals = [finding for check in OF_ROBOT for finding in check(evidence)]
    likely = (finding for finding in verdict.findings if finding.cause and finding not in by_rivals)
    return Sampled(
        evidence.rivals,
        tuple(alignment(evidence)),
        tuple(likely),
        held_out,
        tuple(zeros_apart(evidence)),
        evidence.tilt,
        evidence.bursts,
        evidence.nuisances,
        evidence.scales,
        evidence.pulls,
    )


def robot_verdict(evidence: Evidence) -> Verdict:
    """The verdict on a robot's identified parameters."""
    fit = evidence.robot_fit
    findings = fit_findings(fit, "the model") if fit is not None else []
    return verdict_of([*findings, *(finding for check in OF_ROBOT for finding in check(evidence))])
