"""A line for each command that answers, and the inputs that it needs beside the frozen runs' own."""

import contextlib
import json
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from dynident.apps.fleet.reduction import Log, Recipe, Store, Stored
from dynident.apps.logs.read import read_recording
from dynident.common.arrays import Array
from dynident.estimation import identify
from dynident.estimation.fit.linear_problem import weighted
from dynident.model import INERTIAL, Recording, load_robot
from dynident.tests.commands.typed import typed
from dynident.tests.fleet.conftest import drawn, noise_of
from dynident.tests.frozen.inputs import EXAMPLES, folder_of_inputs
from dynident.tests.live.conftest import playing

AMPERES = "--unloaded ur_currents_unloaded.csv --loaded ur_currents_loaded.csv"
PAIR = "--unloaded rx_arm_unloaded.csv --loaded rx_arm_loaded.csv"

NOISE = "--torque-noise 24,30,10.8,5.1,6.6,2.3 --json b.json"
BRIEF = f"--robot rx90 --columns payload --starts 1 --seed 2 {NOISE}"
WHOLE = f"--robot rx90 --via-points 4 --starts 1 {NOISE}"
SCALE = "--mass 6+-0.1"
NEAR = f"--robot rx90 --pose=0,-45,90,0,45,0 --joints 4,5,6 {SCALE} --duration 4 {NOISE}"
REST = "--robot rx90 --pose=0,-45,90,0,45,0 --joints 2,5 --mass 6 --torque-noise 1% --json b.json starts=1"
SCORE = f"rx_arm.csv --robot rx90 {NOISE}"

PORTS = {"port": 20000 + os.getpid() % 10000, "script_port": 30010 + os.getpid() % 10000}
"""The played controller's ports while lines run: others for each process that tests."""
PLAYED = f"--host 127.0.0.1 --port {PORTS['port']}"

LINES = {
    "weigh": "--robot rx90 --unloaded rx_near_unloaded.csv --loaded rx_near_loaded.csv --json b.json",
    "verify": "--robot rx90 --before before.csv --after after.csv",
    "payload": f"--robot rx90 {PAIR} --method 4 --json b.json",
    "identify": "--robot rx90 --data rx_arm_unloaded.csv --json b.json",
    "rollout": "--robot rx90 --robot-parameters earlier.json --data rx_arm_loaded.csv --json b.json",
    "gains": f"--robot ur10e {AMPERES} --mass 6.2 equation-rate=25 --json b.json",
    "apply": f"flange.json --to ur --yes {PLAYED} script-port={PORTS['script_port']}",
    "record": f"ur {PLAYED} --seconds 0.1 --out b.csv",
    "fleet reduce": "first.csv --robot rx90 --store store --json b.json",
    "fleet report": "nightly --json b.json",
    "compare": "first.csv second.csv --robot rx90 --json b.json",
    "check": "--robot rx90 --json b.json rx_arm_unloaded.csv",
    "export": "rx_payload.json --to ur --flange-frame 0 0 0 0 0 0",
    "robot list": "",
    "robot show": "--robot rx90",
    "robot new": "--name arm --joint=z,0,0,0 --joint=y,0,0,0.3 --flange 0,0,0.6,z,x",
    "robot check": "--robot rx90 --data rx_arm_unloaded.csv --json b.json",
    "robot export": "--robot six_axis.toml --to urdf --out a.urdf",
    "codegen": "--robot rx90 --function base_regressor --out code",
    "design": f"{BRIEF} --via-points 4",
    "near": NEAR,
    "score": SCORE,
    "simulate": "--robot rx90 --trajectory rx_short.csv --rate 50 --out out",
    "demo": "--trajectories 3 --out out",
}


def save(path: Path | str, *columns: Array, names: str, head: str = "") -> None:
    """Write columns as CSV; "q,tau" names those of as many joints."""
    n = (sum(np.shape(column)[1] if np.ndim(column) > 1 else 1 for column in columns) - 1) // len(names.split(","))
    header = ",".join(["t", *(f"{name}{j}" for name in names.split(",") for j in range(1, n + 1))])
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=head + header, comments="", fmt="%.12g")


def log(path: Path | str, recording: Recording, torque: str = "tau") -> None:
    """Write a recording whose gains are exact."""
    save(path, recording.t, recording.q, recording.torque, names=f"q,{torque}", head="# gain_sigma = 0\n")


