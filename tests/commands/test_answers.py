"""Commands that answer, and what goes from one to another: refused, warned of, or the same again."""

import gzip
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs import read_trajectory
from dynident.apps.results import read_stored_gains
from dynident.model import INERTIAL, load_robot
from dynident.model.files.robot_file import robot_toml
from dynident.tests.commands.typed import answered, refused, typed
from dynident.tests.selection import cases

IDENTIFY = "identify --robot rx90 --data rx_arm_unloaded.csv"


def test_stored_parameters_of_another_robot(inputs: Path) -> None:
    robot = answered(IDENTIFY).document
    line = "payload --robot rx90 --robot-parameters robot.json --loaded rx_arm_loaded.csv"
    for change, more, words in (
        ({"robot": "tx40"}, "", "'tx40', not 'rx90'"),
        ({"columns": robot["columns"][1:]}, "", "robot.json"),
        ({}, "offsets=true", "must be those the stored parameters"),
        ({}, "coulomb=paper", "must be those the stored parameters"),
    ):
        (inputs / "robot.json").write_text(json.dumps(robot | change))
        assert words in refused(f"{line} {more}")


def test_what_is_no_robot_to_use_is_not_written(inputs: Path) -> None:
    """Its verdict says so, or a link is heavier than the arm."""
    stored = answered(IDENTIFY).document | {"reasons_against_use": ["the weather"]}
    (inputs / "r.json").write_text(json.dumps(stored))
    masses = "\n".join(f"{kind}{j} = {int(kind == 'M') * 100}" for j in range(1, 7) for kind in INERTIAL)
    description = robot_toml(replace(load_robot("ur10e"), parameters={}))
    (inputs / "heavy.toml").write_text(f"{description}\n[parameters]\n{masses}\n")
    line = "robot export --to mjcf --out a.xml --robot"
    for arm, words in (
        ("rx90 --robot-parameters r.json", "not written: the weather"),
        ("heavy.toml", "link1 would weigh 100 kg, the whole arm weighs 33.5"),
    ):
        ended = typed(f"{line} {arm}")
        assert (ended.status, Path("a.xml").exists()) == (1, False)
        assert words in ended.err
    assert typed(f"{line} rx90 --robot-parameters r.json --despite-verdict").status == 0
    assert Path("a.xml").exists()


@pytest.mark.long
def test_gains_from_the_same_pair_confirm_nothing(inputs: Path) -> None:
    """Told in text, JSON and report, whatever the file is called; a recording in common is told too."""
    loaded = inputs / "ur_currents_loaded.csv"
    (inputs / "copy.csv.gz").write_bytes(gzip.compress(loaded.read_bytes()))
    (inputs / "other.csv").write_text(loaded.read_text().rstrip() + "1\n")
    arm, bare = "--robot ur10e.toml", "--unloaded ur_currents_unloaded.csv"
    gains = answered(f"gains {arm} {bare} --loaded ur_currents_loaded.csv --mass 6.2+-0.03").document
    (inputs / "gains.json").write_text(json.dumps(gains))

    def notes(line: str) -> list[str]:
        answer = answered(f"payload {arm} {line}", status=(0, 1))
        told: list[str] = answer.document["estimates"][-1]["gain_sigma"].get("notes", [])
        shown = answer.text.replace(" ", "")  # a long path is broken anywhere
        assert all("".join(note.split()) in shown for note in told)
        return told

    own = f"{bare} --drive-gains gains.json --method 3"
    (same,) = notes(f"{own} --loaded copy.csv.gz --report report.html")
    assert same.startswith("These gains come from this same pair (copy.csv.gz, 6.2 kg as given then)")
    assert "confirms nothing" in same
    assert "confirms nothing" in (inputs / "report.html").read_text()
    (common,) = notes(f"{own} --loaded other.csv")
    assert common.startswith("ur_currents_unloaded.csv: the gains were identified from it too")
    stored = answered(f"identify {arm} --data other.csv --drive-gains gains.json")
    assert "of the identified drive gains" in stored.text
    assert "identified from it too" not in stored.text
    (inputs / "robot.json").write_text(json.dumps(stored.document))
    kept = stored.document["gain_sigma"]
    assert (kept["recordings"], kept["mass"]) == (gains["recordings"], 6.2)
    values = ",".join(map(repr, gains["drive_gains"]["values"]))
    for more in ("", "--gain-sigma 1%"):
        line = f"--robot-parameters robot.json --drive-gains {values} {more} --loaded copy.csv.gz"
        assert notes(line)[0] == same
    del gains["recordings"]
    (inputs / "gains.json").write_text(json.dumps(gains))
    assert read_stored_gains(inputs / "gains.json").errors.recordings == {}


def test_verify_tells_harm(inputs: Path) -> None:
    header, *rows = (inputs / "rx_near_loaded.csv").read_text().splitlines()
    for name, share in (("before", 0.95), ("after", 0.9)):  # of the torque, as the controller predicted it
        more = (",".join(f"{share * float(torque)}" for torque in row.split(",")[7:13]) for row in rows)
        lines = [f"{row},{predicted}" for row, predicted in zip(rows, more, strict=True)]
        names = ",".join(f"tauref{j}" for j in range(1, 7))
        (inputs / f"{name}.csv").write_text("\n".join([f"{header},{names}", *lines, ""]))
        for signal, own in (("q", slice(1, 7)), ("tau", slice(7, 13)), ("tauref", slice(-6, None))):
            cells = [line.split(",") for line in (f"{header},{names}", *lines)]
            columns = "\n".join(",".join([row[0], *row[own]]) for row in cells)
            (inputs / f"{name}_{signal}.csv").write_text(f"{columns}\n")
    split = "{0}_q.csv {0}_tau.csv {0}_tauref.csv"
    for before, after, status in (("before.csv", split.format("after"), 1), ("after.csv", "before.csv", 0)):
        ended = typed(f"verify --robot rx90 --before {before} --after {after}")
        assert (ended.status, "makes it worse" in ended.out) == (status, bool(status))
    assert "give one recording" in typed("verify --robot rx90 --before before.csv after.csv --after after.csv").err


