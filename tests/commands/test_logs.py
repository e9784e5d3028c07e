"""The command line's ways in: log maps and flags, ``check``, ``gains``, gains from a file."""

import contextlib
import gzip
import io
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps.results import read_stored_gains
from dynident.cli import main
from dynident.model import InertialParameters, Robot, load_robot
from dynident.tests.commands.runs import Run
from dynident.trajectories import Simulator, ViaPoints

GAINS = np.array([12.0, 12.4, 9.9, 10.4, 10.3, 10.1])
BODY = InertialParameters.from_com(6.0, [0.0, 0.1, 0.05], np.diag([0.03, 0.03, 0.02]))


@pytest.fixture(scope="module")
def arm() -> Robot:
    known = {**load_robot("rx90").parameters, **{f"OFF{joint}": 0.5 for joint in range(1, 7)}}
    return replace(load_robot("ur10e"), parameters=known)


@pytest.fixture(scope="module")
def logs(arm: Robot, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Currents of a pair in SI units, and the same with degrees, milliampere, milliseconds and other names."""
    folder = tmp_path_factory.mktemp("logs")
    draw = np.random.default_rng(0)
    simulator = Simulator(arm)
    motion = ViaPoints(draw.uniform(-1.0, 1.0, (30, 6)), np.full(29, 1.0)).motion(100.0)
    paths: dict[str, str] = {}
    for name, load in (("empty", None), ("loaded", BODY)):
        recording = simulator.record(motion, load, [1.0, 1.0, 0.6, 0.3, 0.3, 0.2], 1 if load else 0)
        i = recording.torque / GAINS
        for kind, q, currents, t, pattern in (
            ("si", recording.q, i, recording.t, ("q{}", "i{}")),
            ("odd", np.degrees(recording.q), 1000.0 * i, 1000.0 * recording.t, ("axis {} pos", "axis {} cur")),
        ):
            header = ["t"] + [each.format(j) for each in pattern for j in range(1, 7)]
            path = folder / f"{name}_{kind}.csv"
            table = np.column_stack([t, q, currents])
            np.savetxt(path, table, delimiter=",", header=",".join(header), comments="", fmt="%.9g")
            paths[f"{name}_{kind}"] = str(path)
    paths["map"] = str(folder / "map.toml")
    Path(paths["map"]).write_text(
        '[time]\nunit = "ms"\n[position]\ncolumns = "axis {} pos"\nunit = "deg"\n'
        '[current]\ncolumns = "axis {} cur"\nunit = "mA"\n'
    )
    paths["folder"] = str(folder)
    return paths


def gains_command(logs: dict[str, str], kind: str, *more: str) -> tuple[str, ...]:
    pair = ("--unloaded", logs[f"empty_{kind}"], "--loaded", logs[f"loaded_{kind}"])
    return ("gains", "--robot", "ur10e", *pair, "--mass", "6+-0.03", *more)


@pytest.fixture(scope="module")
def identified(logs: dict[str, str]) -> tuple[Path, str]:
    """The gains of the pair: the JSON, and what was printed."""
    path = Path(logs["folder"]) / "gains.json"
    with contextlib.redirect_stdout(io.StringIO()) as out:
        assert main(gains_command(logs, "si", "--json", str(path))) == 0
    return path, out.getvalue()


def constrained_width(document: dict[str, Any]) -> float:
    """Width of the mass's 95 % interval of the constrained estimate."""
    (low, high) = next(e for e in document["estimates"] if e["estimator"] == "constrained")["interval95"]["M"]
    return float(high - low)


@pytest.mark.long
def test_gains_flow_into_the_payload(
    run: Run, logs: dict[str, str], identified: tuple[Path, str], tmp_path: Path
) -> None:
    path, out = identified
    assert "inertia only" in out
    document = json.loads(path.read_text(encoding="utf-8"))
    values, sigma = (np.array(document["drive_gains"][key]) for key in ("values", "sigma"))
    assert (np.abs(values - GAINS) < 4.0 * sigma).all()
    assert np.abs(values / GAINS - 1.0)[1:].max() < 0.05
    answer = tmp_path / "payload.json"
    pair = ("--unloaded", logs["empty_si"], "--loaded", logs["loaded_si"])
    command = ("payload", "--robot", "ur10e", *pair, "--method", "4", "--json", str(answer), "--drive-gains")
    exact = ",".join(map(str, values))
    run(*command, exact, "--gain-sigma", "0")
    without = constrained_width(json.loads(answer.read_text(encoding="utf-8")))
    status, out, _ = run(*command, str(path))
    assert status == 0
    assert "errors of the drive gains as they were identified" in out
    content = json.loads(answer.read_text(encoding="utf-8"))
    assert constrained_width(content) > 1.1 * without
    assert content["processing"]["drive_gains"] == pytest.approx(values)
    assert content["estimates"][0]["parameters"]["M"] == pytest.approx(6.0, rel=0.03)


@pytest.mark.long
def test_gains_of_coupled_drives(run: Run, tmp_path: Path) -> None:
    """One gain per motor, told as such; how sure they are is in the intervals of what is weighed with them."""
    robot = load_robot("rx90")
    coupling, draw, paths = robot.coupling, np.random.default_rng(0), []
    assert coupling is not None
    motion = ViaPoints(draw.uniform(-1.0, 1.0, (30, 6)), np.full(29, 1.0)).motion(250.0)
    for name, load in (("empty", None), ("loaded", BODY)):
        recording = Simulator(robot).record(motion, load)
        currents = coupling.motor_torques(recording.torque) / GAINS + 0.05 * draw.standard_normal(recording.q.shape)
        paths.append(str(tmp_path / f"{name}.csv"))
        header = ",".join(["t", *(f"{kind}{j}" for kind in ("q", "i") for j in range(1, 7))])
        table = np.column_stack([recording.t, recording.q, currents])
        np.savetxt(paths[-1], table, delimiter=",", header=header, comments="", fmt="%.9g")
    pair, target = ("--unloaded", paths[0], "--loaded", paths[1]), tmp_path / "gains.json"
    status, out, _ = run("gains", "--robot", "rx90", *pair, "--mass", "6", "--json", str(target))
    assert status == 0
    assert "motor" in out
    assert "(motor 6 turns with joints 5 and 6)" in " ".join(out.split())
    gains = json.loads(target.read_text(encoding="utf-8"))["drive_gains"]
    assert (np.abs(np.array(gains["values"]) - GAINS) < 4.0 * np.array(gains["sigma"])).all()
    assert np.array(gains["values"]) == pytest.approx(GAINS, rel=0.02)
    answer, widths = tmp_path / "payload.json", []
    exact = (",".join(map(str, gains["values"])), "--gain-sigma", "0")
    for value in (exact, (str(target),)):
        command = ("payload", "--robot", "rx90", *pair, "--method", "4", "--json", str(answer), "--drive-gains")
        status, out, _ = run(*command, *value)
        assert status == 0
        content = json.loads(answer.read_text(encoding="utf-8"))
        widths.append(constrained_width(content))
        assert content["estimates"][0]["parameters"]["M"] == pytest.approx(6.0, rel=0.02)
        assert max(content["relative_residual"]["per_joint"]) < 0.1
    assert widths[1] > 1.1 * widths[0]
    text = " ".join(out.split())
    assert "errors of the drive gains as they were identified" in text
    assert "% per motor" in text


@pytest.mark.long
def test_gains_from_the_same_pair_confirm_nothing(
    run: Run, logs: dict[str, str], identified: tuple[Path, str], tmp_path: Path
) -> None:
    """Told in text, JSON and report, whatever the file is called; a recording in common is told too."""
    gains, answer, report = (tmp_path / name for name in ("gains.json", "payload.json", "report.html"))
    gains.write_bytes(identified[0].read_bytes())
    copy, second = tmp_path / "copy.csv.gz", tmp_path / "other.csv"
    copy.write_bytes(gzip.compress(Path(logs["loaded_si"]).read_bytes()))
    lines = Path(logs["loaded_si"]).read_text().splitlines()
    second.write_text("\n".join([*lines[:-1], lines[-1] + "1"]) + "\n")

    def notes(loaded: str, *more: str) -> list[str]:
        pair = ("--unloaded", logs["empty_si"], "--loaded", loaded, "--drive-gains", str(gains))
        status, out, err = run("payload", "--robot", "ur10e", *pair, "--method", "3", "--json", str(answer), *more)
        assert status in (0, 1), err
        constrained = json.loads(answer.read_text())["estimates"][-1]
        gain_notes: list[str] = constrained["gain_sigma"].get("notes", [])
        shown = "".join(out.split())  # a long path is broken anywhere
        assert all("".join(note.split()) in shown for note in gain_notes)
        return gain_notes

    (same,) = notes(str(copy), "--report", str(report))
    assert same.startswith(f"These gains come from this same pair ({copy}, 6 kg as given then)")
    assert "confirms nothing" in same
    assert "confirms nothing" in report.read_text()
    (shared,) = notes(str(second))
    assert shared.startswith(f"{logs['empty_si']}: the gains were identified from it too")
    status, out, _ = run("identify", "--robot", "ur10e", "--data", str(second), "--drive-gains", str(gains))
    assert status == 0
    assert "as they were identified" in " ".join(out.split())
    assert "identified from it too" not in " ".join(out.split())
    stored = tmp_path / "robot.json"
    run("identify", "--robot", "ur10e", "--data", str(second), "--drive-gains", str(gains), "--json", str(stored))
    document = json.loads(gains.read_text())
    gain_notes = json.loads(stored.read_text())["gain_sigma"]
    assert (gain_notes["recordings"], gain_notes["mass"]) == (document["recordings"], 6.0)
    numbers = ",".join(map(repr, document["drive_gains"]["values"]))
    for more in ((), ("--gain-sigma", "1%")):
        weighed = ("payload", "--robot-parameters", str(stored), "--drive-gains", numbers, *more)
        _, out, _ = run(*weighed, "--robot", "ur10e", "--loaded", str(copy), "--json", str(answer))
        notes_then = json.loads(answer.read_text())["estimates"][-1]["gain_sigma"]["notes"]
        assert notes_then[0] == same
        assert "confirms nothing" in " ".join(out.split())
    assert [len(document["recordings"][kind]) for kind in ("unloaded", "loaded")] == [1, 1]
    del document["recordings"]
    gains.write_text(json.dumps(document))
    assert read_stored_gains(gains).recordings == {}


@pytest.mark.long
def test_log_map_gives_the_same_gains(
    run: Run, logs: dict[str, str], identified: tuple[Path, str], tmp_path: Path
) -> None:
    path = tmp_path / "odd.json"
    assert run(*gains_command(logs, "odd", "--log-map", logs["map"], "--json", str(path)))[0] == 0
    values = [json.loads(p.read_text(encoding="utf-8"))["drive_gains"]["values"] for p in (identified[0], path)]
    assert values[0] == pytest.approx(values[1], rel=1e-4)


@pytest.mark.long
def test_check(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    document, pictures = tmp_path / "check.json", tmp_path / "pictures"
    pictures.mkdir()
    both = (logs["empty_si"], logs["loaded_si"])
    status, out, _ = run("check", *both, "--robot", "ur10e", "--plots", str(pictures), "--json", str(document))
    assert status == 0
    assert out.count("nothing looks wrong") + out.count("note:") >= 2
    stems = ("01_empty_si", "02_loaded_si")
    assert sorted(path.name for path in pictures.iterdir()) == [
        f"{s}.{end}" for s in stems for end in ("pdf", "png", "svg")
    ]
    looks = json.loads(document.read_text(encoding="utf-8"))["logs"]
    assert [look["currents"] for look in looks] == [True, True]
    assert [look["usable"] for look in looks] == [True, True]
    assert looks[0]["time"]["rate"] == pytest.approx(100.0)
    assert len(looks[0]["excitation"]) == 58


def test_check_tells_degrees(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    how = tmp_path / "map.toml"
    how.write_text(Path(logs["map"]).read_text().replace('unit = "deg"\n', ""))
    status, out, _ = run("check", logs["empty_odd"], "--robot", "ur10e", "--log-map", str(how))
    assert status == 1
    assert "degrees" in out
    assert "--units q=deg" in out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--log-map", "none.toml"), "none.toml: no such file"),
        (("--units", "q=grad"), "unit 'grad' of position"),
        (("--signs", "1,2,1,1,1,1"), "sign must be 1 or -1"),
        (("--signs", "1,-1"), "position.sign has 2 entries"),
        (("--joints", "a,b"), "2 joints, the robot has 6"),
    ],
)
def test_wrong_flags_are_one_line(run: Run, logs: dict[str, str], arguments: tuple[str, ...], words: str) -> None:
    status, out, err = run("check", logs["empty_si"], "--robot", "ur10e", *arguments)
    assert (status, out) == (2, "")
    assert words in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("--mass", "-1"), "a mass above 0 kg"),
        (("--payload", "none.toml"), "none.toml: no such file"),
        (("--payload", "x.toml", "--mass", "1"), "give either --mass or --payload"),
    ],
)
def test_wrong_loads_are_one_line(run: Run, logs: dict[str, str], more: tuple[str, ...], words: str) -> None:
    pair = ("--unloaded", logs["empty_si"], "--loaded", logs["loaded_si"])
    status, _, err = run("gains", "--robot", "ur10e", *pair, *more)
    assert status == 2
    assert words in err


