"""D-optimal motions against random ones of every class: predicted sigma, and its confirmation by simulated runs."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from dynident.benchmarks.design_setup import GUARDED, NOISE, NOISE_OF_LIMITS, ROBOT, SEEDS, TABLE2, console, titled
from dynident.benchmarks.random_motions import CLASSES, Rival, random_motions
from dynident.common.arrays import Array
from dynident.model import Motion
from dynident.trajectories import (
    Design,
    DesignProblem,
    FourierShape,
    Goal,
    Score,
    Simulator,
    ViaPointShape,
    build_design,
    floor_under,
    score_motion,
    solve_design,
)
from dynident.trajectories.design.score import FINER, score_samples
from dynident.trajectories.motions.family import Samples

RANDOM = 200
RUNS = 100
PASSING = "14 points passing"
SHAPES: dict[str, ViaPointShape | FourierShape] = {
    PASSING: ViaPointShape(14),
    "14 points at rest": ViaPointShape(14, passing=False),
    "Fourier 10 s": FourierShape(5, 10.0),
}


class _Best(NamedTuple):
    """Best random motions of one class, by the median and by the worst sigma, of each draw.

    ``figures`` (draws, 2); ``motion`` and its score are the best of all draws by the median.
    """

    figures: Array
    motion: Rival
    score: Score


def information() -> None:
    """D-optimal motions against the best of 200 random ones, at equal duration, and a check by simulation."""
    goal = Goal("d", columns=tuple(TABLE2), noise=NOISE)
    like = build_design(ROBOT, SHAPES[PASSING], goal, bounds=GUARDED)
    draws = {kind: [random_motions(like, kind, RANDOM, seed) for seed in SEEDS] for kind in CLASSES}
    _compared("10 % of Table 2's FS", goal, SHAPES, draws)
    _compared("10 % of the torque limits", replace(goal, noise=NOISE_OF_LIMITS), {PASSING: SHAPES[PASSING]}, draws)


def _compared(
    noise: str, goal: Goal, shapes: dict[str, ViaPointShape | FourierShape], draws: dict[str, list[list[Rival]]]
) -> None:
    """Random motions keep the limits whatever the noise, so that one set of draws serves all."""
    problems = {name: build_design(ROBOT, shape, goal, bounds=GUARDED) for name, shape in shapes.items()}
    rivals = {kind: _best(problems[PASSING], drawn) for kind, drawn in draws.items()}
    by_problem = {name: [solve_design(problem, seed=seed) for seed in SEEDS] for name, problem in problems.items()}
    _print(f"d, torque noise {noise}", by_problem, rivals)
    design, strongest = by_problem[PASSING][0], min(rivals.values(), key=lambda best: best.figures[:, 0].min())
    console.print(_confirmed(design, strongest))
    console.print(_floor(design, strongest))


def _best(problem: DesignProblem, draws: list[list[Rival]]) -> _Best:
    """The best of each draw."""
    figures, motions = [], []
    for drawn in draws:
        spreads = np.array([_spread(problem, rival.family.sample(rival.x, FINER)) for rival in drawn])
        figures.append(spreads.min(axis=0))
        motions.append(drawn[int(spreads[:, 0].argmin())])
    best = motions[int(np.array(figures)[:, 0].argmin())]
    return _Best(np.array(figures), best, score_samples(problem, best.family.sample(best.x, FINER)))


def _print(title: str, by_problem: dict[str, list[Design]], rivals: dict[str, _Best]) -> None:
    """The middle of five seeds against the middle, and the luckiest, of five draws."""
    table = titled(
        f"{title}: sigma in % of the value, one second at {Goal().rate:g} Hz; designed: middle\n"
        f"of five seeds (worst); random: best of {RANDOM} in that figure, middle of five draws (least)",
        "median",
        "random",
        "change",
        "worst",
        "random",
        "change",
    )
    for name, designs in by_problem.items():
        missed = max(score_motion(design.problem, design.motion(997.0)).max_violation for design in designs)
        ours = np.array([_spread(design.problem, design.score.samples) for design in designs])
        cpu = [design.cpu_s for design in designs]
        console.print(f"{name}: {np.median(cpu):.1f} CPU s ({max(cpu):.1f}), largest violation {missed:.1e}")
        for kind, best in rivals.items():
            row = []
            for our_figures, theirs in zip(ours.T, best.figures.T, strict=True):
                middle, rival_middle = 100.0 * np.median(our_figures), 100.0 * np.median(theirs)
                lucky = 100.0 * theirs.min()
                row += [
                    f"{middle:.3g} ({100 * our_figures.max():.3g})",
                    f"{rival_middle:.3g} ({lucky:.3g})",
                    f"{100 * (middle / rival_middle - 1):+.0f} %",
                ]
            table.add_row(f"{name} / random {kind}", *row)
    console.print(table)


def _floor(design: Design, rival: _Best) -> str:
    """How far the geometric mean of uncertainty is from what states without continuity would give."""
    least = min(
        (floor_under(design.problem, design.score.value, seed=seed) for seed in range(2)),
        key=lambda floor: floor.value,
    )
    designed, floor = (np.exp(0.5 * (x - rival.score.value)) for x in (design.score.value, least.value))
    return (
        "geometric mean of uncertainty over that of the random motion best in the median: "
        f"designed {designed:.2f}, floor over weighted states {floor:.2f}"
    )


def _confirmed(design: Design, rival: _Best) -> str:
    """Spread of estimates from simulated noisy runs of the designed and a random motion, against the prediction."""
    problem, (family, x) = design.problem, rival.motion
    ours, theirs = (_simulated(problem, plan.motion(problem.goal.rate)) for plan in (design.plan, family.plan(x)))
    sigma, rival_sigma = design.learnt.sigma, rival.score.learnt.sigma
    longer = np.sqrt(design.score.duration / rival.score.duration)  # to equal duration
    actual = longer * np.median([ours[name] / theirs[name] for name in TABLE2])
    expected = longer * np.median([sigma[name] / rival_sigma[name] for name in TABLE2])
    return (
        f"{RUNS} simulated runs each: spread of the designed motion over the random one best in the median, "
        f"at equal duration\n(median over parameters) {actual:.3f}, predicted {expected:.3f}, "
        f"{100 * (actual / expected - 1):+.1f} %"
    )


def _simulated(problem: DesignProblem, motion: Motion) -> dict[str, float]:
    """Standard deviation of weighted least squares over runs with white torque noise."""
    torque = Simulator(ROBOT).measure(motion).torque
    samples = Samples(np.ones(len(motion.t)), motion.q, motion.qd, motion.qdd)
    weight = np.repeat(1.0 / problem.noise, len(motion.t))
    W = problem.kernel.matrix(samples)[:, problem.places] * weight[:, None]
    draw = np.random.default_rng(0)
    noise = (draw.standard_normal(torque.shape) * problem.noise for _ in range(RUNS))
    noisy = [(torque + errors).T.ravel() * weight for errors in noise]
    solutions = np.linalg.lstsq(W, np.array(noisy).T, rcond=None)[0]
    return dict(zip(problem.names, solutions.std(axis=1, ddof=1).tolist(), strict=True))


def _spread(problem: DesignProblem, samples: Samples) -> tuple[float, float]:
    """Median and worst predicted relative sigma, for one second of motion."""
    weights = problem.row_weights(samples, weighted=True, duration=1.0)
    G = problem.information(problem.kernel.entries(samples, 0.0), weights)
    sigma = np.sqrt(np.diag(np.linalg.inv(G))) / np.abs([TABLE2[name] for name in problem.names])
    return float(np.median(sigma)), float(sigma.max())
