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
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident import fleet
from dynident.cli import main
from dynident.common import files
from dynident.common.errors import InputError
from dynident.estimation.recordings.read import read_recordings
from dynident.fleet import engine
from dynident.fleet.catalog import Entry, catalog, found_logs
from dynident.model import load_robot
from dynident.tests.frozen.inputs import unpack

ROBOT = load_robot("rx90")
GOOD = ("a/2026-01-01.csv", "a/2026-01-02.csv", "b/2026-01-01.csv")


class Lost(engine.Here):
    """Loses its workers after ``most`` tasks."""

    def __init__(self, most: int) -> None:
        self.most = most

    def submit(self, fn: Callable[..., Any], /, *arguments: Any, **more: Any) -> Future[Any]:
        self.most -= 1
        if self.most >= 0:
            return super().submit(fn, *arguments, **more)
        future: Future[Any] = Future()
        future.set_exception(BrokenExecutor("gone"))
        return future


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Three good recordings, and every kind of wrong one; the working folder."""
    place = tmp_path_factory.mktemp("fleet")
    source_folder = tmp_path_factory.mktemp("given")
    unpack(source_folder)
    source = source_folder / "rx_arm_unloaded.csv"
    header, rows = source.read_text().partition("\n")[0], np.loadtxt(source, delimiter=",", skiprows=1)
    with contextlib.chdir(place):
        for seed, name in enumerate((*GOOD, "turned/2026-01-01.csv")):
            noise = np.random.default_rng(seed).normal(scale=0.3, size=(len(rows), 6))
            table = rows + np.pad(noise, ((0, 0), (rows.shape[1] - 6, 0)))
            if name.startswith("turned"):
                table[60, 0] = table[50, 0]
            Path(name).parent.mkdir(exist_ok=True)
            np.savetxt(name, table, delimiter=",", header=header, comments="", fmt="%.9g")
        Path("b/2026-01-02.csv").write_bytes(Path(GOOD[0]).read_bytes())
        Path("b/2026-01-03.csv").write_bytes(Path(GOOD[0]).read_bytes()[:2000])
        Path("b/2026-13-01.csv").write_bytes(Path(GOOD[0]).read_bytes() + b"\n")
        Path("other.csv").write_text("t,q1\n0,1\n")
        yield place


@pytest.fixture(scope="module")
def store(logs: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What one run makes of them all."""
    place = tmp_path_factory.mktemp("stores") / "serial"
    reduced = fleet.reduce_fleet(entries(), ROBOT, place)
    assert (reduced.new, reduced.known) == (3, 0)
    return place


def entries() -> tuple[Entry, ...]:
    return catalog(found_logs(["a", "b", "turned", "*.csv"]), "{arm}/{day}.csv")


def test_good_ones_are_in_and_each_wrong_one_is_named(store: Path) -> None:
    opened = fleet.Store.opened(store)
    assert [row.file for row in opened.rows()] == sorted(GOOD)
    assert [passport.about["arm"] for _, passport in opened.passports()] == ["a", "a", "b"]
    refused = opened.refused()
    assert sorted(refused) == ["b/2026-01-02.csv", "b/2026-01-03.csv", "b/2026-13-01.csv", "other.csv",
                               "turned/2026-01-01.csv"]  # fmt: skip
    assert "the same bytes as a/2026-01-01.csv" in refused["b/2026-01-02.csv"]
    assert "is no date" in refused["b/2026-13-01.csv"]
    assert "does not end in" in refused["other.csv"]
    assert "back" in refused["turned/2026-01-01.csv"]
    assert all(reason and "fault of ours" not in reason for reason in refused.values())


def test_a_lost_run_started_again_ends_in_the_same_store(store: Path, tmp_path: Path) -> None:
    place = tmp_path / "lost"
    with pytest.raises(InputError, match=r"workers were lost after 2 of 5 .*: run it again, what is done is kept"):
        fleet.reduce_fleet(entries(), ROBOT, place, executor=Lost(2))
    with pytest.raises(InputError, match="reduced in part"):
        fleet.Store.opened(place)
    again = fleet.reduce_fleet(entries(), ROBOT, place)
    assert again.known == 2
    assert contents(place) == contents(store)
    untouched = fleet.reduce_fleet(entries(), ROBOT, place)
    assert (untouched.new, untouched.known) == (0, 3)
    assert contents(place) == contents(store)


