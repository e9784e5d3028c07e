"""How often the 95 % intervals of ``identify`` hold a robot's base parameters: 20 simulated robots x 3 recordings.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/base_coverage.py [--robots 20] [--recordings 3] [--first 0]

The shipped arms in turn with the bodies and drives of their stand-ins, each link's and each joint's numbers times
a factor between .7 and 1.3. Every recording is a random motion with noise of .05 to .25 of each joint's torque,
white or (every other one) of a third that remembers 20 samples, and is identified for itself. The intervals are
those that are stated: robust where the recording allows it, else the formula's. Asked: 92 to 99 % over all, no
robot and no kind of parameter below 85 %.
"""

import argparse
import time
from collections import defaultdict
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from dynident.benchmarks import invented
from dynident.common.errors import InputError
from dynident.estimation import identify
from dynident.model import INERTIAL, Robot, base_parameters, robot_names
from dynident.model.drives import parameter_kind
from dynident.trajectories import Simulator, random_via_points
from rich.console import Console
from rich.progress import track
from rich.table import Table

ASKED, LEAST = (0.92, 0.99), 0.85
RATE, SPAN, SPAN_OF_FULL_TURNS = 200.0, 0.8, 0.3
"""Hz; share of the joints' ranges that motions use, where they are several turns a smaller one."""
MEMORY = 20.0
"""Samples that every other recording's noise remembers."""


class Run(NamedTuple):
    """One recording: its robot, kinds of its base parameters, and which lay in their intervals."""

    robot: str
    kinds: tuple[str, ...]
    inside: tuple[bool, ...]
    robust: bool


def varied(name: str, draw: np.random.Generator) -> Robot:
    """A robot of a kind with other links and drives; a body times a factor can exist as the body can."""
    robot = invented.robot(name)
    factors = draw.uniform(0.7, 1.3, (robot.n + 1, 2))
    values = {}
    for parameter, value in robot.parameters.items():
        joint = int(parameter[len(parameter_kind(parameter)) :])
        values[parameter] = value * float(factors[joint, 0 if parameter_kind(parameter) in INERTIAL else 1])
    return replace(robot, parameters=values)


def runs(index: int, recordings: int) -> list[Run]:
    """One robot's recordings, each identified for itself."""
    names = robot_names()
    name, draw = names[index % len(names)], np.random.default_rng([index, 17])
    robot = varied(name, draw)
    simulator, base = Simulator(robot), base_parameters(robot)
    truth = base.grouping @ np.array([robot.parameters.get(column, 0.0) for column in base.standard])
    done = []
    for k in range(recordings):
        noise, memory = float(draw.uniform(0.05, 0.25)), MEMORY * (k % 2)
        span = SPAN_OF_FULL_TURNS if name.startswith("ur") else SPAN
        motion = random_via_points(robot, 14, int(draw.integers(1_000_000)), 0.6, span).motion(RATE)
        recording = invented.recorded(name, motion, None, 100 * index + k, noise, memory, simulator)
        try:
            estimate = identify(robot, [recording]).estimate
        except InputError as error:
            print(f"{name} {index}, recording {k}: {error}")
            continue
        interval = estimate.interval95 if estimate.robust_interval95 is None else estimate.robust_interval95
        inside = (interval[:, 0] <= truth) & (truth <= interval[:, 1])
        kinds = tuple(map(parameter_kind, base.columns))
        done.append(Run(f"{index} {name}", kinds, tuple(inside.tolist()), estimate.robust is not None))
    return done


def shares(done: list[Run]) -> tuple[float, dict[str, float], dict[str, float]]:
    """Shares inside: over all, by robot, by kind of parameter (regrouped ones with their first)."""
    robots: defaultdict[str, list[bool]] = defaultdict(list)
    kinds: defaultdict[str, list[bool]] = defaultdict(list)
    for run in done:
        robots[run.robot] += run.inside
        for kind, inside in zip(run.kinds, run.inside, strict=True):
            kinds[kind.removesuffix("R")].append(inside)
    every = [inside for run in done for inside in run.inside]
    by_robot, by_kind = ({name: float(np.mean(hits)) for name, hits in part.items()} for part in (robots, kinds))
    return float(np.mean(every)), by_robot, by_kind


def table(title: str, part: dict[str, float]) -> Table:
    """Shares in percent, the least first."""
    result = Table("", "inside [%]", title=title, box=None)
    for name, share in sorted(part.items(), key=lambda entry: entry[1]):
        result.add_row(name, f"{100 * share:.1f}", style="" if share >= LEAST else "bold")
    return result


def main() -> None:
    """Print shares."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--recordings", type=int, default=3)
    parser.add_argument("--first", type=int, default=0, help="number of the first robot, which draws all of it")
    arguments = parser.parse_args()
    before = time.process_time()
    robots = range(arguments.first, arguments.first + arguments.robots)
    done = [run for index in track(robots, "robots") for run in runs(index, arguments.recordings)]
    share, by_robot, by_kind = shares(done)
    console = Console()
    console.print(table("By robot", by_robot), table("By kind of parameter", by_kind))
    count, robust = sum(len(run.inside) for run in done), sum(run.robust for run in done)
    low, high = (100 * bound for bound in ASKED)
    console.print(
        f"{len(done)} recordings ({robust} with robust intervals), {count} base parameters: {100 * share:.1f} % "
        f"inside (asked {low:g} to {high:g}), least robot {100 * min(by_robot.values()):.1f} %, least kind "
        f"{100 * min(by_kind.values()):.1f} % (asked {100 * LEAST:g}); {time.process_time() - before:.0f} s CPU"
    )


if __name__ == "__main__":
    main()
