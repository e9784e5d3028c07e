"""Simulated logs, and the command to run on them."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps.commands import demo
from dynident.apps.commands.demo import PAYLOAD
from dynident.model import InertialParameters, Recording, load_robot
from dynident.tests.commands.runs import Run, runner, write_csv
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points
from dynident.trajectories.design import floor, goal, search

QUIET = tuple(0.2 * sigma for sigma in RX90_NOISE)


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys)


@pytest.fixture(scope="session")
def experiments() -> dict[str, Any]:
    """The paper's experiments that were simulated, and one answer to them, by what they were made of."""
    return {}


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch, experiments: dict[str, Any]) -> None:
    """Laws on options and files hold whatever is found: searches of a few steps, one answer to all experiments."""
    monkeypatch.setattr(floor, "_ITERATIONS", 10)
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


@pytest.fixture(scope="session")
def logs(shared: Callable[[str, Callable[[Path], object]], Path]) -> dict[str, str]:
    """Simulated RX90 logs: two trajectories without and with the paper's payload, and spoilt ones."""
    folder = shared("logs", _write_logs)
    names = json.loads((folder / "names.json").read_text())
    return {name: str(folder / path) for name, path in names.items()}


def _write_logs(folder: Path) -> None:
    robot = load_robot("rx90")
    simulator = Simulator(robot)
    load: InertialParameters = PAYLOAD
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
    paths["latin"] = folder / "latin.csv"
    paths["latin"].write_bytes("t,q1,Drehmoment_Größe\n0,0,0\n".encode("latin-1"))
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
    late = bare.t + 20.0 * np.floor(bare.t / 1.5)
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
    names = {name: path.name for name, path in paths.items()}
    (folder / "names.json").write_text(json.dumps(names))
