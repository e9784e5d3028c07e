"""``simulate`` and ``demo``: recordings that give their truth back, tables beside the paper's, repetition."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from dynident.estimation import Estimate
from dynident.estimation.fit.estimate import Fit
from dynident.examples.paper.printed import paper_tables
from dynident.examples.paper.repetition import Answer, Repetition, answer_of
from dynident.examples.paper.tables import short_value
from dynident.model import base_parameters, load_robot
from dynident.tests.commands.lines import save
from dynident.tests.commands.typed import answered, refused, typed
from dynident.trajectories import plan_point_to_point
from dynident.trajectories.motions.via_points import random_points


@pytest.mark.long
def test_demo(here: Path) -> None:
    ended = typed("demo --out demo --trajectories 3 --seed 4 --details")
    assert ended.status == 0
    assert "…" not in ended.out
    assert "it carries 7.025 kg" in ended.text
    data, robot = (json.loads(Path(f"demo/{name}.json").read_text()) for name in ("payload", "robot"))
    assert [estimate["method"] for estimate in data["estimates"]].count(4) == 2
    assert len(data["estimates"]) == 8
    for estimate in data["estimates"]:
        assert estimate["parameters"]["M"] == pytest.approx(7.025, rel=0.03)
    assert len(robot["columns"]) == 54
    assert robot["validation"]["all"] < 0.15
    assert Path("demo/torques.png").stat().st_size > 50_000
    page = Path("demo/report.html").read_text(encoding="utf-8")
    assert all(words in page for words in ('id="parameters"', "FSM6", "held out"))
    assert page.count("<svg") == 10


def program(*words: str) -> str:
    return subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True, check=True).stdout


@pytest.mark.long
def test_the_papers_tables_tell_wrong_gains() -> None:
    line = "dynident.examples.paper.tables --trajectories 2 --gain-error 0.02 --noise none"
    out = program(*line.split())
    for words in ("Table 1", "Table 2", "method 4", "FSM6", "7.216", "6.700", "condition number", "robust sigma"):
        assert words in out
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
    out = program("dynident.examples.paper", *f"1 --out {tmp_path} --trajectories 2 --seed 5".split())
    assert (tmp_path / "simulated_experiment.md").read_text() in out
    assert (tmp_path / "simulated_experiment.png").stat().st_size > 20_000
    numbers = json.loads((tmp_path / "simulated_experiment.json").read_text())
    assert set(numbers) == {"paper", "slow", "gains"}
    for scenario in numbers.values():
        assert scenario["method 4"]["M_L"]["truth"] == pytest.approx(7.025)
    for words in ("| method 4 |", "Slow noise", "Drive gains wrong by 2 %", "| FSM6 |"):
        assert words in out


def answers(count: int, sigma: float, half: float, bias: float = 0.0) -> list[Answer]:
    draw, truth, rows = np.random.default_rng(0), np.array([1.0, -2.0]), []
    for _ in range(count):
        values = truth + bias + sigma * draw.standard_normal(2)
        rows.append(Answer(("a", "b"), truth, values, values - half, values + half, np.full(2, sigma)))
    return rows


def test_bias_spread_and_coverage_of_repeated_experiments_are_found() -> None:
    """Of estimators that are known: intervals of two sigma hold in 95 %."""
    repetition = Repetition.of(answers(4000, sigma=0.1, half=0.196, bias=0.05))
    assert np.allclose(repetition.bias, 0.05, atol=0.01)
    assert np.allclose(repetition.spread, 0.1, rtol=0.05)
    assert np.allclose(repetition.rms, np.hypot(0.1, 0.05), rtol=0.05)
    assert repetition.within("b", 0.025) == pytest.approx(0.3829 - 0.038, abs=0.04)
    assert np.allclose(Repetition.of(answers(4000, 0.1, 0.196)).coverage, 0.95, atol=0.015)
    assert np.isnan(Repetition.of(answers(1, 0.1, 0.2)).spread).all()
    first, second = answers(2, 0.1, 0.2)
    with pytest.raises(ValueError, match="different parameters"):
        Repetition.of([first, second._replace(names=("a", "c"))])


def test_without_robust_intervals_the_formula_answers() -> None:
    fit = Fit(np.ones(1), np.ones(1), (10,))
    estimate = Estimate(("a",), np.array([2.0]), np.array([[0.04]]), 1e6, fit, np.ones(1))
    answer = answer_of(estimate, np.array([2.1]))
    assert (answer.high - answer.low)[0] == pytest.approx(2 * 1.96 * 0.2, rel=1e-3)
    assert answer.sigma[0] == pytest.approx(0.2)


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Exact recordings without and with a payload, of a trajectory file."""
    folder = tmp_path_factory.mktemp("simulated")
    robot = load_robot("rx90")
    motion = plan_point_to_point(robot, random_points(robot, 14, 0)).motion(250.0)
    save(folder / "move.csv", motion.t, motion.q, names="q")
    (folder / "load.toml").write_text("mass = 5\ncom = [0.02, 0, 0.1]\ninertia_com = [0.05, 0, 0, 0.05, 0, 0.05]\n")
    line = f"simulate --robot rx90 --trajectory {folder}/move.csv --payload {folder}/load.toml"
    assert typed(f"{line} --noise none --out {folder}").status == 0
    another = f"{line.replace(' --robot rx90', ' --robot rx90 --sag 4')} --out {folder}/new"
    assert "another never sags" in refused(another)
    return folder


def test_simulated_recordings_give_their_payload_back(simulated: Path) -> None:
    """Exact recordings: what is left is the sign of the speed, and the filter."""
    pair = f"--unloaded {simulated}/move_unloaded.csv --loaded {simulated}/move_loaded.csv"
    estimate = answered(f"payload --robot rx90 {pair} --method 4").document["estimates"][0]
    assert estimate["parameters"]["M"] == pytest.approx(5.0, rel=3e-3)
    assert np.allclose(estimate["com"], [0.02, 0.0, 0.1], atol=1e-3)


def test_simulated_recordings_give_the_robot_back(simulated: Path) -> None:
    result = answered(f"identify --robot rx90 --data {simulated}/move_unloaded.csv").document
    assert result["relative_residual"]["all"] < 0.01
    robot = load_robot("rx90")
    base = base_parameters(robot)
    assert [entry["name"] for entry in result["base_parameters"]] == list(base.names)
    values = [entry["value"] for entry in result["base_parameters"]]
    assert values == pytest.approx(base.value(robot.parameters), rel=0.02, abs=0.02)


def test_an_arm_that_is_not_known_is_not_simulated(here: Path, root: Path) -> None:
    """Its file tells neither its links nor its mass."""
    arm = root / "tests/reference/robots/puma560.toml"
    assert "lacks XX1" in refused(f"simulate --robot {arm} --out x")
    assert not list(here.iterdir())
