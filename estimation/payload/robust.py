"""Robust covariance of a method's estimate: the jackknife, or with few blocks of time the sandwich."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from typing import Protocol

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ..fit.covariance import FEW, RobustCovariance, Rule, jackknife, naming_blocks
from ..fit.estimate import Estimate
from .long_motion import FORMULA_ONLY, LongMotion
from .short_motion import ShortMotion


class Posed(Protocol):
    """A problem of the payload that is solved for given weights of the joints."""

    def solved(self, weights: Array | None = None) -> Estimate:
        """Estimate the parameters asked for; weights are estimated unless they are given."""

    def without_blocks(self, weights: Array, pairs: Sequence[tuple[int, int]]) -> Array:
        """Estimate without blocks of time with and without payload, one row for each of ``left_out``."""

    def lasting(self, weights: Array) -> Array:
        """Between-session covariance, which no block of time shows."""

    def sandwich(self, weights: Array, inflation: Sequence[float]) -> Array:
        """HAC (sandwich) covariance: errors of each joint remember."""


def with_robust(
    problem: LongMotion | ShortMotion, posed: Posed, estimate: Estimate | None = None, rule: Rule | None = None
) -> tuple[Estimate, str]:
    """Add the robust covariance to the estimate of a posed problem; without, and why, where there is none.

    Args:
        estimate: its result, where it is there already; its weights are kept.
        rule: for the covariance; by default the jackknife where there are blocks enough, else the sandwich.
    """
    estimate = posed.solved() if estimate is None else estimate
    if rule == "formula":
        return estimate, ""
    if isinstance(problem, LongMotion) and not problem.loaded.blocks:
        known = problem.known  # of which no robust covariance is known, nothing was cut into blocks
        formula_only = problem.settings.robust and known is not None and known.robust is None
        return estimate, FORMULA_ONLY if formula_only else ""
    try:
        return replace(estimate, robust=_robust(problem, posed, estimate, rule)), ""
    except InputError as error:
        return estimate, str(error)


def _robust(
    problem: LongMotion | ShortMotion, posed: Posed, estimate: Estimate, rule: Rule | None
) -> RobustCovariance:
    """Compute by the rule asked for, weights fixed at those of the result."""
    weights, length, known, robust = estimate.weights, problem.block_length, problem.known, None
    if rule != "sandwich":
        try:
            groups = problem.left_out
            with naming_blocks(length):
                values = posed.without_blocks(weights, list(chain.from_iterable(groups)))
            ends = np.cumsum([len(group) for group in groups])[:-1]
            robust = jackknife(np.split(values, ends), estimate.values, length)
        except InputError:
            if rule == "jackknife" or isinstance(problem, ShortMotion) or not problem.inflation:
                raise
    blocks = robust.blocks if robust is not None else 0
    if robust is not None:
        few = isinstance(problem, LongMotion) and problem.few
        few = few or (problem.corrected and robust.degrees_of_freedom + 1 < FEW)
        lasting = posed.lasting(weights)  # what no block shows; none where the method does without anything known
        if lasting.any():
            # A robot that was identified earlier adds its own robust covariance, propagated: its blocks were left
            # out one at a time as well.
            own = known.robust if known is not None else None
            if known is not None and own is None and isinstance(problem, LongMotion):
                raise InputError(FORMULA_ONLY)
            robust = RobustCovariance(
                robust.covariance + lasting,
                blocks + (own.blocks if own else 0),
                min(robust.degrees_of_freedom, own.degrees_of_freedom) if own else robust.degrees_of_freedom,
                max(length, own.block_length) if own else length,
            )
        if rule == "jackknife" or not few:
            return robust
    # By how much each joint's errors remember; the jackknife's standard deviations count where they are larger.
    if not problem.inflation:
        raise InputError("a sandwich needs recordings in blocks of time: how long errors remember is not known")
    covariance = posed.sandwich(weights, problem.inflation)
    # Of a robot that the recordings correct a few seconds say next to nothing: its jackknife is left out.
    if robust is not None and not problem.corrected:
        wider = np.maximum(robust.sigma / np.sqrt(np.diag(covariance)), 1.0)
        covariance = covariance * np.outer(wider, wider)
    degrees = max(int(estimate.degrees_of_freedom), 1)
    return RobustCovariance(covariance, blocks, degrees, length, by_memory=True)
