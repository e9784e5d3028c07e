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
from ..motions.near import FreeNear
from ..motions.via_points import FreeViaPoints
from .criterion import ORDERS, STARTS
from .descent import FINE_WIDTH, WIDTH, Multipliers, Smooth, minimised
from .full_trajectory import harder, kept_throughout
from .limits import LimitCheck
from .problem import DesignProblem
from .score import TOLERANCE, Learnt, Score, score_of

_MARGIN = 0.01  # of a limit, between samples; the settling adapts it
_ASTRAY = 0.1  # in the limits' units: what violates more after the first look seldom comes back
_STIFFNESS = 10.0  # of the augmented Lagrangian; values are of the order of 1
_NEARER = 60  # iterations towards the limits
_OF = 3  # starts, one is improved to the end of the first stage
_SMALL = 400  # numbers whose curvature is kept as a matrix
_ROOM = 5e-4  # of a limit: for what a motion does between the samples of the fine grid
_BEYOND = 0.2  # of a limit: what misses it by more is not mended by going slower
_EASES, _MORE = 14, 1.5  # each so many times as much as the last


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
        plan: the motion: ``ViaPoints``, ``Fourier`` or ``NearMotion``.
        score: its criterion, what it teaches, its limits; exact sign, fine grid.
        seed, starts: where the search began.
        evaluations: of criterion and gradient.
        cpu_s: processor time of the search [s].
        interrupted: whether it was stopped before its end.
        missed: limits that the whole run misses, between the samples of ``score`` and on the ways between poses.
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
        """The robot, how long the motion takes, and whether it keeps its limits, in a line."""
        words = "keeps every limit" if self.feasible else "does not keep every limit"
        return f"motion of {self.problem.robot.name}, {self.score.duration:.4g} s, {words}"

    def motion(self, rate: float) -> Motion:
        """Sample the motion at ``rate`` [Hz]."""
        return self.plan.motion(rate)

    @property
    def learnt(self) -> Learnt:
        """log det, both condition numbers and predicted standard deviations."""
        return self.score.learnt

    @property
    def feasible(self) -> bool:
        """Whether all limits are met; ``score.violations`` and ``missed`` name those that are not."""
        return self.score.feasible and not self.missed


def solve_design(
    problem: DesignProblem,
    *,
    seed: int = 0,
    starts: int | None = None,
    progress: Callable[[Step], None] = lambda step: None,
) -> Design:
    """Find the most informative motion.

    Several random starts are improved for a while, the best of them to the end; then the limits are checked on
    a grid ten times finer, and drawn in where the motion oversteps them between samples. At last the whole run is
    looked at, and the slow rehearsal where there is one: where they miss a torque limit, the motion is eased, or
    the search goes on from it below that limit, with the rehearsal's torques as limits too.
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
    starts = STARTS[problem.criterion.kind] if starts is None else starts
    search = _searched(problem, seed, starts, progress)
    outcome = kept_throughout(problem, *search.found)
    further = None if search.interrupted else harder(problem, outcome)
    if further is not None:
        evaluations, search = search.evaluations, _searched(further, seed, 1, progress, search.found[0])
        search.evaluations += evaluations
        x, score = search.found
        outcome = kept_throughout(problem, x, score.judged_by(problem))
    plan, cpu = problem.family.plan(outcome.x), time.process_time() - begun
    return Design(
        problem, plan, outcome.score, seed, starts, search.evaluations, cpu, search.interrupted, outcome.missed
    )


def _searched(
    problem: DesignProblem, seed: int, starts: int, progress: Callable[[Step], None], begin: Array | None = None
) -> "_Search":
    """A search that has come to its end, or was interrupted."""
    search = _Search(problem, np.random.default_rng(seed), progress, begin)
    try:
        search.run(starts)
    except KeyboardInterrupt:
        search.interrupted = True
    return search


class Effort(NamedTuple):
    """How long a search goes on.

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
"""Where each descent learns the curvature anew: many numbers, many minima, or a surrogate that changes."""


