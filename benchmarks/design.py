"""Trajectory design on the RX90: condition numbers, and predicted sigma.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/design.py [conditions] [information]
     [--seeds 5] [--random 200] [--draws 5]

One core, warm cache, CPU seconds of the optimisation alone; the median over seeds counts, the worst is shown.
Accelerations are ten times the speed per second in conditions, three times elsewhere,
with torque limits. information: D-optimal motions against the best of ``--random`` random ones of each class
(promised.py compares predictions with what simulated recordings show).
"""

import argparse
from dataclasses import replace

import numpy as np
from dynident import trajectories
from dynident.benchmarks.random_motions import CLASSES, Rival, random_motions
from dynident.benchmarks.shared import options, show
from dynident.common.arrays import Array
from dynident.examples.paper.printed import paper_tables
from dynident.model import load_robot
from dynident.trajectories.design.goal import Kind, Shape
from dynident.trajectories.design.score import FINER
from dynident.trajectories.motions.family import Samples

ROBOT = load_robot("rx90")
TORQUE = (300.0, 300.0, 120.0, 50.0, 40.0, 20.0)
STRONG = [3.0 * joint.limits.speed for joint in ROBOT.joints]
GUARDED = trajectories.JointBounds.of(ROBOT, acceleration=STRONG, torque=TORQUE)
TABLE2 = {name: printed.value for name, printed in paper_tables().table2_robot.items()}
NOISE = tuple(0.1 * TABLE2[f"FS{j + 1}"] for j in range(ROBOT.n))
INFORMATIVE = trajectories.Goal("d", columns=tuple(TABLE2), noise=NOISE)
VIA, FOURIER = trajectories.ViaPointShape(14), trajectories.FourierShape(5, 10.0)
AT_REST = trajectories.ViaPointShape(14, passing=False)
TRAPEZOIDS = replace(AT_REST, segment=trajectories.Trapezoid())


def designed(problem: trajectories.DesignProblem, seeds: int) -> list[trajectories.Design]:
    """One design by each seed."""
    return [trajectories.solve_design(problem, seed=seed) for seed in range(seeds)]


def missed(designs: list[trajectories.Design]) -> float:
    """Largest violation, checked again from the motion itself at a rate that the solver did not use."""
    return max(trajectories.score_motion(design.problem, design.motion(997.0)).max_violation for design in designs)


def conditions(arguments: argparse.Namespace) -> None:
    """Condition numbers of via points, Fourier series and payload motions."""
    within = trajectories.ViaPointShape(14, longest=10.0)
    tasks: list[tuple[str, Shape, Kind, bool, float, float]] = [
        ("14 via points, cond", VIA, "cond", False, 18.0, 5.0),
        ("14 via points, cond-scaled", VIA, "cond-scaled", False, 2.6, 5.0),
        ("14 via points by trapezoids, cond", TRAPEZOIDS, "cond", False, 18.0, 5.0),
        ("Fourier 10 s, 5 harmonics, cond", FOURIER, "cond", False, 27.0, 2.0),
        ("Fourier 10 s, 5 harmonics, cond-scaled", FOURIER, "cond-scaled", False, 4.0, 2.0),
        ("payload, via points in 10 s, cond", within, "cond", True, 1.6, 2.0),
        ("payload, via points in 10 s, cond-scaled", within, "cond-scaled", True, 1.05, 2.0),
    ]
    rows = []
    for name, shape, kind, payload, target, seconds in tasks:
        problem = trajectories.build_design(ROBOT, shape, trajectories.Goal(kind, payload_only=payload))
        designs = designed(problem, arguments.seeds)
        cpu, learnt = [design.cpu_s for design in designs], [design.learnt for design in designs]
        cond = [one.condition_number_scaled if kind == "cond-scaled" else one.condition_number for one in learnt]
        times = (f"{seconds:g}", f"{np.median(cpu):.2f}", f"{max(cpu):.2f}")
        seen = (f"{np.median(cond):.3f}", f"{max(cond):.3f}")
        rows.append([name, f"{target:g}", *seen, *times, f"{missed(designs):.1e}"])
    show("Condition numbers", rows, "worst", "CPU s, asked", "median", "worst", "peak violation")


