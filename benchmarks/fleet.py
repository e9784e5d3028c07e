"""Fleets: recordings a second by one and two processes, size of a passport, power and false alarms.

Run: python benchmarks/fleet.py [--recordings 12]

About three minutes of processor time; ``--recordings 1000`` is the whole size.
"""

import argparse
import os
import resource
import tempfile
import time
from pathlib import Path

import numpy as np
from dynident import fleet
from dynident.common.arrays import Array
from dynident.estimation.fit import weighted
from dynident.fleet import RobotPassport
from dynident.fleet.drawing import drawn, noise_of
from dynident.fleet.nights import MASS, arm_of
from dynident.fleet.trends import Scatter, Series, alarm_of, bound_of
from dynident.model import load_robot
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points

RATE, LENGTH, ARMS = 250.0, 60.0, 100
SCATTER = {"FS": 0.03, "FV": 0.04}


def recordings(folder: Path, count: int) -> list[str]:
    """One motion of a minute, with other noise each time."""
    robot = load_robot("rx90")
    plan = random_via_points(robot, 40, seed=1)
    motion = plan.motion(RATE)
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


def throughput(paths: list[str], folder: Path) -> RobotPassport:
    """Recordings a second of processor time and of the clock, one process and two, in turns."""
    robot = load_robot("rx90")
    fleet.reduce_fleet(paths[:1], robot, folder / "warm")
    begin, cpu = time.monotonic(), time.process_time()
    fleet.reduce_fleet(paths, robot, folder / "here")
    here, own = time.monotonic() - begin, time.process_time() - cpu
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with fleet.engine.process_pool(2) as pool:
        list(pool.map(time.sleep, [0.5] * 4))
        fleet.reduce_fleet(paths[:2], robot, folder / "start", executor=pool, workers=2)
        begin = time.monotonic()
        fleet.reduce_fleet(paths, robot, folder / "two", executor=pool, workers=2)
        two = time.monotonic() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    store = fleet.Store.opened(folder / "here")
    sizes = [store.path(row.passport).stat().st_size for row in store.rows()]
    print(f"{len(paths)} recordings of {LENGTH:g} s at {RATE:g} Hz, six joints, {os.cpu_count()} processors")
    print(
        f"  this process: {own / len(paths):.2f} s of processor time each, {here / len(paths):.2f} s of the clock"
    )
    print(f"  two processes against one, by the clock: {here / two:.2f} times (asked 1.7); theirs: {spent:.0f} s")
    print(f"  1,000 by two at this pace: {1000 * two / len(paths) / 60:.1f} min (asked 10)")
    print(f"  largest worker: {after.ru_maxrss / 1024:.0f} MiB (asked 350)")
    print(f"  a passport: {np.mean(sizes) / 1024:.0f} KiB")
    return next(p for _, p in store.passports() if isinstance(p, RobotPassport))


def nightly(passport: RobotPassport) -> dict[str, float]:
    """How much each night's own error spreads the quantities, by drawn equations; shares for friction."""
    values, noise, draw = weighted(passport.equations).values, noise_of(passport), np.random.default_rng(0)
    nights = [
        drawn(passport, values, noise, draw, f"{k}", {"arm": "a", "day": f"2026-01-{k + 1:02d}"}) for k in range(25)
    ]
    arm = arm_of(nights)
    spread = {}
    for name in arm.nights[0].numbers:
        numbers = np.array([night.numbers[name].value for night in arm.nights])
        size = abs(numbers.mean()) if name[:2] in SCATTER else 1.0
        spread[name] = float(numbers.std(ddof=1)) / size
    return spread


def memory_of(days: int, draw: np.random.Generator) -> Array:
    """Scatter of variance 1 that remembers half of the day before."""
    x = draw.standard_normal(days)
    for d in range(1, days):
        x[d] = 0.5 * x[d - 1] + np.sqrt(0.75) * x[d]
    return x


def found_within(days: int, own: float, step: float, sigma: float, bound: float, seeds: int) -> float:
    """Share of seeds in which a step is an alarm on one of its first days; scatter and memory as measured."""
    hits, usual = 0, 55
    for seed in range(seeds):
        draw = np.random.default_rng(seed)
        values = sigma * memory_of(60, draw) + own * draw.standard_normal(60) + step * (np.arange(60) >= usual)
        scatter = Scatter(sigma, 0.5, 1.0, 0.0, 0.0)
        for count in range(usual + 1, usual + days + 1):
            series = Series(
                "a", "q", True, 1.0, np.arange(60.0)[:count], values[:count], np.full(count, own), np.zeros(count)
            )
            alarm = alarm_of(series, scatter, bound)
            if alarm is not None and abs(alarm.since - usual) <= 2:
                hits += 1
                break
    return hits / seeds


def false_alarms(spread: dict[str, float], months: int, scale: float) -> float:
    """New alarms a month of a fleet where nothing changes, by this many arms' series drawn for so many months."""
    draw, names = np.random.default_rng(1), list(spread)
    bound, count = bound_of(ARMS * len(names)), 0
    for name in names:
        sigma, own = scale * SCATTER.get(name[:2], 0.0), spread[name]
        scatter = Scatter(sigma, 0.5 if sigma else 0.0, 1.0, 0.0, 0.0)
        for _ in range(months):
            values = sigma * memory_of(30 + 30, draw) + own * draw.standard_normal(60)
            raised = False
            for day in range(30, 60):
                series = Series(
                    "a",
                    name,
                    True,
                    1.0,
                    np.arange(day + 1.0),
                    values[: day + 1],
                    np.full(day + 1, own),
                    np.zeros(day + 1),
                )
                alarm = alarm_of(series, scatter, bound) is not None
                count, raised = count + (alarm and not raised), alarm
    return count / months * ARMS


def main() -> None:
    """Print what is asked beside what is seen."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--recordings", type=int, default=12)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        passport = throughput(recordings(Path(name), asked.recordings), Path(name))
    spread = nightly(passport)
    bound = bound_of(ARMS * len(spread))
    print(f"{ARMS} arms, {len(spread)} quantities each: an alarm beyond {bound:.2f} sigma")
    for scale in (1.0, 2.0):
        print(f"scatter of friction {scale:g} times 3 and 4 %, memory .5:")
        for joint in range(1, 7):
            share = found_within(5, spread[f"FS{joint}"], 0.1, scale * SCATTER["FS"], bound, 200)
            print(f"  Coulomb friction {joint} +10 % within 5 days: {100 * share:.0f} % (asked 90), "
                  f"a night's own error {100 * spread[f'FS{joint}']:.1f} %")  # fmt: skip
        print(f"  false alarms a month over the fleet: {false_alarms(spread, 20, scale):.2f} (asked 1)")
    for step in (0.2, 0.5):
        share = found_within(1, spread[MASS], step, 1e-9, bound, 200)
        print(f"payload changed by {step:g} kg, found the same day: {100 * share:.0f} % (asked 95), own error "
              f"{spread[MASS]:.3f} kg")  # fmt: skip


if __name__ == "__main__":
    main()
