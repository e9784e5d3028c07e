"""Hoses at the flange that are told, over all arms: with payload, without, beside a stored robot.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/hoses.py [--arms ur10e,..] [--memory 20] [--jobs 2]

Springs from 2 m above the base or from 1 m beside it, half of the rated payload, 20 s of one motion at 100 Hz,
noise of 4 % of the torque, with ``--memory`` such as remembers so many samples. A stored robot was identified
from another motion. The table of docs/verdict.md.
"""

from functools import partial
from typing import NamedTuple

import numpy as np
from dynident.benchmarks import invented
from dynident.benchmarks.shared import each, options, show
from dynident.common.arrays import Array
from dynident.estimation import Settings, identify, payload_problem
from dynident.estimation.diagnosis.engine import states_of
from dynident.estimation.diagnosis.hypotheses import effects_of
from dynident.estimation.diagnosis.verdict import system_of
from dynident.estimation.payload.methods import PayloadProblem
from dynident.estimation.payload.short_motion import known_robot_weighing
from dynident.model import InertialParameters, robot_names
from dynident.tests.estimation.diagnosis.hung import ABOVE, BESIDE, first, pulled
from dynident.trajectories import random_via_points

NOISE, SHORT = 0.04, 10.0


class Case(NamedTuple):
    """A spring [N/m], where it is fastened [m], which recordings it is in, and whether the robot is stored."""

    words: str
    stiffness: float
    end: Array
    bare: bool = False
    loaded: bool = True
    stored: bool = False


CASES = (
    Case("none", 0.0, ABOVE),
    *(Case("with payload, from above", stiffness, ABOVE) for stiffness in (5.0, 10.0, 20.0)),
    *(Case("with payload, from beside", stiffness, BESIDE) for stiffness in (5.0, 10.0)),
    Case("without payload alone, from above", 10.0, ABOVE, bare=True, loaded=False),
    Case("none, 10 s beside a stored robot", 0.0, ABOVE, stored=True),
    Case("10 s beside a stored robot, from above", 10.0, ABOVE, stored=True),
)


def counted(memory: float, name: str) -> list[bool]:
    """True for each case that is told of an arm."""
    robot = invented.robot(name)
    body = InertialParameters.from_com(0.5 * robot.rated_payload, [0.02, -0.02, 0.08], 0.003 * np.eye(3))
    noise = (3.0 if memory else 1.0) * NOISE  # what remembers is made a third as large
    motion, earlier_motion = (random_via_points(robot, 12, seed=seed).motion(100.0) for seed in (7, 8))
    both = (invented.recorded(name, motion, load, k, noise, memory) for k, load in enumerate((None, body)))
    bare, heavy = map(first, both)
    known = identify(robot, [invented.recorded(name, earlier_motion, None, 2, noise, memory)]).estimate

    def told(case: Case) -> bool:
        loaded, unloaded = (
            pulled(recording, case.stiffness, case.end, name=name) if hangs else recording
            for recording, hangs in ((heavy, case.loaded), (bare, case.bare))
        )
        problem: PayloadProblem
        if case.stored:
            problem = known_robot_weighing(robot, [first(loaded, SHORT)], known)
        else:
            problem = payload_problem(robot, [loaded], [unloaded], settings=Settings(robust=False))
        assert problem.source is not None
        system = system_of(problem, states_of(problem.source))
        assert system is not None
        return "pull" in effects_of(system)

    return [told(case) for case in CASES]


def main() -> None:
    arguments = options(__doc__, arms=",".join(robot_names()), memory=0.0, jobs=2)
    names = arguments.arms.split(",")
    counts = np.array(each(partial(counted, arguments.memory), names, arguments.jobs))
    rows = []
    for case, tells in zip(CASES, counts.T, strict=True):
        missed = [name for name, tell in zip(names, tells, strict=True) if not tell and case.stiffness]
        asked = len(names) if case.stiffness else 0
        rows.append([f"{case.words}, {case.stiffness:g} N/m", asked, int(tells.sum()), ", ".join(missed)])
    show(f"Told of {len(names)} arms", rows, "not of")


if __name__ == "__main__":
    main()
