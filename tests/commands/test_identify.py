"""``dynident identify``: essential parameters, a robot that can exist, and the whole robot for a simulator."""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import NoReturn

import pytest
from dynident import estimation
from dynident.apps.report.recordings import write_recording
from dynident.estimation import SolverError
from dynident.estimation.possible.whole_robot import origins
from dynident.model import INERTIAL, base_parameters, load_robot
from dynident.model.drives import parameter_kind
from dynident.model.files.robot_file import robot_toml
from dynident.tests.commands.typed import answered, refused, typed
from dynident.trajectories import Simulator, random_via_points


@pytest.mark.long
def test_essential_parameters_by_either_rule(logs: Path) -> None:
    counts = []
    for option in ("plots=plots", "essential=1.1", "essential=5%"):
        answer = answered(f"identify --robot rx90 --data bare0.csv --data bare1.csv {option}")
        elimination = answer.document["elimination"]
        essential = [entry["name"] for entry in answer.document["base_parameters"] if entry["essential"]]
        assert [entry["name"] for entry in elimination["parameters"]] == essential
        assert f"{len(essential)} of 54 parameters essential" in answer.text
        assert len(elimination["path"]) == 55
        counts.append((len(essential), elimination))
    assert [elimination["rule"] for _, elimination in counts] == ["ratio", "ratio", "sigma"]
    assert counts[0][1]["sigma_ratio"] < 1.02 < counts[1][1]["sigma_ratio"] < 1.1
    assert counts[1][0] < counts[0][0]
    assert counts[2][1]["largest_relative_sigma_percent"] <= 5.0
    written = {path.name for path in Path("plots").iterdir()}
    assert {f"essential_path.{ending}" for ending in ("png", "svg", "pdf")} < written


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
    bounds = "--constrained prior --prior-mass 70 prior-budget=4 --total-mass 30 60"
    found = answered(f"{line} {bounds}").document["constrained"]
    values = {entry["name"]: entry["value"] for entry in found["parameters"]}
    assert 30.0 - 1e-4 <= sum(values[f"M{j}"] for j in range(1, 7)) <= 60.0 + 1e-4
    assert found["prior"]["budget"] == 4.0
    assert "70 kg" in found["prior"]["source"]


@pytest.fixture
def gen3(recordings: Path) -> str:
    """A Gen3's 4.7 s, whose sensors do not obey any robot."""
    return f"--robot {recordings}/gen3/gen3.urdf --data {recordings}/gen3/gen3_opti1.csv.gz"


@pytest.mark.long
def test_without_a_bound_of_the_mass_the_note_says_what_to_do(gen3: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whether the solver ends cleanly on them hangs on rounding: its failure is put in where it is asked about."""

    def fails(*_: object) -> NoReturn:
        raise SolverError("AlmostSolved")

    monkeypatch.setattr(estimation, "solve_constrained_prior", fails)
    errors = typed(f"identify {gen3} --prior-mass 7").err
    (line,) = [text for text in errors.split("dynident: note: ") if "no robot that can exist is given" in text]
    assert "--total-mass 0 KG" in " ".join(line.split())


@pytest.mark.long
def test_a_bound_of_the_mass_leads_to_a_file(gen3: str, here: Path) -> None:
    """Of the moving links, twice the prior; a robot that is not to be used is written despite its verdict only."""
    typed(f"identify {gen3} --prior-mass 7 --total-mass 0 14 --json r.json")
    document = json.loads(Path("r.json").read_text())
    values = {entry["name"]: entry["value"] for entry in document["constrained"]["parameters"]}
    assert sum(values[f"M{link}"] for link in range(1, 8)) <= 14.0 * (1.0 + 1e-6)
    export = f"robot export --to mjcf {gen3.partition(' --data')[0]} --robot-parameters r.json --out arm.xml"
    assert (typed(export).status, Path("arm.xml").exists()) == (1, False)
    assert (typed(f"{export} --despite-verdict").status, Path("arm.xml").exists()) == (0, True)


EXPORT = "robot export --robot rx90 --robot-parameters r.json"


@pytest.fixture
def identify(here: Path) -> str:
    """Identification of an RX90 without payload, into r.json."""
    robot = load_robot("rx90")
    motion = random_via_points(robot, 8, seed=5).motion(100.0)
    write_recording(here / "bare.csv", Simulator(robot).record(motion, None, [0.5] * 6, 1))
    return "identify --robot rx90 equation-rate=1000 --data bare.csv --json r.json"


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


def test_without_a_mass_one_line_names_the_option(identify: str) -> None:
    """A description without parameters and mass: base parameters, unless a mass is told."""
    Path("bare.toml").write_text(robot_toml(replace(load_robot("rx90"), parameters={}, mass=None)))
    for more, gauge in (("", "base"), ("--prior-mass 50", "prior")):
        status, _, error = typed(f"{identify.replace('rx90', 'bare.toml')} {more}")
        assert status == 0
        assert len([line for line in error.splitlines() if "--prior-mass KG" in line]) == (gauge == "base")
        assert json.loads(Path("r.json").read_text())["constrained"]["gauge"] == gauge


@pytest.mark.long
def test_who_decided_stands_in_every_output(identify: str) -> None:
    """Table, HTML, JSON and URDF of a robot nearest to a prior: the same labels."""
    ended = typed(f"{identify} --constrained prior --report r.html --details")
    assert ended.status == 0, ended.err
    document = json.loads(Path("r.json").read_text())
    stored, robot = {entry["name"]: entry for entry in document["constrained"]["parameters"]}, load_robot("rx90")
    labels = {name: origin.decided_by() for name, origin in origins(robot, base_parameters(robot)).items()}
    assert {name: entry["decided_by"] for name, entry in stored.items()} == labels
    assert {"data", "prior", "prior within MX2R"} <= set(labels.values())
    html, terminal = Path("r.html").read_text(), ended.out.split("decided by")[1]
    for name, label in labels.items():
        assert re.search(rf"<th[^>]*>{name}</th>(?:<td[^>]*>[^<]*</td>)*<td[^>]*>{label}</td></tr>", html), name
        assert re.search(rf"^ *{name} .* {label[:20]}", terminal, flags=re.MULTILINE), name
    assert typed(f"{EXPORT} --to urdf --out rx90.urdf").status == 0
    again = load_robot("rx90.urdf").parameters
    inertial = {name: value for name, value in again.items() if parameter_kind(name) in INERTIAL}
    assert inertial == pytest.approx({name: stored[name]["value"] for name in inertial}, abs=1e-9)
    del document["constrained"]["parameters"][0]
    Path("r.json").write_text(json.dumps(document))
    assert "other parameters than this robot's" in refused(f"{EXPORT} --to urdf --out new.urdf")
