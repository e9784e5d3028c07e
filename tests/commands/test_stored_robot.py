"""A robot identified once, payloads ever after."""

import json
from pathlib import Path

import numpy as np
import pytest
from dynident.tests.commands.runs import Run, by_estimator, payload_arguments


@pytest.mark.long
def test_identify_once_weigh_ever_after(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    stored, target = tmp_path / "robot.json", tmp_path / "payload.json"
    data_arguments = ("--data", logs["bare0"], "--data", logs["bare1"], "--validate", logs["bare2"])
    status, out, _ = run("identify", "--robot", "rx90", *data_arguments, "--json", str(stored))
    assert status == 0
    assert "…" not in out
    robot = json.loads(stored.read_text())
    assert set(robot) >= {
        "robot", "processing", "data", "columns", "covariance", "base_parameters", "condition_number",
        "relative_residual", "validation",
    }  # fmt: skip
    assert np.shape(robot["covariance"]) == np.shape(robot["covariance_robust"]) == (54, 54)
    assert robot["robust"]["blocks"] >= 10
    assert robot["chi2_by"] == "jackknife"
    assert "sigma_robust/sigma (jackknife over" in " ".join(out.split())
    assert robot["base_parameters"][0]["name"] == "ZZ1R"
    assert robot["base_parameters"][0]["grouping"].startswith("ZZ1R = ZZ1 + IA1")
    assert set(robot["base_parameters"][0]) == {
        "name", "grouping", "value", "sigma", "relative_sigma_percent", "sigma_robust", "interval95",
        "interval95_robust", "sigma_by_gains", "interval95_with_gains", "essential",
    }  # fmt: skip
    loaded = ("--loaded", logs["loaded0"], "--loaded", logs["loaded1"])
    exact = ("--friction-change", "0")  # as method 1 takes it, with the robot in the same run
    status, _, _ = run(
        "payload", "--robot", "rx90", "--robot-parameters", str(stored), *loaded, *exact, "--json", str(target)
    )
    assert status == 0
    ((later,), _) = by_estimator(json.loads(target.read_text()))
    assert later["method"] == 1
    run(*payload_arguments(logs, "--method", "1", "--json", str(target)))
    ((at_once,), _) = by_estimator(json.loads(target.read_text()))
    assert later["parameters"] == pytest.approx(at_once["parameters"], rel=1e-9)
    wider = later["sigma"]["M"] / at_once["sigma"]["M"]  # the joints disagree by another way to compare them
    # the share of a tilt: without the unloaded recording less is seen of it
    assert later["sigma"] == pytest.approx({k: wider * sigma for k, sigma in at_once["sigma"].items()}, rel=0.01)
    for name, sigma in at_once["sigma_robust"].items():
        assert 0.3 < later["sigma_robust"][name] / sigma < 3.0
    robot |= {"covariance_robust": None, "robust": None}
    stored.write_text(json.dumps(robot))
    status, out, _ = run(
        "payload", "--robot", "rx90", "--robot-parameters", str(stored), *loaded, "--json", str(target)
    )
    assert status == 0
    assert "identify the robot again" in " ".join(out.split())
    ((old,), _) = by_estimator(json.loads(target.read_text()))
    assert old["sigma_robust"] is None
    wider = old["sigma"]["M"] / later["sigma"]["M"]
    assert old["sigma"] == pytest.approx({k: wider * sigma for k, sigma in later["sigma"].items()}, rel=0.01)


@pytest.mark.long
def test_uncertain_gains_of_a_stored_robot(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    """Said once, to identify, they hold for every payload weighed with that robot; said again, what is said now."""
    stored, exact, target = tmp_path / "robot.json", tmp_path / "exact.json", tmp_path / "payload.json"
    identify = ("identify", "--robot", "rx90", "--data", logs["bare0"])
    status, out, _ = run(*identify, "--json", str(exact))
    assert status == 0
    assert "Drive gains are taken as exact: no residual shows their errors" in " ".join(out.split())
    assert "by gains" not in out
    status, out, _ = run(*identify, "--gain-sigma", "2%", "--json", str(stored))
    assert status == 0
    assert "include errors of the drive gains: 2 % per motor" in " ".join(out.split())
    assert "by gains" in out
    document, before = json.loads(stored.read_text()), json.loads(exact.read_text())
    assert (document["gain_sigma"], before["gain_sigma"]) == ({"per_joint": [0.02], "common": 0.0}, None)
    for now, then in zip(document["base_parameters"], before["base_parameters"], strict=True):
        assert (now["value"], now["sigma_robust"]) == (then["value"], then["sigma_robust"])
        assert then["sigma_by_gains"] is then["interval95_with_gains"] is None
        low, high = now["interval95_with_gains"]
        assert low < now["interval95_robust"][0] < now["interval95_robust"][1] < high
        assert now["sigma_by_gains"] > 0.0

    def weighed(file: Path, *more: str) -> tuple[float, str]:
        arguments = ("payload", "--robot", "rx90", "--robot-parameters", str(file), "--loaded", logs["loaded1"])
        status, out, err = run(*arguments, *more, "--json", str(target))
        assert status in (0, 1), err
        _, (constrained,) = by_estimator(json.loads(target.read_text()))
        low, high = constrained["interval95"]["M"]
        return high - low, " ".join(out.split())

    plain, text = weighed(exact)
    assert "Drive gains are taken as exact" in text
    told_now, text = weighed(exact, "--gain-sigma", "2%")
    assert "were identified with" not in text
    told_then, text = weighed(stored)
    assert "include errors of the drive gains: 2 % per motor" in text
    assert "that the robot's parameters were identified with" in text
    assert told_then == pytest.approx(told_now, rel=1e-6)
    assert told_now > 1.5 * plain
    again, text = weighed(stored, "--gain-sigma", "2%")
    assert again == told_then
    assert "another uncertainty" not in text
    _, text = weighed(stored, "--gain-sigma", "2%,2%,2%,2%,2%,2%")
    assert "another uncertainty" not in text
    less, text = weighed(stored, "--gain-sigma", "1%")
    assert plain < less < told_now
    assert "identified with another uncertainty of the gains" in text


@pytest.mark.long
def test_wrong_gain_errors_are_refused_before_any_work(run: Run, logs: dict[str, str]) -> None:
    """Joint 6 stands still in the recording, which the reduction refuses: it was not reached."""
    identify = ("identify", "--robot", "rx90", "--data", logs["still"])
    assert "joint 6 never moves" in run(*identify)[2]
    status, _, err = run(*identify, "--gain-sigma", "1%,2%")
    assert (status, len(err.splitlines())) == (2, 1)
    assert "2 uncertainties of drive gains for 6 joints" in err


def test_stored_parameters_of_another_robot(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    stored = tmp_path / "robot.json"
    run("identify", "--robot", "rx90", "--data", logs["bare0"], "--json", str(stored))
    robot = json.loads(stored.read_text())
    for change, words in (
        ({"robot": "tx40"}, "'tx40', not 'rx90'"),
        ({"columns": robot["columns"][1:]}, "robot.json"),
    ):
        stored.write_text(json.dumps({**robot, **change}))
        arguments = ("payload", "--robot", "rx90", "--robot-parameters", str(stored), "--loaded", logs["loaded0"])
        status, _, err = run(*arguments)
        assert status == 2
        assert words in err
    stored.write_text(json.dumps(robot))
    for option in (("--offsets", "true"), ("--coulomb", "paper")):
        assert "must be those the stored parameters" in run(*arguments, *option)[2]
    del robot["covariance"]
    stored.write_text(json.dumps(robot))
    assert "'covariance': missing" in run(*arguments)[2]
