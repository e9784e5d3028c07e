"""The README stays true: its code and its commands run."""

import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.cli import main
from dynident.model import InertialParameters, load_robot
from dynident.trajectories import Simulator, ViaPoints, random_via_points

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README, flags=re.DOTALL)


def test_python_does_the_main_job(capsys: pytest.CaptureFixture[str]) -> None:
    (code,) = blocks("python")
    lines = [line for line in code.splitlines() if line and not line.startswith(("#", "from"))]
    assert len(lines) <= 15
    exec(compile(code, "README.md", "exec"), {})
    printed = capsys.readouterr().out
    masses = [float(mass) for mass in re.findall(r"method \d: ([\d.]+) kg", printed)]
    assert len(masses) == 4
    assert masses == pytest.approx([7.025] * 4, rel=0.02)


def test_commands_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = load_robot("rx90")
    simulator = Simulator(robot)
    motion = random_via_points(robot, 14, 0).motion(250.0)
    body = InertialParameters.from_com(7.0, [0.0, 0.0, 0.1], 0.03 * np.eye(3))
    header = ",".join(["t"] + [f"{kind}{j}" for kind in ("q", "tau") for j in range(1, 7)])
    lines = README.splitlines()
    assert any("--drive-gains" in line for line in lines if line.startswith("dynident"))
    for name, load in (("unloaded", None), ("loaded", body)):
        recording = simulator.record(motion, load, [0.5] * 6, 1)
        values = np.column_stack([recording.t, recording.q, recording.torque])
        np.savetxt(tmp_path / f"{name}.csv", values, delimiter=",", header=header, comments="", fmt="%.9g")
    monkeypatch.chdir(tmp_path)
    _write_currents(tmp_path)
    commands = [line for block in blocks("console") for line in block.splitlines() if line.startswith("dynident")]
    assert len(commands) == 5
    for command in commands:
        assert main(shlex.split(command)[1:]) == 0, command


def _write_currents(folder: Path) -> None:
    """Currents of a made-up UR10e for the command with drive gains."""
    known = {**load_robot("rx90").parameters, **{f"OFF{joint}": 0.5 for joint in range(1, 7)}}
    simulator = Simulator(replace(load_robot("ur10e"), parameters=known))
    draw = np.random.default_rng(0)
    motion = ViaPoints(draw.uniform(-1.0, 1.0, (15, 6)), np.full(14, 1.5)).motion(100.0)
    body = InertialParameters.from_com(3.0, [0.0, 0.1, 0.1], 0.03 * np.eye(3))
    header = ",".join(["t"] + [f"{kind}{j}" for kind in ("q", "i") for j in range(1, 7)])
    for name, load in (("empty", None), ("load", body)):
        recording = simulator.record(motion, load, [0.2] * 6, 1 if load else 0)
        values = np.column_stack([recording.t, recording.q, recording.torque / [12, 12, 10, 11, 11, 11]])
        np.savetxt(folder / f"{name}.csv.gz", values, delimiter=",", header=header, comments="", fmt="%.9g")


def test_make_targets_folders_and_picture_exist() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in re.findall(r"make (\w+)", README):
        assert re.search(rf"^{target}:", makefile, flags=re.MULTILINE), target
    for folder in re.findall(r"`([a-z/]+)/`", README):
        assert (ROOT / folder).is_dir()
    for picture in re.findall(r"!\[.*?\]\((.*?)\)", README):
        assert (ROOT / picture).is_file()
