"""Criterion d: information per second, and how far it gets below random motions with the paper's noise."""

import numpy as np
import pytest
from dynident.examples.paper.printed import paper_tables
from dynident.tests.trajectories.design_problems import BOUNDS, ROBOT, limited
from dynident.trajectories import (
    DesignProblem,
    FourierShape,
    Goal,
    Score,
    ViaPointShape,
    build_design,
    random_via_points,
    score_motion,
    solve_design,
)
from dynident.trajectories.design.criterion import Kind

TABLE2 = {name: printed.value for name, printed in paper_tables().table2_robot.items()}
SPEEDS = 0.95 ** np.arange(30)
NOISE = tuple(0.1 * TABLE2[f"FS{j}"] for j in range(1, 7))


@pytest.fixture(scope="module")
def problem() -> DesignProblem:
    goal = Goal("d", columns=tuple(TABLE2), noise=NOISE)
    return build_design(ROBOT, ViaPointShape(14), goal, bounds=BOUNDS)


def random_scores(problem: DesignProblem, count: int) -> list[Score]:
    """At rest in each point, as fast as all limits allow, in steps of 5 %."""
    robot = limited(ROBOT, problem.bounds)
    scores = []
    for seed in range(count):
        motions = (random_via_points(robot, 14, seed, speed, 0.75).motion(100.0) for speed in SPEEDS)
        scores.append(next(score for score in (score_motion(problem, x) for x in motions) if score.feasible))
    return scores


def spread(score: Score) -> list[float]:
    """Median and worst relative sigma, for one second of motion."""
    sigma = np.array(list(score.relative_sigma(TABLE2).values())) * np.sqrt(score.duration)
    return [float(np.median(sigma)), float(sigma.max())]


def test_d_counts_information_per_second(problem: DesignProblem) -> None:
    """What is optimised is what is compared at equal duration: -log det per parameter of one second's data."""
    for score in random_scores(problem, 3):
        per_second = score.learnt.log_det / len(TABLE2) - np.log(score.duration)
        assert score.value == pytest.approx(-per_second, abs=1e-9)


@pytest.mark.long
def test_a_design_is_a_quarter_below_random_motions(problem: DesignProblem) -> None:
    design = solve_design(problem, starts=3)
    assert design.feasible
    best = np.min([spread(score) for score in random_scores(problem, 40)], axis=0)
    assert (spread(design.score) < 0.75 * best).all()


@pytest.mark.parametrize(("kind", "starts"), [("d", 6), ("cond", 3)])
def test_starts_by_default(kind: Kind, starts: int) -> None:
    texts: list[str] = []
    goal = Goal(kind, columns=("FV1", "FS1"))
    design = solve_design(
        build_design(ROBOT, FourierShape(2, 4.0), goal), progress=lambda text, best, evaluations: texts.append(text)
    )
    assert design.starts == starts
    improved = [text for text in texts if text.endswith("improved")]
    assert improved[:starts] == [f"start {k + 1} improved" for k in range(starts)]
    assert len(improved) == starts + -(-starts // 3), "the best third goes on"
    assert set(improved[starts:]) <= set(improved[:starts])
