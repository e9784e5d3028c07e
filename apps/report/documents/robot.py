"""The documents of ``identify``, ``rollout`` and ``gains``."""

from collections.abc import Sequence
from typing import Any

from msgspec import UNSET

from ....common.schema import Document
from ....estimation import Identification
from ....estimation.answers.gains import DriveGains
from ....estimation.possible.prior import PriorRobot
from ....estimation.possible.robot import PossibleRobot
from ....model import INERTIAL, BaseParameters, Processing
from ...results import StoredGains, StoredRobot
from ...results.parts import (
    ActiveDocument,
    HorizonDocument,
    Number,
    ParameterDocument,
    PossibleParameter,
    PossibleRobotDocument,
    PriorDocument,
    ProcessingDocument,
    ResidualDocument,
    RobustDocument,
    RolloutDocument,
)
from ...results.stored import GainsTable, LoadDocument, MountingDocument, RobotData
from ...rollout import Rollout
from .parts import (
    elimination_document,
    equation_rate,
    gain_errors_document,
    processing_document,
    robust_document,
    verdict_document,
)


def identification_document(
    result: Identification,
    processing: Processing,
    drive_gains: Sequence[float] | None,
    constrained: PossibleRobot | None = None,
    rollouts: Sequence[Rollout] = (),
) -> StoredRobot:
    """Make the document of ``dynident identify --json``.

    Args:
        drive_gains: torque per current [N·m/A], if currents were read.
        constrained: the robot that can exist, if it was asked for.
        rollouts: predicted motion of recordings held out, if it was asked for.
    """
    estimate, problem, base = result.estimate, result.problem, result.base
    raw, scaled = problem.condition_numbers()
    labels = dict(zip(estimate.names, base.names, strict=True))
    return StoredRobot(
        robot=result.robot.name,
        fingerprint=result.robot.fingerprint,
        processing=processing_document(result.robot, processing, drive_gains),
        data=RobotData(
            rows_per_joint=problem.rows,
            degrees_of_freedom=estimate.degrees_of_freedom,
            error_norms=estimate.fit.error_norms,
            torque_norms=estimate.fit.torque_norms,
            weights=estimate.weights,
            equations=problem.equations,
        ),
        columns=estimate.names,
        covariance=estimate.covariance,
        covariance_robust=estimate.robust.covariance if estimate.robust else None,
        robust=robust_document(estimate.robust, result.without_robust),
        base_parameters=_base_parameters(result),
        elimination=elimination_document(result.elimination, result.warnings, labels),
        constrained=constrained_document(constrained, base) if constrained is not None else None,
        chi2_by="formula" if estimate.robust is None else "jackknife",
        condition_number=raw,
        condition_number_scaled=scaled,
        gain_sensitivity=estimate.gain_sensitivity,
        gain_sigma=gain_errors_document(result.gains) if result.gains else None,
        relative_residual=ResidualDocument.of(estimate.fit),
        validation=ResidualDocument.of(result.validation) if result.validation else None,
        rollouts=tuple(map(rollout_document, rollouts)) or UNSET,
        reasons_against_use=result.verdict.reasons,
    )


def _base_parameters(result: Identification) -> tuple[ParameterDocument, ...]:
    estimate, base = result.estimate, result.base
    columns: dict[str, Any] = {
        "name": base.names,
        "grouping": base.groupings(),
        "value": estimate.values,
        "sigma": estimate.sigma,
        "relative_sigma_percent": estimate.relative_sigma_percent,
        "sigma_robust": estimate.sigma_robust,
        "interval95": estimate.interval95,
        "interval95_robust": estimate.robust_interval95,
        "sigma_by_gains": estimate.sigma_by_gains,
        "interval95_with_gains": estimate.interval95_with_gains,
        "essential": [name in result.essential for name in estimate.names],
    }
    rows: list[dict[str, Any]] = [
        {key: None if column is None else column[k] for key, column in columns.items()}
        for k in range(len(estimate.names))
    ]
    return tuple(ParameterDocument(**row) for row in rows)


