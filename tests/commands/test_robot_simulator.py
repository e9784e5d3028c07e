"""``robot simulator``: a whole robot for a simulator, and who decided each number."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.estimation.possible.whole_robot import origins
from dynident.model import INERTIAL, base_parameters, load_robot
from dynident.model.drives import parameter_kind
from dynident.model.files.robot_file import robot_toml
from dynident.tests.commands.runs import Run
from dynident.tests.commands.test_robot import write_csv
from dynident.trajectories import Simulator, random_via_points


@pytest.fixture(scope="module")
def bare_log(tmp_path_factory: pytest.TempPathFactory) -> str:
    """An RX90 without payload."""
    robot = load_robot("rx90")
    log = Simulator(robot).record(random_via_points(robot, 8, seed=5).motion(100.0), None, [0.5] * 6, 1)
    return str(write_csv(tmp_path_factory.mktemp("bare") / "d.csv", log, np.ones(6)))


@pytest.mark.long
def test_whole_robot_for_a_simulator(run: Run, tmp_path: Path, bare_log: str) -> None:
    """From its own description, and from an identification, whose default are links that can exist."""
    robot = load_robot("rx90")
    out, parameters = tmp_path / "rx90.urdf", tmp_path / "r.json"
    assert run("robot", "export", "--to", "urdf", "--robot", "rx90", "--out", str(out))[0] == 0
    own = load_robot(out)
    assert own.parameters["M3"] == pytest.approx(robot.parameters["M3"])
    identify = (
        "identify",
        "--robot",
        "rx90",
        "--equation-rate",
        "1000",
        "--data",
        bare_log,
        "--json",
        str(parameters),
    )
    status, text, error = run(*identify)
    assert status == 0, error
    for form in ("mjcf", "usd", "urdf", "sdf"):
        out = tmp_path / f"rx90.{form}"
        export = (
            "robot",
            "export",
            "--to",
            form,
            "--robot",
            "rx90",
            "--robot-parameters",
            str(parameters),
            "--out",
            str(out),
        )
        status, text, error = run(*export)
        assert status == 0, error
        assert "54 base parameters identified" in " ".join(text.split())  # a long path is broken anywhere
        assert "Prior: the robot file of rx90." in out.read_text()
    out.unlink()
    assert run(*identify, "--constrained", "base")[0] == 0
    status, _, error = run(*export)
    assert (status, error.count("\n")) == (2, 1)
    assert "run 'dynident identify --prior-mass KG'" in error
    assert not out.exists()


def test_a_robot_that_is_not_to_be_used_is_not_written(run: Run, tmp_path: Path, bare_log: str) -> None:
    out, parameters = tmp_path / "rx90.xml", tmp_path / "r.json"
    run("identify", "--robot", "rx90", "--equation-rate", "1000", "--data", bare_log, "--json", str(parameters))
    document = json.loads(parameters.read_text())
    document["reasons_against_use"] = ["the weather"]
    parameters.write_text(json.dumps(document))
    export = (
        "robot",
        "export",
        "--to",
        "mjcf",
        "--robot",
        "rx90",
        "--robot-parameters",
        str(parameters),
        "--out",
        str(out),
    )
    status, _, error = run(*export)
    assert (status, out.exists()) == (1, False)
    assert "not written: the weather" in error
    assert run(*export, "--despite-verdict")[0] == 0
    assert out.exists()


def test_a_link_heavier_than_the_arm_is_not_written(run: Run, tmp_path: Path) -> None:
    text = "\n".join(f"{kind}{j} = {int(kind == 'M') * 100}" for j in range(1, 7) for kind in INERTIAL)
    description = robot_toml(replace(load_robot("ur10e"), parameters={}))
    (tmp_path / "heavy.toml").write_text(f"{description}\n[parameters]\n{text}\n")
    out = tmp_path / "a.xml"
    status, _, error = run(
        "robot", "export", "--to", "mjcf", "--robot", str(tmp_path / "heavy.toml"), "--out", str(out)
    )
    assert (status, out.exists()) == (1, False)
    assert "link1 would weigh 100 kg, the whole arm weighs 33.5 kg" in error


def test_without_a_mass_one_line_names_the_option(run: Run, tmp_path: Path, bare_log: str) -> None:
    """A description without parameters and mass: base parameters, unless a mass is told."""
    path, out = tmp_path / "bare.toml", tmp_path / "r.json"
    path.write_text(robot_toml(replace(load_robot("rx90"), parameters={}, mass=None)))
    identify = ("identify", "--robot", str(path), "--equation-rate", "1000", "--data", bare_log, "--json", str(out))
    status, _, error = run(*identify)
    assert status == 0
    assert len([line for line in error.splitlines() if "--prior-mass KG" in line]) == 1
    assert json.loads(out.read_text())["constrained"]["gauge"] == "base"
    status, _, error = run(*identify, "--prior-mass", "50")
    assert (status, "--prior-mass" in error) == (0, False)
    assert json.loads(out.read_text())["constrained"]["gauge"] == "prior"


@pytest.mark.long
def test_who_decided_stands_in_every_output(run: Run, tmp_path: Path, bare_log: str) -> None:
    """Table, HTML, JSON and URDF of a robot nearest to a prior: the same labels."""
    files = {option: tmp_path / f"r.{option}" for option in ("json", "report")}
    options = [part for option, path in files.items() for part in (f"--{option}", str(path))]
    status, printed, error = run(
        "identify",
        "--robot",
        "rx90",
        "--equation-rate",
        "1000",
        "--data",
        bare_log,
        "--constrained",
        "prior",
        *options,
    )
    assert status == 0, error
    document = json.loads(files["json"].read_text())
    stored = {entry["name"]: entry for entry in document["constrained"]["parameters"]}
    robot = load_robot("rx90")
    by_name = origins(robot, base_parameters(robot))
    assert {name: entry["decided_by"] for name, entry in stored.items()} == {
        name: origin.decided_by() for name, origin in by_name.items()
    }
    assert {"data", "prior", "prior within MX2R"} <= {origin.decided_by() for origin in by_name.values()}
    html, terminal = files["report"].read_text(), printed.split("decided by")[1]
    for name, origin in by_name.items():
        label = origin.decided_by()
        assert re.search(rf"<th[^>]*>{name}</th>(?:<td[^>]*>[^<]*</td>)*<td[^>]*>{label}</td></tr>", html), name
        assert re.search(rf"^ *{name} .* {label[:20]}", terminal, flags=re.MULTILINE), name
    out = tmp_path / "rx90.urdf"
    urdf = (
        "robot",
        "export",
        "--to",
        "urdf",
        "--robot",
        "rx90",
        "--robot-parameters",
        str(files["json"]),
        "--out",
        str(out),
    )
    status, _, error = run(*urdf)
    assert status == 0, error
    again = load_robot(out)
    for name in again.parameters:
        if parameter_kind(name) in INERTIAL:
            assert again.parameters[name] == pytest.approx(stored[name]["value"], abs=1e-9)
    del document["constrained"]["parameters"][0]
    files["json"].write_text(json.dumps(document))
    assert "other parameters than this robot's" in run(*urdf)[2]
