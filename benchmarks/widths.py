"""How wide the intervals of an answer are, and how often they hold, where nothing is wrong or gains are.

Run: python benchmarks/widths.py [--runs 60] [--first 0] [--jobs 2] [--gains 0] [--days]

Each run draws one of four arms, a payload, one or two motions of at least 20 s together (each without and with
payload), and a torque noise that is white or remembers. The arm is as its model says, its friction the same in all
recordings. With ``--gains 5`` the gain of joint 2 or 3 is off by 5 % in all recordings; with ``--days`` every
joint's friction is another one under load, by 6 %. Half widths of the mass are compared with those of the same
recordings where no guard widens them: friction held as it was, joints that disagree not allowed for.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from dynident.benchmarks import invented
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import SolverError, answer_payload, payload_estimate, payload_problem
from dynident.estimation.diagnosis.joints import disagreement
from dynident.estimation.payload.result import constrain_payload
from dynident.model import InertialParameters, Motion, Recording, Robot
from dynident.trajectories import Simulator
from rich.console import Console
from rich.progress import track
from rich.table import Table

NAMES = (*invented.NAMES, "panda")
MOTION = 20.0
"""s: shortest duration of all motions together."""
DAY = 0.06
"""Change of each friction, relative, 1 sigma."""
LEVELS = {"use": "use", "mass_and_com_only": "mass, com", "do_not_use": "do not use"}


class Drawn(NamedTuple):
    """Recordings of one arm without and with a payload."""

    name: str
    robot: Robot
    body: InertialParameters
    unloaded: list[Recording]
    loaded: list[Recording]


class Run(NamedTuple):
    """What a drawn set was answered with; masses relative to the true one, nan where there is no answer.

    ``level`` of the verdict; ``held``: whether the interval of the mass holds it; ``ten``, ``com``: share of the
    ten's and of the centre of mass's intervals that hold; ``error`` of the mass; ``half``: half width of its
    interval; ``bare``: without guards; ``factor``: by joints that disagree.
    """

    name: str
    level: str
    held: float
    ten: float
    com: float
    error: float
    half: float
    bare: float
    factor: float


def drawn(seed: int, gain: float = 0.0, day: bool = False) -> Drawn:
    """Draw one set of recordings.

    Args:
        seed: of every draw.
        gain: relative error of one gain, of joint 2 or 3, in all recordings.
        day: let friction under load be another one.
    """
    draw = np.random.default_rng([seed, 15])
    name = NAMES[seed % 4]
    body = invented.payload(name, invented.PAYLOADS[seed // 4 % 5], draw)
    noise, memory = float(draw.uniform(0.02, 0.2)), 20.0 * int(draw.integers(2))
    pairs, seeds = int(draw.integers(1, 3)), [int(number) for number in draw.integers(1_000_000, size=8)]
    robot = invented.robot(name)
    motions = [_motion(name, number, MOTION / pairs) for number in seeds[:pairs]]
    scale = np.ones(robot.n)
    scale[int(draw.integers(1, 3))] += gain * float(draw.choice([-1.0, 1.0]))
    another = Simulator(replace(robot, parameters=_another_day(robot, draw))) if day else None
    sets = []
    for load, arm, first in ((None, None, 4), (body, another, 6)):
        recordings = [
            invented.recorded(name, motion, load, number, noise, memory, arm)
            for motion, number in zip(motions, seeds[first:], strict=False)
        ]
        sets.append([replace(recording, torque=recording.torque * scale) for recording in recordings])
    return Drawn(name, robot, body, *sets)


def _motion(name: str, seed: int, shortest: float) -> Motion:
    """A random motion of at least so many seconds."""
    points = 8
    while True:
        motion = invented.motion(name, seed, points)
        if float(motion.t[-1]) >= shortest:
            return motion
        points += 2


def _another_day(robot: Robot, draw: np.random.Generator) -> dict[str, float]:
    return {
        name: value * (1.0 + DAY * float(draw.standard_normal())) if name.startswith(("FS", "FV")) else value
        for name, value in robot.parameters.items()
    }


def run(seed: int, gain: float = 0.0, day: bool = False) -> Run:
    """Draw a set and answer it, with guards and without."""
    data = drawn(seed, gain, day)
    try:
        problem = payload_problem(data.robot, data.loaded, data.unloaded)
        answer = answer_payload(problem, (4,))
        bare = constrain_payload(
            payload_estimate(replace(problem, settings=replace(problem.settings, friction_change=0.0)), 4)
        )
    except (InputError, SolverError) as error:
        return Run(data.name, str(error), *[np.nan] * 7)
    ten = _held(answer.recommended.intervals.parameters, data.body.vector)
    com = _held(answer.recommended.intervals.com, data.body.com)
    half, narrow = (
        0.5 * float(np.ptp(estimate.intervals.parameters[9])) / data.body.mass
        for estimate in (answer.recommended, bare)
    )
    factor = disagreement(answer.by_joints, np.zeros((data.robot.n, data.robot.n)))
    off = answer.mass / data.body.mass - 1.0
    hits = float(ten[9]), float(ten.mean()), float(com.mean())
    return Run(data.name, answer.verdict.level, *hits, off, half, narrow, factor)


def _held(intervals: Array, truth: Array) -> Array:
    return ((intervals[:, 0] <= truth) & (truth <= intervals[:, 1])).astype(float)


def runs(seeds: range, gain: float, day: bool, jobs: int) -> list[Run]:
    """All of them, in order."""
    ask = partial(run, gain=gain, day=day)
    if jobs == 1:
        return [ask(seed) for seed in track(seeds, "runs")]
    with ProcessPoolExecutor(jobs) as pool:
        return list(track(pool.map(ask, seeds), "runs", total=len(seeds)))


def table(done: list[Run]) -> Table:
    """Coverage and half widths by arm."""
    result = Table(box=None)
    shares = ("mass held %", "ten held %", "com held %")
    headings = (
        "arm",
        "runs",
        *shares,
        "rms error %",
        "half width %",
        "over bare",
        "widened",
        *LEVELS.values(),
        "error",
    )
    for heading in headings:
        result.add_column(heading, justify="left" if heading == "arm" else "right")
    for name in (*NAMES, "all"):
        own = [trial for trial in done if name in (trial.name, "all")]
        levels = [sum(trial.level == level for trial in own) for level in LEVELS]
        numbers = np.array([trial[2:] for trial in own if np.isfinite(trial.half)]).reshape(-1, 7)
        *hits, error, half, bare, factor = numbers.T
        result.add_row(
            name, str(len(own)), *(f"{100 * share.mean():.0f}" for share in hits),
            f"{100 * np.sqrt(np.mean(error**2)):.2f}", f"{100 * np.median(half):.2f}",
            f"{np.median(half / bare):.2f}", str(int(np.sum(factor > 1.0))), *map(str, levels),
            str(len(own) - sum(levels)),
        )  # fmt: skip
    return result


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=60)
    parser.add_argument("--first", type=int, default=0, metavar="SEED")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--gains", type=float, default=0.0, metavar="PERCENT")
    parser.add_argument("--days", action="store_true")
    arguments = parser.parse_args()
    seeds = range(arguments.first, arguments.first + arguments.runs)
    console = Console(width=130)
    done = runs(seeds, arguments.gains / 100.0, arguments.days, arguments.jobs)
    console.print(table(done))
    for seed, trial in zip(seeds, done, strict=True):
        if trial.level not in LEVELS:
            console.print(f"seed {seed} {trial.name}: {trial.level}", markup=False)


if __name__ == "__main__":
    main()
