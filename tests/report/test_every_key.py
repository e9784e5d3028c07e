"""Every key of every JSON document holds the number it is named after, and is read back as it was written."""

import math
from dataclasses import asdict
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from dynident import __version__
from dynident.common.errors import InputError
from dynident.common.schema import Document, convert, write_json
from dynident.estimation import Verdict
from dynident.estimation.diagnosis import Finding, robot_verdict
from dynident.estimation.diagnosis.evidence import Evidence
from dynident.estimation.diagnosis.finding import error
from dynident.estimation.diagnosis.fits import RobotFit, RobotFits
from dynident.estimation.diagnosis.log_check import Excited
from dynident.estimation.diagnosis.log_facts import JointFacts, TimeFacts
from dynident.estimation.files import StoredPayload, StoredRobot, read_stored_gains
from dynident.estimation.files.parts import PossibleRobotDocument
from dynident.estimation.payload import RIPPLE_CHANCE
from dynident.model import INERTIAL, Processing
from dynident.report import documents
from dynident.tests.report import made
from dynident.tests.report.written import written
from dynident.trajectories import BlendedPoints, Fourier, PayloadSet, Trapezoid, ViaPoints


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
}  # fmt: skip
GAINS = {
    "per_joint": [0.01, 0.02, 0.03], "common": 0.004, "identified": np.diag([1e-4, 2e-4, 3e-4]),
    "recordings": {"unloaded": ["u"], "loaded": ["l"]}, "mass": 6.5, "notes": ["said"],
}  # fmt: skip
VERDICT = {"level": "mass_and_com_only", "reasons": ["why"]}


def residual(fit: Any) -> dict[str, Any]:
    return {"all": fit.relative, "per_joint": fit.relative_per_joint}


def robust(estimate: Any) -> dict[str, Any]:
    told = estimate.robust
    return {"blocks": 8, "block_length_s": 1.75, "degrees_of_freedom": 6, "warning": told.warning}


def elimination(found: Any, label: dict[str, str], warnings: list[str]) -> dict[str, Any]:
    estimate = found.estimate
    return {
        "rule": "ratio",
        "description": found.rule.description,
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
    }  # fmt: skip


def free_payload(result: Any) -> dict[str, Any]:
    estimate, body = result.estimate, result.body
    return {
        "estimator": "wls",
        "method": result.method,
        "parameters": ten(estimate.values),
        "sigma": ten(estimate.sigma),
        "sigma_robust": ten(estimate.sigma_robust),
        "interval95": ten(estimate.interval95),
        "interval95_robust": ten(estimate.robust_interval95),
        "robust": robust(estimate),
        "com": body.com,
        "com_sigma": result.sigma_com,
        "com_sigma_robust": result.sigma_com_robust,
        "inertia_com": body.inertia_com,
        "inertia_com_sigma": result.sigma_inertia_com,
        "inertia_com_sigma_robust": result.sigma_inertia_com_robust,
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
PAIRS = {"lag_s": 0.011, "lags_s": [0.011, 0.012], "max_position_mismatch_rad": 0.0072}


def test_identify() -> None:
    result = made.identification()
    estimate = result.estimate
    groupings = ("AR = A + C", "BR = B - D")
    document = documents.identification_document(result, made.PROCESSING, (2.5, 3.5), None)
    same(
        document,
        {
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
            },
            "columns": ["A", "B"],
            "covariance": estimate.covariance,
            "covariance_robust": estimate.robust.covariance,
            "robust": robust(estimate),
            "base_parameters": [
                {
                    "name": ("AR", "BR")[k],
                    "grouping": groupings[k],
                    "value": estimate.values[k],
                    "sigma": estimate.sigma[k],
                    "relative_sigma_percent": estimate.relative_sigma_percent[k],
                    "sigma_robust": estimate.sigma_robust[k],
                    "interval95": estimate.interval95[k],
                    "interval95_robust": estimate.robust_interval95[k],
                    "sigma_by_gains": estimate.sigma_by_gains[k],
                    "interval95_with_gains": estimate.interval95_with_gains[k],
                    "essential": bool(k),
                }
                for k in range(2)
            ],
            "elimination": elimination(result.elimination, {"A": "AR", "B": "BR"}, ["warned"]),
            "constrained": None,
            "chi2_by": "jackknife",
            "condition_number": 41.5,
            "condition_number_scaled": 4.25,
            "gain_sensitivity": estimate.gain_sensitivity,
            "gain_sigma": GAINS,
            "relative_residual": residual(made.FIT),
            "validation": residual(made.CHECK),
            "reasons_against_use": robot_verdict(Evidence(made.ANY_ROBOT, parameters=estimate)).reasons,
        },
    )
    stored = convert(written(document), StoredRobot)
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
        expected["prior"] = {"source": "data sheet", "budget": 2.75, "weight": 0.875, "distances": [0.5, 0.75]}
        expected["parameters"] = [
            {"name": "M1", "value": 4.5, "kind": "prior", "base": [], "share": 0.0, "decided_by": "by prior"},
            {"name": "A", "value": 5.5, "kind": "identified", "base": ["AR"], "share": 1.0,
             "decided_by": "by identified"},
        ]  # fmt: skip
    document = documents.constrained_document(result, made.base())
    same(document, expected)
    if prior:
        stored = convert(written(document), PossibleRobotDocument)
        assert (stored.standard, stored.source) == ({"M1": 4.5, "A": 5.5}, "data sheet")


