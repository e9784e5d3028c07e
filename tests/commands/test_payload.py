"""``dynident payload``: the answer, what is known beforehand, which methods."""

import json
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.commands.demo import PAYLOAD
from dynident.tests.commands.runs import Run, by_estimator, payload_arguments


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
    reason = data["recommended"].pop("reason")
    assert data["recommended"] == {"method": 3, "estimator": "constrained"}
    assert reason.startswith("one path, within 0.0")
    truth = PAYLOAD.named()
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
    text = " ".join(out.split())
    assert "± the larger of the formula's (17)-(19) and the block jackknife's standard deviation." in text
    assert "Mass, sigma_robust/sigma" in text


@pytest.mark.long
def test_what_is_known_enters_the_answer(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    """Weighed mass, bounds, box, ellipsoid and uncertain gains: in the table, the notes and the JSON."""
    target = tmp_path / "payload.json"
    known = ("--mass", "7.03+-0.01", "--mass-bounds", "6,8")
    place = ("--com-within=-0.1,0.1,-0.1,0.1,0,0.3", "--ellipsoid", "0,0,0.15,0.3,0.3,0.3")
    gains = ("--gain-sigma", "2,2,1,1,1,3%,common=0.01")
    status, out, _ = run(*payload_arguments(logs, *known, *place, *gains, "--method", "4", "--json", str(target)))
    assert status == 0
    text = " ".join(out.split())
    assert "Intervals include errors of the drive gains: 2, 2, 1, 1, 1, 3 % per motor and 1 % common" in text
    assert "Scale 7.03 ± 0.01 kg, torques 7.0" in text
    assert "sigma apart, in agreement." in text
    assert "taken as exact" not in text.split("Every parameter")[0]
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
    status, out, _ = run(*payload_arguments(logs, "--mass-bounds", ",6", "--json", str(target)))
    assert status == 1
    text = " ".join(out.split())
    assert "Contradicted by method 1, 2, 3, 4: mass from 0 to 6 kg" in text
    assert "do not use" in text
    _, constrained = by_estimator(json.loads(target.read_text()))
    assert all(estimate["conflict"] and estimate["interval95"]["M"] == [None, None] for estimate in constrained)


def test_payload_without_jackknife(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    """One block of motion under load: intervals go by the memory of the errors, and a note says so."""
    target = tmp_path / "payload.json"
    arguments = ("payload", "--robot", "rx90", "--unloaded", logs["bare0"], "--unloaded", logs["bare1"])
    status, out, _ = run(*arguments, "--loaded", logs["brief"], "--json", str(target))
    assert status in (0, 1)
    text = " ".join(out.split())
    assert "the larger of the formula's (17)-(19) and that by the memory of the errors" in text
    assert "blocks are too few for a jackknife: intervals go by the memory of the errors" in text
    assert "jackknife over" not in text
    estimates, constrained = by_estimator(json.loads(target.read_text()))
    assert [estimate["method"] for estimate in estimates] == [1, 4]
    assert {estimate["interval95_by"] for estimate in constrained} == {"memory"}
    for estimate in estimates:
        assert estimate["sigma_robust"]["M"] > 0.0
        assert estimate["parameters"]["M"] == pytest.approx(7.025, abs=5.0 * estimate["sigma"]["M"])


def test_one_method_and_options(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    target = tmp_path / "payload.json"
    options = ("--method", "1", "--free-friction", "--cutoff", "15", "--equation-rate", "50", "--coulomb", "paper")
    status, out, _ = run(*payload_arguments(logs, *options, "--offsets", "true", "--json", str(target)))
    assert status in (0, 1)
    data = json.loads(target.read_text())
    used = data["processing"]
    assert (used["cutoff_hz"], used["equations_hz"], used["coulomb"], used["offsets"]) == (
        15.0,
        50.0,
        "paper",
        True,
    )
    assert data["data"]["base_parameters"] == 60
    assert [estimate["method"] for estimate in data["estimates"]] == [1, 1]
    assert "method 2" not in out


def test_the_rate_of_the_equations(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    """It takes the place of the factor in the robot's file."""
    target = tmp_path / "identify.json"
    identify = ("identify", "--robot", "rx90", "--data", logs["bare0"], "--json", str(target))
    assert run(*identify, "--equation-rate", "20")[0] == 0
    used = json.loads(target.read_text())["processing"]
    assert (used["equations_hz"], used["decimate"]) == (20.0, 1)


def test_a_method_that_cannot_answer_does_not_silence_the_others(run: Run, logs: dict[str, str]) -> None:
    status, out, _ = run("payload", "--robot", "rx90", "--unloaded", logs["bare0"], "--loaded", logs["loaded1"])
    assert status == 0
    assert "Method 3 left out" in out
    assert "method 4" in out


@pytest.mark.long
def test_method_4_tells_the_essential_parameters(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    target = tmp_path / "payload.json"
    status, out, _ = run(*payload_arguments(logs, "--method", "4", "--essential", "10%", "--json", str(target)))
    assert status in (0, 1)
    essential = json.loads(target.read_text())["essential"]
    assert f"Method 4: {essential['essential']} of 64 parameters essential" in " ".join(out.split())
    assert {"M_L", "MZ_L"} <= {entry["name"] for entry in essential["parameters"]}
    run(*payload_arguments(logs, "--method", "1", "--json", str(target)))
    assert json.loads(target.read_text())["essential"] is None
    status, _, err = run(*payload_arguments(logs, "--method", "1", "--essential", "1.05"))
    assert status == 2
    assert "belongs to method 4" in err
