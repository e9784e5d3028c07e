"""Many recordings to a store: the same whoever reduces them, whenever they are killed; what is wrong is named."""

from pathlib import Path

import numpy as np
import pytest
from dynident.apps import fleet
from dynident.apps.fleet.store import Log, catalog, same_time
from dynident.apps.logs.map import LogMap
from dynident.common.errors import InputError
from dynident.estimation.fit.least_squares import weighted
from dynident.model import load_robot
from dynident.tests.fleet.night_logs import GOOD, ROBOT, Lost, contents, entries


def test_good_ones_are_in_and_each_wrong_one_is_named(store: Path) -> None:
    opened = fleet.Store.opened(store)
    good = [log for log in opened.logs() if not log.wrong]
    assert [log.file for log in good] == sorted(GOOD)
    assert [opened.read(log.key).log.arm for log in good] == ["a", "a", "b"]
    refused = {log.file: log.wrong for log in opened.logs() if log.wrong}
    assert sorted(refused) == ["b/2026-01-02.csv", "b/2026-01-03.csv", "b/2026-13-01.csv", "other.csv",
                               "turned/2026-01-01.csv"]  # fmt: skip
    assert "the same bytes as a/2026-01-01.csv" in refused["b/2026-01-02.csv"]
    assert "is no date" in refused["b/2026-13-01.csv"]
    assert "does not end in" in refused["other.csv"]
    assert "back" in refused["turned/2026-01-01.csv"]
    assert all(reason and "fault of ours" not in reason for reason in refused.values())


def test_other_programs_read_what_each_recording_says(store: Path) -> None:
    """A row a recording by pandas: the log, what is known of it, and the parameters that it alone identifies."""
    pandas = pytest.importorskip("pandas")
    table = pandas.read_parquet(store / "recordings").set_index("file").sort_index()
    assert list(table.index) == sorted(GOOD)
    assert list(table["arm"]) == ["a", "a", "b"]
    stored = fleet.Store.opened(store)
    for log in stored.logs():
        if not log.wrong:
            estimate, row = weighted(stored.read(log.key).equations), table.loc[log.file]
            assert tuple(row["parameters"]) == estimate.names
            np.testing.assert_allclose(row["values"], estimate.values, rtol=1e-9)
            np.testing.assert_allclose(row["sigma"], estimate.sigma, rtol=1e-9)
    assert list(pandas.read_parquet(store / "logs.parquet")["wrong"] == "").count(True) == 3


def test_a_lost_run_started_again_ends_in_the_same_store(store: Path, tmp_path: Path) -> None:
    place = tmp_path / "lost"
    with pytest.raises(InputError, match=r"workers were lost after 2 of 5 .*: run it again, what is done is kept"):
        fleet.reduce_fleet(entries(), ROBOT, place, workers=(Lost(2), 1))
    with pytest.raises(InputError, match="reduced in part"):
        fleet.Store.opened(place)
    again = fleet.reduce_fleet(entries(), ROBOT, place)
    assert again.known == 2
    assert contents(place) == contents(store)
    untouched = fleet.reduce_fleet(entries(), ROBOT, place)
    assert (untouched.new, untouched.known) == (0, 3)
    assert contents(place) == contents(store)


def test_a_night_more_adds_to_the_store(logs: Path, store: Path, tmp_path: Path) -> None:
    first = [entry for entry in entries() if entry.file in GOOD[:2]]
    fleet.reduce_fleet(first, ROBOT, tmp_path / "s")
    rest = [entry for entry in entries() if entry.file not in GOOD[:2]]
    assert fleet.reduce_fleet(rest, ROBOT, tmp_path / "s").new == 1
    assert contents(tmp_path / "s") == contents(store)


@pytest.mark.parametrize(("day", "good"), [("2026-02-07", False), ("2026-01-04T23:00", True)])
def test_a_clock_of_another_day_is_named(logs: Path, tmp_path: Path, day: str, good: bool) -> None:
    """A log with times since 1970, of a controller whose clock ran back to January."""
    table = np.loadtxt(logs / GOOD[0], delimiter=",", skiprows=1)
    table[:, 0] += 1767482000.0  # 2026-01-03, in the evening
    header = (logs / GOOD[0]).read_text().partition("\n")[0]
    log = tmp_path / "night.csv"
    np.savetxt(log, table, delimiter=",", header=header, comments="", fmt="%.15g")
    reduced = fleet.reduce_fleet([Log(str(log), "a", day)], ROBOT, tmp_path / "s")
    assert reduced.new == good
    words = f"its own clock begins on 2026-01-03, it is said to be of {day}"
    assert [words in bad.reason for bad in reduced.refused] == [True] * (not good)


def test_another_robot_or_recipe_needs_another_store(store: Path) -> None:
    with pytest.raises(InputError, match="another robot"):
        fleet.reduce_fleet([GOOD[0]], load_robot("ur10e"), store)
    recipe = fleet.Recipe(ROBOT.processing, log_map=LogMap(joints=("x",)))
    with pytest.raises(InputError, match="another recipe"):
        fleet.reduce_fleet([GOOD[0]], ROBOT, store, recipe)


def test_logs_of_one_arm_at_one_time_are_named() -> None:
    logs = [Log(f"{name}.csv", "a", "2026-01-01") for name in "xy"]
    assert same_time(logs) == {"y.csv": "x.csv is of arm 'a' at 2026-01-01 too: give times, or another name"}
    (laden,) = [log for log in catalog(["a/2.csv", "a/much.csv"], "{arm}/{payload}.csv") if log.wrong]
    assert laden.wrong == "payload 'much' is no number"


@pytest.mark.parametrize(
    ("pattern", "words"),
    [
        ("{robot}.csv", "is not known; known: arm"),
        ("{arm}-{day}.txt", "no log's path ends so"),
        ("{arm}{arm}", "arm"),
    ],
)
def test_patterns_that_cannot_be(pattern: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        catalog(["a/1.csv"], pattern)
