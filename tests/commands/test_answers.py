"""Commands that answer: payload, identify, gains, weigh, simulate, and what goes from one to another."""

import gzip
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps.logs import read_trajectory
from dynident.apps.report.recordings import write_recording
from dynident.apps.results import read_stored_gains
from dynident.model import INERTIAL, InertialParameters, load_robot
from dynident.model.files.robot_file import robot_toml
from dynident.tests.commands.lines import save
from dynident.tests.commands.typed import answered, refused, typed
from dynident.trajectories import Simulator, ViaPoints, random_via_points


def test_stored_parameters_of_another_robot(logs: Path) -> None:
    robot = answered("identify --robot rx90 --data bare0.csv").document
    line = "payload --robot rx90 --robot-parameters robot.json --loaded loaded0.csv"
    for change, more, words in (
        ({"robot": "tx40"}, "", "'tx40', not 'rx90'"),
        ({"columns": robot["columns"][1:]}, "", "robot.json"),
        ({}, "offsets=true", "must be those the stored parameters"),
        ({}, "coulomb=paper", "must be those the stored parameters"),
    ):
        (logs / "robot.json").write_text(json.dumps(robot | change))
        assert words in refused(f"{line} {more}")
    del robot["covariance"]
    (logs / "robot.json").write_text(json.dumps(robot))
    assert "'covariance': missing" in refused(line)


EXPORT = "robot export --robot rx90 --robot-parameters r.json"


@pytest.fixture
def identify(here: Path) -> str:
    """Identification of an RX90 without payload, into r.json."""
    robot = load_robot("rx90")
    motion = random_via_points(robot, 8, seed=5).motion(100.0)
    write_recording(here / "bare.csv", Simulator(robot).record(motion, None, [0.5] * 6, 1))
    return "identify --robot rx90 equation-rate=1000 --data bare.csv --json r.json"


def test_what_is_no_robot_to_use_is_not_written(identify: str) -> None:
    """Its verdict says so, or a link is heavier than the arm."""
    typed(identify)
    document = json.loads(Path("r.json").read_text())
    Path("r.json").write_text(json.dumps(document | {"reasons_against_use": ["the weather"]}))
    masses = "\n".join(f"{kind}{j} = {int(kind == 'M') * 100}" for j in range(1, 7) for kind in INERTIAL)
    description = robot_toml(replace(load_robot("ur10e"), parameters={}))
    Path("heavy.toml").write_text(f"{description}\n[parameters]\n{masses}\n")
    for line, words in (
        (f"{EXPORT} --to mjcf --out a.xml", "not written: the weather"),
        (
            "robot export --to mjcf --robot heavy.toml --out a.xml",
            "link1 would weigh 100 kg, the whole arm weighs 33.5",
        ),
    ):
        ended = typed(line)
        assert (ended.status, Path("a.xml").exists()) == (1, False)
        assert words in ended.err
    assert (typed(f"{EXPORT} --to mjcf --out a.xml --despite-verdict").status, Path("a.xml").exists()) == (0, True)


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


def _identify_gains(folder: Path) -> None:
    (folder / "gains.json").write_text(json.dumps(answered(f"gains {PAIR} --mass 6+-0.03").document))


@pytest.fixture
def gains(shared: Callable[[str, Callable[[Path], object]], Path], pair: Path) -> dict[str, Any]:
    """The gains of the pair, also in the working folder."""
    text = (shared("gains", _identify_gains) / "gains.json").read_text()
    (pair / "gains.json").write_text(text)
    return dict(json.loads(text))


def typed_gains(document: dict[str, Any]) -> str:
    return ",".join(map(repr, document["drive_gains"]["values"]))


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


NEAR = "near --robot rx90 --pose=0,-45,90,0,45,0 --speed-override 0.5 --duration 12"


def test_visibility_and_sigma_before_any_motion(here: Path) -> None:
    document, text = answered(f"{NEAR} --joints 2,3,5,6 --samples motion.csv sample-rate=125")
    assert "Visible to joints 2, 3, 5, 6: 10 of 10" in text
    assert document["visibility"]["rank"] == 10
    assert document["predicted_sigma"]["mass"] < 0.13
    assert max(document["predicted_sigma"]["com"]) < 8.4e-3
    assert (document["limits"]["max_violation"], document["limits"]["torque_checked"]) == (0.0, True)
    assert all(limit["room"] >= 0.0 for limit in document["limits"]["nearest"])
    assert "Assumed, not published: torque limits" in text
    robot = load_robot("rx90")
    (_, _, fast, _), (t, _, slow, _) = (
        read_trajectory(here / f"motion{end}.csv", robot) for end in ("", "_rehearsal")
    )
    assert fast is not None
    assert slow is not None
    assert np.abs(slow).max() == pytest.approx(0.1 * np.abs(fast).max(), rel=1e-3)
    assert t[-1] == pytest.approx(document["rehearsal_s"])
    assert "REHEARSAL" in (here / "motion_rehearsal.csv").read_text(encoding="utf-8")
