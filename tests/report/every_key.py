"""Parts of documents as they must be, made from the values that they come from."""

import math
from typing import Any

import numpy as np
from dynident.common.schema import Document, convert
from dynident.model import INERTIAL
from dynident.tests.report.written import written


def plain(value: Any) -> Any:
    """A value as JSON has it: lists, null for what is not finite."""
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value


def ten(values: Any) -> dict[str, Any]:
    """Ten numbers by name."""
    return dict(zip(INERTIAL, values, strict=True))


def same(document: Document, expected: dict[str, Any]) -> None:
    """Key for key what is expected, and what the document's own type takes."""
    read = written(document)
    assert set(read) == set(expected)
    for key, value in plain(expected).items():
        assert read[key] == value, key
    assert written(convert(read, type(document))) == read


PROCESSING = {
    "rate_hz": 101.0, "cutoff_hz": 11.0, "decimate": 7, "still_speed": 0.003, "slow_fraction": 0.04,
    "slow_speed": 0.06, "max_mismatch": 0.05, "drive_gains": [2.5, 3.5], "offsets": True, "coulomb": "paper",
    "torque_side": "link",
}  # fmt: skip
GAINS = {
    "per_joint": [0.01, 0.02, 0.03], "common": 0.004, "identified": np.diag([1e-4, 2e-4, 3e-4]),
    "recordings": {"unloaded": ["u"], "loaded": ["l"]}, "mass": 6.5, "notes": ["said"],
}  # fmt: skip
VERDICT = {"level": "mass_and_com_only", "reasons": ["why"]}


def residual(fit: Any) -> dict[str, Any]:
    return {"all": fit.relative, "per_joint": fit.relative_per_joint}


def robust(estimate: Any) -> dict[str, Any]:
    covariance = estimate.robust
    return {"blocks": 8, "block_length_s": 1.75, "degrees_of_freedom": 6, "warning": covariance.warning}


def elimination(result: Any, label: dict[str, str], warnings: list[str]) -> dict[str, Any]:
    estimate = result.estimate
    return {
        "rule": "ratio",
        "description": result.rule.description,
        "essential": 1,
        "sigma_ratio": 1.01,
        "largest_relative_sigma_percent": 5.0,
        "relative_residual": estimate.fit.relative,
        "parameters": [
            {
                "name": label.get("B", "B"),
                "value": estimate.values[0],
                "sigma": estimate.sigma[0],
                "sigma_robust": estimate.sigma_robust[0],
                "sigma_by_gains": estimate.sigma_by_gains[0],
                "relative_sigma_percent": estimate.relative_sigma_percent[0],
            }
        ],
        "path": [
            {"eliminated": name, "remaining": left, "sigma_ratio": ratio, "largest_relative_sigma_percent": percent}
            for name, left, ratio, percent in (
                (None, 2, 1.0, 90.0), (label.get("A", "A"), 1, 1.01, 5.0), (label.get("B", "B"), 0, 2.5, 0.0)
            )
        ],
        "warnings": warnings,
        "limit": 1.02,
    }  # fmt: skip


def free_payload(result: Any) -> dict[str, Any]:
    estimate, body = result.estimate, result.body
    more = {"from_scale": True} if result.from_scale else {}
    return {
        **more,
        "estimator": "wls",
        "method": result.method,
        "parameters": ten(estimate.values),
        "sigma": ten(estimate.sigma),
        "sigma_robust": ten(estimate.sigma_robust),
        "interval95": ten(estimate.interval95),
        "interval95_robust": ten(estimate.robust_interval95),
        "robust": robust(estimate),
        "com": body.com,
        "com_sigma": result.spread.com,
        "com_sigma_robust": getattr(result.robust_spread, "com", None),
        "inertia_com": body.inertia_com,
        "inertia_com_sigma": result.spread.inertia_com,
        "inertia_com_sigma_robust": getattr(result.robust_spread, "inertia_com", None),
        "min_pseudo_inertia_eigenvalue": body.min_pseudo_inertia_eigenvalue,
        "physically_consistent": True,
        "relative_residual": estimate.fit.relative,
    }


def possible_payload(payload: Any) -> dict[str, Any]:
    free, intervals = payload.free.estimate, payload.intervals
    return {
        "estimator": "constrained",
        "method": payload.method,
        "parameters": ten(payload.result.values),
        "sigma": ten(free.sigma),
        "sigma_robust": ten(free.sigma_robust),
        "sigma_with_gains": ten(payload.sigma),
        "gain_sigma": GAINS,
        "interval95": ten(intervals.parameters),
        "interval95_by": "jackknife",
        "com": payload.body.com,
        "com_interval95": intervals.com,
        "inertia_com": payload.body.inertia_com,
        "inertia_com_interval95": intervals.inertia_com,
        "principal_moments": payload.principal_moments,
        "principal_moments_interval95": intervals.principal_moments,
        "min_pseudo_inertia_eigenvalue": 0.0021,
        "physically_consistent": True,
        "constraints": ["mass from 1 kg"],
        "active": [{"constraint": "mass from 1 kg", "multiplier": 0.33, "p_value": 0.0625}],
        "chi2_rise": 2.125,
        "p_value": 0.4375,
        "conflict": False,
        "weighed": [
            {"mass": 3.1, "sigma": 0.05, "identified": 3.2, "identified_sigma": 0.06, "degrees_of_freedom": 7.5,
             "z": 1.28, "p_value": 0.21}
        ],
        "solver_status": "Solved",
    }  # fmt: skip


MASS_BY_JOINTS = [
    {"joints": [1], "visible": True, "mass": 3.01, "sigma": 0.11, "interval95": [2.8, 3.3], "share": 0.98,
     "share_sigma": 0.015},
    {"joints": [2], "visible": False, "mass": None, "sigma": None, "interval95": None, "share": None,
     "share_sigma": None},
    {"joints": [1, 2], "visible": True, "mass": 3.02, "sigma": 0.12, "interval95": [2.7, 3.4]},
]  # fmt: skip
PAIRS = {
    "lag_s": 0.011, "lags_s": [0.011, 0.012], "max_position_mismatch_rad": 0.0072,
    "rms_position_mismatch_rad": 0.0036,
}  # fmt: skip
