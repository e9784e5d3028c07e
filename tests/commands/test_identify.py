"""``dynident identify``: essential parameters, a robot that can exist."""

import json
from pathlib import Path

import pytest
from dynident.tests.commands.runs import Run, identify_arguments


@pytest.mark.long
def test_essential_parameters_by_either_rule(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    target, plots = tmp_path / "robot.json", tmp_path / "plots"
    counts = []
    for option in (("--plots", str(plots)), ("--essential", "1.1"), ("--essential", "5%")):
        status, out, _ = run(*identify_arguments(logs, *option, "--json", str(target)))
        assert status == 0
        data = json.loads(target.read_text())
        elimination = data["elimination"]
        essential = [entry["name"] for entry in data["base_parameters"] if entry["essential"]]
        assert [entry["name"] for entry in elimination["parameters"]] == essential
        assert f"{len(essential)} of 54 parameters essential" in " ".join(out.split())
        assert len(elimination["path"]) == 55
        counts.append(
            (
                len(essential),
                elimination["rule"],
                elimination["largest_relative_sigma_percent"],
                elimination["sigma_ratio"],
            )
        )
    assert [rule for _, rule, _, _ in counts] == ["ratio", "ratio", "sigma"]
    assert counts[0][3] < 1.02 < counts[1][3] < 1.1
    assert counts[1][0] < counts[0][0]
    assert counts[2][2] <= 5.0
    written = {path.name for path in plots.iterdir()}
    assert {f"essential_path.{ending}" for ending in ("png", "svg", "pdf")} < written


def test_a_robot_that_can_exist(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    target = tmp_path / "robot.json"
    by_gauge = {}
    for gauge in ("none", "base", "prior"):
        status, out, _ = run(*identify_arguments(logs, "--constrained", gauge, "--details", "--json", str(target)))
        assert status == 0
        by_gauge[gauge] = json.loads(target.read_text())["constrained"]
        assert ("Constrained: the nearest robot that can exist" in " ".join(out.split())) == (gauge != "none")
        assert ("prior within MX2R" in out) == (gauge == "prior")
    assert by_gauge["none"] is None
    assert by_gauge["prior"]["chi2_rise"] == pytest.approx(by_gauge["base"]["chi2_rise"] + 1.0, rel=1e-6)
    assert {entry["kind"] for entry in by_gauge["prior"]["parameters"]} == {"identified", "combination", "prior"}
    assert min(by_gauge["prior"]["min_eigenvalues"].values()) > 0.0
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
        (("--constrained", "base", "--prior-mass", "30"), "--prior-mass belongs to --constrained prior, not base"),
        (("--constrained", "prior", "--prior-mass", "-3"), "must be positive"),
        (("--constrained", "prior", "--prior-budget", "0"), "budget 0"),
        (("--total-mass", "9", "1"), "give low <= high"),
        (("--total-mass", "-9", "-1"), "high above 0"),
        (("--essential", "1"), "must be above 1"),
        (("--essential=-5%",), "write 2% or 0.02"),
        (("--essential", "few"), "is not a number"),
    ],
)
def test_options_that_mean_nothing(run: Run, logs: dict[str, str], options: tuple[str, ...], words: str) -> None:
    status, _, err = run(*identify_arguments(logs, *options))
    assert status == 2
    assert words in err
    assert err.strip().count("\n") == 0
