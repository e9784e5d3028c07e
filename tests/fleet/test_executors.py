"""Workers that are processes, a pool that dies, or a cluster: the store is that of one run alone."""

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
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from dynident.apps import fleet
from dynident.apps.fleet import reduction
from dynident.apps.fleet.store import RefusedDocument
from dynident.apps.logs.read import read_recordings
from dynident.cli import main
from dynident.common.errors import InputError
from dynident.tests.fleet.night_logs import ROBOT, Here, contents, entries


@pytest.mark.long
def test_two_processes_one_of_them_killed(store: Path, tmp_path: Path) -> None:
    """The pool is made anew; nothing is lost, nothing counts twice."""
    killed: list[int] = []

    def kill(_: float) -> None:
        if not killed:
            killed.append(int(multiprocessing.active_children()[0].pid or 0))
            os.kill(killed[0], signal.SIGKILL)

    reduced = fleet.reduce_fleet(entries(), ROBOT, tmp_path / "s", workers=2, progress=kill)
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
    reduced = fleet.reduce_fleet(entries(), ROBOT, tmp_path / "s", workers=2)
    assert reduced.workers_lost >= 1
    assert reduced.new == 2
    assert {bad.file for bad in reduced.refused if bad.reason == reduction.KILLS} == {
        "b/2026-01-01.csv", "b/2026-01-03.csv"
    }  # fmt: skip


class KilledWorker(Exception):  # noqa: N818
    """A task that each worker died of, as Dask says it."""


def test_a_log_that_kills_each_worker_of_a_cluster_is_refused(store: Path, tmp_path: Path) -> None:
    class Killed(Here):
        def submit(self, fn: Callable[..., Any], /, *arguments: Any, **more: Any) -> Future[Any]:
            if arguments[1].file.startswith("b/2026-01-01"):
                future: Future[Any] = Future()
                future.set_exception(KilledWorker())
                return future
            return super().submit(fn, *arguments, **more)

    reduced = fleet.reduce_fleet(entries(), ROBOT, tmp_path / "s", workers=(Killed(), 1))
    assert RefusedDocument("b/2026-01-01.csv", reduction.KILLS) in reduced.refused
    assert (reduced.new, reduced.workers_lost) == (2, 1)


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
            fleet.reduce_fleet(entries(), ROBOT, tmp_path / "a", workers=(executor, count))
            killed.join()
        assert contents(tmp_path / "a") == contents(store)
        with (
            pytest.raises(InputError, match=r"workers were lost after \d of 5"),
            reduction.dask_executor(address) as (executor, count),
        ):
            fleet.reduce_fleet(
                entries(), ROBOT, tmp_path / "b", workers=(executor, 1), progress=lambda _: running[0].kill()
            )
    with cluster(port) as (address, _):
        reached(address, 2)
        line = f"fleet reduce a b turned other.csv --robot rx90 --store {tmp_path / 'b'} --cluster {address}"
        assert main([*line.split(), "--pattern", "{arm}/{day}.csv"]) == 0
    assert "5 logs refused" in capsys.readouterr().out
    assert contents(tmp_path / "b") == contents(store)
