"""Fleets: recordings a second by one process and two, and the memory of a worker.

Run: python benchmarks/fleet.py [--recordings 8]
"""

import os
import resource
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from dynident.apps.fleet.reduction import Store, process_pool, reduce_fleet
from dynident.benchmarks.shared import options, show
from dynident.model import load_robot
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points

RATE, LENGTH = 250.0, 60.0


def recordings(folder: Path, count: int) -> list[str]:
    """One motion of a minute, with other noise each time."""
    robot = load_robot("rx90")
    motion = random_via_points(robot, 40, seed=1).motion(RATE)
    keep = motion.t < LENGTH
    simulator, paths = Simulator(robot), []
    for seed in range(count):
        recording = simulator.record(motion, noise=RX90_NOISE, seed=seed)
        table = np.column_stack([recording.t, recording.q, recording.torque])[keep]
        path = folder / f"{seed:04d}.csv"
        names = ",".join(["t", *(f"q{j}" for j in range(1, 7)), *(f"tau{j}" for j in range(1, 7))])
        np.savetxt(path, table, delimiter=",", header=names, comments="", fmt="%.7g")
        paths.append(str(path))
    return paths


def throughput(folder: Path, count: int) -> None:
    """Processor time and the clock of one process and two, in turns; memory of a worker over many recordings."""
    robot, paths = load_robot("rx90"), recordings(folder, count)
    clock, spent = {1: list[float](), 2: list[float]()}, {1: list[float](), 2: list[float]()}
    with process_pool(1) as one_worker, process_pool(2) as two:
        for number, pool in ((1, one_worker), (2, two)):
            list(pool.map(time.sleep, [0.5] * 2 * number))
            reduce_fleet(paths[:2], robot, folder / f"start{number}", workers=(pool, number))
        for turn in range(2):
            for number, pool in ((1, one_worker), (2, two)):
                before, begin = sum(pool.map(used, [0.3] * 4 * number)), time.monotonic()
                store = folder / f"{number}-{turn}"
                reduce_fleet(paths, robot, store, workers=(pool, number))
                clock[number].append(time.monotonic() - begin)
                spent[number].append((sum(pool.map(used, [0.3] * 4 * number)) - before) / 4.0)
        reduced = Store.opened(store)
        sizes = [reduced.path(log.key).stat().st_size for log in reduced.logs()]
        memory = list(resident(paths, folder))
    ratio, rows = min(clock[1]) / min(clock[2]), []
    for number in (1, 2):
        rows += [
            [f"{number} process(es), by the clock [s]", "", f"{min(clock[number]):.1f}"],
            [f"{number} process(es), processor time a recording [s]", "", f"{min(spent[number]) / count:.2f}"],
        ]
    rows += [
        ["two against one by the clock, times", ">= 1.7", f"{ratio:.2f}"],
        ["1,000 recordings by two at this pace [min]", "<= 10", f"{1000 * min(clock[2]) / count / 60:.1f}"],
        ["a worker after recordings 1, 10, .. 60 [MiB]", "<= 350", ", ".join(f"{x:.0f}" for x in memory)],
        ["a recording in the store [KiB]", "", f"{np.mean(sizes) / 1024:.0f}"],
    ]
    show(f"{count} recordings of {LENGTH:g} s at {RATE:g} Hz, six joints, {os.cpu_count()} processors", rows)


def used(seconds: float) -> float:
    """In a worker: its processor time so far, after a wait that lets the others take their turn."""
    time.sleep(seconds)
    return time.process_time()


def resident(paths: list[str], folder: Path) -> Iterator[float]:
    """Largest memory of one worker after 1, 10, .. 60 recordings [MiB]."""
    robot, done = load_robot("rx90"), 0
    with process_pool(1) as fresh:
        for goal in (1, 10, 20, 30, 40, 50, 60):
            while done < goal:
                store = folder / f"memory{done}"
                reduce_fleet([paths[done % len(paths)]], robot, store, workers=(fresh, 1))
                done += 1
            yield fresh.submit(resource.getrusage, resource.RUSAGE_SELF).result().ru_maxrss / 1024.0


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        throughput(Path(name), options(__doc__, recordings=8).recordings)
