"""The search for the most informative motion: descents on an augmented Lagrangian, from random starts.

The same descents estimate the floor under a criterion: how small it gets if a motion is in any state at any time.
A motion visits states (q, qd, qdd), and its information matrix is a weighted mean over them. The best weighted set
of states within the limits, continuity ignored, is an optimal experimental design; no motion is better.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from msgspec import field

from ...common import Array, Brief, Document, Float, Speaks, one_thread
from ...model import Motion
from ..motions.family import FreeStates, Plan, Samples
from ..motions.fourier import FreeSeries, NearShape
from ..motions.via_points import FreeRests, FreeViaPoints
from .descent import FINE_WIDTH, WIDTH, Lagrangian
from .limits import LimitCheck, excess
from .problem import DesignProblem
from .score import TOLERANCE, Learnt, Score, harder, kept_throughout, score_motion, score_of

_MARGIN, _FLOOR_MARGIN = 0.01, 1e-3  # of a limit, between samples; the settling adapts it
_ASTRAY = 0.1  # in the limits' units: what violates more after the first look seldom comes back
_STIFFNESS = 10.0  # of the augmented Lagrangian; values are of the order of 1
_NEARER = 60  # iterations towards the limits
_OF = 3  # starts, one is improved to the end of the first stage
_SMALL = 400  # numbers whose curvature is kept as a matrix
_ROOM = 5e-4  # of a limit: for what a motion does between the samples of the fine grid
_BEYOND = 0.2  # of a limit: what misses it by more is not mended by going slower
_EASES, _MORE = 14, 1.5  # each so many times as much as the last
_FLOOR_ITERATIONS = 200  # of a round
_BUDGET = 300.0  # s of processor time; usual searches take 2 to 60
_BEGINNING = 0.25  # of it: after that no further random start is begun


Progress = Callable[[str, float | None, int], None]
"""Function called after each stage: what was done, the criterion of the best motion so far that keeps all limits
(None before there is one), and evaluations of criterion and gradient."""


@dataclass(frozen=True, eq=False, repr=False)
class Design(Speaks, Brief):
    """The most informative motion that was found.

    Attributes:
        plan: the motion: ``ViaPoints`` or ``Fourier``.
        score: its criterion, what it teaches, its limits; exact sign, fine grid.
        seed, starts: where the search began; after a quarter of its time it begins at no further start.
        evaluations: of criterion and gradient.
        cpu_s: processor time of the search [s].
        interrupted: whether it was stopped before its end, by Ctrl-C or after 300 s of processor time.
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

    @cached_property
    def gap(self) -> float:
        """Distance to the floor under any motion, as in ``Floor.gap``; it takes about as long as the search."""
        return floor_under(self.problem, self.score.value).gap

    @property
    def feasible(self) -> bool:
        """True if all limits are met; ``score.violations`` and ``missed`` name those that are not."""
        return self.score.feasible and not self.missed


