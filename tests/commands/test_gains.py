"""``dynident gains``, and what becomes of gains that were identified; log maps and flags on the way in."""

import gzip
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps.results import read_stored_gains
from dynident.model import InertialParameters, load_robot
from dynident.tests.commands.lines import save
from dynident.tests.commands.typed import answered, refused
from dynident.trajectories import Simulator, ViaPoints

GAINS = np.array([12.0, 12.4, 9.9, 10.4, 10.3, 10.1])
BODY = InertialParameters.from_com(6.0, [0.0, 0.1, 0.05], np.diag([0.03, 0.03, 0.02]))
MAP = """[time]
unit = "ms"
[position]
columns = "axis {} pos"
unit = "deg"
[current]
columns = "axis {} cur"
unit = "mA"
"""
PAIR = "--robot ur10e --unloaded empty.csv --loaded loaded.csv"


def _write(folder: Path) -> None:
    """Currents of a pair in SI units, and the same with degrees, milliampere, milliseconds and other names."""
    known = {**load_robot("rx90").parameters, **{f"OFF{joint}": 0.5 for joint in range(1, 7)}}
    simulator = Simulator(replace(load_robot("ur10e"), parameters=known))
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (30, 6))
    motion = ViaPoints(points, np.full(29, 1.0)).motion(100.0)
    (folder / "map.toml").write_text(MAP)
    for name, load in (("empty", None), ("loaded", BODY)):
        recording = simulator.record(motion, load, [1.0, 1.0, 0.6, 0.3, 0.3, 0.2], 1 if load else 0)
        i, odd = recording.torque / GAINS, folder / f"{name}_odd.csv"
        save(folder / f"{name}.csv", recording.t, recording.q, i, names="q,i")
        save(odd, 1e3 * recording.t, np.degrees(recording.q), 1e3 * i, names="axis pos,axis cur")
        head, rows = odd.read_text().split("\n", 1)
        odd.write_text(",".join(["t", *(f"axis {c[8:]} {c[5:8]}" for c in head.split(",")[1:])]) + "\n" + rows)


@pytest.fixture
def pair(shared: Callable[[str, Callable[[Path], object]], Path], here: Path) -> Path:
    for path in shared("currents", _write).iterdir():
        (here / path.name).symlink_to(path)
    return here


def _identify(folder: Path) -> None:
    (folder / "gains.json").write_text(json.dumps(answered(f"gains {PAIR} --mass 6+-0.03").document))


@pytest.fixture
def gains(shared: Callable[[str, Callable[[Path], object]], Path], pair: Path) -> dict[str, Any]:
    """The gains of the pair, also in the working folder."""
    text = (shared("gains", _identify) / "gains.json").read_text()
    (pair / "gains.json").write_text(text)
    return dict(json.loads(text))


def width(document: dict[str, Any]) -> float:
    """Width of the mass's 95 % interval of the constrained estimate."""
    (low, high) = next(e for e in document["estimates"] if e["estimator"] == "constrained")["interval95"]["M"]
    return float(high - low)


def typed_gains(document: dict[str, Any]) -> str:
    return ",".join(map(repr, document["drive_gains"]["values"]))


@pytest.mark.long
def test_gains_flow_into_the_payload(gains: dict[str, Any]) -> None:
    values, sigma = (np.array(gains["drive_gains"][key]) for key in ("values", "sigma"))
    assert (np.abs(values - GAINS) < 4.0 * sigma).all()
    assert np.abs(values / GAINS - 1.0)[1:].max() < 0.05
    line = f"payload {PAIR} --method 4 --drive-gains"
    without = answered(f"{line} {typed_gains(gains)} --gain-sigma 0", status=(0, 1)).document
    answer = answered(f"{line} gains.json")
    assert "errors of the drive gains as they were identified" in answer.text
    assert width(answer.document) > 1.1 * width(without)
    assert answer.document["processing"]["drive_gains"] == pytest.approx(values)
    assert answer.document["estimates"][0]["parameters"]["M"] == pytest.approx(6.0, rel=0.03)


@pytest.mark.long
def test_gains_from_the_same_pair_confirm_nothing(gains: dict[str, Any], pair: Path) -> None:
    """Told in text, JSON and report, whatever the file is called; a recording in common is told too."""
    (pair / "copy.csv.gz").write_bytes(gzip.compress((pair / "loaded.csv").read_bytes()))
    (pair / "other.csv").write_text((pair / "loaded.csv").read_text().rstrip() + "1\n")

    def notes(line: str) -> list[str]:
        answer = answered(f"payload --robot ur10e {line}", status=(0, 1))
        told: list[str] = answer.document["estimates"][-1]["gain_sigma"].get("notes", [])
        shown = answer.text.replace(" ", "")  # a long path is broken anywhere
        assert all("".join(note.split()) in shown for note in told)
        return told

    own = "--unloaded empty.csv --drive-gains gains.json --method 3"
    (same,) = notes(f"{own} --loaded copy.csv.gz --report report.html")
    assert same.startswith("These gains come from this same pair (copy.csv.gz, 6 kg as given then)")
    assert "confirms nothing" in same
    assert "confirms nothing" in (pair / "report.html").read_text()
    (common,) = notes(f"{own} --loaded other.csv")
    assert common.startswith("empty.csv: the gains were identified from it too")
    stored = answered("identify --robot ur10e --data other.csv --drive-gains gains.json")
    assert "as they were identified" in stored.text
    assert "identified from it too" not in stored.text
    (pair / "robot.json").write_text(json.dumps(stored.document))
    kept = stored.document["gain_sigma"]
    assert (kept["recordings"], kept["mass"]) == (gains["recordings"], 6.0)
    for more in ("", "--gain-sigma 1%"):
        line = f"--robot-parameters robot.json --drive-gains {typed_gains(gains)} {more} --loaded copy.csv.gz"
        assert notes(line)[0] == same
    assert [len(gains["recordings"][kind]) for kind in ("unloaded", "loaded")] == [1, 1]
    del gains["recordings"]
    (pair / "gains.json").write_text(json.dumps(gains))
    assert read_stored_gains(pair / "gains.json").recordings == {}


@pytest.mark.parametrize(
    ("document", "words"),
    [
        ({"robot": "x", "drive_gains": {"values": [1.0], "relative_covariance": [[0.0]]}}, "gains of 'x'"),
        ({"recordings": [1, 2]}, "key 'recordings"),
        ({"recordings": {"loaded": "abc"}}, "key 'recordings"),
        ({"load": [1]}, "key 'load"),
        ({"load": {"known": [1]}}, "key 'load"),
        ([], "give the --json of 'dynident gains'"),
    ],
)
def test_gains_that_are_none(pair: Path, document: Any, words: str) -> None:
    if isinstance(document, dict):
        own = {"values": [1.0] * 6, "relative_covariance": np.eye(6).tolist()}
        document = {"robot": "ur10e", "drive_gains": own} | document
    (pair / "g.json").write_text(json.dumps(document), encoding="utf-8")
    error = refused("check empty.csv --robot ur10e --drive-gains g.json")
    assert words in error
    assert "gains of" in error or "give the --json of 'dynident gains'" in error
