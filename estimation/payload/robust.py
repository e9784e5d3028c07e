"""Robust covariance of a payload: the whole method solved again without each block of time."""

from collections.abc import Callable, Iterator
from dataclasses import replace

from ...common.arrays import Array
from ...common.errors import InputError
from ..fit.estimate import Estimate
from ..fit.least_squares import weighted
from ..fit.robust import RobustCovariance, jackknife
from .problem import FORMULA_ONLY, FixedWeights, PayloadProblem

Method = Callable[[PayloadProblem, FixedWeights | None], Estimate]
"""A payload method; estimates its weights unless they are given."""


def robust_covariance(problem: PayloadProblem, method: Method, estimate: Estimate) -> RobustCovariance:
    """Covariance of a method's result by the delete-a-block jackknife, weights fixed at those of the result.

    A robot that was identified earlier (``known``, method 1) adds its own robust covariance, propagated.

    Args:
        problem: with ``blocks``.
        method: the method.
        estimate: its result on the whole problem.

    Raises:
        InputError: if there are too few blocks, the data without one do not determine the payload, or the robot
            known earlier came without robust covariance.
    """
    if problem.blocks is None:
        raise InputError("robust standard deviations need recordings in blocks of time")
    bare = problem.unloaded
    weights = FixedWeights(weighted(bare).weights if bare is not None else None, estimate.weights)

    def solve(part: PayloadProblem) -> Array:
        return method(part, weights).values

    robust = jackknife(solve, deletions(problem), estimate.values, problem.blocks.length)
    return _with_robots_share(robust, problem, method, weights)


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


def with_robust(problem: PayloadProblem, method: Method, estimate: Estimate) -> tuple[Estimate, str]:
    """A method's result with its robust covariance; as it was, and why, where there is none."""
    if problem.blocks is None:
        return estimate, problem.without_blocks
    try:
        return replace(estimate, robust=robust_covariance(problem, method, estimate)), ""
    except InputError as error:
        return estimate, str(error)


def _with_robots_share(
    robust: RobustCovariance, problem: PayloadProblem, method: Method, weights: FixedWeights
) -> RobustCovariance:
    """The same with what a method owes to a robot known earlier, whose blocks left one at a time as well."""
    known = problem.known
    if known is None:
        return robust
    of_robot = known.robust.covariance if known.robust is not None else known.covariance

    def covariance(C: Array) -> Array:
        return method(replace(problem, known=replace(known, covariance=C, robust=None)), weights).covariance

    share = covariance(of_robot) - covariance(0.0 * of_robot)
    if not share.any():
        return robust  # the method does without
    if known.robust is None:
        raise InputError(FORMULA_ONLY)
    return RobustCovariance(
        robust.covariance + share,
        robust.blocks + known.robust.blocks,
        min(robust.degrees_of_freedom, known.robust.degrees_of_freedom),
        max(robust.block_length, known.robust.block_length),
    )
