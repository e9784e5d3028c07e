"""Verdicts on good recordings: 200 sets, over robots, payloads and kinds of noise.

Run: python benchmarks/verdicts.py [--runs 200] [--first 0] [--jobs 2]

Each run draws a robot, a payload, one or two motions (each without and with payload, on the same or on different
motions), the size of the torque noise and whether it is white or remembers (AR(1), 20 samples). The level must be
"use" where the robust standard deviation of the inertia at the centre of mass is under 30 % and "mass and centre of
mass only" where it is not. Thresholds were set with seeds from 10,000 on.
"""

from collections import Counter
from typing import NamedTuple

import numpy as np
from dynident.benchmarks import invented
from dynident.benchmarks.shared import each, options, show
from dynident.common.errors import InputError
from dynident.estimation import SolverError, answer_payload, payload_problem

LIMIT = 0.30
LEVELS = ("use", "mass_and_com_only", "do_not_use", "error")


class Run(NamedTuple):
    """One good set of recordings: level of the verdict, and the one by the robust standard deviation alone.

    Errors of the mass and the largest of a moment of inertia at the centre of mass are relative; ``text``: reasons.
    """

    robot: str
    payload: str
    level: str
    text: str
    expected: str = ""
    mass_error: float = np.nan
    inertia_error: float = np.nan


def run(seed: int) -> Run:
    """Draw one set of good recordings and answer it."""
    draw = np.random.default_rng([seed, 2026])
    name, kind = invented.NAMES[seed % 3], invented.PAYLOADS[seed // 3 % 5]
    body = invented.payload(name, kind, draw)
    noise, memory = float(draw.uniform(0.05, 0.25)), 20.0 * int(draw.integers(2))
    pairs, apart = int(draw.integers(1, 3)), bool(draw.random() < 0.25)
    seeds = [int(s) for s in draw.integers(1_000_000, size=2 * pairs)]
    bare = [invented.motion(name, s) for s in seeds[:pairs]]
    moved = [invented.motion(name, s) for s in seeds[pairs:]] if apart else bare
    unloaded = [invented.recorded(name, m, None, 2 * seed + k, noise, memory) for k, m in enumerate(bare)]
    loaded = [invented.recorded(name, m, body, 2 * seed + k + 10**6, noise, memory) for k, m in enumerate(moved)]
    try:
        answer = answer_payload(payload_problem(invented.robot(name), loaded, unloaded))
    except (InputError, SolverError) as error:
        return Run(name, kind, "error", str(error))
    payload, verdict = answer.recommended, answer.verdict
    spread = payload.free.robust_spread
    assert spread is not None
    relative = spread.moments / np.maximum(np.diag(payload.body.inertia_com), 1e-12)
    expected = "use" if relative.max() < LIMIT else "mass_and_com_only"
    off = np.diag(payload.body.inertia_com) / np.diag(body.inertia_com) - 1.0
    errors = (payload.body.mass / body.mass - 1.0, float(np.abs(off).max()))
    return Run(name, kind, verdict.level, "; ".join(verdict.reasons), expected, *errors)


def main() -> None:
    """Print counts of levels by robot and payload, and each verdict that is another than was to be expected."""
    arguments = options(__doc__, runs=200, first=0, jobs=2)
    seeds = range(arguments.first, arguments.first + arguments.runs)
    done = each(run, seeds, arguments.jobs)
    rows = []
    for group in (*((name, kind) for name in invented.NAMES for kind in invented.PAYLOADS), ()):
        own = [trial for trial in done if group in ((trial.robot, trial.payload), ())]
        answered = [trial for trial in own if trial.level in LEVELS[:2]]
        if own:
            right, levels = sum(trial.level == trial.expected for trial in answered), Counter(t.level for t in own)
            worst = max((100 * abs(trial.mass_error) for trial in answered), default=np.nan)
            used = max((100 * trial.inertia_error for trial in own if trial.level == "use"), default=np.nan)
            counts = [levels[level] for level in LEVELS]
            rows.append([", ".join(group) or "all", len(own), right, *counts, f"{worst:.2f}", f"{used:.0f}"])
    title = f"{len(done)} good sets of recordings; asked: all, seen: level as the inertia's deviation says"
    show(title, rows, *("use", "mass, com", "do not use", "error", "mass error %", "inertia error % where use"))
    for seed, trial in zip(seeds, done, strict=True):
        if trial.level != trial.expected:
            print(f"seed {seed} {trial.robot} {trial.payload}: {trial.level}: {trial.text}")


if __name__ == "__main__":
    main()
