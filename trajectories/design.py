"""Solves a design problem: the result type, and which solver does it."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..common.errors import InputError
from ..model import Motion
from .augmented import search_augmented
from .criterion import STARTS
from .interior import search_interior
from .problem import DesignProblem
from .samples import Plan
from .score import Learnt, Score
from .search import Search, Step

Solver = Literal["auto", "augmented", "ipopt"]
"""augmented: an augmented Lagrangian and L-BFGS; ipopt: the interior point method; auto: what measured best."""

_BEST = "augmented"
"""Of both, on every class of problems that was measured (benchmarks/design.py solvers): see docs/theory.md."""
_SEARCHES = {"augmented": search_augmented, "ipopt": search_interior}


@dataclass(frozen=True, eq=False)
class Design:
    """The most informative motion that was found.

    Attributes:
        problem: what was asked.
        plan: the motion: ``ViaPoints``, ``BlendedPoints`` or ``Fourier``.
        score: its criterion, what it teaches, its limits; exact sign, fine grid.
        seed, starts: where the search began.
        evaluations: of criterion and gradient.
        cpu_s: processor time of the search [s].
        interrupted: whether it was stopped before its end.
        solver: "augmented" or "ipopt".
    """

    problem: DesignProblem
    plan: Plan
    score: Score
    seed: int
    starts: int
    evaluations: int
    cpu_s: float
    interrupted: bool = False
    solver: str = "augmented"

    def motion(self, rate: float) -> Motion:
        """Sample the motion at ``rate`` [Hz]."""
        return self.plan.motion(rate)

    @property
    def learnt(self) -> Learnt:
        """log det, both condition numbers and predicted standard deviations."""
        return self.score.learnt

    @property
    def feasible(self) -> bool:
        """Whether all limits are met; ``score.violations`` names those that are not, and by how much."""
        return self.score.feasible


def solve_design(
    problem: DesignProblem,
    *,
    seed: int = 0,
    starts: int | None = None,
    progress: Callable[[Step], None] = lambda step: None,
    solver: Solver = "auto",
) -> Design:
    """Find the most informative motion.

    Several random starts are improved for a while, the best of them to the end; then the limits are checked on
    a grid ten times finer, and drawn in where the motion oversteps them between samples. Ctrl-C ends the search
    with the best motion so far.

    Args:
        problem: made by ``build_design``.
        seed: of the random starts; the same seed gives the same motion.
        starts: number of random starts; None for 6 by "d" and "a", 3 by condition numbers.
        progress: called after each stage.
        solver: how to search.

    Returns:
        The motion with its score. If the limits cannot be met, the motion that misses them least, with
        ``feasible`` False and the violations named in ``score.violations``.
    """
    if solver != "auto" and solver not in _SEARCHES:
        raise InputError(f"solver {solver!r} is not one of auto, {', '.join(_SEARCHES)}")
    way = _BEST if solver == "auto" else solver
    begun, interrupted = time.process_time(), False
    starts = STARTS[problem.criterion.kind] if starts is None else starts
    search = Search(problem, np.random.default_rng(seed), starts, progress)
    try:
        _SEARCHES[way](search)
    except KeyboardInterrupt:
        interrupted = True
    if search.best is None:  # interrupted before the first look
        search.consider(problem.family.random(search.draw), "random start")
    assert search.best is not None
    x, score = search.best
    cpu = time.process_time() - begun
    plan = problem.family.plan(x)
    return Design(problem, plan, score, seed, starts, search.evaluations, cpu, interrupted, way)
