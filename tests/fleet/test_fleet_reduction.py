"""Many recordings to a store: the same whoever reduces them, whenever they are killed; what is wrong is named."""

import contextlib
import multiprocessing
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps.fleet import reduction
from dynident.apps.fleet.reduction import Log, Recipe, Store, catalog, reduce_fleet
from dynident.apps.logs.map import LogMap
from dynident.apps.logs.read import read_recordings
from dynident.cli import main
from dynident.common.errors import InputError
from dynident.estimation.fit.linear_problem import weighted
from dynident.model import load_robot
from dynident.tests.commands.lines import make_recordings
from dynident.tests.commands.typed import refused
from dynident.tests.fleet.conftest import GOOD, ROBOT, Lost, contents, entries
from dynident.tests.frozen.inputs import unpack


def test_good_ones_are_in_and_each_wrong_one_is_named(store: Path) -> None:
    opened = Store.opened(store)
    good = [log for log in opened.logs() if not log.reason]
    assert [log.file for log in good] == sorted(GOOD)
    assert [opened.read(log.key).log.arm for log in good] == ["a", "a", "b"]
    refused = {log.file: log.reason for log in opened.logs() if log.reason}
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
    stored = Store.opened(store)
    for log in stored.logs():
        if not log.reason:
            estimate, row = weighted(stored.read(log.key).equations), table.loc[log.file]
            assert tuple(row["parameters"]) == estimate.names
            np.testing.assert_allclose(row["values"], estimate.values, rtol=1e-9)
            np.testing.assert_allclose(row["sigma"], estimate.sigma, rtol=1e-9)
    assert list(pandas.read_parquet(store / "logs.parquet")["reason"] == "").count(True) == 3


def test_a_lost_run_started_again_ends_in_the_same_store(store: Path, tmp_path: Path) -> None:
    place = tmp_path / "lost"
    with pytest.raises(InputError, match=r"workers were lost after 2 of 5 .*: run it again, what is done is kept"):
        reduce_fleet(entries(), ROBOT, place, workers=(Lost(2), 1))
    with pytest.raises(InputError, match="reduced in part"):
        Store.opened(place)
    again = reduce_fleet(entries(), ROBOT, place)
    assert again.known == 2
    assert contents(place) == contents(store)
    untouched = reduce_fleet(entries(), ROBOT, place)
    assert (untouched.new, untouched.known) == (0, 3)
    assert contents(place) == contents(store)


def test_a_night_more_adds_to_the_store(logs: Path, store: Path, tmp_path: Path) -> None:
    first = [entry for entry in entries() if entry.file in GOOD[:2]]
    reduce_fleet(first, ROBOT, tmp_path / "s")
    rest = [entry for entry in entries() if entry.file not in GOOD[:2]]
    assert reduce_fleet(rest, ROBOT, tmp_path / "s").new == 1
    assert contents(tmp_path / "s") == contents(store)


@pytest.mark.parametrize(("day", "good"), [("2026-02-07", False), ("2026-01-04T23:00", True)])
def test_a_clock_of_another_day_is_named(logs: Path, tmp_path: Path, day: str, good: bool) -> None:
    """A log with times since 1970, of a controller whose clock ran back to January."""
    table = np.loadtxt(logs / GOOD[0], delimiter=",", skiprows=1)
    table[:, 0] += 1767482000.0  # 2026-01-03, in the evening
    header = (logs / GOOD[0]).read_text().partition("\n")[0]
    log = tmp_path / "night.csv"
    np.savetxt(log, table, delimiter=",", header=header, comments="", fmt="%.15g")
    reduced = reduce_fleet([Log(str(log), "a", day)], ROBOT, tmp_path / "s")
    assert reduced.new == good
    words = f"its clock starts on 2026-01-03 but it is said to be of {day}"
    assert [words in bad.reason for bad in reduced.refused] == [True] * (not good)


def test_another_robot_or_recipe_needs_another_store(store: Path) -> None:
    with pytest.raises(InputError, match="another robot"):
        reduce_fleet([GOOD[0]], load_robot("ur10e"), store)
    recipe = Recipe(ROBOT.processing, log_map=LogMap(joints=("x",)))
    with pytest.raises(InputError, match="another recipe"):
        reduce_fleet([GOOD[0]], ROBOT, store, recipe)


def test_logs_of_one_arm_at_one_time_are_named(tmp_path: Path) -> None:
    logs = [Log(f"{name}.csv", "a", "2026-01-01") for name in "xy"]
    _, second = reduce_fleet(logs, ROBOT, tmp_path / "s").refused
    assert second.file == "y.csv"
    assert second.reason == "x.csv is of arm 'a' at 2026-01-01 too: give times, or another name"
    (laden,) = [log for log in catalog(["a/2.csv", "a/much.csv"], "{arm}/{payload}.csv") if log.reason]
    assert laden.reason == "payload 'much' is no number"


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


