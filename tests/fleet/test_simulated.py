"""Fleets that never were: as the truth beside them says, the same by one seed, found by reduce and report."""

import contextlib
import csv
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.apps import fleet
from dynident.apps.fleet.nights import arm_of
from dynident.apps.fleet.simulated import Scenario, damaged, simulated_arms
from dynident.cli import main
from dynident.common.errors import InputError
from dynident.estimation.fit import weighted
from dynident.model import load_robot, robot_names, with_stand_in
from dynident.tests.frozen.inputs import EXAMPLES

SIX = str(EXAMPLES / "robots" / "six_axis.toml")
QUICK = f"fleet simulate {SIX} --rate 100 --points 8 --noise 0.02"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Four arms as equations, one of each kind; the working folder."""
    place = tmp_path_factory.mktemp("simulated")
    with contextlib.chdir(place):
        line = f"{QUICK} --out drawn --equations --arms 4 --days 12 --replaced 1 --missing 5% --damaged 5% --seed 4"
        assert main(line.split()) == 0
        yield place


def truth(folder: Path) -> list[dict[str, object]]:
    arms: list[dict[str, object]] = json.loads((folder / "drawn" / "truth.json").read_text())["arms"]
    return arms


@pytest.mark.long
def test_the_report_finds_what_the_truth_says(folder: Path) -> None:
    assert main(["fleet", "report", "drawn/six_axis/store", "--json", "report.json"]) == 0
    report = json.loads(Path("report.json").read_text())
    events = {str(arm["arm"]): arm["event"] for arm in truth(folder) if arm["event"]}
    alarms = {(alarm["arm"], alarm["quantity"]) for alarm in report["alarms"]}
    for arm, event in events.items():
        assert isinstance(event, dict)
        if event["what"] == "wear":
            assert (arm, event["quantity"]) in alarms
        if event["what"] == "payload":
            assert (arm, "mass") in alarms
    exchanged = {exchange["arm"]: exchange["day"] for exchange in report["exchanges"]}
    replaced = {
        arm: event for arm, event in events.items() if isinstance(event, dict) and event["what"] == "replaced"
    }
    assert exchanged == {arm: event["day"] for arm, event in replaced.items()}


@pytest.mark.long
def test_what_is_missing_or_damaged_is_not_in_the_store(folder: Path) -> None:
    rows = list(csv.DictReader((folder / "drawn/six_axis/truth.csv").read_text().splitlines()))
    store = fleet.Store.opened(folder / "drawn/six_axis/store")
    good = {f"{row['arm']}/{row['day']}.csv" for row in rows if row["log"] == "good"}
    assert {row.file for row in store.rows()} == good
    assert set(store.refused()) == {
        f"{row['arm']}/{row['day']}.csv" for row in rows if row["log"] in ("cut", "clock")
    }
    assert len(good) < len(rows) == 48


def test_the_same_seed_gives_the_same_bytes_and_more_arms_or_days_leave_the_first(tmp_path: Path) -> None:
    robot = load_robot(SIX)
    few = simulated_arms(robot, Scenario(arms=2, days=5, worn=0, laden=0))
    assert [arm.nights for arm in few] == [
        arm.nights for arm in simulated_arms(robot, Scenario(arms=2, days=5, worn=0, laden=0))
    ]
    more = simulated_arms(robot, Scenario(arms=3, days=5, worn=0, laden=0))
    assert [arm.nights for arm in more[:2]] == [arm.nights for arm in few]
    with contextlib.chdir(tmp_path):
        for out in ("a", "b"):
            assert main(f"{QUICK} --out {out} --arms 1 --days 2 --worn 0 --laden 0".split()) == 0
        contents = [
            {path.relative_to(out): path.read_bytes() for path in Path(out).rglob("*") if path.is_file()}
            for out in ("a", "b")
        ]
        assert contents[0] == contents[1]


def test_friction_scatters_as_told() -> None:
    """Standard deviation, memory and temperature of many days, all joints together."""
    robot = load_robot(SIX)
    (arm,) = simulated_arms(robot, Scenario(arms=1, days=3000, worn=0, laden=0, coulomb=0.03, memory=0.5))
    x = np.array(
        [[night.parameters[f"FS{j}"] / arm.parameters[f"FS{j}"] for j in range(1, 7)] for night in arm.nights]
    )
    warm = np.array([night.temperature - 20.0 for night in arm.nights])
    slope = warm @ (x - x.mean(axis=0)) / (warm @ warm)
    left = x - x.mean(axis=0) - np.outer(warm, slope)
    assert abs(slope.mean() + 0.01) < 3e-4
    assert abs(left.std() - 0.03) < 5e-4
    assert abs(np.mean(left[1:] * left[:-1]) / left.var() - 0.5) < 0.02


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--arms 1", "1 worn, 1 laden and 0 replaced of 1 arms"),
        ("--missing 60% --damaged 60%", "more than all logs"),
        ("--points 1", "give 2 to 500"),
        ("--points 1000000", "give 2 to 500"),
    ],
)
def test_what_cannot_be_is_refused(
    options: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(f"{QUICK} --out {tmp_path / 'o'} {options}".split()) == 2
    assert words in capsys.readouterr().err
    assert main(f"fleet simulate rx90 rx90 --out {tmp_path / 'o'}".split()) == 2
    assert "'rx90' twice: give each type once" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["..", "../beside", "/beside", "a/b"])
def test_nothing_is_written_beside_the_folder(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A type's folder is called as its robot: a name that leads elsewhere is refused."""
    lines = Path(SIX).read_text().splitlines()
    renamed = [f'name = "{name}"' if line.startswith("name = ") else line for line in lines]
    (tmp_path / "odd.toml").write_text("\n".join(renamed))
    line = ["fleet", "simulate", str(tmp_path / "odd.toml"), "--out", str(tmp_path / "in" / "out")]
    assert main(line) == 2
    assert "no name of a folder" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["odd.toml"]


