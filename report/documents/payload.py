"""The document of ``payload``."""

from collections.abc import Sequence

from ...common.arrays import Array
from ...estimation import PayloadAnswer, PayloadProblem
from ...estimation.files import StoredPayload
from ...estimation.files.parts import ActiveDocument, EliminationDocument, ResidualDocument
from ...estimation.files.stored_payload import (
    FreeEstimate,
    JointsMassDocument,
    PayloadData,
    PossibleEstimate,
    Recommended,
    VerdictDocument,
    WeighedDocument,
)
from ...estimation.payload import ByJoints, ConstrainedPayload, JointShare, PayloadEstimate
from ...model import INERTIAL, Processing
from .parts import (
    elimination_document,
    gain_errors_document,
    processing_document,
    residual_document,
    robust_document,
)


def payload_document(
    answer: PayloadAnswer,
    processing: Processing,
    drive_gains: Sequence[float] | None = None,
    warnings: Sequence[str] = (),
) -> StoredPayload:
    """What ``dynident payload --json`` writes; ``warnings``: what speaks against the essential parameters."""
    problem, check, fit = answer.problem, answer.validation, answer.robot_fit
    return StoredPayload(
        robot=problem.robot.name,
        frame=problem.robot.payload_frame,
        processing=processing_document(problem.robot, processing, drive_gains),
        relative_residual=ResidualDocument(
            fit.relative if fit else None,
            fit.relative_per_joint if fit else None,
            residual_document(check) if check else None,
        ),
        data=_data(problem, processing),
        estimates=(*map(free_estimate, answer.estimates), *map(possible_estimate, answer.constrained)),
        recommended=Recommended(answer.recommended.method, "constrained"),
        mass_by_joints=mass_by_joints(answer.by_joints),
        essential=_essential(answer, warnings),
        left_out={str(method): reason for method, reason in answer.left_out.items()},
        verdict=VerdictDocument(answer.verdict.level, tuple(answer.verdict.reasons)),
    )


def _essential(answer: PayloadAnswer, warnings: Sequence[str]) -> EliminationDocument | None:
    """Essential parameters of robot and payload together, as in Table 2, where method 4 was used."""
    if answer.elimination is None:
        return None
    base = answer.problem.base
    return elimination_document(answer.elimination, warnings, dict(zip(base.columns, base.names, strict=True)))


def _data(problem: PayloadProblem, processing: Processing) -> PayloadData:
    bare = problem.unloaded
    raw, scaled = bare.condition_numbers() if bare else (None, None)
    pairs = problem.pairs
    return PayloadData(
        equations=bare.equations if bare else problem.loaded.equations,
        equations_loaded=problem.loaded.equations,
        rate=problem.rate,
        cutoff=processing.cutoff,
        lag_s=pairs[0].lag if pairs else None,
        lags_s=tuple(pair.lag for pair in pairs),
        max_position_mismatch_rad=max((pair.max_mismatch for pair in pairs), default=None),
        condition_number=raw,
        condition_number_scaled=scaled,
        base_parameters=len(problem.base.columns),
    )


def free_estimate(result: PayloadEstimate) -> FreeEstimate:
    """A method's own estimate."""
    estimate, body = result.estimate, result.body
    there = bool(body.mass)
    return FreeEstimate(
        method=result.method,
        parameters=result.named(estimate.values),
        sigma=result.named(estimate.sigma),
        sigma_robust=result.named(estimate.sigma_robust) if estimate.sigma_robust is not None else None,
        interval95=_intervals(estimate.interval95),
        interval95_robust=_intervals(estimate.robust_interval95),
        robust=robust_document(estimate.robust, result.without_robust),
        com=body.com if there else None,
        com_sigma=result.sigma_com if there else None,
        com_sigma_robust=result.sigma_com_robust if there else None,
        inertia_com=body.inertia_com if there else None,
        inertia_com_sigma=result.sigma_inertia_com if there else None,
        inertia_com_sigma_robust=result.sigma_inertia_com_robust if there else None,
        min_pseudo_inertia_eigenvalue=body.min_pseudo_inertia_eigenvalue,
        physically_consistent=body.physically_consistent,
        relative_residual=estimate.fit.relative,
    )


def possible_estimate(payload: ConstrainedPayload) -> PossibleEstimate:
    """The payload that can exist, with intervals."""
    free, result, intervals = payload.free.estimate, payload.result, payload.intervals
    named, p_values = payload.free.named, {id(tested.constraint): tested.p_value for tested in payload.tested}
    return PossibleEstimate(
        method=payload.method,
        parameters=named(result.values),
        sigma=named(free.sigma),
        sigma_robust=named(free.sigma_robust) if free.sigma_robust is not None else None,
        sigma_with_gains=named(payload.sigma) if payload.gains else None,
        gain_sigma=gain_errors_document(payload.gains) if payload.gains else None,
        interval95=_intervals(intervals.parameters),
        interval95_by="jackknife" if payload.robust else "formula",
        com=payload.body.com,
        com_interval95=intervals.com,
        inertia_com=payload.body.inertia_com,
        inertia_com_interval95=tuple(intervals.inertia_com),
        principal_moments=payload.principal_moments,
        principal_moments_interval95=intervals.principal_moments,
        min_pseudo_inertia_eigenvalue=result.min_pseudo_inertia_eigenvalue,
        physically_consistent=payload.body.physically_consistent,
        constraints=tuple(constraint.description for constraint in result.constraints),
        active=tuple(
            ActiveDocument(held.multiplier, constraint=held.description, p_value=p_values[id(held.constraint)])
            for held in result.active
        ),
        chi2_rise=result.chi2_rise,
        p_value=result.p_value,
        conflict=payload.conflict,
        weighed=tuple(map(WeighedDocument.of, payload.weighings)),
        solver_status=result.status,
    )


def mass_by_joints(seen: ByJoints) -> tuple[JointsMassDocument, ...]:
    """The mass by some joints' torques; null where they do not see it."""
    shares: dict[tuple[int, ...], JointShare] = {(share.joint,): share for share in seen.shares}
    rows = []
    for mass in seen.masses:
        share = shares.get(mass.joints)
        alone = {"share": share.share, "share_sigma": None if share.share is None else share.sigma} if share else {}
        rows.append(JointsMassDocument.of(mass, visible=mass.mass is not None, **alone))
    return tuple(rows)


def _intervals(interval95: Array | None) -> dict[str, tuple[float, float]] | None:
    if interval95 is None:
        return None
    return {kind: (low, high) for kind, (low, high) in zip(INERTIAL, interval95.tolist(), strict=True)}