def test_payload() -> None:
    answer = made.payload()
    document = documents.payload_document(answer, made.PROCESSING, (2.5, 3.5))
    same(
        document,
        {
            "robot": "arm",
            "frame": "flange: plain", "flange_in_payload_frame": FLANGE,
            "rated_payload_kg": 12.25,
            "processing": PROCESSING,
            "relative_residual": {**residual(made.FIT), "validation": residual(made.CHECK)},
            "data": {
                "equations": 120, "equations_loaded": 130, "rate_hz": 99.5, "cutoff_hz": 11.0, **PAIRS,
                "condition_number": 42.5, "condition_number_scaled": 4.5, "base_parameters": 2,
            },
            "estimates": [free_payload(answer.estimates[0]), possible_payload(answer.constrained[0])],
            "recommended": {"method": 3, "estimator": "constrained"},
            "mass_by_joints": MASS_BY_JOINTS,
            "essential": elimination(answer.elimination, {"A": "AR", "B": "BR"}, ["warned"]),
            "left_out": {"2": "no pair"},
            "verdict": VERDICT,
        },
    )  # fmt: skip
    assert isinstance(document, StoredPayload)


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
        "physically_consistent": None,
    }  # fmt: skip
    all_ten = possible and [free_payload(answer.free), possible_payload(answer.possible)]
    shown = answer.possible.body if possible else answer.assumed
    document = documents.payload_document(answer, made.PROCESSING, (2.5, 3.5))
    same(
        document,
        {
            "robot": "arm",
            "frame": "flange: plain", "flange_in_payload_frame": FLANGE,
            "rated_payload_kg": 12.25,
            "joints": [1, 2],
            "processing": PROCESSING,
            "relative_residual": {
                "all": estimate.fit.relative, "per_joint": answer.free.unexplained(answer.short.torque_rms),
                "validation": None,
            },
            "data": {
                "equations": 140, "rate_hz": 98.5, "cutoff_hz": 11.0, **PAIRS, "condition_number": 43.5,
                "condition_number_scaled": 4.75,
            },
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
                                   "interval95": answer.com_interval, "sigma": answer.spread.com},
                "inertia": {
                    "use": "use inertia", "why": "why inertia", "value": shown.inertia_com,
                    "interval95": answer.possible.intervals.inertia_com if possible else None,
                    "sigma": answer.spread.inertia_com if possible else None,
                },
            },
            "estimates": all_ten or [some],
            "recommended": {"method": 1, "estimator": "constrained" if possible else "wls"},
            "mass_from_scale": not possible,
            "agreement": [{"name": "difference", "mass": 3.06, "com": answer.agreement[0].com}],
            "mass_by_joints": MASS_BY_JOINTS,
            "repeats": {
                "sources": ["a.csv", "b.csv"], "masses": [3.03, 3.04], "sigmas": [0.13, 0.14], "spread": 0.05,
                "excess": 1.5, "drift_per_recording": 0.001, "drift_sigma": 0.002, "drifts": False,
            } if possible else None,
            "assumed": None if possible else {"inertia": "a box", "parameters": answer.assumed.named()},
            "verdict": {"level": "use", "reasons": []},
        },
    )  # fmt: skip
    assert isinstance(document, StoredPayload)


