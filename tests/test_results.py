"""Files beside the JSON: equations, versions."""

import json
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.commands.demo import PAYLOAD
from dynident.apps.report.recordings import write_recording
from dynident.cli import main
from dynident.model import load_robot
from dynident.trajectories import Simulator, random_via_points


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """One RX90 trajectory without and with the paper's payload."""
    folder = tmp_path_factory.mktemp("logs")
    simulator = Simulator(load_robot("rx90"))
    motion = random_via_points(load_robot("rx90"), 14, seed=0).motion(250.0)
    for name, load in (("bare", None), ("loaded", PAYLOAD)):
        recording = simulator.record(motion, load, [0.3] * 6, 1 if load else 0)
        write_recording(folder / f"{name}.csv", recording)
    return {name: str(folder / f"{name}.csv") for name in ("bare", "loaded")}


@pytest.mark.parametrize("command", ["identify", "payload"])
def test_equations(command: str, logs: dict[str, str], tmp_path: Path) -> None:
    """The NPZ gives the estimate of the JSON."""
    inputs = {
        "identify": ["--data", logs["bare"]],
        # The equations (30), whose friction is the same with and without payload.
        "payload": ["--unloaded", logs["bare"], "--loaded", logs["loaded"], "--friction-change", "0"],
    }
    files = {option: tmp_path / f"out.{option}" for option in ("json", "npz")}
    options = [part for option, path in files.items() for part in (f"--{option}", str(path))]
    assert main([command, "--robot", "rx90", *inputs[command], *options]) == 0
    document = json.loads(files["json"].read_text(encoding="utf-8"))
    with np.load(files["npz"], allow_pickle=False) as data:
        weights = data["row_weights"]
        values = np.linalg.lstsq(data["W"] * weights[:, None], data["Y"] * weights, rcond=None)[0]
        solved = dict(zip((str(name) for name in data["columns"]), values, strict=True))
    if command == "identify":
        for parameter, column in zip(document["base_parameters"], document["columns"], strict=True):
            assert solved[column] == pytest.approx(parameter["value"], rel=1e-6, abs=1e-7)
    else:
        (fourth,) = (e for e in document["estimates"] if (e["method"], e["estimator"]) == (4, "wls"))
        for kind, value in fourth["parameters"].items():
            assert solved[f"{kind}_L"] == pytest.approx(value, rel=1e-6, abs=1e-7)


def test_a_target_that_cannot_be_written_costs_no_work(
    logs: dict[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["identify", "--robot", "rx90", "--data", logs["bare"], "--npz", "/nowhere/out"]) == 2
    assert "--npz '/nowhere/out'" in capsys.readouterr().err


def test_version_names_the_solvers(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    versions = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert next(iter(versions)) == "dynident"
    for package in ("casadi", "clarabel", "numpy", "scipy"):
        assert versions[package] == version(package)
    assert versions["python"] == ".".join(map(str, sys.version_info[:3]))


def test_version_and_help_load_nothing_heavy() -> None:
    code = (
        "import sys\nfrom dynident.cli import main\n"
        "try:\n    main([sys.argv[1]])\nexcept SystemExit:\n    pass\nprint(*sys.modules, file=sys.stderr)"
    )
    for option in ("--version", "--help"):
        answer = subprocess.run([sys.executable, "-c", code, option], capture_output=True, text=True, check=True)
        assert not set(answer.stderr.split()) & {"numpy", "casadi", "scipy", "matplotlib", "msgspec"}