@dataclass
class _Search:
    """The best motion so far, and the way to better ones.

    Attributes:
        draw: random numbers of the starts.
        progress: called after each stage.
        begin: where another search ended; None for random starts.
        evaluations: of criterion and gradient.
        best: the motion and its score.
        interrupted: whether it was stopped before its end.
    """

    problem: DesignProblem
    draw: np.random.Generator
    progress: Callable[[Step], None]
    begin: Array | None = None
    evaluations: int = 0
    best: tuple[Array, Score] | None = None
    interrupted: bool = False

    @property
    def found(self) -> tuple[Array, Score]:
        """The best motion and its score; a random start if the search was interrupted before its first look."""
        if self.best is None:
            self.consider(self.random(), "random start")
        assert self.best is not None
        return self.best

    @cached_property
    def effort(self) -> Effort:
        """The effort with which motions of the problem's family come out best for the time it takes."""
        family = self.problem.family
        if family.size <= _SMALL and isinstance(family, FreeNear):
            return _NEAR
        if family.size <= _SMALL and isinstance(family, FreeViaPoints) and self.problem.criterion.weighted:
            return _VIA
        return _FRESH

    def run(self, starts: int) -> None:
        """Improve random starts for a while, the best of them to the end; then settle it within its limits.

        A search that goes on from another one's end has that start alone. One that does not come within its limits
        draws its last motion back.
        """
        course, effort = self._best_start(starts) if self.begin is None else self._begun(0), self.effort
        order = ORDERS[self.problem.criterion.kind][-1]
        last: float | None = None

        def gains(width: float, iterations: int, text: str) -> bool:
            """Improve; whether this motion or the last one misses a limit, or this one is clearly better."""
            nonlocal last
            score = self._improved(course, order, width, iterations, text)
            before, last = last, score.value if score.feasible else None
            return effort.gain is None or before is None or last is None or before - last > effort.gain

        for stage in range(effort.stages - 1):
            if not gains(WIDTH, effort.refined, f"refined {stage + 1}"):
                break
        gains(FINE_WIDTH, effort.refined, f"refined {effort.stages}")
        for turn in range(effort.turns):
            if course.limits.settle(self.problem, course.x):
                return
            if not gains(FINE_WIDTH, effort.settled, f"settled {turn + 1}"):
                return
        for x in (course.x, self.found[0]):
            self.consider(drawn_back(self.problem, x), "drawn back")

    def _best_start(self, starts: int) -> "_Course":
        """The most promising of some random starts, improved for a while.

        All are improved for half of that, the best third of them for the other half.
        """
        orders, first = ORDERS[self.problem.criterion.kind][:2], self.effort.first
        courses = [self._begun(k) for k in range(starts)]
        if len(orders) == 1 and starts == 1:
            self._improved(courses[0], *orders, WIDTH, first, "start 1 improved")
            return courses[0]
        for of, order in ((1, orders[0]), (_OF, orders[-1])):
            courses = courses[: -(-len(courses) // of)]
            for course in courses:
                self._improved(course, order, WIDTH, first // 2, f"start {course.number} improved")
            courses.sort(key=self._promise)
        return courses[0]

    def _begun(self, k: int) -> "_Course":
        x = self._brought_in(self.random())
        self.consider(x, f"start {k + 1}")
        limits = Multipliers(self.problem.limits, self.problem.state(x, WIDTH), _STIFFNESS, _MARGIN)
        return _Course(k + 1, x, limits)

    def _promise(self, course: "_Course") -> tuple[bool, float, int]:
        """Starts near their limits by their value; the first of equal ones."""
        merit, _ = self.problem.evaluate(course.x, ORDERS[self.problem.criterion.kind][-1], WIDTH, course.limits)
        astray = course.limits.violation(self.problem.state(course.x, WIDTH)) > _ASTRAY
        return astray, merit, course.number

    def random(self) -> Array:
        """A motion to start from: where another search ended, or a random one."""
        return self.problem.family.random(self.draw, self.problem.clear) if self.begin is None else self.begin

    def consider(self, x: Array, text: str) -> Score:
        """Judge a motion, made slower or smaller if that is enough to keep the limits; remember the best."""
        x, score = eased_within(self.problem, x)
        if self.best is None or _rank(score) < _rank(self.best[1]):
            self.best = (x, score)
        best = self.best[1]
        self.progress(Step(text, best.value if best.feasible else None, self.evaluations))
        return score

    def _improved(self, course: "_Course", order: float, width: float, iterations: int, text: str) -> Score:
        """Descend, update the multipliers where that ends, and judge the motion there."""
        function = partial(self.problem.evaluate, order=order, width=width, limits=course.limits)
        course.x, course.curvature = self._descended(function, course.x, iterations, course.curvature)
        course.limits.update(self.problem.state(course.x, width))
        return self.consider(course.x, text)

    def _brought_in(self, x: Array) -> Array:
        """A motion near x that keeps the limits at its samples, if there is one that a descent finds."""
        problem = self.problem
        for _ in range(3):
            limits = Multipliers(problem.limits, problem.state(x, WIDTH), 1.0, 2.0 * _MARGIN)
            if limits.violation(problem.state(x, WIDTH)) <= 0.0:
                break
            function = partial(problem.trespass, width=WIDTH, limits=limits)
            x, _ = self._descended(function, x, _NEARER)
        return x

    def _descended(
        self, function: Smooth, x: Array, iterations: int, curvature: Array | None = None
    ) -> tuple[Array, Array | None]:
        """Descend and count the evaluations."""

        def counted(y: Array) -> tuple[float, Array]:
            self.evaluations += 1
            return function(y)

        by_matrix = self.effort.by_matrix
        return minimised(counted, x, self.problem.family, iterations, by_matrix=by_matrix, curvature=curvature)


@dataclass
class _Course:
    """A random start on its way to a good motion.

    Attributes:
        number: of the start, from 1.
        limits: multipliers of its limits.
        curvature: of the augmented Lagrangian where the last descent ended; None where it is not known.
    """

    number: int
    x: Array
    limits: Multipliers
    curvature: Array | None = None


def _rank(score: Score) -> tuple[float, float]:
    """Feasible motions by their value, the others after them by what they miss."""
    return (0.0, score.value) if score.feasible else (score.max_violation, score.value)


def eased_within(problem: DesignProblem, x: Array) -> tuple[Array, Score]:
    """The motion made slower or smaller until there is room between fine samples too, if that helps; its score."""
    score = score_of(problem, x)
    if score.max_violation > _BEYOND:
        return x, score
    slower, smaller = _overstepped(score)
    if slower == 1.0 and smaller == 1.0:
        return x, score
    eased = problem.family.eased(x, slower, smaller)
    after = score_of(problem, eased)
    return (eased, after) if after.max_violation <= max(score.max_violation, TOLERANCE) else (x, score)


def drawn_back(problem: DesignProblem, x: Array) -> Array:
    """The motion slower and smaller by more and more until it keeps all limits; as it is where that never does."""
    slower, smaller = _overstepped(score_of(problem, x))
    for ease in range(_EASES):
        times = _MORE**ease
        eased = problem.family.eased(x, 1.0 + times * (slower - 1.0), smaller**times)
        if score_of(problem, eased).feasible:
            return eased
    return x


def _overstepped(score: Score) -> tuple[float, float]:
    """How many times slower and smaller a motion would have to be if all that it misses went with its size."""
    slower, smaller = 1.0, 1.0
    for limit in score.limits:
        if limit.room >= _ROOM:
            continue
        if limit.name == "position":
            smaller = min(smaller, 1.0 / (1.0 + _ROOM - limit.room))
        elif limit.name != "duration":
            slower = max(slower, 1.0 + _ROOM - limit.room)
    return slower, smaller
