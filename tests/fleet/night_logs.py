"""A night's logs, three good and every other one wrong, and what is asked of the stores they end in."""

import shutil
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future
from pathlib import Path
from typing import Any

import numpy as np
from dynident.apps.fleet.store import Log, catalog, found_logs
from dynident.model import load_robot
from dynident.tests.frozen.inputs import unpack

ROBOT = load_robot("rx90")
GOOD = ("a/2026-01-01.csv", "a/2026-01-02.csv", "b/2026-01-01.csv")


class Here(Executor):
    """Does each task at once, in this process."""

    def submit(self, fn: Callable[..., Any], /, *arguments: Any, **more: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_result(fn(*arguments, **more))
        return future


class Lost(Here):
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


def entries() -> tuple[Log, ...]:
    return catalog(found_logs(["a", "b", "turned", "*.csv"]), "{arm}/{day}.csv")


def write_logs(place: Path) -> None:
    """Three good recordings, and every kind of wrong one."""
    inputs = place / "inputs"
    inputs.mkdir()
    unpack(inputs)
    source = inputs / "rx_arm_unloaded.csv"
    header, rows = source.read_text().partition("\n")[0], np.loadtxt(source, delimiter=",", skiprows=1)
    shutil.rmtree(inputs)
    for seed, name in enumerate((*GOOD, "turned/2026-01-01.csv")):
        noise = np.random.default_rng(seed).normal(scale=0.3, size=(len(rows), 6))
        table = rows + np.pad(noise, ((0, 0), (rows.shape[1] - 6, 0)))
        if name.startswith("turned"):
            table[60, 0] = table[50, 0]
        (place / name).parent.mkdir(exist_ok=True)
        np.savetxt(place / name, table, delimiter=",", header=header, comments="", fmt="%.9g")
    good = (place / GOOD[0]).read_bytes()
    (place / "b/2026-01-02.csv").write_bytes(good)
    (place / "b/2026-01-03.csv").write_bytes(good[:2000])
    (place / "b/2026-13-01.csv").write_bytes(good + b"\n")
    (place / "other.csv").write_text("t,q1\n0,1\n")
