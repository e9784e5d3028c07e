"""The document of ``payload`` and ``weigh``."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from msgspec import UNSET

from ....common.arrays import Array
from ....estimation import PAYLOAD, LongMotion, PayloadAnswer, PayloadProblem, ShortMotion
from ....estimation.payload.by_joints import ByJoints, JointShare
from ....estimation.payload.constrained import ConstrainedPayload
from ....estimation.payload.result import PayloadEstimate
from ....estimation.payload.ripple import RIPPLE_CHANCE
from ....model import INERTIAL, Processing
from ...results import StoredPayload
from ...results.parts import ActiveDocument, ResidualDocument
from ...results.stored_payload import (
    AgreementDocument,
    Assumed,
    ConstantTorques,
    FlangeDocument,
    FreeEstimate,
    JointsMassDocument,
    PayloadData,
    PossibleEstimate,
    QuantityDocument,
    Recommended,
    RepeatsDocument,
    RippleDocument,
    VisibilityDocument,
    WeighedDocument,
)
from .parts import (
    elimination_document,
    gain_errors_document,
    processing_document,
    robust_document,
    verdict_document,
)


def payload_document(
    answer: PayloadAnswer,
    processing: Processing,
    drive_gains: Sequence[float] | None = None,
) -> StoredPayload:
    """Make the document of ``payload --json`` and ``weigh --json``."""
    problem, flange = answer.problem, answer.problem.robot.flange_pose
    more: dict[str, Any] = {}
    if isinstance(problem, ShortMotion):
        more = _weighing(answer, problem)
    else:
        # Of robot and payload together, as in Table 2, where method 4 was used.
        names = dict(zip(problem.base.columns, problem.base.names, strict=True))
        steps = answer.elimination
        more["essential"] = elimination_document(steps, answer.warnings, names) if steps else None
        more["left_out"] = {str(method): reason for method, reason in answer.left_out.items()}
    if flange is not None:
        degrees, source = np.degrees(flange.rpy) + 0.0, problem.robot.sources.get("flange", "")
        more["flange_in_payload_frame"] = FlangeDocument(flange.p, degrees, source)
    return StoredPayload(
        robot=problem.robot.name,
        frame=problem.robot.payload_frame,
        rated_payload_kg=problem.robot.rated_payload,
        processing=processing_document(problem.robot, processing, drive_gains),
        relative_residual=_residual(answer),
        data=_data(problem, processing),
        estimates=_estimates(answer),
        recommended=Recommended(
            answer.free.method, "constrained" if answer.constrained else "wls", answer.recommendation.reason
        ),
        mass_by_joints=mass_by_joints(answer.by_joints),
        verdict=verdict_document(answer.verdict),
        **more,
    )


def _weighing(answer: PayloadAnswer, short: ShortMotion) -> dict[str, Any]:
    """Collect the keys of a short motion; a number that was not determined is null."""
    body, stand_in, repeats = answer.assumed, answer.stand_in, answer.repeats
    drift, drift_sigma = (repeats.drift if repeats is not None else None) or (None, None)
    return {
        "joints": tuple(short.joints),
        "visibility": VisibilityDocument.of(short.visibility),
        "constant_torques": ConstantTorques(tuple(j + 1 for j in short.held.joints), short.held.sigma),
        "ripple": tuple(
            RippleDocument.of(wave, source=run.source, probability_by_noise=RIPPLE_CHANCE)
            for run in short.runs
            for wave in run.ripple
        ),
        "quantities": quantities(answer),
        "mass_from_scale": answer.free.from_scale,
        "agreement": tuple(map(AgreementDocument.of, answer.agreement)),
        "repeats": RepeatsDocument.of(repeats, drift_per_recording=drift, drift_sigma=drift_sigma)
        if repeats is not None
        else None,
        "assumed": Assumed(stand_in.description, body.named()) if stand_in and body else None,
    }


def _residual(answer: PayloadAnswer) -> ResidualDocument:
    """Residual of the robot's own parameters; of a short motion, the payload's."""
    check, fit = answer.validation, answer.robot_fit
    if isinstance(answer.problem, ShortMotion):
        own = answer.free.estimate.fit
        return ResidualDocument(own.relative, answer.free.unexplained(answer.problem.torque_rms), None)
    return ResidualDocument(
        fit.relative if fit else None,
        fit.relative_per_joint if fit else None,
        ResidualDocument.of(check) if check else None,
    )


def _data(problem: PayloadProblem, processing: Processing) -> PayloadData:
    """The equations of the robot; of a short motion, of the payload."""
    short = isinstance(problem, ShortMotion)
    bare = problem.unloaded if isinstance(problem, LongMotion) else None
    solved = problem.loaded.select(PAYLOAD) if short else bare
    raw, scaled = solved.condition_numbers() if solved else (None, None)
    pairs = problem.pairs
    return PayloadData(
        equations=bare.equations if bare else problem.loaded.equations,
        equations_loaded=UNSET if short else problem.loaded.equations,
        rate=problem.source.rate,
        cutoff=processing.cutoff,
        lag_s=pairs[0].lag if pairs else None,
        lags_s=tuple(pair.lag for pair in pairs),
        max_position_mismatch_rad=max((pair.max_mismatch for pair in pairs), default=None),
        condition_number=raw,
        condition_number_scaled=scaled,
        base_parameters=UNSET if short else len(problem.base.columns),
    )


def _estimates(answer: PayloadAnswer) -> tuple[FreeEstimate | PossibleEstimate, ...]:
    """Free estimates, then possible ones; of a payload that is visible in part what was determined."""
    if answer.constrained:
        return (*map(free_estimate, answer.estimates), *map(possible_estimate, answer.constrained))
    free, estimate = answer.free, answer.free.estimate
    robust = estimate.sigma_robust
    return (
        FreeEstimate(
            method=free.method,
            parameters=_named(range(10), answer.ten),
            sigma=_named(free.places, estimate.sigma),
            sigma_robust=_named(free.places, robust) if robust is not None else None,
            interval95=None,
            com=answer.com,
            com_sigma=answer.spread.com,
            inertia_com=None,
            physically_consistent=None,
        ),
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
    named = payload.free.named
    return PossibleEstimate(
        method=payload.method,
        parameters=named(result.values),
        sigma=named(free.sigma),
        sigma_robust=named(free.sigma_robust) if free.sigma_robust is not None else None,
        sigma_with_gains=named(payload.sigma) if payload.gains else None,
        gain_sigma=gain_errors_document(payload.gains) if payload.gains else None,
        interval95=_intervals(intervals.parameters),
        interval95_by="formula" if free.robust is None else "memory" if free.robust.by_memory else "jackknife",
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
            ActiveDocument(active.multiplier, constraint=active.description, p_value=active.p_value)
            for active in payload.tested
        ),
        chi2_rise=result.chi2_rise,
        p_value=result.p_value,
        conflict=payload.conflict,
        weighed=tuple(map(WeighedDocument.of, payload.weighings)),
        solver_status=result.status,
    )


def mass_by_joints(by_joints: ByJoints) -> tuple[JointsMassDocument, ...]:
    """The mass by some joints' torques; null where they do not see it."""
    shares: dict[tuple[int, ...], JointShare] = {(share.joint,): share for share in by_joints.shares}
    rows = []
    for mass in by_joints.masses:
        share = shares.get(mass.joints)
        alone = {"share": share.share, "share_sigma": None if share.share is None else share.sigma} if share else {}
        rows.append(JointsMassDocument.of(mass, visible=mass.mass is not None, **alone))
    return tuple(rows)


