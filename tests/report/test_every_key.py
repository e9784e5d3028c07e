"""Every key of every JSON document holds the number it is named after, and is read back as it was written."""

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from dynident.apps.fleet.comparing import OddDocument
from dynident.apps.logs.following import Change, FollowingChange
from dynident.apps.report import documents
from dynident.apps.results import read_stored_gains
from dynident.common.errors import InputError
from dynident.common.schema import Document, convert, write_json
from dynident.estimation import PayloadResult, RobotResult, robot_result
from dynident.estimation.answers.payload import payload_result
from dynident.estimation.diagnosis.evidence import Evidence
from dynident.estimation.diagnosis.verdict import judge
from dynident.estimation.payload.nuisance import RIPPLE_CHANCE
from dynident.estimation.payload.result import StandIn
from dynident.estimation.results.parts import PossibleRobotDocument
from dynident.model import INERTIAL
from dynident.tests.report import made
from dynident.tests.report.made import written
from msgspec.structs import asdict


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


BOX = StandIn("box", (0.1, 0.2, 0.3))


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
    "torque_side": "link", "friction": ["FL2"],
}  # fmt: skip
FRICTION = [
    {"name": "FL2", "kept": True, "fall": 0.75, "error": 0.125},
    {"name": "FR1", "kept": False, "fall": 0.25, "error": 0.5, "why_not": "explains no more"},
]
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


def uncertain(estimate: Any, k: int) -> dict[str, Any]:
    """A parameter's value and each of its standard deviations."""
    names = ("sigma", "sigma_robust", "sigma_by_gains", "relative_sigma_percent")
    return {"value": estimate.values[k]} | {name: getattr(estimate, name)[k] for name in names}


def elimination(result: Any, label: dict[str, str], warnings: list[str]) -> dict[str, Any]:
    estimate = result.estimate
    return {
        "rule": "ratio", "description": result.rule.description, "limit": 1.02, "warnings": warnings,
        "essential": 1, "sigma_ratio": 1.01, "largest_relative_sigma_percent": 5.0,
        "relative_residual": estimate.fit.relative,
        "parameters": [{"name": label.get("B", "B"), **uncertain(estimate, 0)}],
        "path": [
            {"eliminated": name, "remaining": left, "sigma_ratio": ratio, "largest_relative_sigma_percent": percent}
            for name, left, ratio, percent in (
                (None, 2, 1.0, 90.0), (label.get("A", "A"), 1, 1.01, 5.0), (label.get("B", "B"), 0, 2.5, 0.0)
            )
        ],
    }  # fmt: skip


def free_payload(result: Any) -> dict[str, Any]:
    estimate, body = result.estimate, result.body
    more = {"from_scale": True} if result.from_scale else {}
    return {
        **more,
        "estimator": "wls",
        "method": result.method,
        "parameters": ten(estimate.values),
        "sigma": ten(estimate.sigma), "sigma_robust": ten(estimate.sigma_robust), "robust": robust(estimate),
        "interval95": ten(estimate.interval95), "interval95_robust": ten(estimate.robust_interval95),
        "com": body.com, "com_sigma": result.spread.com,
        "com_sigma_robust": getattr(result.robust_spread, "com", None),
        "inertia_com": body.inertia_com, "inertia_com_sigma": result.spread.inertia_com,
        "inertia_com_sigma_robust": getattr(result.robust_spread, "inertia_com", None),
        "min_pseudo_inertia_eigenvalue": body.min_pseudo_inertia_eigenvalue,
        "physically_consistent": True,
        "relative_residual": estimate.fit.relative,
    }  # fmt: skip


