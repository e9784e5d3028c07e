"""Diagnosis of recordings and verdict on numbers, the same for every command.

A check that is added to the table serves every command whose evidence shows what it looks at.
"""

import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from ...model import Robot
from ...model.base import friction_columns
from ..fit.covariance import NORMAL95
from ..fit.estimate import Gains, error_model
from ..payload.by_joints import payload_by_joints
from ..payload.long_motion import prior_of
from ..payload.methods import PayloadEstimate, PayloadProblem, moved
from ..payload.short_motion import ShortMotion, StaticMotion
from . import checks
from .causes import SUSPICIOUS, alternatives, likely_causes, other_readings
from .engine import BLOCKS, States, System, states_of
from .evidence import Evidence, Finding, Level, Verdict
from .hypotheses import HYPOTHESES, effects_of, hypotheses, matter, tilt_correction
from .scales import beyond, disagreement, joints, nominal_gravity, scale, scales, weight

Check = Callable[[Evidence], Iterable[Finding]]
CHECKS: tuple[Check, ...] = (
    hypotheses,
    weight,
    checks.residual,
    checks.parameters,
    checks.masses,
    checks.measured,
    joints,
    scale,
    checks.new_zeros,
    other_readings,
    checks.other_ways,
    checks.rests,
    checks.excitation,
    checks.gains,
)
"""Checks of the recordings, in the order in which their findings are reported."""
COLUMNS: tuple[Check, ...] = (hypotheses, joints, scale, other_readings)
"""Checks that say nothing where signs, units or mounting go against the weight of the links."""
BEFOREHAND: tuple[Check, ...] = (checks.conflicts,)
"""Checks of what was known beforehand: reported after the causes, and no reason to search any."""
_OUTDONE = 1.5
"""A cause that leaves so many times the squared residual of the best one is not reported: a turned joint may look
like another robot."""


def judge(*evidence: Evidence) -> Verdict:
    """Judge numbers made from one set of recordings, or from several together."""
    findings = list[Finding]()
    for part in evidence:
        short, wrong = list(checks.too_short(part)), any(finding.cause for finding in weight(part))
        speaking = [check for check in CHECKS if not (wrong and check in COLUMNS)]
        own, likely = short or [finding for check in speaking for finding in check(part)], list[Finding]()
        # Where no check spoils all, causes are searched if a joint leaves too much; suggested, never corrected.
        contradicted = any(finding.severity == "error" for finding in own)
        fits = [estimate.estimate.fit for estimate in part.estimates if estimate.method != 3]
        fits += [part.parameters.fit] if part.parameters is not None else []
        left = [checks.relative_per_joint(fit, part) for fit in fits if any(fit.rows)]
        suspicious = contradicted or any(np.nanmax(relative) > SUSPICIOUS for relative in left)
        if part.source is not None and suspicious and not (short or wrong):
            likely = likely_causes(part.robot, states_of(part.source), contradicted, part.gained is not None)
        # What stands out already must be outdone.
        explained = max((finding.explains for finding in own if finding.cause), default=0.0)
        findings += own + [finding for finding in likely if finding.explains > explained]
        findings += [finding for check in BEFOREHAND for finding in check(part)]
    against = [finding for finding in findings if finding.severity != "note"]
    if len(against) > 1:  # a robot that cannot exist, beside any other sign
        findings = [one._replace(severity="error") if one.about == checks.IMPOSSIBLE else one for one in findings]
    partly: Level = "mass_and_com_only" if evidence[0].gained is None else "identified_only"
    return verdict_of(findings, evidence[0].best is not None, partly)


def verdict_of(findings: Sequence[Finding], brief: bool = True, partly: Level = "mass_and_com_only") -> Verdict:
    """Make the verdict of findings, in the order in which they are reported: those that explain most first.

    Where no number may be used, what spoils single ones and is no cause is left out if ``brief``, else last.
    ``partly``: the level where only single numbers are spoilt.
    """

    def rank(finding: Finding) -> tuple[float, bool]:
        # Of equal causes that of all recordings comes first; what takes off too little to be a cause comes last.
        if finding not in causes:
            return 3.0 if finding.explains else 2.0, False
        return 1.0 - round(finding.explains, 2), finding.about != "everything"

    distinct, level = list(dict.fromkeys(findings)), partly
    notes = [finding for finding in distinct if finding.severity == "note"]
    causes = [finding for finding in distinct if finding.cause and finding.severity == "error"]
    most = _OUTDONE * min((1.0 - finding.explains for finding in causes), default=1.0)
    outdone = [one for one in distinct if one.cause and one.about == "everything" and 1.0 - one.explains > most]
    against = [finding for finding in distinct if finding.severity != "note" and finding not in outdone]
    # The mass is what every number rests on.
    spoils_all = [one for one in against if one.severity == "error" or one.about in ("mass", "everything")]
    if spoils_all:
        weighty = [finding for finding in against if finding in spoils_all or finding.cause]
        rest = [] if brief else [finding for finding in against if finding not in weighty]
        level, against = "do_not_use", [*sorted(weighty, key=rank), *rest]
    reasons, remarks = (tuple(finding.text for finding in own) for own in (against, notes))
    return Verdict(level if against else "use", reasons, remarks).made_by((*against, *notes))


