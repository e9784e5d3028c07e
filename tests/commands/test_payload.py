"""``dynident payload``: the answer, what is known beforehand, which methods; a robot identified once and kept."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps.commands.demo import PAYLOAD
from dynident.apps.report.recordings import write_recording
from dynident.model import InertialParameters, Pose, load_robot, mounted, with_tool
from dynident.tests.commands.typed import Answer, answered, refused
from dynident.tests.model.urdf_files import dressed_urdf
from dynident.tests.selection import cases
from dynident.trajectories import Simulator, random_via_points

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


@pytest.mark.long
def test_what_is_known_enters_the_answer(logs: Path) -> None:
    """Weighed mass, bounds, box, ellipsoid and uncertain gains: in the table, the notes and the JSON."""
    known = (
        "--mass 7.03+-0.01 --mass-bounds 6,8 --com-within=-0.1,0.1,-0.1,0.1,0,0.3 --ellipsoid 0,0,0.15,0.3,0.3,0.3"
    )
    gains = "--gain-sigma 2,2,1,1,1,3%,common=0.01"
    answer = answered(f"payload --robot rx90 {TWO} {known} {gains} --method 4")
    assert "Intervals include errors of the drive gains: 2, 2, 1, 1, 1, 3 % per motor and 1 % common" in answer.text
    assert "Scale 7.03 ± 0.01 kg, torques 7.0" in answer.text
    assert "sigma apart, in agreement." in answer.text
    assert "taken as exact" not in answer.text.split("Every parameter")[0]
    _, (constrained,) = by_estimator(answer)
    assert constrained["gain_sigma"] == {"per_joint": [0.02, 0.02, 0.01, 0.01, 0.01, 0.03], "common": 0.01}
    assert len(constrained["constraints"]) == 5
    (scale,) = constrained["weighed"]
    assert abs(scale["z"]) < 4.0
    assert constrained["sigma_with_gains"]["M"] > constrained["sigma_robust"]["M"]
    low, high = constrained["interval95"]["M"]
    assert low < 7.025 < high < low + 0.1


def test_a_bound_that_excludes_the_payload_is_named(logs: Path) -> None:
    answer = answered(f"payload --robot rx90 {TWO} --mass-bounds ,6 --method 4", status=(1,))
    assert "Contradicted by method 4: mass from 0 to 6 kg" in answer.text
    assert "do not use" in answer.text
    _, (constrained,) = by_estimator(answer)
    assert constrained["conflict"]
    assert constrained["interval95"]["M"] == [None, None]


def test_payload_without_jackknife(logs: Path) -> None:
    """One block of motion under load: intervals go by the memory of the errors, and a note says so."""
    line = "payload --robot rx90 --unloaded bare0.csv --unloaded bare1.csv --loaded brief.csv"
    answer = answered(line, status=(0, 1))
    assert "the larger of the formula's (17)-(19) and that by the memory of the errors" in answer.text
    assert "blocks are too few for a jackknife: intervals go by the memory of the errors" in answer.text
    assert "jackknife over" not in answer.text
    free, constrained = by_estimator(answer)
    assert [estimate["method"] for estimate in free] == [1, 4]
    assert {estimate["interval95_by"] for estimate in constrained} == {"memory"}
    for estimate in free:
        assert estimate["sigma_robust"]["M"] > 0.0
        assert estimate["parameters"]["M"] == pytest.approx(7.025, abs=5.0 * estimate["sigma"]["M"])


def test_one_method_and_options(logs: Path) -> None:
    options = "--method 1 free-friction=true --cutoff 15 equation-rate=50 coulomb=paper offsets=true"
    answer = answered(f"payload --robot rx90 {TWO} {options}", status=(0, 1))
    used = {"cutoff_hz": 15.0, "equations_hz": 50.0, "decimate": 1, "coulomb": "paper", "offsets": True}
    assert answer.document["processing"].items() >= used.items()
    assert answer.document["data"]["base_parameters"] == 60
    assert [estimate["method"] for estimate in answer.document["estimates"]] == [1, 1]
    assert "method 2" not in answer.text
    assert answer.document["essential"] is None


def test_a_method_that_cannot_answer_does_not_silence_the_others(logs: Path) -> None:
    answer = answered("payload --robot rx90 --unloaded bare0.csv --loaded loaded1.csv")
    assert "Method 3 left out" in answer.text
    assert "method 4" in answer.text


@pytest.mark.long
def test_method_4_tells_the_essential_parameters(logs: Path) -> None:
    answer = answered(f"payload --robot rx90 {TWO} --method 4 essential=10%", status=(0, 1))
    essential = answer.document["essential"]
    assert f"{essential['essential']} of 64 parameters essential" in answer.text
    assert {"M_L", "MZ_L"} <= {entry["name"] for entry in essential["parameters"]}


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


@pytest.mark.long
def test_uncertain_gains_of_a_stored_robot(logs: Path) -> None:
    """Said once, to identify, they hold for every payload weighed with that robot; said again, what is said now."""
    exact, told = (answered(f"identify --robot rx90 --data bare0.csv {more}") for more in ("", "--gain-sigma 2%"))
    for name, answer in (("exact", exact), ("told", told)):
        (logs / f"{name}.json").write_text(json.dumps(answer.document))
    assert "Drive gains are taken as exact: no residual shows their errors" in exact.text
    assert "include errors of the drive gains: 2 % per motor" in told.text
    assert ("by gains" in exact.text, "by gains" in told.text) == (False, True)
    assert exact.document["gain_sigma"] is None
    assert told.document["gain_sigma"] == {"per_joint": [0.02], "common": 0.0}
    for now, then in zip(told.document["base_parameters"], exact.document["base_parameters"], strict=True):
        assert (now["value"], now["sigma_robust"]) == (then["value"], then["sigma_robust"])
        assert then["sigma_by_gains"] is then["interval95_with_gains"] is None
        low, high = now["interval95_with_gains"]
        assert low < now["interval95_robust"][0] < now["interval95_robust"][1] < high
        assert now["sigma_by_gains"] > 0.0

    def weighed(name: str, more: str = "") -> tuple[float, str]:
        line = f"payload --robot rx90 --robot-parameters {name}.json --loaded loaded1.csv {more}"
        answer = answered(line, status=(0, 1))
        _, (constrained,) = by_estimator(answer)
        low, high = constrained["interval95"]["M"]
        return high - low, answer.text

    plain, text = weighed("exact")
    assert "Drive gains are taken as exact" in text
    told_now, text = weighed("exact", "--gain-sigma 2%")
    assert "were identified with" not in text
    told_then, text = weighed("told")
    assert "include errors of the drive gains: 2 % per motor" in text
    assert "that the robot's parameters were identified with" in text
    assert told_then == pytest.approx(told_now, rel=1e-6)
    assert told_now > 1.5 * plain
    again, text = weighed("told", "--gain-sigma 2%,2%,2%,2%,2%,2%")
    assert again == pytest.approx(told_then, rel=1e-6)
    assert "another uncertainty" not in text
    less, text = weighed("told", "--gain-sigma 1%")
    assert plain < less < told_now
    assert "identified with another uncertainty of the gains" in text


def test_stored_parameters_of_another_robot(logs: Path) -> None:
    robot = answered("identify --robot rx90 --data bare0.csv").document
    line = "payload --robot rx90 --robot-parameters robot.json --loaded loaded0.csv"
    for change, more, words in (
        ({"robot": "tx40"}, "", "'tx40', not 'rx90'"),
        ({"columns": robot["columns"][1:]}, "", "robot.json"),
        ({}, "offsets=true", "must be those the stored parameters"),
        ({}, "coulomb=paper", "must be those the stored parameters"),
    ):
        (logs / "robot.json").write_text(json.dumps(robot | change))
        assert words in refused(f"{line} {more}")
    del robot["covariance"]
    (logs / "robot.json").write_text(json.dumps(robot))
    assert "'covariance': missing" in refused(line)


@pytest.mark.long
def test_payload_on_a_wall_in_a_tool_frame(here: Path) -> None:
    """From a URDF on the wall, the answer stands in the tool frame that is asked for, and says so."""
    load = InertialParameters.from_com(5.0, [0.02, 0.01, 0.1], np.diag([0.03, 0.025, 0.02]))
    (here / "arm.urdf").write_text(dressed_urdf(load_robot("irb120"), seed=1, limits=False), encoding="utf-8")
    robot = mounted(load_robot(here / "arm.urdf"), (0.0, np.pi / 2, 0.0))
    drives = {f"{kind}{j}": value for j in range(1, 7) for kind, value in (("IA", 0.5), ("FS", 2.0), ("FV", 3.0))}
    robot = replace(robot, parameters={**robot.parameters, **drives})
    simulator = Simulator(with_tool(robot, Pose.from_rpy((0.0, 0.0, 0.1), (0.0, 0.0, np.pi / 2)), "tool"))
    motion = random_via_points(load_robot("irb120"), 10, seed=3).motion(100.0)
    for name, body in (("bare", None), ("loaded", load)):
        write_recording(here / f"{name}.csv", simulator.record(motion, body, [0.05] * 6, 3))
    answer = answered(
        "payload --robot arm.urdf --mount wall --tool-frame 0,0,0.1,0,0,90 --method 3 --unloaded bare.csv "
        "--loaded loaded.csv",
        status=(0, 1),
    )
    frame = "tool frame (0, 0, 0.1 m; rpy 0, 0, 90 deg) in: flange: link tool0 of arm.urdf"
    assert answer.document["frame"] == frame
    assert "tool frame (0, 0, 0.1 m" in answer.text
    estimate = answer.document["estimates"][0]
    assert estimate["parameters"]["M"] == pytest.approx(5.0, rel=0.01)
    np.testing.assert_allclose(estimate["com"], load.com, atol=3e-3)


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