@pytest.mark.parametrize("kind", ["cut", pytest.param("clock", marks=pytest.mark.long)])
def test_a_damaged_log_is_refused_by_name(kind: str, tmp_path: Path) -> None:
    """A recording is cut after its first rows, or its clock runs back; the good one beside it is reduced."""
    with contextlib.chdir(tmp_path):
        assert main(f"{QUICK} --out o --arms 1 --days 2 --worn 0 --laden 0".split()) == 0
        logs = Path("o/six_axis/logs/arm001")
        bad = logs / "2026-01-02.csv"
        bad.write_text(damaged(bad.read_text(), kind))  # type: ignore[arg-type]
        reduced = fleet.reduce_fleet(fleet.catalog.catalog([], table="o/six_axis/robots.csv"), load_robot(SIX), "s")
        assert (reduced.new, list(reduced.refused)) == (1, ["o/six_axis/logs/arm001/2026-01-02.csv"])
        assert {"cut": "", "clock": "time runs back"}[kind] in next(iter(reduced.refused.values()))


def test_a_wrong_robot_name_in_the_table_is_told_with_the_right_one(folder: Path) -> None:
    """One recording of one arm under another's name, among good ones."""
    store = fleet.Store.opened(folder / "drawn/six_axis/store")
    whose: dict[str, list[fleet.RobotPassport]] = {}
    events = {str(arm["arm"]): arm["event"] for arm in truth(folder)}
    quiet = [arm for arm, event in events.items() if event is None]
    worn = next(arm for arm, event in events.items() if isinstance(event, dict) and event["what"] == "wear")
    for row, passport in store.passports():
        assert isinstance(passport, fleet.RobotPassport)
        whose.setdefault(row.about["arm"], []).append(passport)
    own, wrong = whose[quiet[0]], whose[worn][1]
    assert arm_of(own).exchange is None
    about = {**wrong.about, "arm": quiet[0], "day": "2026-01-20"}
    history = fleet.fleet_of([arm_of([*own, replace(wrong, about=about)]), arm_of(whose[worn])])
    (exchange,) = history.exchanges
    assert (exchange.arm, exchange.day, exchange.alone, exchange.like) == (quiet[0], "2026-01-20", True, worn)


@pytest.mark.long
def test_drawn_and_recorded_agree_in_mean_and_spread(tmp_path: Path) -> None:
    """A fleet as recordings and the same fleet as equations: friction of each night about its truth."""
    options = "--arms 1 --days 24 --worn 0 --laden 0 --apart 0%"
    with contextlib.chdir(tmp_path):
        assert main(f"{QUICK} --out r {options}".split()) == 0
        assert main(f"{QUICK} --out e {options} --equations".split()) == 0
        robot = load_robot(SIX)
        fleet.reduce_fleet(fleet.catalog.catalog([], table="r/six_axis/robots.csv"), robot, "s")
        rows = list(csv.DictReader(Path("r/six_axis/truth.csv").read_text().splitlines()))
        off = []
        for root in ("s", "e/six_axis/store"):
            nights = sorted(fleet.Store.opened(root).passports(), key=lambda pair: pair[0].about["day"])
            shares = []
            for row, (_, passport) in zip(rows, nights, strict=True):
                assert isinstance(passport, fleet.RobotPassport)
                estimate = weighted(passport.equations)
                shares.append(
                    [
                        (estimate.values[estimate.names.index(name)] - float(row[name])) / estimate.sigma[k]
                        for name in estimate.names
                        if name[:2] in ("FS", "FV")
                        for k in (estimate.names.index(name),)
                    ]
                )
            off.append(np.array(shares))
    spread = [x.std(axis=0, ddof=1) for x in off]
    assert 0.8 < np.sqrt(np.mean(spread[0] ** 2) / np.mean(spread[1] ** 2)) < 1.25
    apart = (off[0].mean(axis=0) - off[1].mean(axis=0)) / np.sqrt((spread[0] ** 2 + spread[1] ** 2) / len(rows))
    assert np.abs(apart).max() < 5.0


@pytest.mark.long
def test_a_fleet_of_every_shipped_robot(tmp_path: Path) -> None:
    """Every type that can be simulated gives equations that its report reads; the others say what they lack."""
    for name in robot_names():
        try:
            with_stand_in(load_robot(name))
        except InputError:
            continue
        with contextlib.chdir(tmp_path):
            options = "--arms 1 --days 2 --worn 0 --laden 0 --equations"
            assert main(f"fleet simulate {name} --out o-{name} {options}".split()) == 0, name
            assert main(f"fleet report o-{name}/{load_robot(name).name}/store".split()) == 0, name