def test_a_rate_of_equations_stands_in_the_place_of_a_factor() -> None:
    processing = Processing(equation_rate=12.5)
    assert written(documents.gains_document(made.drive_gains(), processing))["processing"]["equations_hz"] == 12.5


def test_gains(tmp_path: Path) -> None:
    gains = made.drive_gains()
    document = documents.gains_document(gains, made.PROCESSING)
    same(
        document,
        {
            "robot": "arm",
            "processing": {
                "rate_hz": 101.0,
                "cutoff_hz": 11.0,
                "decimate": 7,
                "slow_fraction": 0.04,
                "slow_speed": 0.06,
            },
            "load": {
                "known": {"M_L": 6.1, "M_L2": 6.2},
                "mass_sigma": 0.015,
                "identified": ten(gains.payloads[0].vector),
                "mountings": [
                    {"mounting": 1, "identified": ten(gains.payloads[0].vector)},
                    {"mounting": 3, "identified": ten(gains.payloads[1].vector)},
                ],
            },
            "drive_gains": {
                "values": gains.values,
                "sigma": gains.values * gains.larger_relative_sigma,
                "relative_sigma": gains.larger_relative_sigma,
                "relative_sigma_formula": gains.relative_sigma,
                "relative_sigma_robust": gains.relative_sigma_robust,
                "relative_covariance": gains.larger_relative_covariance,
                "without_constraints": gains.free_values,
                "identified": [True, True, False],
                "rests_on": ["gravity", "speed", "nothing"],
            },
            "recordings": {"unloaded": ["u0", "u1"], "loaded": ["l0"]},
            "robust": {"blocks": 9, "block_length_s": 1.25},
            "relative_residual": residual(made.FIT),
            "disagreement": 1.25,
            "verdict": {"level": "identified_only", "reasons": ["motor 3"], "notes": ["a note"]},
        },
    )
    path = tmp_path / "gains.json"
    write_json(path, document)
    stored = read_stored_gains(path)
    assert np.array_equal(stored.values, gains.values)
    assert np.array_equal(stored.identified, gains.larger_relative_covariance)
    assert (stored.robot, stored.mass, stored.recordings) == ("arm", 6.1, gains.recordings)
    gains.verdict = Verdict("do_not_use", (error("another scale"),))
    write_json(path, documents.gains_document(gains, made.PROCESSING))
    with pytest.raises(InputError, match=r"do not use \(another scale\)"):
        read_stored_gains(path)


FLANGE = {"xyz": [0.125, 0.25, 0.375], "rpy_deg": [0.0, 0.0, 90.0], "source": "told there"}
LIMIT = SimpleNamespace(
    name="speed", worst="joint 2", value=1.5, limit=2.0, violation=0.25, relative=0.125, room=0.5
)

HELD = SimpleNamespace(
    kind="torque", values=lambda state: np.array([[0.25, 0.75, -0.5, 0.5]]), unit=np.array([20.0, 20.0, 20.0, 20.0])
)


def score(value: float) -> Any:
    """A motion judged."""
    sigma = {"A": 0.1 + value, "B": 0.2 + value}
    learnt = SimpleNamespace(
        condition_number=51.0 + value, condition_number_scaled=5.5 + value, log_det=33.0 + value, sigma=sigma
    )
    return SimpleNamespace(
        value=value, learnt=learnt, duration=12.0 + value, limits=(LIMIT,), max_violation=0.125 + value,
        feasible=False, violations=(f"too fast by {value}",), relative_sigma=lambda reference: {"A": 0.75},
        samples=SimpleNamespace(q=np.zeros((1, 2))),
    )  # fmt: skip


