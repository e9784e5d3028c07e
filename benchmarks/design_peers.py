"""Random search and CMA-ES on a design problem, with the same compiled criterion as the gradient's way."""

import time

import cma
import numpy as np
from dynident.common.arrays import Array
from dynident.trajectories import DesignProblem
from dynident.trajectories.design.criterion import Criterion
from dynident.trajectories.design.limits import excess
from dynident.trajectories.motions.via_points import FreeViaPoints

_WIDTH = 0.01  # rad/s: of the smoothed sign
_ORDER = 200.0  # of the surrogate: as good as exact
_FINER = 4  # grid of the random motions' check


def largest(problem: DesignProblem, x: Array) -> Array | None:
    """The motion stretched as far as the limits allow; None if it keeps them at no scale."""
    family = problem.family
    stretches = isinstance(family, FreeViaPoints) and family.free_duration
    for scale in np.geomspace(4.0, 0.1, 60):
        y = family.eased(x, 1.0 / scale, 1.0) if stretches else family.eased(x, 1.0, scale)
        if _violation(problem, y, _FINER) <= 1e-9:
            return y
    return None


def random_search(problem: DesignProblem, seconds: float, seed: int) -> float:
    """Best value among random feasible motions within some CPU time."""
    draw, best, end = np.random.default_rng(seed), np.inf, time.process_time() + seconds
    while time.process_time() < end:
        x = largest(problem, problem.family.random(draw))
        if x is not None:
            best = min(best, _value(problem, x))
    return best


def cma_es(problem: DesignProblem, seconds: float, seed: int) -> float:
    """Best feasible value that CMA-ES finds within some CPU time; violations are penalised (exact penalty)."""
    family, end = problem.family, time.process_time() + seconds
    start = largest(problem, family.random(np.random.default_rng(seed)))
    assert start is not None
    best = _value(problem, start)
    options = {"seed": seed + 1, "verbose": -9, "bounds": [family.low, family.high], "tolfun": 0.0, "tolx": 0.0}
    search = cma.CMAEvolutionStrategy(start, 0.1, options)
    while time.process_time() < end:
        candidates, costs = search.ask(), []
        for x in candidates:
            missed, value = _violation(problem, x, 1), _value(problem, x)
            if missed <= 0.0:
                best = min(best, value)
            costs.append(value + 10.0 * max(missed, 0.0))
        search.tell(candidates, costs)
    return best


def _value(problem: DesignProblem, x: Array) -> float:
    state = problem.state(x, _WIDTH)
    own = np.ix_(problem.places, problem.places)
    weights = problem.row_weights(state.samples, problem.criterion.weighted)
    criterion: Criterion = problem.criterion
    return criterion(problem.kernel.gram(state.entries, weights)[own], _ORDER)[0]


def _violation(problem: DesignProblem, x: Array, finer: int) -> float:
    state = problem.state(x, 0.0, finer)
    return max(float(excess(limit, limit.values(state)).max()) for limit in problem.limits)
