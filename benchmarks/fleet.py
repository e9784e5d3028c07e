"""Fleets: recordings a second by one process and two, memory, power of alarms and false ones, beside an ideal.

Run: python benchmarks/fleet.py [--recordings 8] [--seeds 20] [--months 200] [--only throughput|power|false|ideal]

Processor time: power 20 s a seed, false alarms 1 s a month, throughput a second a log, ideal 30 s.
"""

import argparse
import os
import resource
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from dynident.apps import fleet
from dynident.apps.fleet import RobotPassport
from dynident.apps.fleet.alarms import alarm_of, bound_of, steps_of
from dynident.apps.fleet.drawing import drawn, noise_of
from dynident.apps.fleet.nights import Arm, arm_of, night_of
from dynident.apps.fleet.series import Scatter, Series, scatter_of, series_of
from dynident.apps.fleet.simulated import Scenario, simulated_arms
from dynident.common.arrays import Array
from dynident.model import load_robot
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points
from numpy.typing import NDArray
from scipy.optimize import brentq

RATE, LENGTH, ARMS = 250.0, 60.0, 100
SCATTER = {"FS": 0.03, "FV": 0.04}
QUANTITIES = 21
"""Of an RX90: 14 frictions, a payload, 6 scales; false alarms are counted over those of all arms."""
STEP, USUAL, DAYS = 0.1, 55, 5
NIGHTLY = 1.0 / (30.0 * ARMS * QUANTITIES)
"""False alarms a day of one series, so that those of the fleet are one a month."""


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


def throughput(folder: Path, count: int) -> None:
    """Processor time and the clock of one process and two, in turns; memory of a worker over many recordings."""
    robot, paths = load_robot("rx90"), recordings(folder, count)
    clock, spent = {1: list[float](), 2: list[float]()}, {1: list[float](), 2: list[float]()}
    with fleet.engine.process_pool(1) as one_worker, fleet.engine.process_pool(2) as two:
        for number, pool in ((1, one_worker), (2, two)):
            list(pool.map(time.sleep, [0.5] * 2 * number))
            fleet.reduce_fleet(paths[:2], robot, folder / f"start{number}", executor=pool, workers=number)
        for turn in range(2):
            for number, pool in ((1, one_worker), (2, two)):
                before, begin = sum(pool.map(used, [0.3] * 4 * number)), time.monotonic()
                store = folder / f"{number}-{turn}"
                fleet.reduce_fleet(paths, robot, store, executor=pool, workers=number)
                clock[number].append(time.monotonic() - begin)
                spent[number].append((sum(pool.map(used, [0.3] * 4 * number)) - before) / 4.0)
        sizes = [
            fleet.Store.opened(store).path(row.passport).stat().st_size for row in fleet.Store.opened(store).rows()
        ]
        memory = list(resident(paths, folder))
    print(f"{count} recordings of {LENGTH:g} s at {RATE:g} Hz, six joints, {os.cpu_count()} processors")
    for number in (1, 2):
        each = min(spent[number]) / count
        print(
            f"  {number} process(es): {min(clock[number]):.1f} s of the clock, {each:.2f} s of processor time each"
        )
    ratio = min(clock[1]) / min(clock[2])
    print(f"  two against one by the clock: {ratio:.2f} times (asked 1.7)")
    print(f"  1,000 by two at this pace: {1000 * min(clock[2]) / count / 60:.1f} min (asked 10)")
    print(f"  a worker after recordings 1, 10, .. 60 [MiB]: {', '.join(f'{x:.0f}' for x in memory)} (asked 350)")
    print(f"  a passport: {np.mean(sizes) / 1024:.0f} KiB")


def used(seconds: float) -> float:
    """In a worker: its processor time so far, after a wait that lets the others take their turn."""
    time.sleep(seconds)
    return time.process_time()


def resident(paths: list[str], folder: Path) -> Iterator[float]:
    """Largest memory of one worker after 1, 10, .. 60 recordings [MiB]."""
    robot, done = load_robot("rx90"), 0
    with fleet.engine.process_pool(1) as fresh:
        for goal in (1, 10, 20, 30, 40, 50, 60):
            while done < goal:
                store = folder / f"memory{done}"
                fleet.reduce_fleet([paths[done % len(paths)]], robot, store, executor=fresh, workers=1)
                done += 1
            yield fresh.submit(resource.getrusage, resource.RUSAGE_SELF).result().ru_maxrss / 1024.0


def night_passport(folder: Path) -> RobotPassport:
    """The passport of one minute of the RX90."""
    reduced = fleet.reduce_fleet(recordings(folder, 1), load_robot("rx90"), folder / "power")
    return next(p for _, p in reduced.store.passports() if isinstance(p, RobotPassport))


