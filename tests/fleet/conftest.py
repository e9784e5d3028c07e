"""A night's logs, three good and every other one wrong, the store they end in, and recordings that never were."""

import contextlib
import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps.fleet.comparing import compared_by
from dynident.apps.fleet.reduction import Log, Stored, catalog, found_logs, reduce_fleet
from dynident.common.arrays import Array
from dynident.estimation.equations.equations import Equations, merged
from dynident.model import load_robot
from dynident.tests.frozen.inputs import unpack

Shared = Callable[[str, Callable[[Path], object]], Path]
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


@pytest.fixture(scope="module")
def logs(shared: Shared, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Three good recordings, and every kind of wrong one; the working folder."""
    place = tmp_path_factory.mktemp("fleet") / "logs"
    shutil.copytree(shared("night_logs", write_logs), place)
    with contextlib.chdir(place):
        yield place


@pytest.fixture(scope="module")
def store(logs: Path, shared: Shared, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The store that one run makes of them all."""
    place = tmp_path_factory.mktemp("stores") / "serial"
    shutil.copytree(shared("night_store", _reduce), place)
    return place


def _reduce(place: Path) -> None:
    reduced = reduce_fleet(entries(), ROBOT, place)
    assert (reduced.new, reduced.known) == (3, 0)


def noise_of(recording: Stored) -> Array:
    """Standard deviation of white noise on each joint's equations that spreads estimates as a recording's errors.

    The residual's own, times what the jackknife finds beyond the formula on the whole, shape (n,).
    """
    equations = recording.equations
    estimate, ratio = compared_by(equations)
    rows = np.maximum(np.array(equations.rows, dtype=float), 1.0)
    return np.asarray(equations.error_norms(estimate.values) / np.sqrt(rows) * float(np.median(ratio)))


def drawn(recording: Stored, values: Array, noise: Array, draw: np.random.Generator, log: Log) -> Stored:
    """A recording as that motion would give it on another night, with base parameters (c,) and noise (n,)."""
    cut, length = recording.equations.blocks, recording.equations.block_length
    parts = cut or (recording.equations.whole,)
    drawn_parts = [_drawn_block(part, values, noise, draw) for part in parts]
    whole = replace(merged(drawn_parts), blocks=tuple(drawn_parts) if cut else (), block_length=length)
    return replace(recording, log=log, equations=whole)


def _drawn_block(block: Equations, values: Array, noise: Array, draw: np.random.Generator) -> Equations:
    """One block of time: white noise stays white in a factor's rows; what is left over goes to its last row."""
    factors = []
    for factor, rows, sigma in zip(block.factors, block.rows, noise, strict=True):
        drawn_rows, y = np.array(factor), factor[:, :-1] @ values
        there = min(len(y), rows)  # of fewer rows than the factor has the rest is empty
        y[:there] += sigma * draw.standard_normal(there)
        over = rows - len(y)
        if over > 0:
            y[-1] = np.hypot(y[-1] - factor[-1, :-1] @ values, sigma * np.sqrt(draw.chisquare(over)))
            y[-1] += factor[-1, :-1] @ values
        drawn_rows[:, -1] = y
        factors.append(drawn_rows)
    return replace(block, factors=tuple(factors))
