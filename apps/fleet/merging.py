"""One passport of several: what they show together."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain, combinations

import numpy as np

from ...common.errors import InputError
from ...estimation.diagnosis.evidence import Sampled
from ...estimation.diagnosis.nuisances import Tilt
from ...estimation.diagnosis.rivals import Rival
from ...estimation.equations.equations import Equations, merged
from ...estimation.payload.problem import PayloadProblem
from .answers import answered, free_estimate
from .comparing import difference
from .passport import Passport, PayloadPassport, RobotPassport


def merged_passports(passports: Sequence[Passport]) -> Passport:
    """One passport of all logs of several.

    Raises:
        InputError: if they are of other robots or recipes, hold a recording twice, cannot be merged, or contradict
            each other: the parameters are named.
    """
    if len(passports) < 2:
        raise InputError("one passport: give two or more to merge")
    for first, second in combinations(passports, 2):
        first.check_alike(second)
    estimates = [free_estimate(answered(passport)) for passport in passports]
    for (a, first_one), (b, second_one) in combinations(enumerate(estimates), 2):
        apart = difference(first_one, second_one)
        if apart.contradicting:
            named = "; ".join(map(apart.words, apart.contradicting[:6]))
            raise InputError(
                f"{passports[a].name} and {passports[b].name} contradict each other: {named}: look at both with "
                "'dynident passport compare'"
            )
    return pooled(passports)


def pooled(passports: Sequence[Passport]) -> Passport:
    """One passport of all logs, whatever they say; they are alike.

    Raises:
        InputError: if passports of this kind hold too little for it.
    """
    logs = tuple(dict.fromkeys(chain.from_iterable(passport.logs for passport in passports)))
    first, about = passports[0], _common([dict(passport.about) for passport in passports])
    if isinstance(first, RobotPassport):
        robots = [passport for passport in passports if isinstance(passport, RobotPassport)]
        equations = merged(passport.equations for passport in robots)
        return replace(first, logs=logs, about=about, equations=equations, sampled=_together(robots))
    assert isinstance(first, PayloadPassport)
    payloads = [passport for passport in passports if isinstance(passport, PayloadPassport)]
    problem = _one_problem([passport.problem for passport in payloads])
    return replace(first, logs=logs, about=about, problem=problem, sampled=_together(payloads))


def _one_problem(problems: Sequence[PayloadProblem]) -> PayloadProblem:
    """The equations of several payload problems together; raises InputError as ``_check_by_equations``."""
    first = problems[0]
    _check_by_equations(problems)
    bare = [problem.unloaded for problem in problems if problem.unloaded is not None]
    differences = [problem.difference for problem in problems if problem.difference is not None]
    reasons = sorted({problem.without_difference for problem in problems})
    return replace(
        first,
        loaded=merged(problem.loaded for problem in problems),
        unloaded=merged(bare) if bare else None,
        difference=merged(differences) if len(differences) == len(problems) else None,
        without_difference=reasons[-1],
        stretches=tuple(chain.from_iterable(problem.stretches for problem in problems)),
        inflation=_memory(problems) if first.inflation else (),
        few=all(problem.few for problem in problems),
    )


def _check_by_equations(problems: Sequence[PayloadProblem]) -> None:
    """Refuse what more than equations decide."""
    if any(problem.short is not None or problem.scale is not None for problem in problems):
        raise InputError(
            "weighings, and payloads with --scale-sigma, do not merge by their equations: give all logs to one run"
        )
    if len({problem.known is None for problem in problems}) > 1:
        raise InputError("one passport rests on a stored robot, another does not: they do not merge")


def _memory(problems: Sequence[PayloadProblem]) -> tuple[float, ...]:
    """By how much the memory of each joint's errors raises variances: the mean over all rows."""
    rows = np.array([problem.loaded.rows for problem in problems])
    memory = np.array([problem.inflation for problem in problems])
    return tuple((memory * rows / np.maximum(rows.sum(axis=0), 1)).sum(axis=0).tolist())


def _together(passports: Sequence[RobotPassport | PayloadPassport]) -> Sampled:
    """What the samples of several passports showed."""
    parts = [passport.sampled for passport in passports]
    return Sampled(
        _best_rivals(parts),
        tuple(dict.fromkeys(chain.from_iterable(part.alignment for part in parts))),
        tuple(dict.fromkeys(chain.from_iterable(part.causes for part in parts))),
        _all_held_out(parts),
        tuple(dict.fromkeys(chain.from_iterable(part.zeros for part in parts))),
        _pooled([part.tilt for part in parts]),
        next((part.bursts for part in parts if part.bursts is not None), None),
        tuple(chain.from_iterable(part.nuisances for part in parts)),
        tuple(chain.from_iterable(part.scales for part in parts)),
        tuple(chain.from_iterable(part.pulls for part in parts)),
    )


def _best_rivals(parts: Sequence[Sampled]) -> tuple[Rival, ...]:
    """Other ways to take the recordings, each as it does best, by kind and name."""
    rivals: dict[tuple[str, str], Rival] = {}
    for rival in sorted(chain.from_iterable(part.rivals for part in parts), key=lambda rival: rival.fall):
        rivals[rival.kind, rival.name] = rival
    return tuple(rivals[key] for key in sorted(rivals))


def _all_held_out(parts: Sequence[Sampled]) -> Equations | None:
    """Equations of all recordings that were held out, if any were."""
    held_out = [part.held_out for part in parts if part.held_out is not None]
    return merged(held_out) if held_out else None


def _pooled(tilts: Sequence[Tilt | None]) -> Tilt | None:
    """How far gravity leans by several recordings, each weighted by what it shows of that; none unless each does.

    A plain mean would let the one that shows least decide. The effects on the payload are weighted alike: exact for
    recordings of one motion, near enough for others.
    """
    shown = [tilt for tilt in tilts if tilt is not None]
    if not shown or len(shown) < len(tilts):
        return None
    weights = [np.linalg.inv(tilt.covariance) for tilt in shown]
    covariance = np.linalg.inv(sum(weights))
    shares = [weight @ covariance for weight in weights]  # add up to 1; values' are the transposed ones
    values = sum((share.T @ tilt.values for share, tilt in zip(shares, shown, strict=True)), np.zeros(2))
    by_four, by_three = (
        np.sum([tilt.effects[k] @ share for share, tilt in zip(shares, shown, strict=True)], axis=0) for k in (0, 1)
    )
    return Tilt(values, covariance, (by_four, by_three))


def _common(several: Sequence[dict[str, str]]) -> dict[str, str]:
    """What all say alike."""
    first, *others = several
    return {key: value for key, value in first.items() if all(entry.get(key) == value for entry in others)}
