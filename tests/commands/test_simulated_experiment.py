"""The commands simulate and demo: recordings that give their truth back, tables beside the paper's, repetition."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.cli import main
from dynident.examples.paper.printed import paper_tables
from dynident.examples.paper.tables import short_value
from dynident.model import base_parameters, load_robot
from dynident.tests.commands.runs import Run
from dynident.trajectories import plan_point_to_point
from dynident.trajectories.motions.via_points import random_points

BARE = Path(__file__).parents[1] / "reference/robots/puma560.toml"
"""An arm whose file tells neither its links nor its mass."""


@pytest.mark.long
def test_demo(run: Run, tmp_path: Path) -> None:
    status, out, _ = run("demo", "--out", str(tmp_path / "demo"), "--trajectories", "3", "--seed", "4")
    assert status == 0
    assert "…" not in out
    data: dict[str, Any] = json.loads((tmp_path / "demo" / "payload.json").read_text())
    assert len(data["estimates"]) == 8
    assert {estimate["method"] for estimate in data["estimates"]} == {1, 2, 3, 4}
    for estimate in data["estimates"]:
        assert estimate["parameters"]["M"] == pytest.approx(7.025, rel=0.03)
    robot: dict[str, Any] = json.loads((tmp_path / "demo" / "robot.json").read_text())
    assert len(robot["columns"]) == 54
    assert robot["validation"]["all"] < 0.15
    assert (tmp_path / "demo" / "torques.png").stat().st_size > 50_000
    assert "it carries 7.025 kg" in " ".join(out.split())
    page = (tmp_path / "demo" / "report.html").read_text(encoding="utf-8")
    for words in ('id="parameters"', "FSM6", "held out"):
        assert words in page
    assert page.count("<svg") == 8


def tables(*arguments: str) -> str:
    command = [sys.executable, "-m", "dynident.examples.paper.tables", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


@pytest.mark.long
def test_the_papers_tables() -> None:
    out = tables("--trajectories", "3", "--seed", "4")
    for words in ("Table 1", "Table 2", "method 4", "FSM6", "7.216", "6.700", "condition number", "robust sigma"):
        assert words in out
    assert "Drive gains are off" not in out


@pytest.mark.long
def test_the_tables_tell_wrong_gains() -> None:
    out = tables("--trajectories", "2", "--gain-error", "0.02", "--noise", "none")
    assert "Drive gains are off by" in out


def test_values_are_as_the_paper_prints() -> None:
    assert str(short_value(0.157, 0.019)) == ".157±.019"
    assert str(short_value(10.05, 0.02)) == "10.050±.020"
    assert short_value(-0.0001, 0.0) == "0.000"


def test_printed_sigma_and_percent_agree() -> None:
    """2 sigma and the relative sigma of every row of Tables 1 and 2 are of the same estimate."""
    tables = paper_tables()
    for rows in (tables.table1, tables.table2, tables.table2_robot):
        for name, row in rows.items():
            sigma = row.relative_sigma_percent / 100.0 * abs(row.value)
            rounding = 0.00025 + 0.0005 * row.relative_sigma_percent / 100.0
            assert sigma == pytest.approx(row.two_sigma / 2.0, abs=2.0 * rounding), name


@pytest.mark.long
def test_the_experiment_repeats(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "dynident.examples.paper", "2", "--out", str(tmp_path)]
    out = subprocess.run(
        [*command, "--trajectories", "2", "--seed", "5"], capture_output=True, text=True, check=True
    ).stdout
    assert (tmp_path / "simulated_experiment.md").read_text() in out
    assert (tmp_path / "simulated_experiment.png").stat().st_size > 20_000
    numbers = json.loads((tmp_path / "simulated_experiment.json").read_text())
    assert set(numbers) == {"paper", "slow", "gains"}
    for scenario in numbers.values():
        assert scenario["method 4"]["M_L"]["truth"] == pytest.approx(7.025)
    for words in ("| method 4 |", "Slow noise", "Drive gains wrong by 2 %", "| FSM6 |"):
        assert words in out


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Exact recordings without and with a payload, of a trajectory file."""
    folder = tmp_path_factory.mktemp("simulated")
    robot = load_robot("rx90")
    motion = plan_point_to_point(robot, random_points(robot, 14, 0)).motion(250.0)
    header = ",".join(["t", *(f"q{j}" for j in range(1, 7))])
    table = np.column_stack([motion.t, motion.q])
    np.savetxt(folder / "move.csv", table, delimiter=",", header=header, comments="", fmt="%.10g")
    (folder / "load.toml").write_text("mass = 5\ncom = [0.02, 0, 0.1]\ninertia_com = [0.05, 0, 0, 0.05, 0, 0.05]\n")
    arguments = [
        "--trajectory",
        str(folder / "move.csv"),
        "--payload",
        str(folder / "load.toml"),
        "--noise",
        "none",
    ]
    assert main(["simulate", "--robot", "rx90", *arguments, "--out", str(folder / "out")]) == 0
    return folder


