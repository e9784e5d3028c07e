"""Robust covariance of a payload: the whole method solved again without each block of time."""

from collections.abc import Callable, Iterator
from dataclasses import replace

from ...model import InputError
from ...model.arrays import Array
from ..estimate import Estimate
from ..least_squares import weighted
from ..robust import RobustCovariance, jackknife
from .problem import FixedWeights, PayloadProblem

Method = Callable[[PayloadProblem, FixedWeights | None], Estimate]
"""A payload method; estimates its weights unless they are given."""


def robust_covariance(problem: PayloadProblem, method: Method, estimate: Estimate) -> RobustCovariance:
    """Covariance of a method's result by the delete-a-block jackknife, weights fixed at those of the result.

    A robot that was identified earlier (``known``, method 1) keeps the covariance it came with.

    Args:
        problem: with ``blocks``.
        method: the method.
        estimate: its result on the whole problem.

    Raises:
        InputError: if there are too few blocks, or the data without one do not determine the payload.
    """
    if problem.blocks is None:
        raise InputError("robust standard deviations need recordings in blocks of time")
    bare = problem.unloaded
    weights = FixedWeights(weighted(bare).weights if bare is not None else None, estimate.weights)

    def solve(part: PayloadProblem) -> Array:
        return method(part, weights).values

    robust = jackknife(solve, deletions(problem), estimate.values, problem.blocks.length)
    return replace(robust, covariance=robust.covariance + _robots_share(problem, method, estimate, weights))


def deletions(problem: PayloadProblem) -> list[Iterator[PayloadProblem]]:
    """The problem without each block; blocks that share no motion are left out one recording at a time."""
    blocks = problem.blocks
    assert blocks is not None
    loaded = (replace(problem, loaded=part) for part in blocks.loaded_without)
    if not blocks.unloaded:
        return [loaded]
    unloaded = (replace(problem, unloaded=part) for part in blocks.unloaded_without)
    if not blocks.difference:
        return [loaded, unloaded]
    both = zip(loaded, unloaded, blocks.difference_without, strict=True)
    return [(replace(a, unloaded=b.unloaded, difference=change) for a, b, change in both)]


def _robots_share(problem: PayloadProblem, method: Method, estimate: Estimate, weights: FixedWeights) -> Array:
    """Part of the formula's covariance that comes from a known robot's."""
    if problem.known is None:
        return 0.0 * estimate.covariance
    certain = replace(problem.known, covariance=0.0 * problem.known.covariance)
    return estimate.covariance - method(replace(problem, known=certain), weights).covariance
