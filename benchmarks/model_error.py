"""Errors of the recommended payload where the arm has friction or ripple that its model lacks.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/model_error.py [--runs 40] [--jobs 2] [--other-path]

Simulated arms, each motion of at least 24 s once without and once with a payload, on the same path or, with
``--other-path``, on another; torque noise of 1 to 5 %, white or with memory. Per joint the arm has besides, in both
recordings: Stribeck friction, 30 to 80 % of FS more about rest; friction of 3 to 9 % of the torque that the gear
carries, payload included; or ripple of 1 to 4 % of the torque at two wavelengths, half of it growing with the load.
Intervals without what joints that disagree add to them, gains exact.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from dynident.benchmarks import invented
from dynident.benchmarks.shared import each, held, options, rms, show
from dynident.common.arrays import Array
from dynident.estimation import payload_estimate, payload_problem
from dynident.estimation.payload.methods import recommended_method, usable_methods
from dynident.estimation.payload.result import constrain_payload
from dynident.model import InertialParameters, Motion
from dynident.model.drives import FRICTION, parameter_kind

NAMES = (*invented.NAMES, "panda")
SHORTEST = 24.0
"""s, of a motion."""


class Lack(NamedTuple):
    """Friction and ripple that an arm has and its model lacks, drawn for each joint (n,).

    ``fs`` [N·m] and ``slow`` [rad/s] of Stribeck friction, ``load``: friction over the torque that the gear
    carries, ``ripple`` [N·m], ``turns`` [1/rad] and ``phases`` [rad] of both waves, 2 x n.
    """

    fs: Array
    slow: Array
    load: Array
    ripple: Array
    turns: Array
    phases: Array


class Seen(NamedTuple):
    """By one method: relative error of the mass, whether its interval holds it, and the centre of mass's theirs."""

    error: float
    mass: float
    com: float


Kind = Callable[[Lack, Motion, Array], Array]
KINDS: dict[str, Kind] = {
    "Stribeck": lambda lack, motion, torque: lack.fs * np.exp(-((motion.qd / lack.slow) ** 2)) * np.sign(motion.qd),
    "load": lambda lack, motion, torque: lack.load * np.abs(torque) * np.sign(motion.qd),
    "ripple": lambda lack, motion, torque: (
        (1.0 + np.abs(torque) / np.maximum(rms(torque), 1e-9))
        * lack.ripple
        * np.sin(motion.q * lack.turns[:, None, None] + lack.phases[:, None]).sum(axis=0)
    ),
}
"""Torque that the model lacks [N·m], N x n, by motion and the torque that the gears carry."""


def carried(name: str, motion: Motion, load: InertialParameters | None) -> Array:
    """Torque of arm and payload without friction [N·m], N x n."""
    values = invented.robot(name).parameters
    rigid = {key: 0.0 if parameter_kind(key) in FRICTION else value for key, value in values.items()}
    return invented.simulator(name).measure(motion, load, rigid).torque


def run(other_path: bool, case: tuple[str, str, int]) -> dict[str, Seen]:
    """Draw a pair of recordings of an arm and what its model lacks, and see what each method makes of them."""
    name, kind, seed = case
    draw, robot = np.random.default_rng([seed, 33]), invented.robot(name)
    n, payload = robot.n, invented.payload(name, invented.PAYLOADS[seed % 5], draw)
    first, second = (
        invented.long_motion(name, int(number), SHORTEST) for number in draw.integers(1_000_000, size=2)
    )
    own, top = rms(carried(name, first, None)), np.abs(first.qd).max(axis=0)
    static = np.array(
        [robot.parameters.get(f"FS{j}", robot.parameters.get(f"FSM{j}", 0.0)) for j in range(1, n + 1)]
    )
    lack = Lack(
        fs=draw.uniform(0.3, 0.8, n) * static,
        slow=draw.uniform(0.05, 0.2, n) * top,
        load=draw.uniform(0.03, 0.09, n),
        ripple=0.35 * draw.uniform(0.01, 0.04) * own,
        turns=draw.integers(4, 40, 2).astype(float),
        phases=draw.uniform(-np.pi, np.pi, (2, n)),
    )
    noise, memory, recordings = float(draw.uniform(0.01, 0.05)), 20.0 * int(draw.integers(2)), []
    for motion, load in ((first, None), (second if other_path else first, payload)):
        exact = invented.recorded(name, motion, load, int(draw.integers(1_000_000)), noise, memory)
        more = KINDS[kind](lack, motion, carried(name, motion, load))
        recordings.append(replace(exact, torque=exact.torque + more))
    problem = payload_problem(robot, recordings[1:], recordings[:1])
    seen = {}
    for method in usable_methods(problem):
        found = constrain_payload(payload_estimate(problem, method))
        inside = held(
            np.vstack([found.intervals.parameters[9:], found.intervals.com]), np.append(payload.mass, payload.com)
        )
        seen[str(method)] = Seen(found.mass / payload.mass - 1.0, float(inside[0]), float(inside[1:].mean()))
    return seen | {"recommended": seen[str(recommended_method(problem, map(int, seen))[0])]}


def main() -> None:
    """Print errors and coverage by kind and, all kinds together, by arm."""
    arguments = options(__doc__, runs=40, jobs=2, other_path=False)
    cases = [(name, kind, seed) for seed in range(arguments.runs) for name in NAMES for kind in KINDS]
    done = dict(zip(cases, each(partial(run, arguments.other_path), cases, arguments.jobs), strict=True))
    rows, methods = [], [method for method in next(iter(done.values())) if method != "recommended"]
    for group in (*KINDS, *NAMES, "all"):
        own = [seen for case, seen in done.items() if group in (*case, "all")]
        cells = []
        for method in ("recommended", *methods):
            error, mass, com = np.array([seen[method] for seen in own]).T
            cells.append(f"{100 * rms(error):.2f} {100 * mass.mean():4.0f} {100 * com.mean():4.0f}")
        least = min(float(rms(np.array([seen[method].error for seen in own]))) for method in methods)
        rows.append([f"{group}, {len(own)} runs", f"<= {110 * least:.2f}, 92 to 98", *cells])
    title = (
        "rms error of the mass [%], how often its and the centre of mass's intervals hold [%]; seen: recommended"
    )
    show(title, rows, *(f"method {method}" for method in methods))


if __name__ == "__main__":
    main()
