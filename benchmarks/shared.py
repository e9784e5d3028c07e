"""Options, repeated runs, noise with a memory, real recordings, and tables: shared by the benchmarks."""

import argparse
import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from dynident.common.arrays import Array
from dynident.model import Recording
from rich.console import Console
from rich.progress import track
from rich.table import Column, Table

UR10E_GAINS = (11.976, 11.976, 9.839, 10.763, 10.757, 10.680)  # N·m/A, of the real UR10e
UR10E_MASS = 2.805  # kg, weighed: the payload of its loaded recording
Case = TypeVar("Case")
Seen = TypeVar("Seen")


def options(doc: str | None, **defaults: Any) -> argparse.Namespace:
    """Options ``--name`` with their defaults; False is a switch, a tuple names to choose from, all by default."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, default in defaults.items():
        if isinstance(default, tuple):
            metavar = "|".join(default)
            parser.add_argument(name, nargs="*", choices=(*default, default), default=default, metavar=metavar)
        elif default is False:
            parser.add_argument(f"--{name.replace('_', '-')}", action="store_true")
        else:
            parser.add_argument(f"--{name.replace('_', '-')}", type=type(default), default=default)
    return parser.parse_args()


def show(title: str, rows: Iterable[Sequence[object]], *more: str, asked: bool = True) -> None:
    """Print a table: name, asked, seen, and what else was seen."""
    headings = ("asked", "seen", *more) if asked else ("seen", *more)
    table = Table("", *(Column(heading, justify="right") for heading in headings), box=None)
    for row in rows:
        table.add_row(*map(str, row))
    Console(width=150, highlight=False, markup=False).print(f"{title}\n", table, sep="")


def each(ask: Callable[[Case], Seen], cases: Sequence[Case], jobs: int = 1) -> list[Seen]:
    """Answers to all cases, in their order."""
    if jobs == 1:
        return [ask(case) for case in track(cases, "runs", transient=True)]
    with ProcessPoolExecutor(jobs) as pool:
        return list(track(pool.map(ask, cases), "runs", total=len(cases), transient=True))


def held(ends: Array, truth: Array) -> Array:
    """1 where an interval [low, high] holds the truth, else 0."""
    return np.asarray((ends[..., 0] <= truth) & (truth <= ends[..., 1]), dtype=float)


def rms(values: Array) -> Array:
    """Root of the mean square, column by column."""
    return np.asarray(np.sqrt(np.mean(np.square(values), axis=0)))


def lasting(steps: Array, memory: float, warm: bool = True) -> Array:
    """White noise made AR(1), autocorrelation exp(-k / memory), as large; ``warm``: from its first sample on."""
    from scipy.signal import lfilter  # 40 MiB, which fleet.py would count for a worker's

    if not memory:
        return steps
    phi = np.exp(-1.0 / memory)
    scaled = steps * np.sqrt(1.0 - phi**2)
    if warm:
        scaled[0] = steps[0]
    return np.asarray(lfilter([1.0], [1.0, -phi], scaled, axis=0))


def window(recording: Recording, start: float, length: float) -> Recording:
    """So many seconds of a recording from ``start`` on, both by its clock."""
    keep = (recording.t >= start) & (recording.t < start + length)
    qd = recording.qd[keep] if recording.qd is not None else None
    return replace(recording, t=recording.t[keep], q=recording.q[keep], torque=recording.torque[keep], qd=qd)


def recordings_folder(what: str) -> Path | None:
    """Folder of the real recordings; None, and a line, where it is not named."""
    if "DYNIDENT_DATA" in os.environ:
        return Path(os.environ["DYNIDENT_DATA"])
    print(f"{what}: left out, DYNIDENT_DATA is not set to the folder of the recordings")
    return None