def power(passport: RobotPassport, seeds: int) -> None:
    """Arms of drawn nights, temperature and all: a step on each axis in turn, found within five days or not."""
    robot, quiet, stepped = load_robot("rx90"), list[Arm](), dict[tuple[int, int], Arm]()
    grouping, noise = passport.base.grouping, noise_of(passport)
    scenario = Scenario(arms=seeds, days=USUAL + DAYS, worn=0, laden=0, seed=1)
    for seed, arm in enumerate(simulated_arms(robot, scenario)):
        draw, nights, changed = np.random.default_rng([7, seed]), [], dict[tuple[int, int], RobotPassport]()
        for d, night in enumerate(arm.nights):
            about = {"arm": arm.name, "day": night.day, "temperature": str(night.temperature), "payload": "0"}
            values = grouping @ [night.parameters[name] for name in passport.base.standard]
            nights.append(drawn(passport, values, noise, draw, "night", about))
            for joint in range(1, 7) if d >= USUAL else ():
                k = passport.base.columns.index(f"FS{joint}")
                more = values + STEP * values[k] * np.eye(len(values))[k]
                changed[joint, d] = drawn(passport, more, noise, draw, "night", about)
        quiet.append(arm_of(nights))
        for joint in range(1, 7):
            late = [night_of(changed[joint, d], quiet[-1].pooled, 0.0, 0.0) for d in range(USUAL, USUAL + DAYS)]
            stepped[seed, joint] = replace(quiet[-1], nights=(*quiet[-1].nights[:USUAL], *late))
        print(f"  {seed + 1} of {seeds} arms", flush=True)
    print_detections(quiet, stepped)


def print_detections(quiet: Sequence[Arm], stepped: Mapping[tuple[int, int], Arm]) -> None:
    """Print how many steps are seen; ``stepped``: the quiet arms by seed and joint that steps."""
    first, total, seeds = quiet[0].nights[0].day, 0, len(quiet)
    for joint in range(1, 7):
        name = f"FS{joint}"
        usual = [line for arm in quiet for line in series_of(arm, first) if line.quantity == name]
        scatter = scatter_of(usual)
        bound = bound_of(usual[0].days, usual[0].sigma, scatter, NIGHTLY)
        detections = sum(within(line, scatter, bound) for seed in range(seeds)
                    for line in series_of(stepped[seed, joint], first) if line.quantity == name)  # fmt: skip
        total += detections
        print(f"  Coulomb friction {joint} +10 % within 5 days: {detections} of {seeds} (asked 18 of 20); scatter "
              f"{100 * scatter.sigma:.1f} %, memory {scatter.memory:.2f}, {100 * scatter.per_kelvin:+.2f} %/K, own "
              f"{100 * scatter.own * np.median(usual[0].sigma):.1f} %, bound {bound:.2f}")  # fmt: skip
    print(f"  all axes: {100 * total / (6 * seeds):.0f} %")


def within(line: Series, scatter: Scatter, bound: float) -> bool:
    """Whether a step on the day ``USUAL`` is an alarm on one of the days from then on."""
    for count in range(USUAL + 1, USUAL + DAYS + 1):
        part = replace(
            line, **{name: getattr(line, name)[:count] for name in ("days", "values", "sigma", "temperature")}
        )
        alarm = alarm_of(part, scatter, bound)
        if alarm is not None and abs(alarm.since - USUAL) <= 2:
            return True
    return False


def scattering(shape: tuple[int, int], draw: np.random.Generator) -> Array:
    """Scatter of variance 1 that remembers half of the day before; a row a series."""
    x = draw.standard_normal(shape)
    for d in range(1, shape[1]):
        x[:, d] = 0.5 * x[:, d - 1] + np.sqrt(0.75) * x[:, d]
    return x


def ideal(own: float, step: float, sigma: float, days: int, rate: float = NIGHTLY, draws: int = 20000) -> float:
    """Share of steps found by generalized least squares that knows scatter, memory and errors exactly."""
    scatter, nights = Scatter(sigma, 0.5, 1.0, 0.0, 0.0), np.full(USUAL + days, max(own, 1e-9))
    draw = np.random.default_rng(0)
    alarms = []
    day = np.arange(float(USUAL + days))
    values = sigma * scattering((draws, USUAL + days), draw) + own * draw.standard_normal((draws, USUAL + days))
    values += step * (day >= USUAL)
    bound = bound_of(day, nights, scatter, rate)
    for count in range(USUAL + 1, USUAL + days + 1):
        steps = steps_of(day[:count], nights[:count], scatter)
        assert steps is not None
        alarms.append((np.abs(values[:, :count] @ steps.weights.T / steps.sigma) > bound).any(axis=1))
    return float(np.any(alarms, axis=0).mean())