@pytest.mark.long
def test_two_processes_one_of_them_killed(store: Path, tmp_path: Path) -> None:
    """The pool is made anew; nothing is lost, nothing counts twice."""
    killed: list[int] = []

    def kill(_: float) -> None:
        if not killed:
            killed.append(int(multiprocessing.active_children()[0].pid or 0))
            os.kill(killed[0], signal.SIGKILL)

    reduced = reduce_fleet(entries(), ROBOT, tmp_path / "s", workers=2, progress=kill)
    assert reduced.workers_lost >= 1
    assert contents(tmp_path / "s") == contents(store)


def deadly(*_: Any) -> None:
    """A task that ends a process without a word, as a fault in a compiled library does."""
    os._exit(9)


def pool_with_deadly_logs(workers: int) -> Executor:
    """Processes that the logs of arm b end."""
    return ProcessPoolExecutor(workers, multiprocessing.get_context("fork"), poison)


def poison() -> None:
    """In a worker: reading a recording of arm b ends it."""
    vars(reduction)["read_recordings"] = lambda path, *more: (
        deadly() if path.startswith("b/") else read_recordings(path, *more)
    )


@pytest.mark.skipif(sys.platform == "win32", reason="processes are forked, so that they read as the test says")
def test_a_log_that_ends_its_worker_each_time_is_one_row(
    store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reduction, "process_pool", pool_with_deadly_logs)
    reduced = reduce_fleet(entries(), ROBOT, tmp_path / "s", workers=2)
    assert reduced.workers_lost >= 1
    assert reduced.new == 2
    assert {bad.file for bad in reduced.refused if bad.reason == reduction.KILLS} == {
        "b/2026-01-01.csv", "b/2026-01-03.csv"
    }  # fmt: skip


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextlib.contextmanager
def cluster(port: int, workers: int = 2) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """A real scheduler and its workers, processes of their own, on this machine's loopback alone."""
    address, quiet = f"tcp://127.0.0.1:{port}", subprocess.DEVNULL
    start = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
    scheduler = [*start, "--host", "127.0.0.1", "--port", str(port), "--no-dashboard"]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard",
              "--no-nanny", "--host", "127.0.0.1", "--death-timeout", "20"]  # fmt: skip
    running = [subprocess.Popen(line, stdout=quiet, stderr=quiet) for line in [scheduler, *[worker] * workers]]
    try:
        yield address, running
    finally:
        for process in running:
            process.kill()
        for process in running:
            process.wait()


def reached(address: str, workers: int) -> None:
    """Wait until all workers are there."""
    for _ in range(600):
        with contextlib.suppress(InputError), reduction.dask_executor(address) as (_, count):
            if count == workers:
                return
        time.sleep(0.2)
    raise AssertionError("no workers")


@pytest.mark.long
@pytest.mark.filterwarnings("ignore")
def test_a_dask_scheduler_and_two_workers(store: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Equal to the serial store; a worker killed in the middle; the scheduler killed and restarted."""
    port = free_port()
    with cluster(port) as (address, running):
        reached(address, 2)
        with reduction.dask_executor(address) as (executor, count):
            killed = threading.Timer(1.0, running[-1].kill)
            killed.start()
            reduce_fleet(entries(), ROBOT, tmp_path / "a", workers=(executor, count))
            killed.join()
        assert contents(tmp_path / "a") == contents(store)
        with (
            pytest.raises(InputError, match=r"workers were lost after \d of 5"),
            reduction.dask_executor(address) as (executor, count),
        ):
            reduce_fleet(
                entries(), ROBOT, tmp_path / "b", workers=(executor, 1), progress=lambda _: running[0].kill()
            )
    with cluster(port) as (address, _):
        reached(address, 2)
        line = f"fleet reduce a b turned other.csv --robot rx90 --store {tmp_path / 'b'} --cluster {address}"
        assert main([*line.split(), "--pattern", "{arm}/{day}.csv"]) == 0
    assert "5 logs refused" in capsys.readouterr().out
    assert contents(tmp_path / "b") == contents(store)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    place = tmp_path_factory.mktemp("wrong_stores")
    unpack(place)
    with contextlib.chdir(place):
        make_recordings(place)
        yield place


WRONG = ["", "{", "[]", "3", '{"robot": 3}', '{"logs": [{"file": "a.csv"}]}', 3000 * "["]


@pytest.mark.parametrize("text", WRONG)
@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("logs.parquet", "fleet report nightly --json -"),
        ("store.json", "fleet reduce first.csv --robot rx90 --store nightly"),
    ],
)
def test_what_was_changed_in_a_store_is_named(name: str, line: str, text: str, folder: Path) -> None:
    path = folder / "nightly" / name
    good = path.read_bytes()
    path.write_text(text)
    error = refused(line)
    path.write_bytes(good)
    assert name in error