SEARCH = {"seed": 7, "starts": 8, "solver": "augmented", "evaluations": 900, "cpu_s": 6.5, "interrupted": True}
POINTS, TIMES, SPEEDS, STEEP = (made.numbers(*shape) for shape in ((3, 2), (2,), (3, 2), (3, 2)))
BLENDS, A, B = (made.numbers(*shape) for shape in ((3,), (2, 4), (2, 4)))
VIA = {"kind": "via points", "points": POINTS, "durations": TIMES}
PLANS = [
    (
        made.made(
            ViaPoints, points=POINTS, durations=TIMES, speeds=SPEEDS, accelerations=STEEP, segment=Trapezoid(0.3)
        ),
        VIA | {"speeds": SPEEDS, "accelerations": STEEP, "segments": Trapezoid(0.3).name, "ramp": 0.3,
               "blends": None},
    ),
    (
        made.made(BlendedPoints, points=POINTS, durations=TIMES, blends=BLENDS),
        VIA | {"speeds": None, "accelerations": None, "segments": "blend", "ramp": None, "blends": BLENDS},
    ),
    (
        made.made(Fourier, offset=TIMES, a=A, b=B, period=8.5),
        {"kind": "fourier", "offset": TIMES, "a": A, "b": B, "period": 8.5},
    ),
]  # fmt: skip


@pytest.mark.parametrize(("plan", "motion"), [*PLANS, (None, {})])
def test_design(plan: Any, motion: dict[str, Any]) -> None:
    goal = SimpleNamespace(rate=14.0, data_length=60.0)
    problem: Any = SimpleNamespace(
        robot=SimpleNamespace(**vars(made.ROBOT), n=2), criterion=SimpleNamespace(kind="a"), goal=goal,
        noise=np.array([1.5, 2.5]),
        torque_limited=False, payloads=PayloadSet.within(3.5, (0.1, 0.2, 0.3), (0.4, 0.5, 0.6), box=True),
        limits=(HELD,), at_rest=lambda poses: None,
    )  # fmt: skip
    found: Any = SimpleNamespace(plan=plan, **SEARCH) if plan is not None else None
    floor: Any = SimpleNamespace(value=0.04, gap=0.06, states=300)
    document = documents.design_document(
        problem, score(0.03), {"A": 2.0}, design=found, floor=floor, evaluated="log.csv", replay=score(0.05)
    )  # fmt: skip
    same(
        document,
        {
            "robot": "arm", "robot_fingerprint": "f00", "criterion": "a", "criterion_value": 0.03,
            "condition_number": 51.03, "condition_number_scaled": 5.53, "log_det": 33.03,
            "predicted_sigma": {"A": 0.13, "B": 0.23}, "predicted_sigma_percent": {"A": 75.0, "B": None},
            "torque_noise": [1.5, 2.5], "independent_rate_hz": 14.0, "data_length_s": 60.0, "duration_s": 12.03,
            "limits": {"max_violation": 0.155, "met": False, "nearest": [vars(LIMIT)]},
            "payload_bounds": {
                "mass": 3.5, "region": "cube", "centre": [0.4, 0.5, 0.6], "axes": np.diag([0.1, 0.2, 0.3]),
                "holding_torque": [10.0, 15.0],
            },
            "floor": {"criterion_value": 0.04, "gap": 0.06, "states": 300},
            "evaluated": "log.csv",
            "val3_replay": {
                "criterion_value": 0.05, "condition_number": 51.05, "condition_number_scaled": 5.55,
                "duration_s": 12.05, "limits_met": False, "violations": ["too fast by 0.05"],
            },
            "assumed": {"speed": "told"},
            "version": __version__,
            **(SEARCH | {"motion": motion} if motion else {}),
        },
    )  # fmt: skip


