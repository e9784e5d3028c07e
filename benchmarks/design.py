"""Trajectory design on the RX90: condition numbers, predicted sigma, obstacles, floors, and black-box search.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/design.py [part ...]; parts: ``--help``

One core, warm cache, ``time.process_time`` of the optimisation alone; the median of five seeds counts, the worst is
shown. Accelerations are ten times the speed per second where nothing else is said.
"""

import argparse
from collections.abc import Callable

import numpy as np
from dynident.apps.export.motion import WrittenMotion
from dynident.apps.export.motions.val3 import val3_replay
from dynident.benchmarks.design_information import information
from dynident.benchmarks.design_peers import cma_es, random_search
from dynident.benchmarks.design_setup import GUARDED, NOISE, ROBOT, SCENE, SEEDS, TABLE2, console, titled
from dynident.common.arrays import Array
from dynident.trajectories import (
    Design,
    DesignProblem,
    FourierShape,
    Goal,
    Trapezoid,
    ViaPointShape,
    build_design,
    floor_under,
    score_motion,
    solve_design,
)
from dynident.trajectories.design.criterion import Kind
from dynident.trajectories.design.descent import Lagrangian
from dynident.trajectories.design.goal import Shape


def figures() -> None:
    """Condition numbers of via points, Fourier series and payload motions."""
    table = titled(
        "Condition numbers", "asked", "median", "worst", "CPU s, asked", "median", "worst", "peak violation"
    )
    via, within, fourier = ViaPointShape(14), ViaPointShape(14, longest=10.0), FourierShape(5, 10.0)
    trapezoids = ViaPointShape(14, passing=False, segment=Trapezoid())
    tasks: list[tuple[str, Shape, Kind, bool, float, float]] = [
        ("14 via points, cond", via, "cond", False, 18.0, 5.0),
        ("14 via points, cond-scaled", via, "cond-scaled", False, 2.6, 5.0),
        ("14 via points by trapezoids, cond", trapezoids, "cond", False, 18.0, 5.0),
        ("Fourier 10 s, 5 harmonics, cond", fourier, "cond", False, 27.0, 2.0),
        ("Fourier 10 s, 5 harmonics, cond-scaled", fourier, "cond-scaled", False, 4.0, 2.0),
        ("payload, via points in 10 s, cond", within, "cond", True, 1.6, 2.0),
        ("payload, via points in 10 s, cond-scaled", within, "cond-scaled", True, 1.05, 2.0),
    ]
    for name, shape, kind, payload, target, seconds in tasks:
        goal = Goal(kind, payload_only=payload)
        problem = build_design(ROBOT, shape, goal)
        designs = [solve_design(problem, seed=seed) for seed in SEEDS]
        table.add_row(name, *_row(designs, kind, target, seconds))
    console.print(table)


def replays() -> None:
    """What a controller's own trapezoidal profiles leave of the condition number of 14 via points."""
    table = titled(
        "cond as designed, and as --val3 replays it", "designed: median", "worst", "replayed: median", "worst"
    )
    shapes: dict[str, Shape] = {
        "quintic, passing": ViaPointShape(14),
        "quintic, at rest": ViaPointShape(14, passing=False),
        "trapezoid, ramp 0.25": ViaPointShape(14, passing=False, segment=Trapezoid()),
        "trapezoid, ramp 0.15": ViaPointShape(14, passing=False, segment=Trapezoid(0.15)),
    }
    for name, shape in shapes.items():
        problem = build_design(ROBOT, shape, Goal("cond"))
        designs = [solve_design(problem, seed=seed) for seed in SEEDS]
        moves = [val3_replay(WrittenMotion(ROBOT, design.plan, problem.bounds, ())) for design in designs]
        again = [score_motion(problem, move.motion(500.0)).learnt.condition_number for move in moves]
        conditions = [design.learnt.condition_number for design in designs]
        row = (np.median(conditions), max(conditions), np.median(again), max(again))
        table.add_row(name, *(f"{number:.2f}" for number in row))
    console.print(table)


def obstacles() -> None:
    """Designs with torque limits and obstacles."""
    table = titled(
        "Torque limits, accelerations 3 x speed: cond",
        "asked",
        "median",
        "worst",
        "CPU s, asked",
        "median",
        "worst",
        "peak violation",
    )
    for name, shape in (("14 via points", ViaPointShape(14)), ("Fourier 10 s", FourierShape(5, 10.0))):
        for scene in (SCENE, None):
            problem = build_design(ROBOT, shape, Goal("cond"), bounds=GUARDED, scene=scene)
            designs = [solve_design(problem, seed=seed) for seed in SEEDS]
            row = _row(designs, "cond", 32.0, 15.0)
            table.add_row(f"{name}, {'obstacles' if scene else 'none'}", *row)
    console.print(table)