def test_simulated_recordings_give_their_payload_back(simulated: Path, run: Run, tmp_path: Path) -> None:
    """Exact recordings: what is left is the sign of the speed, and the filter."""
    out = simulated / "out"
    target = tmp_path / "payload.json"
    files = ("--unloaded", str(out / "move_unloaded.csv"), "--loaded", str(out / "move_loaded.csv"))
    assert run("payload", "--robot", "rx90", *files, "--method", "4", "--json", str(target))[0] == 0
    estimate = json.loads(target.read_text())["estimates"][0]
    assert estimate["parameters"]["M"] == pytest.approx(5.0, rel=3e-3)
    assert np.allclose(estimate["com"], [0.02, 0.0, 0.1], atol=1e-3)


def test_simulated_recordings_give_the_robot_back(simulated: Path, run: Run, tmp_path: Path) -> None:
    target = tmp_path / "robot.json"
    data = ("--data", str(simulated / "out" / "move_unloaded.csv"))
    assert run("identify", "--robot", "rx90", *data, "--json", str(target))[0] == 0
    result = json.loads(target.read_text())
    assert result["relative_residual"]["all"] < 0.01
    robot = load_robot("rx90")
    base = base_parameters(robot)
    for name, true, parameter in zip(
        base.names, base.value(robot.parameters), result["base_parameters"], strict=True
    ):
        assert parameter["name"] == name
        assert parameter["value"] == pytest.approx(true, rel=0.02, abs=0.02), name


def test_simulate_says_what_it_cannot_do(simulated: Path, run: Run, tmp_path: Path) -> None:
    out = ("--out", str(tmp_path / "x"))
    move = str(simulated / "move.csv")
    for arguments, words in (
        (("--robot", str(BARE)), "lacks XX1"),
        (("--robot", "rx90", "--noise", "loud"), "--noise 'loud'"),
        (("--robot", "rx90", "--noise", "-1"), "--noise '-1'"),
        (("--robot", "rx90", "--rate", "1"), "not a rate"),
        (("--robot", "rx90", "--gain-error", "2"), "not a share"),
        (("--robot", "rx90", "--sag", "0"), "not above 0"),
        (("--robot", "rx90", "--sag", "4"), "give --payload, and --controller proportional or gravity"),
        (("--robot", "rx90", "--payload", str(simulated / "load.toml"), "--sag", "4"), "another never sags"),
        (("--robot", "rx90", "--trajectory", move, "--trajectory", move), "two files are called 'move'"),
        (("--robot", "rx90", "--trajectory", "nothing.csv"), "no such file"),
        (("--robot", "rx90", "--payload", "nothing.toml"), "nothing.toml: no such file"),
    ):
        status, _, err = run("simulate", *arguments, *out)
        assert status == 2, arguments
        assert words in err
        assert len(err.splitlines()) == 1
    assert not (tmp_path / "x").exists()
