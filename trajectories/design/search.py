"""The search for the most informative motion: descents on an augmented Lagrangian, from random starts."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.speech import Speaks
from ...model import Motion
from ..motions.family import Plan
from ..motions.fourier import FreeSeries, NearShape
from ..motions.via_points import FreeViaPoints
from .criterion import CRITERIA
from .descent import FINE_WIDTH, WIDTH, Lagrangian, Smooth, by_matrix, by_steps
from .full_trajectory import harder, kept_throughout
from .limits import LimitCheck
from .problem import DesignProblem
from .score import TOLERANCE, Learnt, Score, score_of, score_samples

_MARGIN = 0.01  # of a limit, between samples; the settling adapts it
_ASTRAY = 0.1  # in the limits' units: what violates more after the first look seldom comes back
_STIFFNESS = 10.0  # of the augmented Lagrangian; values are of the order of 1
_NEARER = 60  # iterations towards the limits
_OF = 3  # starts, one is improved to the end of the first stage
_SMALL = 400  # numbers whose curvature is kept as a matrix
_ROOM = 5e-4  # of a limit: for what a motion does between the samples of the fine grid
_BEYOND = 0.2  # of a limit: what misses it by more is not mended by going slower
_EASES, _MORE = 14, 1.5  # each so many times as much as the last


Progress = Callable[[str, float | None, int], None]
"""Function called after each stage: what was done, the criterion of the best motion so far that keeps all limits
(None before there is one), and evaluations of criterion and gradient."""


@dataclass(frozen=True, eq=False, repr=False)
class Design(Speaks):
    """The most informative motion that was found.

    Attributes:
        plan: the motion: ``ViaPoints``, ``Fourier`` or ``NearMotion``.
        score: its criterion, what it teaches, its limits; exact sign, fine grid.
        seed, starts: where the search began.
        evaluations: of criterion and gradient.
        cpu_s: processor time of the search [s].
        interrupted: whether it was stopped before its end.
        missed: limits that the full trajectory misses, between samples of ``score`` and on ways between poses.
    """

    problem: DesignProblem
    plan: Plan
    score: Score
    seed: int
    starts: int
    evaluations: int
    cpu_s: float
    interrupted: bool = False
    missed: tuple[LimitCheck, ...] = ()

    @property
    def headline(self) -> str:
        """State robot, duration of the motion, and whether it keeps its limits, in a line."""
        kept = "keeps every limit" if self.feasible else "does not keep every limit"
        return f"motion of {self.problem.robot.name}, {self.score.duration:.4g} s, {kept}"

    def motion(self, rate: float) -> Motion:
        """Sample the motion at ``rate`` [Hz]."""
        return self.plan.motion(rate)

    @property
    def learnt(self) -> Learnt:
        """Information of the motion: log det, both condition numbers and predicted standard deviations."""
        return self.score.learnt

    @property
    def feasible(self) -> bool:
        """True if all limits are met; ``score.violations`` and ``missed`` name those that are not."""
        return self.score.feasible and not self.missed


def solve_design(
    problem: DesignProblem,
    *,
    seed: int = 0,
    starts: int | None = None,
    progress: Progress = lambda text, best, evaluations: None,
) -> Design:
    """Find the most informative motion.

    Several random starts are improved for a while, the best of them to the end; then the limits are checked on
    a grid ten times finer, and drawn in where the motion oversteps them between samples. At last the full
    trajectory is looked at, and the slow rehearsal where there is one: where they miss a torque limit, the motion
    is eased, or the search goes on from it below that limit, with the rehearsal's torques as limits too.
    Ctrl-C ends the search with the best motion so far.

    Args:
        problem: made by ``build_design``.
        seed: of the random starts; the same seed gives the same motion.
        starts: number of random starts; None for 6 by "d" and "a", 3 by condition numbers.

    Returns:
        The motion with its score. If the limits cannot be met, the motion that misses them least, with
        ``feasible`` False and the violations named in ``score.violations``.
    """
    begun = time.process_time()
    starts = CRITERIA[problem.criterion.kind].starts if starts is None else starts
    search = _Search(problem, np.random.default_rng(seed), progress)
    search.run(starts)
    x, score, missed = kept_throughout(problem, *search.found)
    further = None if search.interrupted else harder(problem, missed)
    if further is not None:
        search = _Search(further, np.random.default_rng(seed), progress, search.found[0], search.evaluations)
        search.run(1)
        x, score = search.found
        x, score, missed = kept_throughout(problem, x, score_samples(problem, score.samples))
    plan, cpu, (run, rehearsal) = problem.family.plan(x), time.process_time() - begun, missed
    return Design(problem, plan, score, seed, starts, search.evaluations, cpu, search.interrupted, run + rehearsal)


class Effort(NamedTuple):
    """Effort of a search: when it ends.

    Attributes:
        first: iterations from a start, shared by the surrogate's orders.
        refined: iterations of each stage after that.
        settled: iterations of each turn of settling.
        stages: of refinement; the last has the fine sign.
        turns: of settling at most.
        by_matrix: whether descents go on from the curvature that the last one has learnt, kept as a matrix.
        gain: of the criterion, a stage that gains less is the last of its kind; None where a better may follow.
    """

    first: int
    refined: int
    settled: int
    stages: int
    turns: int
    by_matrix: bool
    gain: float | None = None


_NEAR, _VIA = Effort(150, 50, 40, 3, 8, True, 2e-3), Effort(100, 100, 50, 2, 14, True)
_FRESH = Effort(160, 150, 60, 4, 8, False)
"""Effort where each descent learns the curvature anew: many numbers, many minima, or a changing surrogate."""


@dataclass
class _Search:
    """Search from one begin: the best motion so far and its score, and the way to better ones."""

    problem: DesignProblem
    draw: np.random.Generator
    progress: Progress
    begin: Array | None = None
    evaluations: int = 0
    best: tuple[Array, Score] | None = None
    interrupted: bool = False

    @property
    def found(self) -> tuple[Array, Score]:
        """Best motion and its score; a random start if the search was interrupted before its first look."""
        if self.best is None:
            self.consider(self._first(), "random start")
        assert self.best is not None
        return self.best

    @cached_property
    def effort(self) -> Effort:
        """Effort with which motions of the problem's family come out best for the time it takes."""
        family = self.problem.family
        if family.size <= _SMALL and isinstance(family, FreeSeries) and isinstance(family.shape, NearShape):
            return _NEAR
        if family.size <= _SMALL and isinstance(family, FreeViaPoints) and self.problem.criterion.weighted:
            return _VIA
        return _FRESH

    def run(self, starts: int) -> None:
        """Improve random starts for a while, the best of them to the end, unless it is interrupted.

        A search that goes on from another one's end has only that start.
        """
        try:
            self._finish(self._best_start(starts) if self.begin is None else self._begun(1))
        except KeyboardInterrupt:
            self.interrupted = True

    def _finish(self, course: Lagrangian) -> None:
        """Refine a start, then settle it within its limits; where it does not come within them, draw it back."""
        effort, order = self.effort, CRITERIA[self.problem.criterion.kind].orders[-1]
        last: float | None = None

        def gains(width: float, iterations: int, text: str) -> bool:
            """Improve; true if this motion or the last one misses a limit, or this one is clearly better."""
            nonlocal last
            score = self._improved(course, order, width, iterations, text)
            before, last = last, score.value if score.feasible else None
            return effort.gain is None or before is None or last is None or before - last > effort.gain

        for stage in range(effort.stages - 1):
            if not gains(WIDTH, effort.refined, f"refined {stage + 1}"):
                break
        gains(FINE_WIDTH, effort.refined, f"refined {effort.stages}")
        for turn in range(effort.turns):
            if course.settle():
                return
            if not gains(FINE_WIDTH, effort.settled, f"settled {turn + 1}"):
                return
        for x in (course.x, self.found[0]):
            self.consider(drawn_back(self.problem, x), "drawn back")

    def _best_start(self, starts: int) -> Lagrangian:
        """Find the most promising of some random starts, improved for a while.

        All are improved for half of that, the best third of them for the other half.
        """
        orders, first = CRITERIA[self.problem.criterion.kind].orders[:2], self.effort.first
        courses = [(number, self._begun(number)) for number in range(1, starts + 1)]
        if len(orders) == 1 and starts == 1:
            self._improved(courses[0][1], *orders, WIDTH, first, "start 1 improved")
            return courses[0][1]

        def promise(start: tuple[int, Lagrangian]) -> tuple[bool, float, int]:
            """Rank starts near their limits first, by their value; the first of equal ones."""
            number, course = start
            merit, _ = self.problem.evaluate(course.x, last, WIDTH, course)
            return course.violation(self.problem.state(course.x, WIDTH)) > _ASTRAY, merit, number

        last = CRITERIA[self.problem.criterion.kind].orders[-1]
        for of, order in ((1, orders[0]), (_OF, orders[-1])):
            courses = courses[: -(-len(courses) // of)]
            for number, course in courses:
                self._improved(course, order, WIDTH, first // 2, f"start {number} improved")
            courses.sort(key=promise)
        return courses[0][1]

    def _first(self) -> Array:
        """Start where another search ended, or at a random motion."""
        return self.problem.family.random(self.draw, self.problem.clear) if self.begin is None else self.begin

    def _begun(self, number: int) -> Lagrangian:
        """Bring a start within the limits at its samples, if a descent finds the way."""
        problem, x = self.problem, self._first()
        for _ in range(3):
            limits = Lagrangian(problem, x, 1.0, 2.0 * _MARGIN)
            if limits.violation(problem.state(x, WIDTH)) <= 0.0:
                break
            x, _ = self._descended(partial(problem.trespass, width=WIDTH, limits=limits), x, _NEARER)
        self.consider(x, f"start {number}")
        return Lagrangian(problem, x, _STIFFNESS, _MARGIN)

    def consider(self, x: Array, text: str) -> Score:
        """Judge a motion, slower or smaller where that makes room between fine samples too; remember the best."""

        def rank(score: Score) -> tuple[float, float]:
            return (0.0 if score.feasible else score.max_violation), score.value

        score = score_of(self.problem, x)
        slower, smaller = _overstepped(score)
        if score.max_violation <= _BEYOND and (slower > 1.0 or smaller < 1.0):
            eased = self.problem.family.eased(x, slower, smaller)
            after = score_of(self.problem, eased)
            if after.max_violation <= max(score.max_violation, TOLERANCE):
                x, score = eased, after
        if self.best is None or rank(score) < rank(self.best[1]):
            self.best = (x, score)
        best = self.best[1]
        self.progress(text, best.value if best.feasible else None, self.evaluations)
        return score

    def _improved(self, course: Lagrangian, order: float, width: float, iterations: int, text: str) -> Score:
        """Descend, update the multipliers where that ends, and judge the motion there."""
        function = partial(self.problem.evaluate, order=order, width=width, limits=course)
        course.x, course.curvature = self._descended(function, course.x, iterations, course.curvature)
        course.update(width)
        return self.consider(course.x, text)

    def _descended(
        self, function: Smooth, x: Array, iterations: int, curvature: Array | None = None
    ) -> tuple[Array, Array | None]:
        """Descend and count the evaluations."""

        def counted(y: Array) -> tuple[float, Array]:
            self.evaluations += 1
            return function(y)

        if self.effort.by_matrix:
            return by_matrix(counted, x, self.problem.family, iterations, curvature)
        return by_steps(counted, x, self.problem.family, iterations), None


def drawn_back(problem: DesignProblem, x: Array) -> Array:
    """Make the motion slower and smaller until it keeps all limits; as it is where that never does."""
    slower, smaller = _overstepped(score_of(problem, x))
    for ease in range(_EASES):
        times = _MORE**ease
        eased = problem.family.eased(x, 1.0 + times * (slower - 1.0), smaller**times)
        if score_of(problem, eased).feasible:
            return eased
    return x


def _overstepped(score: Score) -> tuple[float, float]:
    """Ratio by which a motion would have to be slower and smaller if all that it misses went with its size."""
    slower, smaller = 1.0, 1.0
    for limit in score.limits:
        if limit.room >= _ROOM:
            continue
        if limit.name == "position":
            smaller = min(smaller, 1.0 / (1.0 + _ROOM - limit.room))
        elif limit.name != "duration":
            slower = max(slower, 1.0 + _ROOM - limit.room)
    return slower, smaller
