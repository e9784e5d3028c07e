"""The document of ``weigh``, readable by what reads the document of ``payload``."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...common.arrays import Array
from ...estimation import WeighAnswer
from ...estimation.files import StoredWeighing
from ...estimation.files.parts import ResidualDocument
from ...estimation.files.stored_payload import (
    AgreementDocument,
    Assumed,
    ConstantTorques,
    FreeEstimate,
    PayloadData,
    PossibleEstimate,
    QuantityDocument,
    Recommended,
    RepeatsDocument,
    RippleDocument,
    VerdictDocument,
    VisibilityDocument,
)
from ...estimation.payload import RIPPLE_CHANCE
from ...model import INERTIAL, Processing
from .parts import processing_document
from .payload import free_estimate, mass_by_joints, possible_estimate


def weigh_document(
    answer: WeighAnswer, processing: Processing, drive_gains: Sequence[float] | None
) -> StoredWeighing:
    """What ``dynident weigh --json`` writes: what was not determined is null."""
    problem, fit = answer.problem, answer.found.estimate.fit
    body, stand_in = answer.assumed, answer.stand_in
    estimator: Any = "constrained" if answer.constrained else "wls"
    return StoredWeighing(
        robot=problem.robot.name,
        frame=problem.robot.payload_frame,
        joints=tuple(problem.joints),
        processing=processing_document(problem.robot, processing, drive_gains),
        relative_residual=ResidualDocument(fit.relative, answer.found.unexplained(problem.torque_rms), None),
        data=_data(answer, processing),
        visibility=VisibilityDocument.of(problem.visibility),
        constant_torques=ConstantTorques(tuple(j + 1 for j in problem.held.joints), problem.held.sigma),
        ripple=tuple(
            RippleDocument.of(wave, source=run.source, probability_by_noise=RIPPLE_CHANCE)
            for run in problem.runs
            for wave in run.ripple
        ),
        quantities=quantities(answer),
        estimates=_estimates(answer),
        recommended=Recommended(problem.method, estimator),
        mass_from_scale=answer.found.from_scale,
        agreement=tuple(map(AgreementDocument.of, answer.agreement)),
        mass_by_joints=mass_by_joints(answer.by_joints),
        repeats=_repeats(answer),
        assumed=Assumed(stand_in.description, body.named()) if stand_in and body else None,
        verdict=VerdictDocument(answer.verdict.level, tuple(answer.verdict.reasons)),
    )


def _data(answer: WeighAnswer, processing: Processing) -> PayloadData:
    problem, pairs = answer.problem, answer.problem.pairs
    raw, scaled = problem.problem.select([f"{kind}_L" for kind in INERTIAL]).condition_numbers()
    return PayloadData(
        equations=problem.problem.equations,
        rate=problem.rate,
        cutoff=processing.cutoff,
        lag_s=pairs[0].lag if pairs else None,
        lags_s=tuple(pair.lag for pair in pairs),
        max_position_mismatch_rad=max((pair.max_mismatch for pair in pairs), default=None),
        condition_number=raw,
        condition_number_scaled=scaled,
    )


def quantities(answer: WeighAnswer) -> dict[str, QuantityDocument]:
    """Mass, centre of mass and inertia with interval, and whether to use them."""
    possible, spread = answer.constrained, answer.spread
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


def _estimates(answer: WeighAnswer) -> tuple[FreeEstimate | PossibleEstimate, ...]:
    """The estimates of ``payload``; parameters that are not determined are null."""
    problem, estimate = answer.problem, answer.found.estimate
    if answer.constrained is not None:
        return free_estimate(answer.found), possible_estimate(answer.constrained)
    places, robust = answer.found.places, estimate.sigma_robust
    return (
        FreeEstimate(
            method=problem.method,
            parameters=_named(range(10), answer.ten),
            sigma=_named(places, estimate.sigma),
            sigma_robust=_named(places, robust) if robust is not None else None,
            interval95=None,
            com=answer.com,
            com_sigma=answer.spread.com,
            inertia_com=None,
            physically_consistent=None,
        ),
    )


def _named(places: Sequence[int], values: Array) -> dict[str, float | None]:
    ten = np.full(10, np.nan)
    ten[list(places)] = values
    return dict(zip(INERTIAL, ten.tolist(), strict=True))


def _repeats(answer: WeighAnswer) -> RepeatsDocument | None:
    if answer.repeats is None:
        return None
    drift, sigma = answer.repeats.drift or (None, None)
    return RepeatsDocument.of(answer.repeats, drift_per_recording=drift, drift_sigma=sigma)