def test_gains_of_another_robot(run: Run, logs: dict[str, str], tmp_path: Path) -> None:
    path = tmp_path / "g.json"
    path.write_text(
        json.dumps({"robot": "x", "drive_gains": {"values": [1.0], "relative_covariance": [[0.0]]}}),
        encoding="utf-8",
    )
    status, _, err = run("check", logs["empty_si"], "--robot", "ur10e", "--drive-gains", str(path))
    assert status == 2
    assert "gains of 'x'" in err
    for part in (
        {"recordings": [1, 2]},
        {"recordings": {"loaded": "abc"}},
        {"load": [1]},
        {"load": {"known": [1]}},
    ):
        gains = {"values": [1.0] * 6, "relative_covariance": np.eye(6).tolist()}
        path.write_text(json.dumps({"robot": "ur10e", "drive_gains": gains, **part}), encoding="utf-8")
        status, _, err = run("check", logs["empty_si"], "--robot", "ur10e", "--drive-gains", str(path))
        assert status == 2
        assert len(err.splitlines()) == 1
        assert f"key '{next(iter(part))}" in err
        assert "give the --json of 'dynident gains'" in err
    path.write_text("[]", encoding="utf-8")
    status, _, err = run("check", logs["empty_si"], "--robot", "ur10e", "--drive-gains", str(path))
    assert status == 2
    assert "give the --json of 'dynident gains'" in err
