"""``dynident payload``: the answer, what is known beforehand, which methods; a robot identified once and kept."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps.commands.demo import PAYLOAD
from dynident.tests.commands.typed import Answer, answered, refused
from dynident.tests.selection import cases

TWO = "--unloaded bare0.csv --loaded loaded0.csv --unloaded bare1.csv --loaded loaded1.csv"
TRUTH = PAYLOAD.named()


def by_estimator(answer: Answer) -> tuple[list[Any], list[Any]]:
    """Free and constrained estimates."""
    estimates = answer.document["estimates"]
    free, constrained = ([x for x in estimates if x["estimator"] == name] for name in ("wls", "constrained"))
    return free, constrained


def test_payload(logs: Path) -> None:
    answer = answered(f"payload --robot rx90 {TWO} --validate bare2.csv")
    data = answer.document["data"]
    assert data["base_parameters"] == 54
    assert data["rate_hz"] == pytest.approx(250.0)
    assert abs(data["lag_s"]) < 1e-3
    free, constrained = by_estimator(answer)
    assert [x["method"] for x in free] == [x["method"] for x in constrained] == [1, 2, 3, 4]
    reason = answer.document["recommended"].pop("reason")
    assert answer.document["recommended"] == {"method": 3, "estimator": "constrained"}
    assert reason.startswith("one path, within 0.0")
    for estimate in constrained:
        assert estimate["physically_consistent"]
        assert estimate["min_pseudo_inertia_eigenvalue"] >= 0.0
        assert estimate["gain_sigma"] is None
        assert estimate["solver_status"] in ("free", "Solved")
        for name, (low, high) in estimate["interval95"].items():
            assert low <= estimate["parameters"][name] <= high
    for estimate in free:
        assert estimate["robust"]["blocks"] >= 10
        assert estimate["parameters"]["M"] == pytest.approx(7.025, rel=0.01)
        assert np.allclose(estimate["com"], [0.0, 0.0, 1.003 / 7.025], atol=0.01)
        for name, value in estimate["parameters"].items():
            low, high = estimate["interval95"][name]
            assert low < value < high
            assert abs(value - TRUTH[name]) < 5.0 * estimate["sigma"][name]
            assert 0.0 < estimate["sigma_robust"][name] < 10.0 * estimate["sigma"][name]
    assert answer.document["verdict"]["level"] in ("use", "mass_and_com_only")
    assert "Verdict" in answer.text
    assert "± the larger of the formula's (17)-(19) and the block jackknife's standard deviation." in answer.text
    assert "Mass, sigma_robust/sigma" in answer.text
    assert "…" not in answer.text


WRONG = {
    "identify --robot rx90 --data constant.csv": "Do not use these parameters",
    "payload --robot rx90 --unloaded flipped.csv --loaded loaded2.csv --method 4": "signs",
    "payload --robot rx90 --unloaded mirrored_bare.csv --loaded mirrored_loaded.csv --method 3": "joint 5",
}


@pytest.mark.parametrize("line", cases(WRONG, lambda line: line.startswith("identify")))
def test_a_description_that_is_not_the_robots_is_not_to_be_used(logs: Path, line: str) -> None:
    assert WRONG[line] in answered(line, status=(1,)).text


@pytest.mark.long
def test_identify_once_weigh_ever_after(logs: Path) -> None:
    """Method 1 gives the same, robust deviations or not; an old file says what it lacks."""
    stored = logs / "robot.json"
    line = f"payload --robot rx90 --robot-parameters {stored} --loaded loaded0.csv --loaded loaded1.csv"
    answer = answered("identify --robot rx90 --data bare0.csv --data bare1.csv --validate bare2.csv")
    robot = answer.document
    stored.write_text(json.dumps(robot))
    assert "…" not in answer.text
    assert "sigma_robust/sigma (jackknife over" in answer.text
    assert np.shape(robot["covariance"]) == np.shape(robot["covariance_robust"]) == (54, 54)
    assert robot["robust"]["blocks"] >= 10
    assert robot["chi2_by"] == "jackknife"
    assert robot["base_parameters"][0]["grouping"].startswith("ZZ1R = ZZ1 + IA1")
    ((later,), _) = by_estimator(answered(f"{line} --friction-change 0"))  # as method 1 takes it in the same run
    ((at_once,), _) = by_estimator(answered(f"payload --robot rx90 {TWO} --method 1"))
    assert later["method"] == 1
    assert later["parameters"] == pytest.approx(at_once["parameters"], rel=1e-9)
    for name, sigma in at_once["sigma_robust"].items():
        assert 0.3 < later["sigma_robust"][name] / sigma < 3.0
    stored.write_text(json.dumps(robot | {"covariance_robust": None, "robust": None}))
    answer = answered(line)
    assert "identify the robot again" in answer.text
    ((old,), _) = by_estimator(answer)
    assert old["sigma_robust"] is None
    for one, other in ((later, at_once), (old, later)):  # joints are compared otherwise, and less is seen of a tilt
        wider = one["sigma"]["M"] / other["sigma"]["M"]
        assert one["sigma"] == pytest.approx({k: wider * sigma for k, sigma in other["sigma"].items()}, rel=0.01)


def test_stored_parameters_of_another_robot(logs: Path) -> None:
    robot = answered("identify --robot rx90 --data bare0.csv").document
    line = "payload --robot rx90 --robot-parameters robot.json --loaded loaded0.csv"
    for change, more, words in (
        ({"robot": "tx40"}, "", "'tx40', not 'rx90'"),
        ({"columns": robot["columns"][1:]}, "", "robot.json"),
        ({}, "--offsets true", "must be those the stored parameters"),
        ({}, "--coulomb paper", "must be those the stored parameters"),
    ):
        (logs / "robot.json").write_text(json.dumps(robot | change))
        assert words in refused(f"{line} {more}")
    del robot["covariance"]
    (logs / "robot.json").write_text(json.dumps(robot))
    assert "'covariance': missing" in refused(line)


@pytest.mark.parametrize("command", ["identify", "payload"])
def test_the_equations_give_the_estimate(command: str, logs: Path) -> None:
    """Those of the NPZ, solved, give the numbers of the JSON: of a payload (30), where friction does not change."""
    inputs = {
        "identify": "--data bare0.csv",
        "payload": "--unloaded bare0.csv --loaded loaded0.csv --friction-change 0 --method 4",
    }
    document = answered(f"{command} --robot rx90 {inputs[command]} --npz out.npz").document
    with np.load("out.npz", allow_pickle=False) as data:
        weights = data["row_weights"]
        values = np.linalg.lstsq(data["W"] * weights[:, None], data["Y"] * weights, rcond=None)[0]
        solved = dict(zip((str(name) for name in data["columns"]), values, strict=True))
    if command == "identify":
        expected = {c: p["value"] for c, p in zip(document["columns"], document["base_parameters"], strict=True)}
    else:
        expected = {f"{kind}_L": value for kind, value in document["estimates"][0]["parameters"].items()}
    assert {name: solved[name] for name in expected} == pytest.approx(expected, rel=1e-6, abs=1e-7)