def test_near() -> None:
    poses, ranges = made.numbers(2, 3), made.numbers(3)
    shape: Any = SimpleNamespace(joints=(2, 3), poses=poses, ranges=ranges)
    motion: Any = SimpleNamespace(
        period=2.5, repeats=4, transfer=1.25, duration=23.0,
        slowed=lambda speed: SimpleNamespace(duration=1.0 / speed),
    )  # fmt: skip
    visibility: Any = SimpleNamespace(joints=(2, 3), rank=5, parameters={"M": "alone"}, combinations=())
    spread: Any = SimpleNamespace(mass=0.011, com=made.numbers(3), inertia_com=made.numbers(3, 3))
    problem = SimpleNamespace(
        robot=made.ROBOT, criterion=SimpleNamespace(kind="a"), torque_limited=True, payloads=None
    )
    design: Any = SimpleNamespace(problem=problem, score=score(0.07), cpu_s=3.5, seed=9)
    same(
        documents.near_document(design, motion, shape, visibility, spread),
        {
            "robot": "arm", "criterion": "a",
            "near": {"poses": poses, "joints": [2, 3], "ranges": ranges, "period_s": 2.5, "repeats": 4,
                     "transfer_s": 1.25},
            "visibility": {"joints": [2, 3], "rank": 5, "parameters": {"M": "alone"}, "combinations": []},
            "predicted_sigma": {"mass": 0.011, "com": spread.com, "inertia_com": spread.inertia_com},
            "condition_number": 51.07, "condition_number_scaled": 5.57, "duration_s": 23.0, "rehearsal_s": 10.0,
            "cpu_s": 3.5, "seed": 9, "payload_bounds": None,
            "limits": {"max_violation": 0.195, "torque_checked": True, "nearest": [vars(LIMIT)]},
            "assumed": {"speed": "told", "torque": "told"},
        },
    )  # fmt: skip


def test_check() -> None:
    time = TimeFacts(1000, 9.9, 101.0, (0.009, 0.011), 0.002, (0.5, 9.5))
    facts: list[Any] = [True, (-1.0, 1.1), 2.2, (-30.0, 31.0), 0.001, 0.05, 0.01]
    joint = JointFacts(*facts)
    look: Any = SimpleNamespace(
        recording=SimpleNamespace(source="a.csv", notes=("resampled",)), currents=True, usable=False, time=time,
        findings=(Finding("warning", "joint 1", "saturates"),), joints=(joint,), relative_residual=0.0125,
        excitation=(Excited("AR", 1.25, 3.5),), condition_number_scaled=12.5,
    )  # fmt: skip
    robot: Any = made.ROBOT
    fits = RobotFits(("t", "q1"), (RobotFit("arm", 0.25),), (("other", "too fast"),), "")
    expected = {
        "source": "a.csv", "columns": ["t", "q1"], "fitting": [{"robot": "arm", "residual": 0.25}],
        "others": ["other"], "fault": None,
    }  # fmt: skip
    same(
        documents.check_document(None, [documents.Look("a.csv", None, fits)]),
        {"robot": None, "logs": [], "fits": [expected]},
    )
    same(
        documents.check_document(robot, [documents.Look("a.csv", look)]),
        {
            "robot": "arm",
            "logs": [{
                "source": "a.csv", "notes": ["resampled"], "currents": True, "usable": False,
                "findings": [{"severity": "warning", "words": "saturates"}], "time": asdict(time),
                "joints": [asdict(joint)],
                "excitation": [{"name": "AR", "value": 1.25, "relative_sigma_percent": 3.5}],
                "relative_residual": 0.0125, "condition_number_scaled": 12.5,
            }],
        },
    )  # fmt: skip


def test_rollout() -> None:
    spread = {"identified": (0.01, 0.02), "constant speed": (0.03, 0.04)}
    rollout: Any = SimpleNamespace(
        source="a.csv", resting=np.array([False, True, False]), diverged=1, horizons=(0.5,), growth=1.25,
        errors=spread, spread=lambda by, seconds, resting: None if resting else spread[by],
        replay=SimpleNamespace(relative=0.045, joints=made.numbers(3), strayed=0.002),
    )  # fmt: skip
    expected = {
        "source": "a.csv", "starts_in_motion": 2, "starts_at_rest": 1, "diverged": 1,
        "horizons": [{"seconds": 0.5, "in_motion": spread, "at_rest": None}], "growth": 1.25,
        "replay_relative": 0.045, "replay_joints": rollout.replay.joints, "replay_strayed": 0.002,
    }  # fmt: skip
    same(documents.rollouts_document("arm", [rollout]), {"robot": "arm", "rollouts": [expected]})


