"""Simulated logs and the frozen runs' inputs in the working folder; searches and experiments of a moment."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps.commands import demo
from dynident.model import load_robot
from dynident.tests.commands.lines import inputs_of_all_lines, log, save
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points
from dynident.trajectories.design import goal, search

QUIET = tuple(0.2 * sigma for sigma in RX90_NOISE)
Shared = Callable[[str, Callable[[Path], object]], Path]


@pytest.fixture(scope="session")
def experiments() -> dict[str, Any]:
    """The paper's experiments that were simulated, and one answer to them, by what they were made of."""
    return {}


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch, experiments: dict[str, Any]) -> None:
    """Laws on options and files hold whatever is found: searches of a few steps, one answer to all experiments."""
    monkeypatch.setattr(search, "_FLOOR_ITERATIONS", 10)
    for name in ("_NEAR", "_VIA", "_FRESH"):
        effort = getattr(search, name)
        monkeypatch.setattr(search, name, effort._replace(first=8, refined=4, settled=4, stages=1, turns=1))
    for name in ("_GLANCES", "_LOOKS", "_FEW"):
        monkeypatch.setattr(goal, name, 1)
    simulate, identify = demo.simulate_paper, demo.identified

    def simulated(*arguments: Any) -> Any:
        key = repr(arguments[1:4])
        if key not in experiments:
            experiments[key] = simulate(*arguments)
        return experiments[key]

    def identified(experiment: Any, progress: Any) -> Any:
        if "answer" not in experiments:
            exact = simulate(experiment.robot, demo.levels("none"), 0, 2)
            experiments["answer"] = identify(exact, progress)
        return experiments["answer"]

    monkeypatch.setattr(demo, "simulate_paper", simulated)
    monkeypatch.setattr(demo, "identified", identified)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def folder() -> Iterator[Path]:
    """Inputs of a line for each command, in the working folder."""
    with inputs_of_all_lines() as place:
        yield place


@pytest.fixture
def logs(shared: Shared, here: Path) -> Path:
    """RX90 logs in the working folder: three trajectories without and with the paper's payload, and wrong ones."""
    for path in shared("logs", _write_logs).iterdir():
        (here / path.name).symlink_to(path)
    return here


def _write_logs(folder: Path) -> None:
    robot = load_robot("rx90")
    simulator = Simulator(robot)
    for k in range(3):
        motion = random_via_points(robot, 14, seed=k).motion(250.0)
        bare = simulator.record(motion, None, QUIET, [k, 0])
        loaded = simulator.record(motion, demo.PAYLOAD, QUIET, [k, 1])
        log(folder / f"bare{k}.csv", bare)
        log(folder / f"loaded{k}.csv", loaded)
    log(folder / "currents.csv", bare, "i")
    t, q, torque = bare.t, bare.q, bare.torque
    part, mirror, still = slice(500, 925), np.array([1, 1, 1, 1, -1, 1]), np.where(np.arange(6) == 5, 0.1, q)
    wrong = {
        "degrees": (t, np.degrees(q), torque),
        "short": (t[:60], q[:60], torque[:60]),
        "brief": (loaded.t[part], loaded.q[part], loaded.torque[part]),
        "still": (t, still, torque),
        "mirrored_bare": (t, q * mirror, torque),
        "mirrored_loaded": (t, q * mirror, loaded.torque),
        "dead": (t, q, torque * [1, 1, 1, 0, 1, 1]),
        "milli": (t, q, 1e3 * torque),
        "gap": (t + 20.0 * np.floor(t / 1.5), q, torque),
        "constant": (t, q, 50.0 + 1e-3 * q),
        "flipped": (t, q, torque * [1, -1, 1, 1, 1, 1]),
    }
    for name, (times, positions, torques) in wrong.items():
        save(folder / f"{name}.csv", times, positions, torques, names="q,tau", head="# gain_sigma = 0\n")
    lines = (folder / "bare0.csv").read_text().splitlines()
    cells = lines[99].split(",")
    lines[99] = ",".join([*cells[:4], "nan", *cells[5:]])
    (folder / "nan.csv").write_text("\n".join(lines))
    (folder / "latin.csv").write_bytes("t,q1,Drehmoment_Größe\n0,0,0\n".encode("latin-1"))
    (folder / "broken.toml").write_text('name = "x"\n[[joints]]\nalpha = 3\n')