def possible_payload(payload: Any) -> dict[str, Any]:
    free, intervals = payload.free.estimate, payload.intervals
    return {
        "estimator": "constrained",
        "method": payload.method,
        "parameters": ten(payload.result.values),
        "sigma": ten(free.sigma), "sigma_robust": ten(free.sigma_robust),
        "sigma_with_gains": ten(payload.result.free.sigma), "gain_sigma": GAINS,
        "interval95": ten(intervals.parameters), "interval95_by": "jackknife",
        "com": payload.body.com, "com_interval95": intervals.com,
        "inertia_com": payload.body.inertia_com, "inertia_com_interval95": intervals.inertia_com,
        "principal_moments": payload.principal_moments,
        "principal_moments_interval95": intervals.principal_moments,
        "min_pseudo_inertia_eigenvalue": 0.0021, "physically_consistent": True,
        "constraints": ["mass from 1 kg"],
        "active": [{"constraint": "mass from 1 kg", "multiplier": 0.33, "p_value": 0.0625}],
        "chi2_rise": 2.125, "p_value": 0.4375, "conflict": False,
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

LEAST = "joint 1 measures 0.980 ± 0.015 times the torque that the other joints predict"


def test_identify() -> None:
    result = made.identification()
    estimate = result.estimate
    groupings = ("AR = A + C", "BR = B - D")
    variances = np.diag(estimate.robust.covariance) / np.diag(estimate.covariance)
    memory = np.sqrt(np.median(variances))
    document, judged = robot_result(result), judge(Evidence(made.ANY_ROBOT, parameters=estimate))
    same(
        document,
        {
            "kind": "robot",
            "version": 1,
            "robot_title": "An arm",
            "joints": ["revolute", "prismatic"],
            "robot": "arm",
            "robot_fingerprint": "f00",
            "processing": PROCESSING,
            "data": {
                "equations": 96,
                "rows_per_joint": [31, 32, 33],
                "degrees_of_freedom": 301.5,
                "error_norms": [1.1, 1.2, 1.3],
                "torque_norms": [21.0, 22.0, 23.0],
                "weights": estimate.weights,
                "torque_noise": memory * estimate.fit.rms,
                "independent_rate_hz": 0.5 * made.PROCESSING.equations_a_second(100.0),
            },
            "columns": ["A", "B"],
            "covariance": estimate.covariance,
            "covariance_robust": estimate.robust.covariance,
            "robust": robust(estimate),
            "base_parameters": [
                {
                    "name": ("AR", "BR")[k],
                    "grouping": groupings[k],
                    **uncertain(estimate, k),
                    "interval95": estimate.interval95[k],
                    "interval95_robust": estimate.robust_interval95[k],
                    "interval95_with_gains": estimate.interval95_with_gains[k],
                    "essential": bool(k),
                }
                for k in range(2)
            ],
            "elimination": elimination(result.elimination, {"A": "AR", "B": "BR"}, ["warned"]),
            "constrained": None,
            "friction": FRICTION,
            "chi2_by": "jackknife",
            "condition_number": 41.5,
            "condition_number_scaled": 4.25,
            "gain_sensitivity": estimate.gain_sensitivity,
            "gain_sigma": GAINS,
            "relative_residual": residual(made.FIT),
            "validation": residual(made.CHECK),
            "reasons_against_use": judged.reasons,
            "verdict": {"level": judged.level, "reasons": judged.reasons},
        },
    )
    stored = convert(written(document), RobotResult)
    for name in ("values", "covariance", "weights", "gain_sensitivity"):
        assert np.array_equal(getattr(stored.estimate, name), getattr(estimate, name)), name
    assert (stored.estimate.names, stored.estimate.degrees_of_freedom) == (("A", "B"), 301.5)
    assert stored.estimate.robust is not None
    assert np.array_equal(stored.estimate.robust.covariance, estimate.robust.covariance)
    assert (stored.drive_gains, stored.fingerprint, stored.robot) == ((2.5, 3.5), "f00", "arm")
    assert stored.gains is not None
    assert (stored.gains.recordings, stored.gains.mass) == (made.GAINS.recordings, 6.5)


@pytest.mark.parametrize("prior", [False, True])
def test_a_robot_that_can_exist(prior: bool) -> None:
    free = made.estimate(("A", "B"))
    result = made.possible_robot(free) if prior else made.possible_base(free)
    moved = (result.values - free.values) / free.sigma
    expected: dict[str, Any] = {
        "gauge": "prior" if prior else "base",
        "status": result.status,
        "chi2_rise": result.chi2_rise,
        "p_value": result.p_value,
        "active": [{"description": "link 2", "multiplier": 0.125}],
        "min_eigenvalues": {"1": result.min_eigenvalues[0], "2": result.min_eigenvalues[1]},
        "base_parameters": [
            {"name": name, "value": result.values[k], "free": free.values[k], "moved_in_sigma": moved[k]}
            for k, name in enumerate(("AR", "BR"))
        ],
        "unidentifiable": ["M1"],
    }
    if prior:
        numbers = {"budget": 2.75, "weight": 0.875, "distances": [0.5, 0.75], "nearest_chi2_rise": 4.5}
        expected["prior"] = {"source": "data sheet", **numbers}
        expected["parameters"] = [
            {"name": "M1", "value": 4.5, "kind": "prior", "base": [], "share": 0.0, "decided_by": "by prior",
             "prior": 7.5},
            {"name": "A", "value": 5.5, "kind": "identified", "base": ["AR"], "share": 1.0,
             "decided_by": "by identified"},
        ]  # fmt: skip
    document = PossibleRobotDocument.made(result, made.base())
    same(document, expected)
    if prior:
        stored = convert(written(document), PossibleRobotDocument)
        assert (stored.standard, stored.source) == ({"M1": 4.5, "A": 5.5}, "data sheet")


def test_payload() -> None:
    answer = made.payload()
    document = payload_result(answer)
    same(
        document,
        {
            "kind": "payload", "version": 1, "robot_title": "An arm",
            "robot": "arm",
            "frame": "flange: plain", "flange_in_payload_frame": FLANGE,
            "rated_payload_kg": 12.25,
            "processing": PROCESSING,
            "relative_residual": {**residual(made.FIT), "validation": residual(made.CHECK)},
            "data": {
                "torque_noise": [0.31, 0.32, 0.33], "independent_rate_hz": 7.5,
                "equations": 120, "equations_loaded": 130, "rate_hz": 99.5, "cutoff_hz": 11.0, **PAIRS,
                "condition_number": 42.5, "condition_number_scaled": 4.5, "base_parameters": 2, "friction": "own",
            },
            "estimates": [free_payload(answer.estimates[0]), possible_payload(answer.constrained[0])],
            "recommended": {"method": 3, "estimator": "constrained", "reason": "one path"},
            "mass_by_joints": MASS_BY_JOINTS,
            "friction": FRICTION,
            "essential": elimination(answer.elimination, {"A": "AR", "B": "BR"}, ["warned"]),
            "left_out": {"2": "no pair"},
            "verdict": VERDICT,
            "gain_sigma": GAINS,
            "joint_that_agrees_least": LEAST,
            "quantities": {
                "mass": {"use": "use", "why": None, "value": 3.05, "interval95": [2.9, 3.2], "sigma": 0.07},
                "centre_of_mass": {"use": "use", "why": None, "value": answer.com,
                                   "interval95": answer.intervals[1:], "sigma": answer.spread.com},
                "inertia": {
                    "use": "not measured well enough", "why": None, "value": answer.possible.body.inertia_com,
                    "interval95": answer.possible.intervals.inertia_com, "sigma": answer.spread.inertia_com,
                },
            },
        },
    )  # fmt: skip
    assert isinstance(document, PayloadResult)


@pytest.mark.parametrize("possible", [True, False])
def test_weigh(possible: bool) -> None:
    answer = made.weighing(possible)
    estimate = answer.free.estimate
    some = {
        "estimator": "wls", "method": 1,
        "parameters": {kind: {"MX": 0.03, "MY": 0.06, "M": 3.05}.get(kind) for kind in INERTIAL},
        "sigma": dict.fromkeys(INERTIAL) | dict(zip(("MX", "MY", "M"), estimate.sigma, strict=False)),
        "sigma_robust": dict.fromkeys(INERTIAL)
        | dict(zip(("MX", "MY", "M"), estimate.sigma_robust, strict=False)),
        "interval95": None, "com": answer.com, "com_sigma": answer.spread.com, "inertia_com": None,
        "physically_consistent": None, "robust": robust(estimate), "from_scale": True,
    }  # fmt: skip
    all_ten = possible and [free_payload(answer.free), possible_payload(answer.possible)]
    document = payload_result(answer)
    if not possible:
        document = document.assuming(BOX)
    com = document.com.value
    shown = answer.possible.body if possible else BOX.body(3.05, com)
    same(
        document,
        {
            "kind": "payload", "version": 1, "robot_title": "An arm",
            "robot": "arm",
            "frame": "flange: plain", "flange_in_payload_frame": FLANGE,
            "rated_payload_kg": 12.25,
            "joints": [1, 2],
            "processing": PROCESSING,
            "relative_residual": {
                "all": estimate.fit.relative, "per_joint": answer.free.unexplained(answer.problem.torque_rms),
                "validation": None,
            },
            "data": {
                "equations": 140, "rate_hz": 98.5, "cutoff_hz": 11.0, **PAIRS, "condition_number": 43.5,
                "condition_number_scaled": 4.75, "friction": "free",
            },
            "joint_that_agrees_least": LEAST,
            "scale": [3.1, 0.05],
            "visibility": {"joints": [1, 2], "rank": 3, "parameters": {"M": "alone"}, "combinations": ["MZ + M"]},
            "constant_torques": {"joints": [1, 2], "sigma": [0.21, 0.22]},
            "ripple": [
                {"source": "a.csv", "joint": 2, "waves_per_turn": 36.0, "amplitude": 0.75,
                 "probability_by_noise": RIPPLE_CHANCE}
            ],
            "quantities": {
                "mass": {"use": "use mass", "why": "why mass", "value": 3.05, "interval95": [2.9, 3.2],
                         "sigma": 0.07},
                "centre_of_mass": {"use": "use centre of mass", "why": "why centre of mass", "value": answer.com,
                                   "interval95": answer.intervals[1:], "sigma": answer.spread.com},
                "inertia": {
                    "use": "use inertia" if possible else "assumed",
                    "why": "why inertia" if possible else BOX.description, "value": shown.inertia_com,
                    "interval95": answer.possible.intervals.inertia_com if possible else None,
                    "sigma": answer.spread.inertia_com if possible else None,
                },
            },
            "estimates": all_ten or [some],
            "recommended": {"method": 1, "estimator": "constrained" if possible else "wls", "reason": ""},
            "mass_from_scale": not possible,
            "agreement": [{"name": "difference", "mass": 3.06, "com": answer.evidence.agreement[0].com}],
            "mass_by_joints": MASS_BY_JOINTS,
            "repeats": {
                "sources": ["a.csv", "b.csv"], "masses": [3.03, 3.04], "sigmas": [0.13, 0.14], "spread": 0.05,
                "excess": 1.5, "drift_per_recording": 0.001, "drift_sigma": 0.002, "drifts": False,
            } if possible else None,
            "assumed": None if possible else {"inertia": BOX.description, "parameters": shown.named()},
            "verdict": {"level": "use", "reasons": []},
        },
    )  # fmt: skip
    assert isinstance(document, PayloadResult)


def test_gains(tmp_path: Path) -> None:
    own, document = made.logarithms(), made.drive_gains()
    assert own.robust is not None
    sigma = 1.25 * np.array([0.02, 0.02, 0.5])  # the larger ones, times the joints' disagreement
    same(
        document,
        {
            "kind": "gains",
            "version": 1,
            "robot_title": "An arm",
            "robot": "arm",
            "processing": PROCESSING | {"drive_gains": None},
            "load": {
                "known": {"M_L": 6.1, "M_L2": 6.2},
                "mass_sigma": 0.015,
                "identified": ten(made.body(6.0).vector),
                "mountings": [
                    {"mounting": 1, "identified": ten(made.body(6.0).vector)},
                    {"mounting": 3, "identified": ten(made.body(6.5).vector)},
                ],
            },
            "drive_gains": {
                "values": np.exp(own.values),
                "sigma": np.exp(own.values) * sigma,
                "relative_sigma": sigma,
                "relative_sigma_formula": own.sigma,
                "relative_sigma_robust": own.sigma_robust,
                "relative_covariance": own.robust.covariance
                * np.outer(sigma / own.robust.sigma, sigma / own.robust.sigma),
                "without_constraints": made.MOTORS + 0.5,
                "identified": [True, True, False],
                "rests_on": ["gravity", "speed", "nothing; too little, known to 62 % only: keep the maker's gain"],
            },
            "recordings": {"unloaded": ["u0", "u1"], "loaded": ["l0"]},
            "robust": {**robust(own), "blocks": 9, "block_length_s": 1.25, "degrees_of_freedom": 8},
            "relative_residual": residual(made.FIT),
            "disagreement": 1.25,
            "verdict": {"level": "identified_only", "reasons": ["motor 3"], "notes": ["a note"]},
        },
    )
    path = tmp_path / "gains.json"
    write_json(path, document)
    read = read_stored_gains(path)
    stored = read.errors
    assert np.array_equal(read.drive_gains.values, document.drive_gains.values)
    assert np.array_equal(stored.identified, document.drive_gains.relative_covariance)
    assert (read.robot, stored.mass, stored.recordings) == ("arm", 6.1, document.fingerprints)
    write_json(path, made.drive_gains("do_not_use"))
    with pytest.raises(InputError, match=r"do not use \(motor 3\)"):
        read_stored_gains(path)


def test_verify() -> None:
    change = Change("joint 2", 0.5, 0.25, 0.51, (0.4, 0.6), "fell")
    total = Change("all", 0.7, 0.35, 0.52, (0.3, 0.7), "fell")
    same(
        FollowingChange("following error", True, 0.015, (change,), total),
        {
            "compared": "following error", "tells": True, "lag_s": 0.015, "joints": [asdict(change)],
            "all": asdict(total),
        },
    )  # fmt: skip


ODD: Any = SimpleNamespace(recordings=("a", "b"), odd=(OddDocument("a", "FS1", 5.5),), parameters=("FS1", "M1"))
ODD_KEYS = [{"recording": "a", "parameter": "FS1", "sigmas": 5.5}]


def test_compare() -> None:
    values = {
        "values": made.numbers(2, 2), "sigma": 2.0 * made.numbers(2, 2), "pooled": made.numbers(2),
        "pooled_interval95": 3.0 * made.numbers(2, 2), "scatter": 4.0 * made.numbers(2),
        "apart": 5.0 * made.numbers(2, 2), "bound": 6.5,
    }  # fmt: skip
    expected = {"recordings": ODD.recordings, "parameters": ODD.parameters, **values, "odd": ODD_KEYS}
    same(documents.DOCUMENTS["compare"](**vars(ODD), **values), expected)


FLANGE = {"xyz": [0.125, 0.25, 0.375], "rpy_deg": [0.0, 0.0, 90.0], "source": "told there"}