@pytest.mark.parametrize("hidden", ["", "not visible yet"])
def test_weigh_live(hidden: str) -> None:
    change: Any = SimpleNamespace(time=57.5, mass=2.75, low=2.5, high=3.0)
    weighed: Any = SimpleNamespace(
        mass=2.8, low=2.7, high=2.9, com=np.array([0.1, 0.2, np.nan]), com_sigma=np.array([0.01, 0.02, np.inf]),
        seconds=20.0, hidden=hidden,
    )  # fmt: skip
    line = {"time_s": 57.5, "change_kg": 2.75, "interval95_kg": [2.5, 3.0], "told_s": 62.5}
    told = documents.change_document(change, 62.5)
    same(told, line)
    expected = {
        "robot": "arm", "frame": "tool0", "seconds": 20.0, "mass_kg": None if hidden else 2.8,
        "interval95_kg": None if hidden else [2.7, 2.9], "com_m": [0.1, 0.2, None],
        "com_sigma_m": [0.01, 0.02, None], "hidden": hidden, "changes": [line],
    }  # fmt: skip
    same(documents.live_document("arm", "tool0", weighed, [told]), expected)


def test_verify() -> None:
    joint = {"name": "joint 2", "before": 0.5, "after": 0.25, "fall": 0.51, "interval": [0.4, 0.6], "clear": "fell"}
    total = {"name": "all", "before": 0.7, "after": 0.35, "fall": 0.52, "interval": [0.3, 0.7], "clear": "fell"}
    found: Any = SimpleNamespace(
        kind="following error", tells=True, lag=0.015, joints=(SimpleNamespace(**joint),),
        total=SimpleNamespace(**total),
    )  # fmt: skip
    expected = {"compared": "following error", "tells": True, "lag_s": 0.015, "joints": [joint], "all": total}
    same(documents.following_document(found), expected)


def test_robot_check() -> None:
    reading = SimpleNamespace(
        order=(1, 0), sign=(1, -1), quarters=(0, 3), torque=(-1, 1), told=lambda: "swap 1 and 2"
    )
    ranked = SimpleNamespace(reading=reading, residual=0.035)
    check: Any = SimpleNamespace(
        ranked=(ranked,), unit="share", as_recorded=SimpleNamespace(residual=0.45), suggested=ranked
    )  # fmt: skip
    rows = {
        "unit": "share", "as_recorded": 0.45, "suggested": "swap 1 and 2",
        "ranked": [{"residual": 0.035, "order": [2, 1], "sign": [1, -1], "zero_deg": [0, 270],
                    "torque_sign": [-1, 1]}],
    }  # fmt: skip
    pose: Any = SimpleNamespace(
        reproduced=False, rms=0.006, errors=np.array([0.007, 0.008]), rms_angle=None, as_is=0.9, determined=True,
        angles=None, base=SimpleNamespace(origin=(0.1, 0.2, 0.3), rpy=(0.4, 0.5, 0.6)),
        tool=SimpleNamespace(origin=(0.7, 0.8, 0.9), rpy=(1.0, 1.1, 1.2)),
    )  # fmt: skip
    robot: Any = made.ROBOT
    log = {
        "log": "a.csv", "reproduced": False, "rms_m": 0.006, "largest_m": 0.008, "rms_angle_rad": None,
        "as_is_m": 0.9, "base": {"xyz_m": [0.1, 0.2, 0.3], "rpy_rad": [0.4, 0.5, 0.6]},
        "tool": {"xyz_m": [0.7, 0.8, 0.9], "rpy_rad": None}, "base_and_tool_determined": True,
    }  # fmt: skip
    logs = [documents.pose_document(documents.PoseLook("a.csv", pose, readings)) for readings in (check, None)]
    expected = [log | {"readings": rows}, log | {"readings": None}]
    same(documents.robot_check_document(robot, logs, check), {"robot": "arm", "poses": expected, **rows})
    same(documents.robot_check_document(robot, logs[:1], None), {"robot": "arm", "poses": expected[:1]})
