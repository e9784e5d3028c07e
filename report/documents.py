"""Results as JSON documents."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..common.arrays import Array
from ..common.files import write_text
from ..estimation import Identification, PayloadAnswer, PayloadProblem
from ..estimation.diagnosis import robot_verdict
from ..estimation.equations import ReducedProblem
from ..estimation.fit import Fit, RobustCovariance
from ..estimation.payload import ConstrainedPayload, PayloadEstimate
from ..estimation.possible import ConstrainedBase, ConstrainedRobot
from ..model import INERTIAL, Processing, Robot
from .by_joints import mass_by_joints_document
from .gains import gain_errors_document
from .robot_documents import constrained_document, elimination_document

Document = dict[str, Any]


def identification_document(
    result: Identification,
    processing: Processing,
    drive_gains: Sequence[float] | None,
    constrained: ConstrainedBase | ConstrainedRobot | None = None,
    warnings: Sequence[str] = (),
) -> Document:
    """What ``dynident identify --json`` writes.

    Args:
        result: the free estimate.
        processing: settings.
        drive_gains: torque per current [N·m/A], if currents were read.
        constrained: the robot that can exist, if it was asked for.
        warnings: what speaks against the essential parameters.
    """
    estimate = result.estimate
    groupings = result.base.groupings()
    robust_sigma, robust_interval = estimate.sigma_robust, estimate.robust_interval95
    by_gains, with_gains = estimate.sigma_by_gains, estimate.interval95_with_gains
    parameters = [
        {
            "name": result.base.names[k],
            "grouping": groupings[k],
            "value": estimate.values[k],
            "sigma": estimate.sigma[k],
            "relative_sigma_percent": estimate.relative_sigma_percent[k],
            "sigma_robust": robust_sigma[k] if robust_sigma is not None else None,
            "interval95": estimate.interval95[k],
            "interval95_robust": robust_interval[k] if robust_interval is not None else None,
            "sigma_by_gains": by_gains[k] if by_gains is not None else None,
            "interval95_with_gains": with_gains[k] if with_gains is not None else None,
            "essential": name in result.essential,
        }
        for k, name in enumerate(estimate.names)
    ]
    raw, scaled = result.problem.condition_numbers()
    return {
        "robot": result.robot.name,
        "robot_fingerprint": result.robot.fingerprint,
        "processing": processing_document(result.robot, processing, drive_gains),
        "data": {
            "equations": result.problem.equations,
            "rows_per_joint": list(result.problem.rows),
            "degrees_of_freedom": estimate.degrees_of_freedom,
            "error_norms": estimate.fit.error_norms,
            "torque_norms": estimate.fit.torque_norms,
            "weights": estimate.weights,
        },
        "columns": list(estimate.names),
        "covariance": estimate.covariance,
        "covariance_robust": estimate.robust.covariance if estimate.robust else None,
        "robust": _robust_document(estimate.robust, result.without_robust),
        "base_parameters": parameters,
        "elimination": elimination_document(
            result.elimination, warnings, dict(zip(estimate.names, result.base.names, strict=True))
        ),
        "constrained": constrained_document(constrained, result.base) if constrained is not None else None,
        "chi2_by": "formula" if estimate.robust is None else "jackknife",
        "condition_number": raw,
        "condition_number_scaled": scaled,
        "gain_sensitivity": estimate.gain_sensitivity,
        "gain_sigma": gain_errors_document(result.gains) if result.gains else None,
        "relative_residual": residual_document(estimate.fit),
        "validation": residual_document(result.validation) if result.validation else None,
        "reasons_against_use": list(robot_verdict(estimate.fit).reasons),
    }


def payload_document(
    answer: PayloadAnswer,
    processing: Processing,
    drive_gains: Sequence[float] | None = None,
    warnings: Sequence[str] = (),
) -> Document:
    """What ``dynident payload --json`` writes; ``warnings``: what speaks against the essential parameters."""
    problem, check = answer.problem, answer.validation
    fitted = residual_document(answer.robot_fit) if answer.robot_fit else {"all": None, "per_joint": None}
    return {
        "robot": problem.robot.name,
        "frame": problem.robot.payload_frame,
        "processing": processing_document(problem.robot, processing, drive_gains),
        "relative_residual": {**fitted, "validation": residual_document(check) if check else None},
        "data": _data_document(problem, processing),
        "estimates": [
            *(free_estimate_document(estimate) for estimate in answer.estimates),
            *(constrained_estimate_document(payload) for payload in answer.constrained),
        ],
        "recommended": {"method": answer.recommended.method, "estimator": "constrained"},
        "mass_by_joints": mass_by_joints_document(answer.by_joints),
        "essential": _combined_document(answer, warnings),
        "left_out": {str(method): reason for method, reason in answer.left_out.items()},
        "verdict": {"level": answer.verdict.level, "reasons": list(answer.verdict.reasons)},
    }


def _combined_document(answer: PayloadAnswer, warnings: Sequence[str]) -> Document | None:
    """Essential parameters of robot and payload together, as in Table 2, where method 4 was used."""
    if answer.elimination is None:
        return None
    base = answer.problem.base
    return elimination_document(answer.elimination, warnings, dict(zip(base.columns, base.names, strict=True)))


def processing_document(robot: Robot, processing: Processing, drive_gains: Sequence[float] | None) -> Document:
    """Settings, so that a result can be repeated."""
    return {
        "rate_hz": processing.rate,
        "cutoff_hz": processing.cutoff,
        "decimate": processing.decimate,
        "still_speed": processing.still_speed,
        "slow_fraction": processing.slow_fraction,
        "max_mismatch": processing.max_mismatch,
        "drive_gains": list(drive_gains) if drive_gains else None,
        "offsets": robot.drives.offsets,
        "coulomb": robot.coupling.coulomb if robot.coupling else None,
    }


def residual_document(fit: Fit) -> Document:
    """Relative residual, all joints and each."""
    return {"all": fit.relative, "per_joint": fit.relative_per_joint}


def _data_document(problem: PayloadProblem, processing: Processing) -> Document:
    bare: ReducedProblem | None = problem.unloaded
    raw, scaled = bare.condition_numbers() if bare else (None, None)
    pairs = problem.pairs
    return {
        "equations": bare.equations if bare else problem.loaded.equations,
        "equations_loaded": problem.loaded.equations,
        "rate_hz": problem.rate,
        "cutoff_hz": processing.cutoff,
        "lag_s": pairs[0].lag if pairs else None,
        "lags_s": [pair.lag for pair in pairs],
        "max_position_mismatch_rad": max((pair.max_mismatch for pair in pairs), default=None),
        "condition_number": raw,
        "condition_number_scaled": scaled,
        "base_parameters": len(problem.base.columns),
    }


def free_estimate_document(result: PayloadEstimate) -> Document:
    """A method's own estimate."""
    estimate, body = result.estimate, result.body
    return {
        "method": result.method,
        "estimator": "wls",
        "parameters": result.named(estimate.values),
        "sigma": result.named(estimate.sigma),
        "sigma_robust": result.named(estimate.sigma_robust) if estimate.sigma_robust is not None else None,
        "interval95": _intervals(estimate.interval95),
        "interval95_robust": _intervals(estimate.robust_interval95),
        "robust": _robust_document(estimate.robust, result.without_robust),
        "com": body.com if body.mass else None,
        "com_sigma": result.sigma_com if body.mass else None,
        "com_sigma_robust": result.sigma_com_robust if body.mass else None,
        "inertia_com": body.inertia_com if body.mass else None,
        "inertia_com_sigma": result.sigma_inertia_com if body.mass else None,
        "inertia_com_sigma_robust": result.sigma_inertia_com_robust if body.mass else None,
        "min_pseudo_inertia_eigenvalue": body.min_pseudo_inertia_eigenvalue,
        "physically_consistent": body.physically_consistent,
        "relative_residual": estimate.fit.relative,
    }


