"""The command line: answers, exit status, JSON; one line and nothing written for what cannot be used."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.cli import main
from dynident.model import InertialParameters, Recording, load_robot
from dynident.report.paper import paper_tables
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points

QUIET = tuple(0.2 * sigma for sigma in RX90_NOISE)


def write_csv(path: Path, recording: Recording, torque: str = "tau", q_scale: float = 1.0) -> Path:
    n = recording.q.shape[1]
    header = ["t"] + [f"{kind}{j}" for kind in ("q", torque) for j in range(1, n + 1)]
    values = np.column_stack([recording.t, q_scale * recording.q, recording.torque])
    np.savetxt(path, values, delimiter=",", header=",".join(header), comments="", fmt="%.9g")
    return path


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Simulated RX90 logs: two trajectories without and with the paper's payload, and spoilt ones."""
    folder = tmp_path_factory.mktemp("logs")
    robot = load_robot("rx90")
    simulator = Simulator(robot)
    load: InertialParameters = paper_tables().payload
    paths: dict[str, Path] = {}
    for k in range(3):
        motion = random_via_points(robot, 14, seed=k).motion(250.0)
        bare = simulator.record(motion, None, QUIET, [k, 0])
        loaded = simulator.record(motion, load, QUIET, [k, 1])
        paths[f"bare{k}"] = write_csv(folder / f"bare{k}.csv", bare)
        paths[f"loaded{k}"] = write_csv(folder / f"loaded{k}.csv", loaded)
    paths["degrees"] = write_csv(folder / "degrees.csv", bare, q_scale=57.29577951308232)
    paths["currents"] = write_csv(folder / "currents.csv", bare, "i")
    short = Recording(bare.t[:60], bare.q[:60], bare.torque[:60])
    paths["short"] = write_csv(folder / "short.csv", short)
    part = slice(500, 925)
    paths["brief"] = write_csv(folder / "brief.csv", Recording(loaded.t[part], loaded.q[part], loaded.torque[part]))
    q = np.array(bare.q)
    q[:, 5] = 0.1
    paths["still"] = write_csv(folder / "still.csv", Recording(bare.t, q, bare.torque))
    mirror = np.array([1, 1, 1, 1, -1, 1])
    paths["mirrored_bare"] = write_csv(folder / "mb.csv", Recording(bare.t, bare.q * mirror, bare.torque))
    paths["mirrored_loaded"] = write_csv(folder / "ml.csv", Recording(bare.t, bare.q * mirror, loaded.torque))
    paths["dead"] = write_csv(folder / "dead.csv", Recording(bare.t, bare.q, bare.torque * [1, 1, 1, 0, 1, 1]))
    paths["milli"] = write_csv(folder / "milli.csv", Recording(bare.t, bare.q, 1e3 * bare.torque))
    late = bare.t + 20.0 * (bare.t > 10.0)
    paths["gap"] = write_csv(folder / "gap.csv", Recording(late, bare.q, bare.torque))
    constant = Recording(bare.t, bare.q, 50.0 + 1e-3 * bare.q)
    paths["constant"] = write_csv(folder / "constant.csv", constant)
    flipped = Recording(bare.t, bare.q, bare.torque * [1, -1, 1, 1, 1, 1])
    paths["flipped"] = write_csv(folder / "flipped.csv", flipped)
    lines = paths["bare0"].read_text().splitlines()
    cells = lines[99].split(",")
    cells[4] = "nan"
    lines[99] = ",".join(cells)
    paths["nan"] = folder / "nan.csv"
    paths["nan"].write_text("\n".join(lines))
    paths["broken_robot"] = folder / "broken.toml"
    paths["broken_robot"].write_text('name = "x"\n[[joints]]\nalpha = 3\n')
    return {name: str(path) for name, path in paths.items()}


Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    def runner(*arguments: str) -> tuple[int, str, str]:
        try:
            status = main(arguments)
        except SystemExit as stop:
            status = int(stop.code or 0)
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return runner


