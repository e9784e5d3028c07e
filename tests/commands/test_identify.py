"""``dynident identify``: essential parameters, a robot that can exist, and the whole robot for a simulator."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from dynident.apps.report.recordings import write_recording
from dynident.model import INERTIAL, load_robot
from dynident.model.files.robot_file import robot_toml
from dynident.tests.commands.typed import answered, refused, typed
from dynident.trajectories import Simulator, random_via_points


def test_a_robot_that_can_exist(logs: Path) -> None:
    line, by_gauge = "identify --robot rx90 --data bare0.csv", {}
    for gauge in ("none", "base", "prior"):
        answer = answered(f"{line} --constrained {gauge}")
        by_gauge[gauge] = answer.document["constrained"]
        assert ("Constrained: the nearest robot that can exist" in answer.text) == (gauge != "none")
        assert ("prior within MX2R" in answer.text) == (gauge == "prior")
    assert by_gauge["none"] is None
    assert by_gauge["prior"]["chi2_rise"] == pytest.approx(by_gauge["base"]["chi2_rise"] + 1.0, rel=1e-6)
    assert {entry["kind"] for entry in by_gauge["prior"]["parameters"]} == {"identified", "combination", "prior"}
    assert min(by_gauge["prior"]["min_eigenvalues"].values()) > 0.0
    bounds = "--constrained prior --prior-mass 70 --prior-budget 4 --total-mass 30 60"
    found = answered(f"{line} {bounds}").document["constrained"]
    values = {entry["name"]: entry["value"] for entry in found["parameters"]}
    assert 30.0 - 1e-4 <= sum(values[f"M{j}"] for j in range(1, 7)) <= 60.0 + 1e-4
    assert found["prior"]["budget"] == 4.0
    assert "70 kg" in found["prior"]["source"]


EXPORT = "robot export --robot rx90 --robot-parameters r.json"


@pytest.fixture
def identify(here: Path) -> str:
    """Identification of an RX90 without payload, into r.json."""
    robot = load_robot("rx90")
    motion = random_via_points(robot, 8, seed=5).motion(100.0)
    write_recording(here / "bare.csv", Simulator(robot).record(motion, None, [0.5] * 6, 1))
    return "identify --robot rx90 --equation-rate 1000 --data bare.csv --json r.json"


@pytest.mark.long
def test_whole_robot_for_a_simulator(identify: str) -> None:
    """From its own description, and from an identification, whose default are links that can exist."""
    assert typed("robot export --to urdf --robot rx90 --out rx90.urdf").status == 0
    assert load_robot("rx90.urdf").parameters["M3"] == pytest.approx(load_robot("rx90").parameters["M3"])
    assert typed(identify).status == 0
    for form in ("mjcf", "usd", "urdf", "sdf"):
        ended = typed(f"{EXPORT} --to {form} --out rx90.{form}")
        assert ended.status == 0, ended.err
        assert "54 base parameters identified" in ended.text
        assert "Prior: the robot file of rx90." in Path(f"rx90.{form}").read_text()
    assert typed(f"{identify} --constrained base").status == 0
    assert "run 'dynident identify --prior-mass KG'" in refused(f"{EXPORT} --to sdf --out new.sdf")
    assert not Path("new.sdf").exists()


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
