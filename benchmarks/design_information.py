"""D-optimal motions against random ones: predicted sigma, and its confirmation by simulated runs."""

import numpy as np
from dynident.benchmarks.design_peers import random_within
from dynident.benchmarks.design_setup import GUARDED, NOISE, ROBOT, SEEDS, TABLE2, console, titled
from dynident.model import Motion
from dynident.model.arrays import Array
from dynident.trajectories import (
    Design,
    DesignProblem,
    FourierShape,
    Goal,
    Score,
    Simulator,
    ViaPointShape,
    build_design,
    solve_design,
)
from dynident.trajectories.samples import Samples

RANDOM = 200
RUNS = 100


def information() -> None:
    """D-optimal motions against the best of 200 random ones, at equal duration, and a check by simulation."""
    table = titled(
        f"d: relative sigma per square root of a second against the best of {RANDOM} random motions in that figure",
        "median",
        "of random",
        "change",
        "worst",
        "of random",
        "change",
        "CPU s",
    )
    goal = Goal("d", columns=tuple(TABLE2), noise=NOISE)
    rivals: dict[str, list[tuple[Array, Score, DesignProblem]]] = {}
    for name, shape in (
        ("random Fourier 10 s, 5 harmonics", FourierShape(5, 10.0)),
        ("random 14 via points at rest", ViaPointShape(14, passing=False)),
    ):
        problem = build_design(ROBOT, shape, goal, bounds=GUARDED)
        rivals[name] = [(*one, problem) for one in random_within(problem, RANDOM, seed=1)]
    for label, own in (("14 via points", ViaPointShape(14)), ("Fourier 10 s", FourierShape(5, 10.0))):
        problem = build_design(ROBOT, own, goal, bounds=GUARDED)
        designs = [solve_design(problem, seed=seed) for seed in SEEDS]
        ours = np.array([_spread(design.score) for design in designs])
        assert all(design.feasible for design in designs)
        for name, motions in rivals.items():
            theirs = np.array([_spread(score) for _, score, _ in motions]).min(axis=0)
            middle = np.median(ours, axis=0)
            change = 100.0 * (middle / theirs - 1.0)
            numbers = [f"{middle[0]:.3f}", f"{theirs[0]:.3f}", f"{change[0]:+.0f} %"]
            numbers += [f"{middle[1]:.3f}", f"{theirs[1]:.3f}", f"{change[1]:+.0f} %"]
            cpu = [design.cpu_s for design in designs]
            table.add_row(f"{label} / {name}", *numbers, f"{np.median(cpu):.1f} ({max(cpu):.1f})")
        if own == ViaPointShape(14):
            console.print(_confirmed(designs[0], *min(rivals["random Fourier 10 s, 5 harmonics"], key=_middle)))
    console.print(table)


def _confirmed(design: Design, x: Array, score: Score, problem: DesignProblem) -> str:
    """Spread of estimates from simulated noisy runs of the designed and a random motion, against the prediction."""
    ratios = []
    for predicted, plan in (
        (design.score, design.plan),
        (score, problem.family.plan(x)),
    ):
        actual = _simulated(design.problem, plan.motion(design.problem.goal.rate))
        ratios.append((np.array([actual[name] for name in TABLE2]), predicted))
    (ours, mine), (theirs, other) = ratios
    actual = np.median(ours / theirs)
    expected = np.median([mine.learnt.sigma[name] / other.learnt.sigma[name] for name in TABLE2])
    return (
        f"{RUNS} simulated runs each: spread of the designed motion over the random one (median over parameters) "
        f"{actual:.3f}, predicted {expected:.3f}, {100 * (actual / expected - 1):+.1f} %"
    )


def _simulated(problem: DesignProblem, motion: Motion) -> dict[str, float]:
    """Standard deviation of weighted least squares over runs with white torque noise."""
    torque = Simulator(ROBOT).measure(motion).torque
    samples = Samples(np.ones(len(motion.t)), motion.q, motion.qd, motion.qdd)
    weight = np.repeat(1.0 / np.array(NOISE), len(motion.t))
    W = problem.kernel.matrix(samples)[:, problem.places] * weight[:, None]
    draw = np.random.default_rng(0)
    noisy = [((torque + draw.standard_normal(torque.shape) * NOISE).T.ravel() * weight) for _ in range(RUNS)]
    found = np.linalg.lstsq(W, np.array(noisy).T, rcond=None)[0]
    return dict(zip(problem.names, found.std(axis=1, ddof=1).tolist(), strict=True))


def _middle(rival: tuple[Array, Score, DesignProblem]) -> float:
    return _spread(rival[1])[0]


def _spread(score: Score) -> tuple[float, float]:
    """Median and worst relative sigma, for one second of motion."""
    sigma = np.array(list(score.relative_sigma(TABLE2).values())) * np.sqrt(score.duration)
    return float(np.median(sigma)), float(sigma.max())