def payload_arguments(logs: dict[str, str], *more: str) -> list[str]:
    arguments = ["payload", "--robot", "rx90"]
    for k in (0, 1):
        arguments += ["--unloaded", logs[f"bare{k}"], "--loaded", logs[f"loaded{k}"]]
    return [*arguments, *more]


def test_payload(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    target = tmp_path / "payload.json"
    status, out, _ = run(*payload_arguments(logs, "--validate", logs["bare2"], "--json", str(target)))
    assert status == 0
    assert "…" not in out
    assert "Verdict" in out
    data = json.loads(target.read_text())
    assert set(data) >= {"robot", "frame", "processing", "relative_residual", "data", "estimates", "verdict"}
    assert set(data["relative_residual"]) >= {"all", "per_joint", "validation"}
    assert set(data["data"]) >= {
        "equations", "rate_hz", "cutoff_hz", "lag_s", "max_position_mismatch_rad", "condition_number",
        "condition_number_scaled", "base_parameters",
    }  # fmt: skip
    assert data["data"]["base_parameters"] == 54
    assert data["data"]["rate_hz"] == pytest.approx(250.0)
    assert abs(data["data"]["lag_s"]) < 1e-3
    free, constrained = by_estimator(data)
    assert [estimate["method"] for estimate in free] == [1, 2, 3, 4]
    assert [estimate["method"] for estimate in constrained] == [1, 2, 3, 4]
    assert data["recommended"] == {"method": 4, "estimator": "constrained"}
    truth = paper_tables().payload.named()
    for estimate in constrained:
        assert set(estimate) >= {
            "parameters", "sigma", "sigma_robust", "interval95", "com", "com_interval95", "inertia_com",
            "inertia_com_interval95", "principal_moments", "principal_moments_interval95", "chi2_rise", "p_value",
            "active", "min_pseudo_inertia_eigenvalue", "physically_consistent", "solver_status", "gain_sigma",
        }  # fmt: skip
        assert estimate["physically_consistent"]
        assert estimate["min_pseudo_inertia_eigenvalue"] >= 0.0
        assert estimate["gain_sigma"] is None
        assert estimate["solver_status"] in ("free", "Solved")
        for name, (low, high) in estimate["interval95"].items():
            assert low <= estimate["parameters"][name] <= high
        assert np.shape(estimate["inertia_com_interval95"]) == (3, 3, 2)
        assert np.shape(estimate["principal_moments_interval95"]) == (3, 2)
    for estimate in free:
        assert estimate["parameters"]["M"] == pytest.approx(7.025, rel=0.01)
        assert estimate["robust"]["blocks"] >= 10
        for name, value in estimate["parameters"].items():
            assert 0.0 < estimate["sigma_robust"][name] < 10.0 * estimate["sigma"][name]
            assert abs(value - truth[name]) < 5.0 * estimate["sigma"][name]
            low, high = estimate["interval95"][name]
            assert low < value < high
        assert np.shape(estimate["inertia_com"]) == (3, 3)
        assert np.allclose(estimate["com"], [0.0, 0.0, 1.003 / 7.025], atol=0.01)
    assert data["verdict"]["level"] in ("use", "mass_and_com_only")
    told = " ".join(out.split())
    assert "± the larger of the formula's (17)-(19) and the block jackknife's standard deviation." in told
    assert "Mass, sigma_robust/sigma" in told


def by_estimator(data: dict[str, Any]) -> tuple[list[Any], list[Any]]:
    """Free and constrained estimates."""
    free, constrained = (
        [one for one in data["estimates"] if one["estimator"] == name] for name in ("wls", "constrained")
    )
    return free, constrained


def test_what_is_known_enters_the_answer(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    """Weighed mass, bounds, box, ellipsoid and uncertain gains: in the table, the notes and the JSON."""
    target = tmp_path / "payload.json"
    known = ("--mass", "7.03", "--mass-sigma", "0.01", "--mass-min", "6", "--mass-max", "8")
    place = ("--com-within=-0.1,0.1,-0.1,0.1,0,0.3", "--ellipsoid", "0,0,0.15,0.3,0.3,0.3")
    gains = ("--gain-sigma", "2,2,1,1,1,3%", "--gain-sigma-common", "0.01")
    status, out, _ = run(*payload_arguments(logs, *known, *place, *gains, "--method", "4", "--json", str(target)))
    assert status == 0
    told = " ".join(out.split())
    assert "Intervals include errors of the drive gains: 2, 2, 1, 1, 1, 3 % per motor and 1 % common" in told
    assert "Weighed 7.03 ± 0.01 kg; method 4 alone identifies 7.0" in told
    assert "sigma apart." in told
    assert "drive gains taken as exact" not in told.split("Free estimates")[0]
    _, (constrained,) = by_estimator(json.loads(target.read_text()))
    assert constrained["gain_sigma"] == {"per_joint": [0.02, 0.02, 0.01, 0.01, 0.01, 0.03], "common": 0.01}
    assert len(constrained["constraints"]) == 5
    (scale,) = constrained["weighed"]
    assert abs(scale["z"]) < 4.0
    assert constrained["sigma_with_gains"]["M"] > constrained["sigma_robust"]["M"]
    low, high = constrained["interval95"]["M"]
    assert low < 7.025 < high
    assert high - low < 0.1


def test_a_bound_that_excludes_the_payload_is_named(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    target = tmp_path / "payload.json"
    status, out, _ = run(*payload_arguments(logs, "--mass-max", "6", "--json", str(target)))
    assert status == 1
    told = " ".join(out.split())
    assert "Contradicted by method 1, 2, 3, 4: mass from 0 to 6 kg" in told
    assert "do not use" in told
    _, constrained = by_estimator(json.loads(target.read_text()))
    assert all(one["conflict"] and one["interval95"]["M"] == [None, None] for one in constrained)


def test_payload_without_jackknife(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    """One block of motion under load: the answer comes, by the formula, and a note says why."""
    target = tmp_path / "payload.json"
    arguments = ("payload", "--robot", "rx90", "--unloaded", logs["bare0"], "--unloaded", logs["bare1"])
    status, out, _ = run(*arguments, "--loaded", logs["brief"], "--json", str(target))
    assert status in (0, 1)
    told = " ".join(out.split())
    assert "by (17)-(19)" in told
    assert "± of method 1, 4 by the formula alone: robust standard deviations need two blocks" in told
    estimates, constrained = by_estimator(json.loads(target.read_text()))
    assert [estimate["method"] for estimate in estimates] == [1, 4]
    assert {estimate["interval95_by"] for estimate in constrained} == {"formula"}
    assert "95 % intervals by the formula (17)-(19) alone" in told
    for estimate in estimates:
        assert estimate["sigma_robust"] is None
        assert "two blocks" in estimate["robust"]["unavailable"]
        assert estimate["parameters"]["M"] == pytest.approx(7.025, abs=5.0 * estimate["sigma"]["M"])


def test_one_method_and_options(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    target = tmp_path / "payload.json"
    options = ("--method", "1", "--free-friction", "--cutoff", "15", "--decimate", "5", "--coulomb", "paper")
    status, out, _ = run(*payload_arguments(logs, *options, "--offsets", "--json", str(target)))
    assert status in (0, 1)
    data = json.loads(target.read_text())
    used = data["processing"]
    assert (used["cutoff_hz"], used["decimate"], used["coulomb"], used["offsets"]) == (15.0, 5, "paper", True)
    assert data["data"]["base_parameters"] == 60
    assert [estimate["method"] for estimate in data["estimates"]] == [1, 1]
    assert "method 2" not in out


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
    status, _, _ = run(
        "payload", "--robot", "rx90", "--robot-parameters", str(stored), *loaded, "--json", str(target)
    )
    assert status == 0
    ((later,), _) = by_estimator(json.loads(target.read_text()))
    assert later["method"] == 1
    run(*payload_arguments(logs, "--method", "1", "--json", str(target)))
    ((at_once,), _) = by_estimator(json.loads(target.read_text()))
    assert later["parameters"] == pytest.approx(at_once["parameters"], rel=1e-9)
    assert later["sigma"] == pytest.approx(at_once["sigma"], rel=1e-9)
    for name, sigma in at_once["sigma_robust"].items():
        assert 0.3 < later["sigma_robust"][name] / sigma < 3.0
    for key in ("covariance_robust", "robust"):
        del robot[key]
    stored.write_text(json.dumps(robot))
    status, out, _ = run(
        "payload", "--robot", "rx90", "--robot-parameters", str(stored), *loaded, "--json", str(target)
    )
    assert status == 0
    assert "identify the robot again" in " ".join(out.split())
    ((old,), _) = by_estimator(json.loads(target.read_text()))
    assert old["sigma_robust"] is None
    assert old["sigma"] == pytest.approx(later["sigma"], rel=1e-9)


def test_uncertain_gains_of_a_stored_robot(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    """Said once, to identify, they hold for every payload weighed with that robot; said again, what is said now."""
    stored, exact, target = tmp_path / "robot.json", tmp_path / "exact.json", tmp_path / "payload.json"
    identify = ("identify", "--robot", "rx90", "--data", logs["bare0"])
    status, out, _ = run(*identify, "--json", str(exact))
    assert status == 0
    assert "Drive gains are taken as exact: --gain-sigma" in " ".join(out.split())
    assert "by gains" not in out
    csv = tmp_path / "t.csv"
    status, out, _ = run(*identify, "--gain-sigma", "2%", "--json", str(stored), "--csv", str(csv))
    assert status == 0
    assert "include errors of the drive gains: 2 % per motor" in " ".join(out.split())
    assert csv.read_text().splitlines()[0].startswith("table,name,value,value sigma,%,by gains,constrained")
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
    less, text = weighed(stored, "--gain-sigma", "1%")
    assert plain < less < told_now
    assert "identified with another uncertainty of the gains" in text


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
    for option in (("--offsets",), ("--coulomb", "paper")):
        assert "must be those the stored parameters" in run(*arguments, *option)[2]
    del robot["covariance"]
    stored.write_text(json.dumps(robot))
    assert "'covariance' missing" in run(*arguments)[2]


def test_a_model_that_does_not_describe_the_robot_is_not_to_be_used(run: Run, logs: dict[str, str]) -> None:
    status, out, _ = run(
        "payload", "--robot", "rx90", "--unloaded", logs["flipped"], "--loaded", logs["loaded2"], "--method", "4"
    )
    assert status == 1
    assert "do not use" in out
    assert "signs" in out


def test_a_joint_counted_backwards_is_not_to_be_used(run: Run, logs: dict[str, str]) -> None:
    """The other joints still fit; the verdict looks at each."""
    pair = ("--unloaded", logs["mirrored_bare"], "--loaded", logs["mirrored_loaded"])
    status, out, _ = run("payload", "--robot", "rx90", *pair)
    assert status == 1
    assert "joint 5" in out


def test_a_robot_that_is_not_described_is_not_to_be_used(run: Run, logs: dict[str, str]) -> None:
    status, out, _ = run("identify", "--robot", "rx90", "--data", logs["constant"])
    assert status == 1
    assert "do not use" in out


def test_a_method_that_cannot_answer_does_not_silence_the_others(run: Run, logs: dict[str, str]) -> None:
    status, out, _ = run("payload", "--robot", "rx90", "--unloaded", logs["bare0"], "--loaded", logs["loaded1"])
    assert status == 0
    assert "Method 3 left out" in out
    assert "method 4" in out


def test_answers_are_the_same_every_time(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    texts = []
    for name in ("a.json", "b.json"):
        run(*payload_arguments(logs, "--json", str(tmp_path / name)))
        texts.append((tmp_path / name).read_bytes())
    assert texts[0] == texts[1]


def bad_inputs() -> list[tuple[str, list[str], list[str]]]:
    """(name, arguments with {log} places, words that the line must hold)."""
    pair = ["--unloaded", "{bare0}", "--loaded", "{loaded0}"]
    rx90 = ["payload", "--robot", "rx90"]
    identify = ["identify", "--robot", "rx90", "--data"]
    return [
        ("unknown robot", ["payload", "--robot", "rx91", *pair], ["'rx91'", "rx90", "tx40", "ur10e"]),
        ("broken robot", ["payload", "--robot", "{broken_robot}", *pair], ["'joints[1].alpha'", "alpha_deg"]),
        ("no file", [*rx90, "--unloaded", "none.csv", "--loaded", "{loaded0}"], ["none.csv", "no such file"]),
        ("nan", [*rx90, "--unloaded", "{nan}", "--loaded", "{loaded0}"], ["nan.csv", "line 100", "'q4'"]),
        ("degrees", [*rx90, "--unloaded", "{degrees}", "--loaded", "{loaded0}"], ["degrees.csv", "degrees"]),
        ("currents", ["identify", "--robot", "rx90", "--data", "{currents}"], ["--drive-gains, 6 numbers"]),
        ("gains", ["identify", "--robot", "rx90", "--data", "{currents}", "--drive-gains", "1,2"], ["2 numbers"]),
        ("text gains", ["identify", "--robot", "rx90", "--data", "{currents}", "--drive-gains", "a"], ["'a'"]),
        ("no currents", ["identify", "--robot", "rx90", "--data", "{bare0}", "--drive-gains", "1,1,1,1,1,1"],
         ["no currents"]),
        ("short", ["identify", "--robot", "rx90", "--data", "{short}"], ["fewer samples than parameters"]),
        ("still", ["identify", "--robot", "rx90", "--data", "{still}"], ["joint 6 never moves", "FS6"]),
        ("other trajectory", [*rx90, "--unloaded", "{bare0}", "--loaded", "{loaded1}", "--method", "3"],
         ["not the same trajectory"]),
        ("dead channel", [*rx90, "--unloaded", "{dead}", "--loaded", "{loaded0}"], ["joint 4", "dead"]),
        ("milli", [*rx90, "--unloaded", "{bare0}", "--loaded", "{milli}"], ["more than a joint", "N·m"]),
        ("gap", [*identify, "{gap}"], ["20.004 s missing", "split"]),
        ("twice", [*identify, "{bare0}", "--data", "{bare0}"], ["same numbers"]),
        ("huge decimation", [*identify, "{bare0}", "--decimate", "300000"], ["lower --decimate"]),
        ("tiny cutoff", [*identify, "{bare0}", "--cutoff", "1e-9"], ["raise --cutoff"]),
        ("tiny rate", [*identify, "{bare0}", "--rate", "0.01"], ["raise --rate"]),
        ("huge rate", [*identify, "{bare0}", "--rate", "1e13"], ["lower --rate"]),
        ("folder", [*identify, "."], ["not a regular file"]),
        ("dead validation", [*identify, "{bare0}", "--validate", "{dead}"], ["joint 4", "dead"]),
        ("nothing to compare", [*rx90, "--loaded", "{loaded0}"], ["--unloaded"]),
        ("method without data", [*rx90, "--loaded", "{loaded0}", "--method", "5"], ["--method"]),
        ("cutoff", [*rx90, *pair, "--cutoff", "300"], ["cut-off", "lower --cutoff"]),
        ("negative cutoff", [*rx90, *pair, "--cutoff", "-1"], ["cutoff must be positive"]),
        ("decimate", [*rx90, *pair, "--decimate", "0"], ["decimate"]),
        ("coulomb", ["payload", "--robot", "ur10e", *pair, "--coulomb", "paper"], ["no coupled drives"]),
        ("free friction", [*rx90, *pair, "--method", "3", "--free-friction"], ["--free-friction", "method 1"]),
        ("mass alone", [*rx90, *pair, "--mass", "7"], ["--mass-sigma", "belong together"]),
        ("negative mass", [*rx90, *pair, "--mass", "-7", "--mass-sigma", "0.1"], ["sigma must be positive"]),
        ("bounds", [*rx90, *pair, "--mass-min", "8", "--mass-max", "7"], ["mass bounds 8 to 7 kg leave nothing"]),
        ("box", [*rx90, *pair, "--com-within", "0,1,2"], ["--com-within", "6 numbers"]),
        ("empty box", [*rx90, *pair, "--com-within", "1,0,0,1,0,1"], ["is empty"]),
        ("flat ellipsoid", [*rx90, *pair, "--ellipsoid", "0,0,0,1,1,0"], ["must be positive"]),
        ("gain sigma", [*rx90, *pair, "--gain-sigma", "2"], ["'2' is not a share", "2% or 0.02"]),
        ("gain sigma text", [*rx90, *pair, "--gain-sigma", "2%,a,1"], ["--gain-sigma", "percent sign"]),
        ("gain sigma count", [*rx90, *pair, "--gain-sigma", "1%,2%"], ["2 uncertainties", "6 joints"]),
        ("common gain sigma", [*rx90, *pair, "--gain-sigma-common", "150%"], ["--gain-sigma-common", "'150%'"]),
        ("no body", [*rx90, *pair, "--ellipsoid", "0,0,-0.5,0.1,0.1,0.1", "--com-within", "0,1,0,1,0,1",
                     "--mass-min", "5"], ["no body holds all constraints", "mass from 5", "ellipsoid", "box"]),
        ("not JSON", [*rx90, "--robot-parameters", "{bare0}", "--loaded", "{loaded0}"], ["cannot be read as JSON"]),
        ("no command", [], ["command"]),
        ("unknown option", [*rx90, *pair, "--speed", "3"], ["--speed"]),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("arguments", "words"), [case[1:] for case in bad_inputs()], ids=[c[0] for c in bad_inputs()]
)
def test_bad_input_is_one_line_and_writes_nothing(
    run: Run, logs: dict[str, str], tmp_path: Path, arguments: list[str], words: list[str]
) -> None:
    target = tmp_path / "result.json"
    filled = [argument.format(**logs) for argument in arguments]
    status, out, err = run(*filled, *(["--json", str(target)] if filled else []))
    assert status == 2
    lines = [line for line in err.splitlines() if not line.startswith("dynident: note:")]
    assert len(lines) == 1
    assert "error: " in lines[0]
    for word in words:
        assert word in lines[0]
    assert out == ""
    assert not target.exists()
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_not_there_is_one_line(run: Run, logs: dict[str, str]) -> None:
    status, _, err = run("identify", "--robot", "rx90", "--data", logs["bare0"], "--json", "/nowhere/result.json")
    assert status == 2
    assert "/nowhere/result.json" in err
    assert run("identify", "--robot", "rx90", "--data", logs["bare0"], "--json", "")[0] == 2
    assert run("demo", "--trajectories", "0")[0] == 2
    assert run("demo", "--seed", "-1")[0] == 2


def test_as_a_program(logs: dict[str, str]) -> None:
    """Exit status and streams of the installed command; also without a compiler."""
    command = [sys.executable, "-c", "import sys; from dynident.cli import main; sys.exit(main())"]
    environment = {**os.environ, "DYNIDENT_NO_COMPILER": "1"}
    bad = subprocess.run(
        [*command, "identify", "--robot", "rx90", "--data", logs["nan"]],
        capture_output=True, text=True, check=False, env=environment,
    )  # fmt: skip
    assert bad.returncode == 2
    assert bad.stdout == ""
    assert "Traceback" not in bad.stderr
    assert len(bad.stderr.splitlines()) == 1
    good = subprocess.run(
        [*command, "identify", "--robot", "rx90", "--data", logs["bare0"]],
        capture_output=True, text=True, check=False, env=environment,
    )  # fmt: skip
    assert good.returncode == 0
    assert "ZZ1R" in good.stdout
    helped = subprocess.run([*command, "--help"], capture_output=True, text=True, check=True)
    for name in ("payload", "identify", "demo"):
        assert name in helped.stdout


def identify_arguments(logs: dict[str, str], *more: str) -> list[str]:
    return ["identify", "--robot", "rx90", "--data", logs["bare0"], "--data", logs["bare1"], *more]


def test_essential_parameters_by_either_rule(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    target, plots = tmp_path / "robot.json", tmp_path / "plots"
    counts = []
    for option in (("--plots", str(plots)), ("--essential-ratio", "1.1"), ("--essential-sigma", "5%")):
        status, out, _ = run(*identify_arguments(logs, *option, "--json", str(target)))
        assert status == 0
        data = json.loads(target.read_text())
        found = data["elimination"]
        essential = [entry["name"] for entry in data["base_parameters"] if entry["essential"]]
        assert [entry["name"] for entry in found["parameters"]] == essential
        assert f"{len(essential)} of 54 parameters essential" in " ".join(out.split())
        assert len(found["path"]) == 55
        counts.append(
            (len(essential), found["rule"], found["largest_relative_sigma_percent"], found["sigma_ratio"])
        )
    assert [rule for _, rule, _, _ in counts] == ["ratio", "ratio", "sigma"]
    assert counts[0][3] < 1.02 < counts[1][3] < 1.1
    assert counts[1][0] < counts[0][0]
    assert counts[2][2] <= 5.0
    written = {path.name for path in plots.iterdir()}
    assert {f"essential_path.{ending}" for ending in ("png", "svg", "pdf")} < written


def test_method_4_tells_the_essential_parameters(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    target = tmp_path / "payload.json"
    status, out, _ = run(
        *payload_arguments(logs, "--method", "4", "--essential-sigma", "10%", "--json", str(target))
    )
    assert status in (0, 1)
    found = json.loads(target.read_text())["essential"]
    assert f"Method 4: {found['essential']} of 64 parameters essential" in " ".join(out.split())
    assert {"M_L", "MZ_L"} <= {entry["name"] for entry in found["parameters"]}
    run(*payload_arguments(logs, "--method", "1", "--json", str(target)))
    assert json.loads(target.read_text())["essential"] is None
    status, _, err = run(*payload_arguments(logs, "--method", "1", "--essential-ratio", "1.05"))
    assert status == 2
    assert "belong to method 4" in err


def test_a_robot_that_can_exist(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    target = tmp_path / "robot.json"
    found = {}
    for gauge in ("none", "base", "prior"):
        status, out, _ = run(*identify_arguments(logs, "--constrained", gauge, "--json", str(target)))
        assert status == 0
        found[gauge] = json.loads(target.read_text())["constrained"]
        assert ("Constrained: the nearest robot that can exist" in " ".join(out.split())) == (gauge != "none")
        assert ("prior within MX2R" in out) == (gauge == "prior")
    assert found["none"] is None
    assert found["prior"]["chi2_rise"] == pytest.approx(found["base"]["chi2_rise"] + 1.0, rel=1e-6)
    assert {entry["kind"] for entry in found["prior"]["parameters"]} == {"identified", "combination", "prior"}
    assert min(found["prior"]["min_eigenvalues"].values()) > 0.0
    bounds = ("--constrained", "prior", "--prior-mass", "70", "--prior-budget", "4", "--total-mass", "30", "60")
    run(*identify_arguments(logs, *bounds, "--json", str(target)))
    document = json.loads(target.read_text())["constrained"]
    masses = [entry["value"] for entry in document["parameters"] if entry["name"] in {f"M{j}" for j in range(1, 7)}]
    assert 30.0 - 1e-4 <= sum(masses) <= 60.0 + 1e-4
    assert document["prior"]["budget"] == 4.0
    assert "70 kg" in document["prior"]["source"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (
            ("--constrained", "none", "--total-mass", "1", "9"),
            "--total-mass belongs to --constrained base or prior",
        ),
        (("--prior-mass", "30"), "--prior-mass belongs to --constrained prior, not base"),
        (("--constrained", "prior", "--prior-mass", "-3"), "must be positive"),
        (("--constrained", "prior", "--prior-budget", "0"), "budget 0"),
        (("--total-mass", "9", "1"), "give low <= high"),
        (("--total-mass", "-9", "-1"), "high above 0"),
        (("--essential-ratio", "1"), "must be above 1"),
        (("--essential-sigma=-5%",), "must be positive"),
        (("--essential-sigma", "few"), "not a percentage"),
        (("--essential-sigma", "5", "--essential-ratio", "1.1"), "not allowed with"),
    ],
)
def test_options_that_mean_nothing(run: Run, logs: dict[str, str], options: tuple[str, ...], words: str) -> None:
    status, _, err = run(*identify_arguments(logs, *options))
    assert status == 2
    assert words in err
    assert err.strip().count("\n") == 0