def peers() -> None:
    """Random search and CMA-ES with the same fast criterion, at our CPU time and at four times as much."""
    table = titled(
        "cond at equal CPU time (CMA-ES also with 4 x), median (worst) of five seeds",
        "ours",
        "random",
        "CMA-ES",
        "CMA-ES, 4 x",
    )
    for name, shape in (
        ("Fourier 10 s, 5 harmonics", FourierShape(5, 10.0)),
        ("14 via points at rest", ViaPointShape(14, passing=False)),
    ):
        problem = build_design(ROBOT, shape, Goal("cond"))
        conditions: dict[str, list[float]] = {"ours": [], "random": [], "CMA-ES": [], "CMA-ES, 4 x": []}
        for seed in SEEDS:
            design = solve_design(problem, seed=seed)
            conditions["ours"].append(design.learnt.condition_number)
            conditions["random"].append(np.exp(random_search(problem, design.cpu_s, seed)))
            conditions["CMA-ES"].append(np.exp(cma_es(problem, design.cpu_s, seed)))
            conditions["CMA-ES, 4 x"].append(np.exp(cma_es(problem, 4.0 * design.cpu_s, seed)))
        table.add_row(name, *(f"{np.median(x):.1f} ({max(x):.1f})" for x in conditions.values()))
    console.print(table)


def floors() -> None:
    """The best weighted states within the limits, continuity ignored."""
    table = titled("Floor over weighted states (least of two seeds)", "design", "floor", "ratio")
    kinds: tuple[Kind, ...] = ("cond", "cond-scaled")
    for kind in kinds:
        design = solve_design(build_design(ROBOT, ViaPointShape(14), Goal(kind)))
        least = min(
            (floor_under(design.problem, design.score.value, seed=seed) for seed in range(2)),
            key=lambda floor: floor.value,
        )
        numbers = (np.exp(design.score.value), np.exp(least.value), np.exp(least.gap))
        table.add_row(f"14 via points, {kind}", *(f"{x:.2f}" for x in numbers))
    goal = Goal("d", columns=tuple(TABLE2), noise=NOISE)
    design = solve_design(build_design(ROBOT, ViaPointShape(14), goal, bounds=GUARDED))
    least = min(
        (floor_under(design.problem, design.score.value, seed=seed) for seed in range(2)),
        key=lambda floor: floor.value,
    )
    numbers = (np.exp(0.5 * design.score.value), np.exp(0.5 * least.value), np.exp(0.5 * least.gap))
    table.add_row("14 via points, d (geometric mean of uncertainty)", *(f"{x:.4f}" for x in numbers))
    console.print(table)


def gradient() -> None:
    """Exact gradient against central differences (Richardson), relative, ten random directions each."""
    table = titled(
        "Gradient against finite differences, largest relative error",
        "via points",
        "with limits",
        "trapezoids",
        "with limits",
        "Fourier",
        "with limits",
    )
    goals = [
        Goal("d", noise=NOISE),
        Goal("a", columns=tuple(TABLE2), reference=TABLE2, noise=NOISE),
        Goal("cond"),
        Goal("cond-scaled"),
    ]
    for goal in goals:
        errors = []
        trapezoids = ViaPointShape(14, passing=False, segment=Trapezoid())
        for shape in (ViaPointShape(14), trapezoids, FourierShape(5, 10.0)):
            problem, draw = build_design(ROBOT, shape, goal, bounds=GUARDED, scene=SCENE), np.random.default_rng(0)
            x = problem.family.random(draw) + 0.02 * draw.standard_normal(problem.family.size)
            limits = Lagrangian(problem, x, 3.0, 0.4)
            for terms in (None, limits):
                errors.append(max(_error(problem, terms, x, draw) for _ in range(10)))
        table.add_row(goal.criterion, *(f"{error:.1e}" for error in errors))
    console.print(table)


def _error(problem: DesignProblem, limits: Lagrangian | None, x: Array, draw: np.random.Generator) -> float:
    direction = draw.standard_normal(len(x)) / np.sqrt(len(x))

    def difference(h: float) -> float:
        ahead, behind = (problem.evaluate(x + s * direction, 8.0, 0.5, limits)[0] for s in (h, -h))
        return (ahead - behind) / (2.0 * h)

    slope = problem.evaluate(x, 8.0, 0.5, limits)[1]
    expected = (4.0 * difference(1e-4) - difference(2e-4)) / 3.0
    return abs(float(slope @ direction) - expected) / max(abs(expected), float(np.linalg.norm(slope)) / len(x))


def _row(designs: list[Design], kind: Kind, target: float, seconds: float) -> list[str]:
    scaled = kind == "cond-scaled"
    conditions = [d.learnt.condition_number_scaled if scaled else d.learnt.condition_number for d in designs]
    cpu = [design.cpu_s for design in designs]
    # Checked again from the motion itself, at a rate the solver did not use.
    missed = max(score_motion(design.problem, design.motion(997.0)).max_violation for design in designs)
    middle, worst = float(np.median(conditions)), max(conditions)
    return [
        f"{target:g}",
        f"{middle:.3f}",
        f"{worst:.3f}",
        f"{seconds:g}",
        f"{np.median(cpu):.2f}",
        f"{max(cpu):.2f}",
        f"{missed:.1e}",
    ]


PARTS: dict[str, Callable[[], None]] = {
    part.__name__: part for part in (gradient, figures, replays, information, obstacles, floors, peers)
}


def main() -> None:
    """Print the parts asked for, or all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], default=[])
    for name in parser.parse_args().parts or PARTS:
        PARTS[name]()


if __name__ == "__main__":
    main()
