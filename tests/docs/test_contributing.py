"""Every worked example of CONTRIBUTING.md works: its blocks are put into a copy of the package, which uses them."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from dynident.model import load_robot
from dynident.tests.docs.pages import ROOT, blocks

PAGE = ROOT / "CONTRIBUTING.md"
PLACE = re.compile(r"^# ([\w/]+\.\w+)(?:, (above|in) (\w+))?\n", flags=re.MULTILINE)
"""Where what follows goes: a new file, above a name's definition, or to the first rows of a table."""
ROOMS = ("common", "model", "estimation", "trajectories", "apps")
RECORDED = """
from dataclasses import replace
import numpy as np
from dynident import RX90_NOISE, InertialParameters, Simulator, identify_payload, load_robot, random_via_points

robot = load_robot("rx90")
body = InertialParameters.from_com(7.0, [0.02, -0.01, 0.14], [[0.02, 0, 0], [0, 0.02, 0], [0, 0, 0.03]])
arm, motion = Simulator(robot), random_via_points(robot, count=10, seed=3).motion(rate=250.0)
bare, loaded = (arm.record(motion, load, RX90_NOISE, seed=k) for k, load in enumerate((None, body)))
"""
"""A pair of recordings."""


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the package and all examples in it."""
    folder = tmp_path_factory.mktemp("contributed")
    package = folder / "dynident"
    for room in ROOMS:
        shutil.copytree(ROOT / room, package / room, ignore=shutil.ignore_patterns("__pycache__"))
    for file in (*ROOT.glob("*.py"), *ROOT.glob("*.pyi")):
        shutil.copy(file, package)
    for block in blocks(PAGE):
        if block.language in ("python", "toml"):
            before, *parts = PLACE.split(block.text)
            assert not before
            for target, where, name, code in zip(*(iter(parts),) * 4, strict=True):
                place(package / target, where, name, code)
    return folder


def place(file: Path, where: str | None, name: str | None, code: str) -> None:
    """Write a new file, or put code into one."""
    if where is None:
        assert not file.exists()
        file.write_text(code, encoding="utf-8")
        return
    lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
    (at,) = (k for k, line in enumerate(lines) if re.match(rf"(def |class )?{name}\b", line))
    at += where == "in"
    end = ",\n" if where == "in" else "\n\n\n"
    file.write_text("".join([*lines[:at], f"{code.rstrip()}{end}", *lines[at:]]), encoding="utf-8")


def run(copy: Path, program: str) -> str:
    """Output of a program that imports the copy."""
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=copy, env=os.environ | {"PYTHONPATH": str(copy)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_fault_log_controller_and_constraint_work(copy: Path) -> None:
    """In one process: the fault where it is, the log as written, the load in the file, the constraint kept."""
    program = f"""{RECORDED}
import json
from dynident import read_recording
from dynident.estimation import PossibleBody
from dynident.estimation.possible.constraints import NearAxis
faded = [replace(one, torque=one.torque * (1.0 - 0.1 * one.t[:, None] / one.t[-1])) for one in (bare, loaded)]
for unloaded, other in ((bare, loaded), faded):
    result = identify_payload(robot, [other], [unloaded])
    print([reason for reason in result.verdict.reasons if "let the drives warm up" in reason])
names = ["t", *(f"q{{j}}" for j in range(1, 7)), *(f"tau{{j}}" for j in range(1, 7))]
rows = np.column_stack([bare.t, bare.q, bare.torque]).tolist()
open("log.jsonl", "w").write("".join(json.dumps(dict(zip(names, row))) + "\\n" for row in rows))
read = read_recording("log.jsonl", robot)
print(len(read.t) == len(bare.t) and abs(read.torque - bare.torque).max() < 1e-9)
print(identify_payload(robot, [loaded], [bare]).export("acme").strip().splitlines()[-1])
for rules in ((PossibleBody(),), (PossibleBody(), NearAxis(0.001))):
    com = identify_payload(robot, [loaded], [bare], constraints=rules).com
    print(np.abs(com.value[:2]).max())
"""
    good, bad, read, line, free, held = run(copy, program).splitlines()
    assert (good, read) == ("[]", "True")
    assert "the torques change by" in bad
    mass, x, y, z = (float(word) for word in line.removeprefix("PAYLOAD ").split(","))
    assert mass == pytest.approx(7.0, abs=0.5)
    flange = load_robot("rx90").flange_pose
    assert flange is not None
    assert [x, y, z] == pytest.approx([20.0, -10.0, 140.0 - 1e3 * flange.origin[2]], abs=10.0)
    assert float(held) < 0.001 + 1e-6 < 0.005 < float(free)


def test_the_criterion_is_lowered_by_a_design(copy: Path) -> None:
    program = """
from dynident import load_robot, random_via_points
from dynident.trajectories import Goal, ViaPointShape, build_design, score_motion, solve_design
robot = load_robot("rx90")
problem = build_design(robot, ViaPointShape(6), Goal("e", payload_only=True))
design = solve_design(problem, seed=0, starts=1)
print(design.feasible, design.score.value)
print(*(score_motion(problem, random_via_points(robot, 6, seed=k).motion(100.0)).value for k in range(5)))
"""
    designed, others = run(copy, program).splitlines()
    feasible, value = designed.split()
    assert feasible == "True"
    assert float(value) < min(map(float, others.split()))


def test_the_robot_has_a_regressor_that_agrees_with_its_dynamics(copy: Path) -> None:
    program = """
import numpy as np
from dynident import load_robot
from dynident.model import inverse_dynamics, robot_names, standard_columns, standard_regressor
robot, draw = load_robot("acme3"), np.random.default_rng(0)
chi, state = draw.normal(size=len(standard_columns(robot))), draw.normal(size=(3, 3))
torque = np.array(inverse_dynamics(robot)(*state, chi)).ravel()
print("acme3" in robot_names(), abs(np.array(standard_regressor(robot)(*state)) @ chi - torque).max())
"""
    shipped, apart = run(copy, program).split()
    assert shipped == "True"
    assert float(apart) < 1e-12