NEAR = "near --robot rx90 --pose=0,-45,90,0,45,0 --speed-override 0.5 --duration 12"


@pytest.mark.usefixtures("hasty")
def test_a_rehearsal_is_written_beside_a_motion(here: Path) -> None:
    document, text = answered(f"{NEAR} --joints 2,3,5,6 --samples motion.csv sample-rate=125", status=(0, 1))
    assert "Visible to joints 2, 3, 5, 6: 10 of 10" in text
    assert "Assumed, because not published: torque limits" in text
    robot = load_robot("rx90")
    (_, _, fast, _), (t, _, slow, _) = (
        read_trajectory(here / f"motion{end}.csv", robot) for end in ("", "_rehearsal")
    )
    assert fast is not None
    assert slow is not None
    assert np.abs(slow).max() == pytest.approx(0.1 * np.abs(fast).max(), rel=1e-3)
    assert t[-1] == pytest.approx(document["rehearsal_s"])
    assert "REHEARSAL" in (here / "motion_rehearsal.csv").read_text(encoding="utf-8")
    answered(f"{NEAR} --joints 2,3,5,6 rehearsal=alone.csv sample-rate=125", status=(0, 1))
    assert (here / "alone.csv").exists()


NOISE = "--torque-noise 24,30,10.8,5.1,6.6,2.3"


@pytest.mark.long
@pytest.mark.many_steps
@pytest.mark.parametrize(
    ("goal", "shape", "apart"),
    [
        ("--columns payload --criterion cond", "--fourier 2 --duration 4", 1e-6),
        ("--criterion d", "--fourier 3 --duration 6", 1e-6),
        # The search chooses the duration, no multiple of the steps of W: some joint has a row more or less.
        ("--columns payload --criterion cond", "--via-points 4", 1e-2),
    ],
)
def test_a_designed_csv_is_judged_as_the_design_was(here: Path, goal: str, shape: str, apart: float) -> None:
    line = f"design --robot rx90 {goal} {shape} {NOISE} --starts 1 --samples m.csv sample-rate=250"
    designed = answered(line).document
    judged, text = answered(f"score --robot rx90 {goal} {NOISE} m.csv")
    assert judged["evaluated"] == "m.csv"
    assert "motion" not in judged
    assert judged["limits"]["met"]
    for key in ("condition_number", "condition_number_scaled", "log_det", "duration_s"):
        assert judged[key] == pytest.approx(designed[key], rel=apart), key
        assert f"{judged[key]:.4g}" in text
    assert judged["predicted_sigma"] == pytest.approx(designed["predicted_sigma"], rel=apart)


@pytest.mark.parametrize(
    ("channels", "keeps"), [(("q", "tau"), True), (("q", "i"), True), (("q",), False), (("q", "qd", "qdd"), False)]
)
def test_where_a_recorded_arm_was_is_no_floor(here: Path, channels: tuple[str, ...], keeps: bool) -> None:
    """The forearm goes below the base's height, as on a pedestal: what was recorded proves that it may."""
    t = np.linspace(0.0, 4.0, 401)[:, None]
    q = np.array([0.0, 0.6, 0.5, 0.0, 1.0, 0.0]) + 0.2 * np.sin(np.pi * t * np.arange(1, 7) / 4)
    signals = {"q": q, "qd": np.gradient(q, 0.01, axis=0), "tau": q, "i": q}
    signals["qdd"] = np.gradient(signals["qd"], 0.01, axis=0)
    header = ",".join(["t", *(f"{kind}{j}" for kind in channels for j in range(1, 7))])
    rows = np.hstack([t, *(signals[kind] for kind in channels)])
    np.savetxt(here / "m.csv", rows, delimiter=",", header=header, comments="")
    _, text = answered("score --robot ur10e --torque-limits none m.csv", status=(0, 1))
    assert ("NOT within its limits of clearance" not in text) == keeps
    assert ("NOT checked: torque, floor" in " ".join(text.split())) == keeps


@pytest.mark.many_steps
@pytest.mark.parametrize(
    "file", cases(("--val3 app", "--ros2 m.yaml", "--urscript m.script"), lambda file: file.startswith("--val3"))
)
def test_files_whose_controllers_break_a_limit_are_refused(here: Path, file: str) -> None:
    """Nothing is written or shown; with room left by the setting torque-margin the same file is written."""
    line = (
        "design --robot tx40 --columns payload --torque-noise 1% --via-points 4 --starts 1 --seed 2 "
        f"acceleration=5x --heaviest-payload 2@0,0,0.05 --within 0.1 --segments trapezoid {file}"
    )
    error = refused(f"{line} --json m.json")
    assert "the motion does not keep its limits (torque with any payload up to 2 kg of joint" in error
    assert not list(here.iterdir())
    status, _, err = typed(f"{line} torque-margin=30%")
    assert status == 0, err
    assert [path.name for path in here.iterdir()] == [file.split()[1]]
