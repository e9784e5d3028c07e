"""Solves a design problem: the result type, and the way from random starts to a motion that keeps every limit."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from ..model import Motion
from ..model.arrays import Array
from .criterion import ORDERS, STARTS
from .lagrangian import Multipliers
from .minimise import minimised
from .problem import DesignProblem
from .samples import Plan
from .score import Learnt, Score
from .settle import FINE_WIDTH, WIDTH, eased_within, settled

_STIFFNESS = 10.0  # of the augmented Lagrangian; values are of the order of 1
_ASTRAY = 0.1  # in the limits' units: what violates more by then seldom comes back
_MARGIN = 0.01  # of a limit, between samples; the settling adapts it
_FIRST = 160  # iterations of each start, shared by the surrogate's orders


class Step(NamedTuple):
    """Where the solver is.

    Attributes:
        text: what was done.
        best: criterion of the best motion so far that keeps all limits; None before there is one.
        evaluations: of criterion and gradient.
    """

    text: str
    best: float | None
    evaluations: int


@dataclass(frozen=True, eq=False)
class Design:
    """The most informative motion that was found.

    Attributes:
        problem: what was asked.
        plan: the motion: ``ViaPoints`` or ``Fourier``.
        score: its criterion, what it teaches, its limits; exact sign, fine grid.
        seed, starts: where the search began.
        evaluations: of criterion and gradient.
        cpu_s: processor time of the search [s].
        interrupted: whether it was stopped before its end.
    """

    problem: DesignProblem
    plan: Plan
    score: Score
    seed: int
    starts: int
    evaluations: int
    cpu_s: float
    interrupted: bool = False

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


@dataclass
class _Search:
    """The state of a search: the best motions so far."""

    problem: DesignProblem
    progress: Callable[[Step], None]
    evaluations: int = 0
    best: tuple[Array, Score] | None = None

    def minimise(self, x: Array, order: float, width: float, limits: Multipliers, iterations: int) -> Array:
        x, count = minimised(
            partial(self.problem.evaluate, order=order, width=width, limits=limits), x, self.problem, iterations
        )
        self.evaluations += count
        return x

    def brought_in(self, x: Array) -> Array:
        """A motion near x that keeps the limits at its samples, if there is one that a descent finds."""
        for _ in range(3):
            limits = Multipliers(self.problem.limits, self.problem.state(x, WIDTH), 1.0, 2.0 * _MARGIN)
            if limits.violation(self.problem.state(x, WIDTH)) <= 0.0:
                break
            x, count = minimised(partial(self.problem.trespass, width=WIDTH, limits=limits), x, self.problem, 60)
            self.evaluations += count
        return x

    def consider(self, x: Array, text: str) -> Score:
        """Judge a motion, made slower or smaller if that is enough to keep the limits; remember the best."""
        x, score = eased_within(self.problem, x)
        if self.best is None or _rank(score) < _rank(self.best[1]):
            self.best = (x, score)
        kept = self.best[1]
        self.progress(Step(text, kept.value if kept.feasible else None, self.evaluations))
        return score


def solve_design(
    problem: DesignProblem,
    *,
    seed: int = 0,
    starts: int | None = None,
    progress: Callable[[Step], None] = lambda step: None,
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

    Returns:
        The motion with its score. If the limits cannot be met, the motion that misses them least, with
        ``feasible`` False and the violations named in ``score.violations``.
    """
    begun, interrupted = time.process_time(), False
    starts = STARTS[problem.criterion.kind] if starts is None else starts
    search = _Search(problem, progress)
    draw = np.random.default_rng(seed)
    try:
        _run(search, draw, starts)
    except KeyboardInterrupt:
        interrupted = True
    if search.best is None:  # interrupted before the first look
        search.consider(problem.family.random(draw), "random start")
    assert search.best is not None
    x, score = search.best
    cpu = time.process_time() - begun
    return Design(problem, problem.family.plan(x), score, seed, starts, search.evaluations, cpu, interrupted)


def _run(search: _Search, draw: np.random.Generator, starts: int) -> None:
    problem, orders = search.problem, ORDERS[search.problem.criterion.kind]
    found: list[tuple[bool, float, int, Array, Multipliers]] = []
    for k in range(starts):
        x = search.brought_in(problem.family.random(draw, problem.clear))
        search.consider(x, f"start {k + 1}")
        limits = Multipliers(problem.limits, problem.state(x, WIDTH), _STIFFNESS, _MARGIN)
        for order in orders[:2]:
            x = search.minimise(x, order, WIDTH, limits, _FIRST // len(orders[:2]))
            limits.update(problem.state(x, WIDTH))
        merit, _ = problem.evaluate(x, orders[-1], WIDTH, limits)
        astray = limits.violation(problem.state(x, WIDTH)) > _ASTRAY
        search.consider(x, f"start {k + 1} improved")
        found.append((astray, merit, k, x, limits))
    *_, x, limits = min(found, key=lambda one: one[:3])
    for stage, width in enumerate((WIDTH, WIDTH, WIDTH, FINE_WIDTH)):
        x = search.minimise(x, orders[-1], width, limits, 150)
        limits.update(problem.state(x, width))
        search.consider(x, f"refined {stage + 1}")
    for turn in range(8):
        if settled(problem, x, limits):
            break
        x = search.minimise(x, orders[-1], FINE_WIDTH, limits, 60)
        limits.update(problem.state(x, FINE_WIDTH))
        search.consider(x, f"settled {turn + 1}")


def _rank(score: Score) -> tuple[float, float]:
    """Feasible motions by their value, the others after them by what they miss."""
    return (0.0, score.value) if score.feasible else (score.max_violation, score.value)