@one_thread()
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
    Ctrl-C, or 300 s of processor time, end the search with the best motion so far.

    Args:
        seed: of the random starts; the same seed gives the same motion.
        starts: number of random starts; None for 6 by "d" and "a", 3 by condition numbers.

    Returns:
        The motion with its score. If the limits cannot be met, the motion that misses them least, with
        ``feasible`` False and the violations named in ``score.violations``.
    """
    starts = problem.criterion.usual_starts if starts is None else starts
    search = _Search(problem, np.random.default_rng(seed), progress, time.process_time())
    found = search.run(starts)
    begun, (x, score, missed) = search.starts, kept_throughout(problem, found, score_of(problem, found))
    if not search.interrupted and (further := harder(problem, missed)) is not None:
        search = replace(search, problem=further, begin=found, best=None)
        found = search.run(1)
        x, score, missed = kept_throughout(problem, found, score_of(problem, found))
    cpu, stopped = time.process_time() - search.begun, search.interrupted or begun < starts
    plan, (run, rehearsal) = problem.family.plan(x), missed
    return Design(problem, plan, score, seed, begun, search.evaluations, cpu, stopped, run + rehearsal)


@dataclass
class _Search:
    problem: DesignProblem
    draw: np.random.Generator
    progress: Progress
    begun: float  # processor time then [s]
    begin: Array | None = None
    evaluations: int = 0
    starts: int = 0
    best: tuple[Array, Score] | None = None
    interrupted: bool = False
    # Effort where each descent learns the curvature anew: many numbers, many minima, or a changing surrogate.
    first: int = 160  # iterations from a start, shared by the surrogate's orders
    refined: int = 150  # iterations of each stage after that
    settled: int = 60  # iterations of each turn of settling
    stages: int = 4  # of refinement; the last has the fine sign
    turns: int = 8  # of settling at most
    by_matrix: bool = False  # whether descents go on from the curvature that the last one has learnt
    gain: float = -np.inf  # of the criterion: a stage that gains no more is the last of its kind

    def __post_init__(self) -> None:
        match self.problem.family:
            case family if family.size > _SMALL:
                pass
            case FreeRests() | FreeSeries(shape=NearShape()):
                self.first, self.refined, self.settled, self.stages = 150, 50, 40, 3
                self.by_matrix, self.gain = True, 2e-3
            case FreeViaPoints() if self.problem.criterion.weighted:
                self.first, self.refined, self.settled, self.stages = 100, 100, 50, 2
                self.by_matrix, self.turns = True, 14

    @property
    def found(self) -> Array:
        """Best motion; a random start if the search was interrupted before its first look."""
        return (self.best or self.consider(self._first(), "random start"))[0]

    def _first(self) -> Array:
        return self.problem.family.random(self.draw, self.problem.clear) if self.begin is None else self.begin

    def run(self, starts: int) -> Array:
        """Improve starts for a while; the best is refined and settled within limits, or made slower and smaller."""
        order, last = self.problem.criterion.orders[-1], np.nan

        def gains(width: float, iterations: int, text: str) -> bool:
            """Improve; true if this motion or the last one misses a limit, or this one is clearly better."""
            nonlocal last
            score = self._improved(course, order, width, iterations, text)
            before, last = last, score.value if score.feasible else np.nan
            return not before - last <= self.gain

        try:
            course = self._best_start(starts) if self.begin is None else self._begun(1)
            for stage in range(self.stages - 1):
                if not gains(WIDTH, self.refined, f"refined {stage + 1}"):
                    break
            gains(FINE_WIDTH, self.refined, f"refined {self.stages}")
            for turn in range(self.turns):
                if course.settle() or not gains(FINE_WIDTH, self.settled, f"settled {turn + 1}"):
                    return self.found
            for x in (course.x, self.found):
                slower, smaller = _overstepped(score_of(self.problem, x))
                steps = _MORE ** np.arange(_EASES)
                eased = (self.problem.family.eased(x, 1.0 + k * (slower - 1.0), smaller**k) for k in steps)
                self.consider(next((y for y in eased if score_of(self.problem, y).feasible), x), "drawn back")
        except (KeyboardInterrupt, TimeoutError):
            self.interrupted = True
        return self.found

    def _best_start(self, starts: int) -> Lagrangian:
        """Find the most promising of some random starts: all are improved, the best third of them further."""
        orders, first = self.problem.criterion.orders, self.first
        courses = [(1, self._begun(1))]
        while len(courses) < starts and time.process_time() < self.begun + _BEGINNING * _BUDGET:
            courses.append((len(courses) + 1, self._begun(len(courses) + 1)))
        if len(orders) == 1 and starts == 1:
            self._improved(courses[0][1], *orders, WIDTH, first, "start 1 improved")
            return courses[0][1]

        def promise(start: tuple[int, Lagrangian]) -> tuple[bool, float, int]:
            number, course = start
            criterion = partial(self.problem.criterion_term, order=orders[-1])
            merit, _ = self.problem.evaluate(course.x, WIDTH, [criterion, course])
            return course.violation(self.problem.state(course.x, WIDTH)) > _ASTRAY, merit, number

        for of, order in ((1, orders[0]), (_OF, orders[:2][-1])):
            courses = courses[: -(-len(courses) // of)]
            for number, course in courses:
                self._improved(course, order, WIDTH, first // 2, f"start {number} improved")
            courses.sort(key=promise)
        return courses[0][1]

    def _begun(self, number: int) -> Lagrangian:
        """Bring a start within the limits at its samples, if a descent finds the way."""
        problem, x = self.problem, self._first()
        self.starts = number
        for _ in range(3):
            limits = Lagrangian(problem, x, 1.0, 2.0 * _MARGIN)
            if limits.violation(problem.state(x, WIDTH)) <= 0.0:
                break
            limits.descend(WIDTH, _NEARER, self._counted, matrix=self.by_matrix)
            x = limits.x
        self.consider(x, f"start {number}")
        return Lagrangian(problem, x, _STIFFNESS, _MARGIN)

    def consider(self, x: Array, text: str) -> tuple[Array, Score]:
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
            self.best = x, score
        best = self.best[1]
        self.progress(text, best.value if best.feasible else None, self.evaluations)
        return x, score

    def _improved(self, course: Lagrangian, order: float, width: float, iterations: int, text: str) -> Score:
        criterion = partial(self.problem.criterion_term, order=order)
        course.descend(width, iterations, self._counted, criterion, matrix=self.by_matrix)
        course.update(width)
        return self.consider(course.x, text)[1]

    def _counted(self, state: Samples, into: Samples) -> float:
        """Count an evaluation, as a term that adds nothing."""
        self.evaluations += 1
        if time.process_time() > self.begun + _BUDGET:
            raise TimeoutError("the search has used up its time")
        return 0.0


def _overstepped(score: Score) -> tuple[float, float]:
    """Ratio by which a motion would have to be slower and smaller if all that it misses went with its size."""
    over = {limit.name: 1.0 + _ROOM - limit.room for limit in score.limits if limit.name != "duration"}
    larger = over.pop("position", 1.0)
    return max(1.0, *over.values()), 1.0 / max(1.0, larger)


class Floor(Document, frozen=True):
    """Least value of a criterion over weighted states within the limits, continuity ignored, between two estimates.

    Attributes:
        value: of the criterion, as in ``Score.value``, the least that was found.
        dual: what no design is below if no state tells more than the most telling one that was found; a search
            finds it, so that it is no proof. None for condition numbers, which are not convex.
        gap: value of the design less the dual, or less the least that was found where there is none: for condition
            numbers the log of their ratio; for "a" the log of the ratio of standard deviations; for "d" twice that,
            as a geometric mean over the parameters.
    """

    value: Float = field(name="criterion_value")
    gap: Float
    states: int
    dual: float | None = field(name="dual_value")


@one_thread()
def floor_under(
    problem: DesignProblem, reached: float, *, states: int = 0, seed: int = 0, effort: int = 3
) -> Floor:
    """Estimate the floor under any motion's criterion, all limits of single states kept.

    States and weights are optimised together from random ones: it is the least that was found.

    Args:
        reached: value of a motion's criterion, as in ``Score.value``.
        states: number of states; 0 for three for each parameter.
        effort: rounds of 200 iterations at the surrogate's last order.
    """
    count = states or 3 * len(problem.names)
    family: Any = FreeStates(problem.bounds, count)  # a family without plans
    free = replace(problem, family=family, limits=problem.of_kind("torque", "clearance"))
    course = Lagrangian(free, family.random(np.random.default_rng(seed), problem.clear), _STIFFNESS, _FLOOR_MARGIN)
    orders = problem.criterion.orders
    for order, width in [(p, WIDTH) for p in (*orders, *[orders[-1]] * effort)] + [(orders[-1], FINE_WIDTH)]:
        course.descend(width, _FLOOR_ITERATIONS, partial(free.criterion_term, order=order))
        course.update(width)
    value = score_motion(free, family.sample(course.x)).value
    if not problem.criterion.weighted:
        return Floor(value, reached - value, count, None)
    # The dual: C is convex in G and M its slope there, so that C(G') >= C(G) + tr M (G' - G), where G' is a mean
    # over states of I. It needs the one state where tr M I is least.
    exact = free.kernel.state(family.sample(course.x))
    G = free.information(exact.entries, free.row_weights(exact, True))
    convex, M = free.criterion(G)
    wide = np.zeros((len(free.kernel.columns),) * 2)
    wide[np.ix_(free.places, free.places)] = M

    def each(state: Samples, into: Samples) -> Array:
        """Evaluate tr M I of each state as if it were all, with slopes of the sum."""
        weights = free.row_weights(state, True) * state.weight.sum() / state.weight
        by_weight = free.kernel.gram_slope(state.entries, weights, wide, into.entries)
        return np.asarray((weights * by_weight).sum(axis=0))

    least = np.inf
    for start in (course.x, family.random(np.random.default_rng([seed, 1]), free.clear)):
        course = Lagrangian(free, start, _STIFFNESS, _FLOOR_MARGIN)
        for _ in range(2):
            course.descend(FINE_WIDTH, _FLOOR_ITERATIONS // 2, lambda state, into: float(each(state, into).sum()))
            course.update(FINE_WIDTH)
        state = free.kernel.state(family.sample(course.x))
        found = each(state, Samples(*map(np.zeros_like, state)))
        for limit in free.limits:
            found = np.where(excess(limit, limit.values(state)).max(axis=1) <= _FLOOR_MARGIN, found, np.inf)
        least = min(least, float(found.min()))
    dual = float(convex + np.trace(M @ (free.earlier.T @ free.earlier - G)) + least)
    return Floor(value, reached - dual, count, dual)