TEXTS = {
    "turned.toml": "[position]\nsign = [1, -1, 1, 1, 1, 1]\n",
    "loud.toml": "verbose = true\n",
    "degrees.toml": '[position]\nunit = "deg"\n',
    "scene.toml": '[[surfaces]]\nname = "floor"\noffset = -0.3\n[[bodies]]\nname = "tool"\nlink=6\nradius = .1\n',
    "heavy.toml": "\n".join(
        [
            'name = "heavy"\nmass_kg = 5\n[[joints]]\nalpha_deg = 0\n[[joints]]\nalpha_deg = 90\n[parameters]',
            *(f"{kind}{j} = {9 * (kind in ('XX', 'YY', 'ZZ', 'M'))}" for j in (1, 2) for kind in INERTIAL),
        ]
    ),
}
"""Files that options name; the robot's links weigh more than the arm."""


@contextlib.contextmanager
def inputs_of_all_lines() -> Iterator[Path]:
    """All that the lines and their options read, in a folder that is the working folder meanwhile."""
    with folder_of_inputs() as folder, playing(**PORTS):
        for name, text in TEXTS.items():
            (folder / name).write_text(text)
        put_payloads(folder)
        for name, share in (("before", 0.9), ("after", 0.95)):
            follow(folder / "rx_near_loaded.csv", folder / f"{name}.csv", share)
        for name in ("unloaded", "loaded"):  # the same numbers twice are refused
            rows = (folder / f"ur_currents_{name}.csv").read_text().splitlines(keepends=True)
            (folder / f"ur_again_{name}.csv").write_text("".join(rows[:-3]))
        shutil.copy(EXAMPLES / "robots/six_axis.urdf", folder)
        typed(f"identify {LINES['identify']} --json earlier.json")
        make_recordings(folder)
        yield folder


def follow(source: Path, target: Path, share: float) -> None:
    """A recording with the torque that its controller predicted, a share of what was measured."""
    header = source.read_text().partition("\n")[0]
    values = np.loadtxt(source, delimiter=",", skiprows=1)
    predicted = ",".join(f"tauref{j}" for j in range(1, 7))
    values = np.hstack([values, share * values[:, 7:13]])
    np.savetxt(target, values, delimiter=",", header=f"{header},{predicted}", comments="", fmt="%.9g")


def put_payloads(folder: Path) -> None:
    """Two payloads in the flange's frame: one to use, and one that its verdict refuses."""
    document = json.loads((folder / "rx_payload.json").read_text())
    document["frame"] = "tool0: the bare flange"
    for name, level in (("flange", "use"), ("refused", "do_not_use")):
        document["verdict"]["level"] = level
        (folder / f"{name}.json").write_text(json.dumps(document))


def make_recordings(folder: Path) -> None:
    """Three recordings of one robot, with other noise each, and a store."""
    robot, rows = load_robot("rx90"), np.loadtxt(folder / "rx_arm_unloaded.csv", delimiter=",", skiprows=1)
    header = (folder / "rx_arm_unloaded.csv").read_text().partition("\n")[0]
    for seed, name in enumerate(("first", "second", "third")):
        noise = np.random.default_rng(seed).normal(scale=0.3, size=(len(rows), 6))
        np.savetxt(
            folder / f"{name}.csv", rows + np.pad(noise, ((0, 0), (rows.shape[1] - 6, 0))), delimiter=",",
            header=header, comments="", fmt="%.9g",
        )  # fmt: skip
    result = identify(robot, [read_recording(folder / "third.csv", robot)])
    make_store(folder, Stored(Log("third.csv"), robot, result.base, result.problem))


def make_store(folder: Path, recording: Stored) -> None:
    """A store of two arms and three nights, drawn on a recording's motion."""
    recipe = Recipe(recording.robot.processing)
    store, draw = Store.made(folder / "nightly", recording.robot, recipe), np.random.default_rng(0)
    values, noise, rows = weighted(recording.equations).values, noise_of(recording), []
    for arm in ("left", "right"):
        for night in range(1, 4):
            key = f"{arm}{night}"
            log = Log(f"{key}.csv", arm, f"2026-01-0{night}", sha256="0" * 64, key=key)
            night_recording = drawn(recording, values, noise, draw, log)
            estimate = weighted(night_recording.equations)
            store.path(key).write_bytes(night_recording.parquet(estimate))
            rows.append(log)
    store.finish(rows)