def constrained_document(result: PossibleRobot, base: BaseParameters) -> PossibleRobotDocument:
    """The nearest robot that can exist: base parameters, and with a prior the standard ones, labelled."""
    free = result.free
    moved = (result.values - free.values) / free.sigma
    prior: dict[str, Any] = {}
    if isinstance(result, PriorRobot):
        prior["prior"] = PriorDocument(result.prior.source, result.budget, result.weight, result.distances)
        prior["parameters"] = tuple(
            PossibleParameter(name, value, **origin._asdict(), decided_by=origin.decided_by())
            for (name, value), origin in zip(
                result.parameters.items(), map(result.origins.__getitem__, result.parameters), strict=True
            )
        )
    return PossibleRobotDocument(
        gauge="prior" if prior else "base",
        chi2_rise=result.chi2_rise,
        status=result.status,
        p_value=result.p_value,
        active=tuple(ActiveDocument(holding.multiplier, holding.description) for holding in result.active),
        min_eigenvalues={str(link): value for link, value in enumerate(result.min_eigenvalues, start=1)},
        base_parameters=tuple(map(PossibleParameter, base.names, result.values, free.values, moved)),
        unidentifiable=result.unidentifiable,
        **prior,
    )


class RolloutsDocument(Document, frozen=True):
    """Open loop and replay on each recording."""

    robot: str
    rollouts: tuple[RolloutDocument, ...]


def rollouts_document(robot: str, rollouts: Sequence[Rollout]) -> RolloutsDocument:
    """Make the document of ``dynident rollout --json``; ``robot``: its name."""
    return RolloutsDocument(robot, tuple(map(rollout_document, rollouts)))


def rollout_document(rollout: Rollout) -> RolloutDocument:
    """Errors by horizon, and the replay."""
    resting, replay = int(rollout.resting.sum()), rollout.replay
    return RolloutDocument(
        source=rollout.source,
        starts_in_motion=len(rollout.resting) - resting,
        starts_at_rest=resting,
        diverged=rollout.diverged,
        horizons=tuple(_horizon(rollout, seconds) for seconds in rollout.horizons),
        growth=rollout.growth,
        replay_relative=replay.relative,
        replay_joints=replay.joints,
        replay_strayed=replay.strayed,
    )


def _horizon(rollout: Rollout, seconds: float) -> HorizonDocument:
    return HorizonDocument(seconds, _spreads(rollout, seconds, False), _spreads(rollout, seconds, True))


def _spreads(rollout: Rollout, seconds: float, resting: bool) -> dict[str, tuple[Number, Number]] | None:
    spreads = {by: rollout.spread(by, seconds, resting) for by in rollout.errors}
    return {by: (spread[0], spread[1]) for by, spread in spreads.items() if spread is not None} or None


def gains_document(gains: DriveGains, processing: Processing) -> StoredGains:
    """Make the document that ``dynident gains --json`` writes and ``--drive-gains`` reads."""
    robust = gains.robust
    return StoredGains(
        robot=gains.robot.name,
        processing=ProcessingDocument(
            rate=processing.rate,
            cutoff=processing.cutoff,
            decimate=processing.decimate,
            equation_rate=equation_rate(processing),
            slow_fraction=processing.slow_fraction,
            slow_speed=processing.slow_speed,
        ),
        load=_load(gains),
        drive_gains=GainsTable(
            values=gains.values,
            sigma=gains.values * gains.larger_relative_sigma,
            relative_sigma=gains.larger_relative_sigma,
            relative_sigma_formula=gains.relative_sigma,
            relative_sigma_robust=gains.relative_sigma_robust,
            relative_covariance=gains.larger_relative_covariance,
            without_constraints=gains.free_values,
            identified=gains.identified,
            rests_on=tuple(gains.identifiability),
        ),
        fingerprints=gains.recordings,
        robust=RobustDocument(robust.blocks, robust.block_length)
        if robust
        else RobustDocument(None, unavailable=gains.without_robust or None),
        relative_residual=ResidualDocument.of(gains.fit),
        disagreement=gains.disagreement,
        verdict=verdict_document(gains.verdict),
    )


def _load(gains: DriveGains) -> LoadDocument:
    tens = [dict(zip(INERTIAL, body.vector.tolist(), strict=True)) for body in gains.payloads]
    each = tuple(MountingDocument(name, ten) for name, ten in zip(gains.mountings.names, tens, strict=True))
    return LoadDocument(
        known=gains.known,
        mass_sigma=max(load.mass_sigma for load in gains.loads),
        identified=tens[0],
        mountings=each if len(each) > 1 else UNSET,
    )