def table() -> list[tuple[str, str]]:
    """List every check: what it looks at, and from where on it says what, for each paragraph of its docstring."""
    rows, looks = list[tuple[str, str]](), [row.finding for row in HYPOTHESES]
    for check in (*looks, checks.too_short, *CHECKS[1:], *BEFOREHAND):
        what = ""
        for paragraph in str(check.__doc__).split("\n\n"):
            what, _, limits = " ".join([what, *paragraph.split()]).strip().partition(". ")
            if limits:  # else the next paragraph holds them
                rows.append((what, limits.format(**vars(sys.modules[check.__module__]))))
                what = ""
    return rows


def diagnose(
    problem: PayloadProblem, best: PayloadEstimate, gains: Gains | None = None, description: Robot | None = None
) -> Evidence:
    """Look at what no residual of a method shows, as far as recordings alone show it.

    Joints have the weights of ``best``, and may disagree by errors of ``gains``. ``description``: the robot as it
    was given, where gains are what is asked for: other readings are then compared with gains of their own.
    """
    states = None if isinstance(problem, StaticMotion) else states_of(problem.source)
    system, weights = system_of(problem, states), best.estimate.weights
    by_joints, found = payload_by_joints(problem, weights), scales(problem, weights, system)
    sigma = float(best.estimate.sigma[best.indices.index(9)]) if 9 in best.indices else np.inf
    most = max((one.fall for one in found if beyond(one)), default=0.0)
    effects = effects_of(system, description is not None, most) if system is not None else {}
    if "bursts" in effects and not matter(effects["bursts"], best.ten[9], sigma):
        effects.pop("bursts")
    exact, few = np.zeros((problem.robot.n,) * 2), isinstance(problem, ShortMotion)
    return Evidence(
        description or problem.robot,
        problem.source,
        by_joints,
        disagreement(by_joints, gains.covariance(problem.robot.n) if gains else exact, few),
        disagreement(by_joints, exact, few),
        effects,
        alternatives(description or problem.robot, states, description is not None),
        found,
        nominal_gravity(problem.robot, states or states_of(problem.source, BLOCKS)),
    )


def system_of(problem: PayloadProblem, states: States | None) -> System | None:
    """Set up the problem on subsampled states; None without them, or where the robot is neither shown nor known."""
    if states is None or (problem.known is not None and not problem.inflation):
        return None
    roles = problem.held.held if isinstance(problem, ShortMotion) else problem.friction
    changes = {name: role.weight for name, role in roles.items()}
    if isinstance(problem, ShortMotion):  # there all friction is free
        changes = dict.fromkeys(friction_columns(problem.robot.with_offsets(True)), 0.0) | changes
    alone = not problem.source.unloaded
    known = prior_of(problem.known, problem.inflation, problem.loaded) if alone else None
    return System.of(problem.robot, states, changes, known)


def allowing(estimate: PayloadEstimate, found: Evidence, gains: Gains | None = None) -> PayloadEstimate:
    """Correct an estimate for a tilt, and widen its intervals for joints that disagree and for bursts.

    Stated errors of the gains excuse joints, and come on top later: each sigma becomes the larger of that and what
    it were with exact gains.
    """
    lean, bursts = map(found.effects.get, ("tilt", "bursts"))
    if lean is not None and not estimate.from_scale:
        estimate = moved(estimate, *tilt_correction(lean, estimate.method))
    if bursts is not None:  # intervals reach the values without them
        estimate = moved(estimate, more=np.outer(bursts.change, bursts.change) / NORMAL95**2)
    factor, by_gains, S = found.disagreement**2, np.zeros(1), estimate.estimate.gain_sensitivity
    if gains is not None and S is not None:
        C = gains.covariance(S.shape[1])
        by_gains = np.einsum("kj,ji,ki->k", S, C, S) / np.square(error_model(estimate.estimate).sigma)
    return moved(estimate, factor=np.sqrt(np.maximum(factor, found.unexcused**2 - by_gains)))


def robot_verdict(evidence: Evidence, free_gains: bool = False) -> Verdict:
    """Judge a robot's parameters, identified from recordings without payload.

    ``free_gains``: whether the torques are currents, brought to an unknown scale.
    """
    robot, states = evidence.robot, states_of(evidence.source)
    effects = effects_of(System.of(robot, states), free_gains) if states is not None else {}
    nominal = None if free_gains else nominal_gravity(robot, states or states_of(evidence.source, BLOCKS))
    others = alternatives(robot, states, free_gains)
    return judge(replace(evidence, effects=effects, alternatives=others, nominal=nominal))
