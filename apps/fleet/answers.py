"""From an answer to its passport, and from the passport alone to the answer again."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import singledispatch
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.versions import versions
from ...estimation.answers.identification import Identification, identified
from ...estimation.answers.payload import answer_payload
from ...estimation.answers.payload_answer import PayloadAnswer
from ...estimation.fit.estimate import Estimate, error_model, fit
from ...estimation.payload.problem import PayloadProblem
from .passport import Log, Passport, PayloadPassport, Recipe, RobotPassport

TINY = np.finfo(float).tiny ** 0.25
"""No standard deviation of anything measured is smaller."""


def robot_passport(
    result: Identification, recipe: Recipe, logs: Sequence[Log], about: Mapping[str, str] | None = None
) -> RobotPassport:
    """The passport of a robot's identified parameters; ``about``: what else is known of the recordings."""
    return RobotPassport(
        robot=result.robot,
        base=result.base,
        recipe=recipe,
        logs=tuple(logs),
        versions=versions(),
        about=dict(about or {}),
        equations=result.problem,
        sampled=result.beside._replace(held_out=result.unseen),
    )


def payload_passport(
    answer: PayloadAnswer, others: Sequence[PayloadProblem], recipe: Recipe, logs: Sequence[Log]
) -> PayloadPassport:
    """The passport of a payload; ``others``: other ways to it, of a short motion."""
    return PayloadPassport(
        robot=answer.problem.robot,
        base=answer.problem.base,
        recipe=recipe,
        logs=tuple(logs),
        versions=versions(),
        problem=_without_samples(answer.problem),
        others=tuple(map(_without_samples, others)),
        sampled=answer.sampled,
    )


def _without_samples(problem: PayloadProblem) -> PayloadProblem:
    return replace(problem, source=None, pairs=(), compared=())


@singledispatch
def answered(passport: Passport) -> Identification | PayloadAnswer:
    """The answer by a passport alone, with its verdict.

    Raises:
        InputError: if its equations do not determine it.
    """
    raise InputError(f"a passport of kind {type(passport).__name__} holds no answer")


@answered.register
def _(passport: RobotPassport) -> Identification:
    recipe, sampled = passport.recipe, passport.sampled
    result = identified(passport.robot, passport.base, passport.equations, recipe.essential, recipe.gains)
    unseen = sampled.held_out
    return replace(
        result,
        validation=fit(unseen, result.estimate.values) if unseen is not None else None,
        processing=recipe.processing,
        unseen=unseen,
        known_beside=sampled,
    )


@answered.register
def _(passport: PayloadPassport) -> PayloadAnswer:
    recipe = passport.recipe
    return answer_payload(
        passport.problem,
        recipe.methods,
        recipe.free_friction,
        processing=recipe.processing,
        constraints=recipe.constraints,
        gains=recipe.gains,
        essential=recipe.essential,
        stand_in=recipe.stand_in,
        others=passport.others,
        known=passport.sampled,
    )


def free_estimate(answer: Identification | PayloadAnswer) -> Estimate:
    """The free estimate to compare with others of one arm: without the drive gains' errors, which all share."""
    own = answer.estimate if isinstance(answer, Identification) else answer.free.estimate
    ratio = compared_sigma(own, own.sigma_robust) / np.maximum(own.sigma, TINY)
    return replace(own, covariance=own.covariance * np.outer(ratio, ratio), robust=None, gain_covariance=None)


def compared_sigma(estimate: Estimate, robust: Array | None) -> Array:
    """Standard deviations to compare recordings by, shape (c,), with the formula's degrees of freedom.

    From a dozen blocks the jackknife knows no single standard deviation well, but well by how much they are larger
    than the formula's on the whole. The larger of its own and of the formula's, so scaled, is taken.

    Args:
        estimate: with the formula's.
        robust: the jackknife's, shape (c,); None without.
    """
    if robust is None:
        return estimate.sigma
    excess = float(np.sqrt(np.mean((robust / np.maximum(estimate.sigma, TINY)) ** 2)))
    return np.asarray(np.maximum(robust, max(1.0, excess) * estimate.sigma))


class Shown(NamedTuple):
    """A number of an answer with its 95 % interval, SI units; nan where it is not determined."""

    name: str
    value: float
    low: float
    high: float


def numbers_of(answer: Identification | PayloadAnswer) -> tuple[Shown, ...]:
    """What an answer tells, with all of its errors, those of the drive gains among them."""
    if isinstance(answer, Identification):
        model = error_model(answer.estimate)
        columns = zip(answer.base.names, model.values.tolist(), model.interval95.tolist(), strict=True)
        return tuple(Shown(name, value, low, high) for name, value, (low, high) in columns)
    payload = answer.payload
    named = [("mass", payload.mass)]
    named += [(f"com {axis}", quantity) for axis, quantity in payload.com._asdict().items()]
    named += [(f"inertia {entry}", quantity) for entry, quantity in payload.inertia._asdict().items()]
    return tuple(Shown(name, quantity.value, quantity.low, quantity.high) for name, quantity in named)
