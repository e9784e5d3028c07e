"""``simulate`` and ``demo``: recordings that give their truth back, tables beside the paper's, repetition."""

import json
from pathlib import Path

import numpy as np
import pytest
from dynident.examples.paper.repetition import Answer, Repetition
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