def _intervals(interval95: Array | None) -> dict[str, tuple[float, float]] | None:
    if interval95 is None:
        return None
    return {kind: (low, high) for kind, (low, high) in zip(INERTIAL, interval95.tolist(), strict=True)}


def quantities(answer: PayloadAnswer) -> dict[str, QuantityDocument]:
    """Mass, centre of mass and inertia with interval, and whether to use them."""
    possible, spread = answer.possible, answer.spread
    body = answer.assumed or (possible.body if possible is not None else None)
    measured = answer.stand_in is None and possible is not None
    values: dict[str, tuple[Any, Any, Any]] = {
        "mass": (answer.mass, answer.mass_interval, spread.mass),
        "centre of mass": (answer.com, answer.com_interval, spread.com),
        "inertia": (
            body.inertia_com if body is not None else None,
            possible.intervals.inertia_com if measured and possible is not None else None,
            spread.inertia_com if measured else None,
        ),
    }
    judged = answer.judged
    return {
        name.replace(" ", "_"): QuantityDocument(judged[name].use, judged[name].why or None, *numbers)
        for name, numbers in values.items()
    }


def _named(places: Sequence[int], values: Array) -> dict[str, float | None]:
    ten = np.full(10, np.nan)
    ten[list(places)] = values
    return dict(zip(INERTIAL, ten.tolist(), strict=True))
