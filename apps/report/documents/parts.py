"""Parts that several documents have."""

from collections.abc import Mapping, Sequence

from msgspec import UNSET, UnsetType

from ....estimation import Gains, SigmaRatio, Verdict
from ....estimation.fit.covariance import RobustCovariance
from ....estimation.fit.essential import Elimination
from ....model import Processing, Robot
from ...results.parts import (
    EliminationDocument,
    EliminationStep,
    GainErrorsDocument,
    ParameterDocument,
    ProcessingDocument,
    RobustDocument,
    VerdictDocument,
)


def processing_document(
    robot: Robot, processing: Processing, drive_gains: Sequence[float] | None
) -> ProcessingDocument:
    """Settings, so that a result can be repeated."""
    return ProcessingDocument.of(
        processing,
        equation_rate=equation_rate(processing),
        drive_gains=tuple(drive_gains) if drive_gains else None,
        offsets=robot.drives.offsets,
        coulomb=robot.coupling.coulomb if robot.coupling else None,
    )


def equation_rate(processing: Processing) -> float | UnsetType:
    """The rate of the equations, where it is given instead of a factor."""
    return processing.equation_rate if processing.equation_rate is not None else UNSET


def robust_document(robust: RobustCovariance | None, reason: str) -> RobustDocument:
    """Say how the robust standard deviations were found, or why there are none."""
    if robust is None:
        return RobustDocument(None, unavailable=reason or None)
    return RobustDocument.of(robust, warning=robust.warning or None)


def gain_errors_document(gains: Gains) -> GainErrorsDocument:
    """Tell the gains' errors; where gains were identified, their covariance, recordings and payload too."""
    known = any(gains.recordings.values())
    return GainErrorsDocument(
        tuple(gains.per_joint),
        gains.common,
        identified=tuple(map(tuple, gains.identified)) or UNSET,
        recordings=gains.recordings if known else UNSET,
        mass=gains.mass if known else UNSET,
        notes=gains.notes or UNSET,
        assumed=gains.assumed or UNSET,
    )


def verdict_document(verdict: Verdict) -> VerdictDocument:
    """Say whether to use the numbers, and why not."""
    return VerdictDocument(verdict.level, verdict.reasons, verdict.notes or UNSET)


def elimination_document(
    elimination: Elimination, warnings: Sequence[str] = (), labels: Mapping[str, str] | None = None
) -> EliminationDocument:
    """Tell how essential parameters were found, and their values without the others.

    Args:
        warnings: what speaks against the set.
        labels: name of a column -> name of the parameter ("MX2" -> "MX2R").
    """
    path, rule, estimate = elimination.path, elimination.rule, elimination.estimate
    named, robust, by_gains = dict(labels or {}), estimate.sigma_robust, estimate.sigma_by_gains
    return EliminationDocument(
        rule="ratio" if isinstance(rule, SigmaRatio) else "sigma",
        description=rule.description,
        essential=len(elimination.essential),
        sigma_ratio=elimination.sigma_ratio,
        largest_relative_sigma_percent=100.0 * elimination.largest_relative_sigma,
        relative_residual=estimate.fit.relative,
        parameters=tuple(
            ParameterDocument(
                name=named.get(name, name),
                value=estimate.values[k],
                sigma=estimate.sigma[k],
                sigma_robust=robust[k] if robust is not None else None,
                sigma_by_gains=by_gains[k] if by_gains is not None else None,
                relative_sigma_percent=estimate.relative_sigma_percent[k],
            )
            for k, name in enumerate(estimate.names)
        ),
        path=tuple(
            EliminationStep(
                named.get(name, name) if name else None,
                len(path.order) - k,
                path.sigma_ratio[k],
                100.0 * path.largest_relative_sigma[k],
            )
            for k, name in enumerate(["", *path.order])
        ),
        warnings=tuple(warnings),
    )