def by_series(own: float, seeds: int) -> int:
    """In how many seeds a step is found where scatter, memory and temperature are measured on 30 arms' series."""
    detections, days = 0, np.arange(float(USUAL + DAYS))
    for seed in range(seeds):
        draw = np.random.default_rng([3, seed])
        warm = 3.0 * draw.standard_normal((30, len(days)))
        values = SCATTER["FS"] * scattering(warm.shape, draw) + own * draw.standard_normal(warm.shape) - 0.01 * warm
        values[0] += STEP * (days >= USUAL)
        lines = [Series("a", "FS1", True, 1.0, days, x - np.median(x), np.full(len(days), own), t - t.mean())
                 for x, t in zip(values, warm, strict=True)]  # fmt: skip
        scatter = scatter_of(lines)
        detections += within(lines[0], scatter, bound_of(days, lines[0].sigma, scatter, NIGHTLY))
    return detections


def ideals() -> None:
    """What no detector can do better, by a night's own error and by what is known."""
    print("found within 5 days where scatter, memory and errors are known exactly, +10 %, 3 % with memory .5:")
    for own in (0.0, 0.01, 0.015, 0.019, 0.037, 0.045):
        shares = [ideal(own, STEP, SCATTER["FS"], DAYS), ideal(own, STEP, SCATTER["FS"], DAYS, 1.0 / (30 * 1200)),
                  ideal(own, STEP, 2.0 * SCATTER["FS"], DAYS)]  # fmt: skip
        print(f"  a night's own {100 * own:.1f} %: {100 * shares[0]:.0f} % (2,100 series), {100 * shares[1]:.0f} % "
              f"(1,200 series), {100 * shares[2]:.0f} % (scatter doubled)")  # fmt: skip
        step = brentq(lambda x, own=own: ideal(own, x, SCATTER["FS"], DAYS, draws=4000) - 0.9, 0.05, 0.4, xtol=1e-3)
        print(f"    the step found in 90 %: {100 * step:.1f} %")
    for joint, own in enumerate((0.015, 0.019, 0.010, 0.013, 0.033, 0.041), 1):
        print(f"  joint {joint}, own {100 * own:.1f} %, scatter measured: {by_series(own, 20)} of 20, "
              f"{by_series(own, 200)} of 200")  # fmt: skip
    for mass in (0.2, 0.5):
        share = ideal(0.029, mass, 1e-6, 1)
        print(f"  payload {mass:g} kg, own .029 kg, the same day: {100 * share:.0f} % (asked 95)")


def false_alarms(months: int, scale: float = 1.0) -> float:
    """New alarms a month of a fleet where nothing changes; scatter, memory and temperature measured each month."""
    draw, count = np.random.default_rng(1), 0
    kinds = [(0.03, 0.015)] * 7 + [(0.04, 0.02)] * 7 + [(0.0, 0.01)] * 7  # scatter and a night's own error
    days = np.arange(60.0)
    for _ in range(months):
        for sigma, own in kinds:
            warm = 3.0 * draw.standard_normal((ARMS, 60))
            values = scale * sigma * scattering((ARMS, 60), draw) + own * draw.standard_normal((ARMS, 60))
            values -= 0.01 * (sigma > 0.0) * warm
            lines = [Series("a", "q", True, 1.0, days, x - np.median(x), np.full(60, own), t - t.mean())
                     for x, t in zip(values, warm, strict=True)]  # fmt: skip
            scatter = scatter_of(lines)
            bound = bound_of(days, lines[0].sigma, scatter, NIGHTLY)
            left = np.array([line.values - scatter.per_kelvin * line.temperature for line in lines])
            before: NDArray[np.bool_] = np.ones(ARMS, dtype=bool)
            for day in range(30, 61):
                steps = steps_of(days[:day], lines[0].sigma[:day], scatter)
                assert steps is not None
                now = np.max(np.abs(left[:, :day] @ steps.weights.T / steps.sigma), axis=1) > bound
                count, before = count + int((now & ~before).sum()), now
    return count / months


def main() -> None:
    """Print what is asked beside what is seen."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--recordings", type=int, default=8)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--months", type=int, default=200)
    parser.add_argument("--only", choices=("throughput", "power", "false", "ideal"))
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        if arguments.only in (None, "throughput"):
            throughput(Path(name), arguments.recordings)
        if arguments.only in (None, "power"):
            power(night_passport(Path(name)), arguments.seeds)
    if arguments.only in (None, "ideal"):
        ideals()
    for scale in (1.0, 2.0) if arguments.only in (None, "false") else ():
        rate = false_alarms(arguments.months if scale == 1.0 else arguments.months // 4, scale)
        print(f"false alarms a month of {ARMS} arms, scatter times {scale:g}: {rate:.2f} (asked 1)")


if __name__ == "__main__":
    main()
