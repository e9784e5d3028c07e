"""What good recordings are answered with: 200 of them, over all robots, payloads and kinds of noise.

Run: python benchmarks/verdicts.py [--runs 200] [--first 0] [--jobs 2]

Each run draws a robot, a payload, one or two motions (each without and with payload, on the same or on different
motions), the size of the torque noise and whether it is white or remembers (AR(1), 20 samples). A run is answered
unless it ends in an error or in "do not use". The level must be "use" where the robust standard deviation of the
inertia at the centre of mass is under 30 % and "mass and centre of mass only" where it is not. Thresholds were set
with seeds from 10,000 on.
"""

import argparse
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np
from dynident.benchmarks import invented
from dynident.common.errors import InputError
from dynident.estimation import PayloadAnswer, SolverError, answer_payload, payload_problem
from rich.console import Console
from rich.progress import track
from rich.table import Table

LIMIT = 0.30
MEMORY = 20.0


@dataclass(frozen=True)
class Run:
    """One good set of recordings and what it was answered with.

    Attributes:
        seed, robot, payload: which.
        level: of the verdict, or "error".
        expected: level by the robust standard deviation alone; empty for an error.
        mass_error: relative.
        inertia_error: largest error of a moment of inertia at the centre of mass, relative to it.
        text: reasons, or the error.
    """

    seed: int
    robot: str
    payload: str
    level: str
    expected: str
    mass_error: float
    inertia_error: float
    text: str

    @property
    def answered(self) -> bool:
        """Whether it was."""
        return self.level in ("use", "mass_and_com_only")


def run(seed: int) -> Run:
    """Draw one set of good recordings and answer it."""
    draw = np.random.default_rng([seed, 2026])
    name, kind = invented.NAMES[seed % 3], invented.PAYLOADS[seed // 3 % 5]
    body = invented.payload(name, kind, draw)
    noise, memory = float(draw.uniform(0.05, 0.25)), MEMORY * int(draw.integers(2))
    pairs, apart = int(draw.integers(1, 3)), bool(draw.random() < 0.25)
    seeds = [int(s) for s in draw.integers(1_000_000, size=2 * pairs)]
    bare = [invented.motion(name, s) for s in seeds[:pairs]]
    moved = [invented.motion(name, s) for s in seeds[pairs:]] if apart else bare
    unloaded = [invented.recorded(name, m, None, 2 * seed + k, noise, memory) for k, m in enumerate(bare)]
    loaded = [invented.recorded(name, m, body, 2 * seed + k + 10**6, noise, memory) for k, m in enumerate(moved)]
    try:
        answer = answer_payload(payload_problem(invented.robot(name), loaded, unloaded))
    except (InputError, SolverError) as error:
        return Run(seed, name, kind, "error", "", np.nan, np.nan, str(error))
    estimate = answer.recommended.body
    off = np.diag(estimate.inertia_com) / np.diag(body.inertia_com) - 1.0
    return Run(
        seed, name, kind, answer.verdict.level, expected(answer), estimate.mass / body.mass - 1.0,
        float(np.abs(off).max()), "; ".join(answer.verdict.reasons),
    )  # fmt: skip


def expected(answer: PayloadAnswer) -> str:
    """Level by the robust standard deviation of the inertia at the centre of mass."""
    payload = answer.recommended
    spread = payload.free.robust_spread
    assert spread is not None
    relative = spread.moments / np.maximum(np.diag(payload.body.inertia_com), 1e-12)
    return "use" if relative.max() < LIMIT else "mass_and_com_only"


def runs(seeds: range, jobs: int = 1) -> list[Run]:
    """All of them, in order."""
    if jobs == 1:
        return [run(seed) for seed in track(seeds, "runs")]
    with ProcessPoolExecutor(jobs) as pool:
        return list(track(pool.map(run, seeds, chunksize=5), "runs", total=len(seeds)))


def table(done: list[Run]) -> Table:
    """Counts by robot and payload."""
    result = Table(title=f"{len(done)} good sets of recordings", box=None)
    headings = (
        "robot",
        "payload",
        "runs",
        "use",
        "mass, com",
        "do not use",
        "error",
        "as sigma says",
        "mass error %",
    )
    for heading in (*headings, "inertia error % where use"):
        result.add_column(heading, justify="left" if heading in headings[:2] else "right")
    for group, members in _grouped(done):
        result.add_row(*group, str(len(members)), *_counts(members))
    return result


def _counts(members: Sequence[Run]) -> list[str]:
    """How often each level was said, how often rightly, and the largest errors."""
    levels, answered = Counter(trial.level for trial in members), [trial for trial in members if trial.answered]
    used = [100 * trial.inertia_error for trial in members if trial.level == "use"]
    right = sum(trial.level == trial.expected for trial in answered)
    worst = max((abs(100 * trial.mass_error) for trial in answered), default=np.nan)
    counts = [str(levels[level]) for level in ("use", "mass_and_com_only", "do_not_use", "error")]
    return [*counts, f"{right}", f"{worst:.2f}", f"{max(used):.0f}" if used else ""]


def _grouped(done: list[Run]) -> Iterator[tuple[tuple[str, str], list[Run]]]:
    for name in invented.NAMES:
        for kind in invented.PAYLOADS:
            yield (name, kind), [trial for trial in done if (trial.robot, trial.payload) == (name, kind)]
    yield ("all", ""), done


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, metavar="SEED")
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    done = runs(range(arguments.first, arguments.first + arguments.runs), arguments.jobs)
    console = Console(width=120)
    console.print(table(done))
    for trial in done:
        if trial.level != trial.expected:
            console.print(
                f"seed {trial.seed} {trial.robot} {trial.payload}: {trial.level}: {trial.text}", markup=False
            )


if __name__ == "__main__":
    main()