def test_a_full_disk_stops_it_whole(store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place, write = tmp_path / "full", files._write

    def full(path: Path, content: bytes) -> None:
        if path.suffix == ".npz" and list(path.parent.glob("*.npz")):
            raise OSError(28, "No space left on device")
        write(path, content)

    monkeypatch.setattr(files, "_write", full)
    with pytest.raises(InputError, match="No space left on device"):
        fleet.reduce_fleet(entries(), ROBOT, place)
    monkeypatch.setattr(files, "_write", write)
    assert len(list((place / "passports").iterdir())) == 1
    fleet.reduce_fleet(entries(), ROBOT, place)
    assert contents(place) == contents(store)


def test_a_fault_in_one_log_stops_nobody(logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: Any) -> None:
        raise ZeroDivisionError("odd")

    monkeypatch.setattr(fleet.worker, "read_recordings", fail)
    reduced = fleet.reduce_fleet([GOOD[0]], ROBOT, tmp_path / "s")
    assert reduced.refused == {GOOD[0]: "a fault of ours, please report it: ZeroDivisionError: odd"}


def test_a_night_more_adds_to_the_store(logs: Path, store: Path, tmp_path: Path) -> None:
    first = [entry for entry in entries() if entry.path in GOOD[:2]]
    fleet.reduce_fleet(first, ROBOT, tmp_path / "s")
    rest = [entry for entry in entries() if entry.path not in GOOD[:2]]
    assert fleet.reduce_fleet(rest, ROBOT, tmp_path / "s").new == 1
    assert contents(tmp_path / "s") == contents(store)


def test_another_robot_or_recipe_needs_another_store(store: Path) -> None:
    with pytest.raises(InputError, match="another robot"):
        fleet.reduce_fleet([GOOD[0]], load_robot("ur10e"), store)
    recipe = fleet.Recipe("identify", ROBOT.processing, essential=None, log_map="x")
    with pytest.raises(InputError, match="another recipe"):
        fleet.reduce_fleet([GOOD[0]], ROBOT, store, recipe)


def test_a_table_names_each_log(logs: Path, tmp_path: Path) -> None:
    table = logs / "robots.csv"
    table.write_text(f"file,arm,day,temperature,payload\n{GOOD[0]},a,2026-01-01,21.5,2\n{GOOD[1]},a,2026-01-01,22,2\n"
                     f"{GOOD[2]},b,2026-01-01,warm,0\ngone.csv,c,2026-01-01,20,0\n")  # fmt: skip
    listed = catalog(found_logs([GOOD[0], "other.csv"]), table=str(table))
    wrong = {Path(entry.path).name: entry.wrong for entry in listed if entry.wrong}
    assert "does not name it" in wrong.pop("other.csv")
    assert wrong == {Path(GOOD[2]).name: "temperature 'warm' is no number"}
    same = fleet.catalog.same_time(listed)
    assert len(same) == 1
    assert "is of arm 'a' at 2026-01-01 too" in next(iter(same.values()))
    for text, words in (
        ("file\nx.csv\n", "needs the columns file and arm"),
        ("file,arm,temprature\nx.csv,a,1\n", "did you mean 'temperature'"),
    ):
        table.write_text(text)
        with pytest.raises(InputError, match=words):
            catalog([], table=str(table))
    table.write_text("file,arm\nx.csv,a\nx.csv,b\n")
    assert ["more than once" in entry.wrong for entry in catalog([], table=str(table))] == [True]
    table.unlink()


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


def test_what_is_no_log(logs: Path) -> None:
    with pytest.raises(InputError, match="no log there"):
        found_logs(["nothing/*.csv"])
    assert found_logs([f"file://{logs}/a/2026-01-01.csv"]) == (f"file://{logs}/a/2026-01-01.csv",)
    with fleet.worker.local(f"file://{logs}/a/2026-01-01.csv") as copy:
        assert Path(copy).read_bytes() == Path(GOOD[0]).read_bytes()


@pytest.mark.long
def test_two_processes_one_of_them_killed(store: Path, tmp_path: Path) -> None:
    """The pool is made anew; nothing is lost, nothing counts twice."""
    killed: list[int] = []

    def kill(_: float) -> None:
        if not killed:
            killed.append(int(multiprocessing.active_children()[0].pid or 0))
            os.kill(killed[0], signal.SIGKILL)

    reduced = fleet.reduce_fleet(entries(), ROBOT, tmp_path / "s", workers=2, progress=kill)
    assert reduced.crashes >= 1
    assert contents(tmp_path / "s") == contents(store)


def deadly(*_: Any) -> None:
    """What ends a process without a word, as a fault in a compiled library does."""
    os._exit(9)


def pool_with_deadly_logs(workers: int) -> Executor:
    """Processes that the logs of arm b end."""
    return ProcessPoolExecutor(workers, multiprocessing.get_context("fork"), poison)


def poison() -> None:
    """In a worker: reading a recording of arm b ends it."""
    vars(fleet.worker)["read_recordings"] = lambda path, *more: (
        deadly() if path.startswith("b/") else read_recordings(path, *more)
    )


@pytest.mark.skipif(sys.platform == "win32", reason="processes are forked, so that they read as the test says")
def test_a_log_that_ends_its_worker_each_time_is_one_row(
    store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fleet.results, "process_pool", pool_with_deadly_logs)
    reduced = fleet.reduce_fleet(entries(), ROBOT, tmp_path / "s", workers=2)
    assert reduced.crashes >= 1
    assert reduced.new == 2
    assert reduced.refused["b/2026-01-01.csv"] == fleet.results.KILLS
    assert {file for file, why in reduced.refused.items() if why == fleet.results.KILLS} == {
        "b/2026-01-01.csv", "b/2026-01-03.csv"
    }  # fmt: skip


def test_workers_that_cannot_begin_are_no_fault_of_a_log(
    logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def pool(_: int) -> contextlib.AbstractContextManager[Executor]:
        return contextlib.nullcontext(Lost(0))

    monkeypatch.setattr(fleet.results, "process_pool", pool)
    with pytest.raises(InputError, match="workers were lost after 0 of"):
        fleet.reduce_fleet(entries(), ROBOT, tmp_path / "s", workers=2)


class KilledWorker(Exception):  # noqa: N818
    """A task that each worker died of, as Dask says it."""


def test_a_batch_that_kills_is_tried_one_by_one(store: Path, tmp_path: Path) -> None:
    class Killed(engine.Here):
        def submit(self, fn: Callable[..., Any], /, *arguments: Any, **more: Any) -> Future[Any]:
            if any(task.entry.path.startswith("b/2026-01-01") for task in arguments[1]):
                future: Future[Any] = Future()
                future.set_exception(KilledWorker())
                return future
            return super().submit(fn, *arguments, **more)

    reduced = fleet.reduce_fleet(entries(), ROBOT, tmp_path / "s", executor=Killed(), batch=3)
    assert reduced.refused["b/2026-01-01.csv"] == fleet.results.KILLS
    assert (reduced.new, reduced.crashes) == (2, 2)


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
        with contextlib.suppress(InputError), engine.dask_executor(address, 1) as (_, count):
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
        with engine.dask_executor(address, 1) as (executor, count):
            killed = threading.Timer(1.0, running[-1].kill)
            killed.start()
            fleet.reduce_fleet(entries(), ROBOT, tmp_path / "a", executor=executor, workers=count)
            killed.join()
        assert contents(tmp_path / "a") == contents(store)
        with (
            pytest.raises(InputError, match=r"workers were lost after \d of 5"),
            engine.dask_executor(address, 1) as (executor, count),
        ):
            fleet.reduce_fleet(
                entries(), ROBOT, tmp_path / "b", executor=executor, progress=lambda _: running[0].kill()
            )
    with cluster(port) as (address, _):
        reached(address, 2)
        line = f"fleet reduce a b turned other.csv --robot rx90 --store {tmp_path / 'b'} --scheduler {address}"
        assert main([*line.split(), "--pattern", "{arm}/{day}.csv", "--batch", "2"]) == 0
    assert "5 logs refused" in capsys.readouterr().out
    assert contents(tmp_path / "b") == contents(store)