def constrained_estimate_document(payload: ConstrainedPayload) -> Document:
    """The payload that can exist, with intervals."""
    free, result, intervals = payload.free.estimate, payload.result, payload.intervals
    p_values = {id(one.constraint): one.p_value for one in payload.tested}
    return {
        "method": payload.method,
        "estimator": "constrained",
        "parameters": payload.free.named(result.values),
        "sigma": payload.free.named(free.sigma),
        "sigma_robust": payload.free.named(free.sigma_robust) if free.sigma_robust is not None else None,
        "sigma_with_gains": payload.free.named(payload.sigma) if payload.gains else None,
        "gain_sigma": gain_errors_document(payload.gains) if payload.gains else None,
        "interval95": _intervals(intervals.parameters),
        "interval95_by": "jackknife" if payload.robust else "formula",
        "com": payload.body.com,
        "com_interval95": intervals.com,
        "inertia_com": payload.body.inertia_com,
        "inertia_com_interval95": intervals.inertia_com,
        "principal_moments": payload.principal_moments,
        "principal_moments_interval95": intervals.principal_moments,
        "min_pseudo_inertia_eigenvalue": result.min_pseudo_inertia_eigenvalue,
        "physically_consistent": payload.body.physically_consistent,
        "constraints": [constraint.description for constraint in result.constraints],
        "active": [
            {
                "constraint": active.constraint.description,
                "multiplier": active.multiplier,
                "p_value": p_values[id(active.constraint)],
            }
            for active in result.active
        ],
        "chi2_rise": result.chi2_rise,
        "p_value": result.p_value,
        "conflict": payload.conflict,
        "weighed": [
            {**weighing._asdict(), "z": weighing.z, "p_value": weighing.p_value} for weighing in payload.weighings
        ],
        "solver_status": result.status,
    }


def _intervals(interval95: Array | None) -> Document | None:
    if interval95 is None:
        return None
    return {kind: list(interval) for kind, interval in zip(INERTIAL, interval95, strict=True)}


def _robust_document(robust: RobustCovariance | None, reason: str) -> Document:
    """What the robust standard deviations rest on, or why there are none."""
    if robust is None:
        return {"blocks": None, "unavailable": reason or None}
    return {
        "blocks": robust.blocks,
        "block_length_s": robust.block_length,
        "degrees_of_freedom": robust.degrees_of_freedom,
        "warning": robust.warning or None,
    }


def write_json(path: str | Path, document: Document) -> None:
    """Write a document in one step, so that a killed run leaves no half file; nan and inf become null."""
    text = json.dumps(_plain(document), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    write_text(path, text)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