def information(arguments: argparse.Namespace) -> None:
    """D-optimal motions against the best random ones of every class, at equal duration.

    Random motions keep the limits whatever the noise, so that one set of draws serves all.
    """
    like = trajectories.build_design(ROBOT, VIA, INFORMATIVE, bounds=GUARDED)
    draws = {
        kind: [random_motions(like, kind, arguments.random, seed) for seed in range(arguments.draws)]
        for kind in CLASSES
    }
    shapes: dict[str, Shape] = {"14 points passing": VIA, "14 points at rest": AT_REST, "Fourier 10 s": FOURIER}
    of_limits = replace(INFORMATIVE, noise=tuple(0.1 * torque for torque in TORQUE))
    for noise, goal, names in (
        ("10 % of Table 2's FS", INFORMATIVE, tuple(shapes)),
        ("10 % of the torque limits", of_limits, ("14 points passing",)),
    ):
        problems = {name: trajectories.build_design(ROBOT, shapes[name], goal, bounds=GUARDED) for name in names}
        _compared(noise, problems, draws, arguments.seeds)


def _compared(
    noise: str, problems: dict[str, trajectories.DesignProblem], draws: dict[str, list[list[Rival]]], seeds: int
) -> None:
    """Print the middle of the seeds against the middle, and the luckiest, of the draws."""
    first = next(iter(problems.values()))
    best: dict[str, Array] = {}  # by class: draws x (median, worst sigma), each of the best motion in that figure
    for kind, drawn in draws.items():
        spreads = [np.array([_spread(first, one.family.sample(one.x, FINER)) for one in own]) for own in drawn]
        best[kind] = np.array([spread.min(axis=0) for spread in spreads])
    designs = {name: designed(problem, seeds) for name, problem in problems.items()}
    rows = []
    for name, own in designs.items():
        ours = np.array([_spread(design.problem, design.score.samples) for design in own])
        cpu = [design.cpu_s for design in own]
        print(f"{name}: {np.median(cpu):.1f} CPU s ({max(cpu):.1f}), largest violation {missed(own):.1e}")
        for kind, figures in best.items():
            row = [f"{name} / random {kind}"]
            for designed_figure, theirs in zip(100.0 * ours.T, 100.0 * figures.T, strict=True):
                middle, rival = np.median(designed_figure), np.median(theirs)
                row += [f"{middle:.3g} ({designed_figure.max():.3g})", f"{rival:.3g} ({theirs.min():.3g})"]
                row += [f"{100 * (middle / rival - 1):+.0f} %"]
            rows.append(row)
    print("designed: middle of the seeds (worst); random: best in that figure, middle of the draws (least)")
    title = f"d, torque noise {noise}: median and worst sigma in % of the value, 1 s at {INFORMATIVE.rate:g} Hz"
    show(title, rows, "random", "change", "worst", "random", "change", asked=False)


def _spread(problem: trajectories.DesignProblem, samples: Samples) -> tuple[float, float]:
    """Median and worst predicted relative sigma, for one second of motion."""
    weights = problem.row_weights(samples, weighted=True)
    G = problem.information(problem.kernel.state(samples).entries, weights)
    sigma = np.sqrt(np.diag(np.linalg.inv(G))) / np.abs([TABLE2[name] for name in problem.names])
    return float(np.median(sigma)), float(sigma.max())


PARTS = {part.__name__: part for part in (conditions, information)}


def main() -> None:
    arguments = options(__doc__, parts=tuple(PARTS), seeds=5, random=200, draws=5)
    for name in arguments.parts:
        PARTS[name](arguments)


if __name__ == "__main__":
    main()
