"""The search for the most informative motion: L-BFGS on an augmented Lagrangian, from random starts."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from ...common.arrays import Array
from ...common.speech import Speaks
from ...model import Motion
from ..motions.samples import Family, Plan
from .criterion import ORDERS, STARTS
from .problem import DesignProblem
from .score import Learnt, Score
from .settle import FINE_WIDTH, WIDTH, Multipliers, eased_within

_MARGIN = 0.01  # of a limit, between samples; the settling adapts it
_ASTRAY = 0.1  # in the limits' units: what violates more after the first look seldom comes back
_STIFFNESS = 10.0  # of the augmented Lagrangian; values are of the order of 1
_FIRST, _REFINED, _SETTLED, _NEARER = 160, 150, 60, 60  # iterations; the first are shared by the surrogate's orders
_TURNS = 8  # of settling
_MEMORY = 40  # pairs of steps and slopes that L-BFGS keeps
_LARGE = 1e6  # stands for inf: the line search then goes back


class Step(NamedTuple):
    """Where the search is.

    Attributes:
        text: what was done.
        best: criterion of the best motion so far that keeps all limits; None before there is one.
        evaluations: of criterion and gradient.
    """

    text: str
    best: float | None
    evaluations: int


@dataclass(frozen=True, eq=False, repr=False)
class Design(Speaks):
    """The most informative motion that was found.

    Attributes:
        problem: what was asked.
        plan: the motion: ``ViaPoints``, ``BlendedPoints``, ``Fourier`` or ``NearMotion``.
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

    @property
    def headline(self) -> str:
        """The robot, how long the motion takes, and whether it keeps its limits, in a line."""
        kept = "keeps every limit" if self.feasible else "does not keep every limit"
        return f"motion of {self.problem.robot.name}, {self.score.duration:.4g} s, {kept}"

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
) -> Design:
    """Find the most informative motion.

    Several random starts are improved for a while, the best of them to the end; then the limits are checked on
    a grid ten times finer, and drawn in where the motion oversteps them between samples. Ctrl-C ends the search
    with the best motion so far.

    Args:
        problem: made by ``build_design``.
        seed: of the random starts; the same seed gives the same motion.
        starts: number of random starts; None for 6 by "d" and "a", 3 by condition numbers.

    Returns:
        The motion with its score. If the limits cannot be met, the motion that misses them least, with
        ``feasible`` False and the violations named in ``score.violations``.
    """
    begun, interrupted = time.process_time(), False
    starts = STARTS[problem.criterion.kind] if starts is None else starts
    search = _Search(problem, np.random.default_rng(seed), progress)
    try:
        search.run(starts)
    except KeyboardInterrupt:
        interrupted = True
    if search.best is None:  # interrupted before the first look
        search.consider(search.random(), "random start")
    assert search.best is not None
    x, score = search.best
    cpu = time.process_time() - begun
    return Design(problem, problem.family.plan(x), score, seed, starts, search.evaluations, cpu, interrupted)


@dataclass
class _Search:
    """The best motion so far, and the way to better ones.

    Attributes:
        problem: what was asked.
        draw: random numbers of the starts.
        progress: called after each stage.
        evaluations: of criterion and gradient.
        best: the motion and its score.
    """

    problem: DesignProblem
    draw: np.random.Generator
    progress: Callable[[Step], None]
    evaluations: int = 0
    best: tuple[Array, Score] | None = None

    def run(self, starts: int) -> None:
        """Improve random starts for a while, the best of them to the end; then settle it within its limits."""
        order = ORDERS[self.problem.criterion.kind][-1]
        x, limits = self._best_start(starts)
        for stage, width in enumerate((WIDTH, WIDTH, WIDTH, FINE_WIDTH)):
            x = self._improved(x, order, width, limits, _REFINED)
            self.consider(x, f"refined {stage + 1}")
        for turn in range(_TURNS):
            if limits.settle(self.problem, x):
                break
            x = self._improved(x, order, FINE_WIDTH, limits, _SETTLED)
            self.consider(x, f"settled {turn + 1}")

    def _best_start(self, starts: int) -> tuple[Array, Multipliers]:
        """The most promising of some random starts, improved for a while, and its multipliers."""
        problem, orders = self.problem, ORDERS[self.problem.criterion.kind]
        candidates: list[tuple[bool, float, int, Array, Multipliers]] = []
        for k in range(starts):
            x = self._brought_in(self.random())
            self.consider(x, f"start {k + 1}")
            limits = Multipliers(problem.limits, problem.state(x, WIDTH), _STIFFNESS, _MARGIN)
            for order in orders[:2]:
                x = self._improved(x, order, WIDTH, limits, _FIRST // len(orders[:2]))
            merit, _ = problem.evaluate(x, orders[-1], WIDTH, limits)
            self.consider(x, f"start {k + 1} improved")
            astray = limits.violation(problem.state(x, WIDTH)) > _ASTRAY
            candidates.append((astray, merit, k, x, limits))
        *_, x, limits = min(candidates, key=lambda candidate: candidate[:3])
        return x, limits

    def random(self) -> Array:
        """A motion to start from."""
        return self.problem.family.random(self.draw, self.problem.clear)

    def consider(self, x: Array, text: str) -> None:
        """Judge a motion, made slower or smaller if that is enough to keep the limits; remember the best."""
        x, score = eased_within(self.problem, x)
        if self.best is None or _rank(score) < _rank(self.best[1]):
            self.best = (x, score)
        best = self.best[1]
        self.progress(Step(text, best.value if best.feasible else None, self.evaluations))

    def _improved(self, x: Array, order: float, width: float, limits: Multipliers, iterations: int) -> Array:
        """A descent, and the multipliers' update where it ends."""
        x = self._descended(partial(self.problem.evaluate, order=order, width=width, limits=limits), x, iterations)
        limits.update(self.problem.state(x, width))
        return x

    def _brought_in(self, x: Array) -> Array:
        """A motion near x that keeps the limits at its samples, if there is one that a descent finds."""
        problem = self.problem
        for _ in range(3):
            limits = Multipliers(problem.limits, problem.state(x, WIDTH), 1.0, 2.0 * _MARGIN)
            if limits.violation(problem.state(x, WIDTH)) <= 0.0:
                break
            x = self._descended(partial(problem.trespass, width=WIDTH, limits=limits), x, _NEARER)
        return x

    def _descended(self, function: Callable[[Array], tuple[float, Array]], x: Array, iterations: int) -> Array:
        x, evaluations = minimised(function, x, self.problem.family, iterations)
        self.evaluations += evaluations
        return x


def minimised(
    function: Callable[[Array], tuple[float, Array]], x: Array, family: Family, iterations: int
) -> tuple[Array, int]:
    """Minimise a smooth number within a family's bounds by L-BFGS: the best x, and the number of evaluations."""

    def finite(y: Array) -> tuple[float, Array]:
        value, slope = function(y)
        return (value, slope) if np.isfinite(value) else (_LARGE, slope)

    answer = minimize(
        finite,
        x,
        jac=True,
        method="L-BFGS-B",
        bounds=np.column_stack([family.low, family.high]),
        options={"maxiter": iterations, "maxfun": 2 * iterations, "maxcor": _MEMORY, "ftol": 1e-8, "gtol": 1e-6},
    )
    return np.asarray(answer.x), int(answer.nfev)


def _rank(score: Score) -> tuple[float, float]:
    """Feasible motions by their value, the others after them by what they miss."""
    return (0.0, score.value) if score.feasible else (score.max_violation, score.value)
