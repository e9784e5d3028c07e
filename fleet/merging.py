"""Passports side by side: whether they say the same, what differs, and one of all of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain, combinations

import numpy as np

from ..common.arrays import Array
from ..common.errors import InputError
from ..estimation.diagnosis.evidence import Sampled
from ..estimation.diagnosis.nuisances import Tilt
from ..estimation.equations.equations import merged
from ..estimation.fit.estimate import Estimate
from ..estimation.fit.robust import student95
from ..estimation.payload.problem import PayloadProblem
from .answers import answered, free_estimate
from .passport import Passport, PayloadPassport, RobotPassport

CHANCE = 1e-3
"""Probability that two passports of one and the same thing are said to contradict each other."""


@dataclass(frozen=True)
class Difference:
    """What two estimates of the same parameters differ by.

    Attributes:
        names: of the parameters, c.
        change: second minus first, shape (c,).
        sigma: its standard deviations, shape (c,).
        degrees_of_freedom: of both together, the fewer.
    """

    names: tuple[str, ...]
    change: Array
    sigma: Array
    degrees_of_freedom: float

    @property
    def sigmas(self) -> Array:
        """Change in units of its standard deviation, shape (c,)."""
        return np.asarray(self.change / np.where(self.sigma > 0.0, self.sigma, np.inf))

    @property
    def bound(self) -> float:
        """Sigmas that no parameter exceeds but with probability ``CHANCE``, all of them together (Bonferroni)."""
        from scipy.special import stdtrit

        return float(stdtrit(max(self.degrees_of_freedom, 1.0), 1.0 - 0.5 * CHANCE / len(self.names)))

    @property
    def contradicting(self) -> tuple[str, ...]:
        """Parameters that differ beyond ``bound``, the worst first."""
        size = np.abs(self.sigmas)
        return tuple(self.names[k] for k in np.argsort(-size, kind="stable") if size[k] > self.bound)

    def words(self, name: str) -> str:
        """One parameter's change."""
        k = self.names.index(name)
        return f"{name} by {self.change[k]:+.3g} ± {self.sigma[k]:.2g} ({abs(self.sigmas[k]):.1f} sigma)"


def difference(first: Estimate, second: Estimate) -> Difference:
    """What two independent estimates of the same parameters differ by.

    Raises:
        InputError: if they are of different parameters.
    """
    if first.names != second.names:
        raise InputError("the passports show different parameters: nothing can be compared")
    degrees = min(first.degrees_of_freedom, second.degrees_of_freedom)
    return Difference(
        first.names, second.values - first.values, np.hypot(first.sigma, second.sigma), max(degrees, 1.0)
    )


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
    """Refuse what more than equations decide.

    Raises:
        InputError: says what.
    """
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
    """What the samples of several passports showed; of other ways to take them the one that does best."""
    rivals, parts = {}, [passport.sampled for passport in passports]
    for rival in sorted(chain.from_iterable(part.rivals for part in parts), key=lambda rival: rival.fall):
        rivals[rival.kind, rival.name] = rival
    held_out = [part.held_out for part in parts if part.held_out is not None]
    return Sampled(
        tuple(rivals[key] for key in sorted(rivals)),
        tuple(dict.fromkeys(chain.from_iterable(part.alignment for part in parts))),
        tuple(dict.fromkeys(chain.from_iterable(part.causes for part in parts))),
        merged(held_out) if held_out else None,
        tuple(dict.fromkeys(chain.from_iterable(part.zeros for part in parts))),
        _pooled([part.tilt for part in parts]),
        next((part.bursts for part in parts if part.bursts is not None), None),
        tuple(chain.from_iterable(part.nuisances for part in parts)),
        tuple(chain.from_iterable(part.scales for part in parts)),
        tuple(chain.from_iterable(part.pulls for part in parts)),
    )


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
    return {key: value for key, value in first.items() if all(other.get(key) == value for other in others)}


@dataclass(frozen=True)
class Compared:
    """Parameters by several recordings, one beside the other.

    Attributes:
        sources: names of the recordings, k.
        names: of the parameters, c.
        values: k x c.
        sigma: own standard deviations, k x c.
        pooled: values by all of them, weighted by their variances, shape (c,).
        pooled_sigma: standard deviations of those, with the scatter where it is more than they say, shape (c,).
        scatter: chi2 of the values about the pooled one over its degrees of freedom, shape (c,).
        degrees_of_freedom: the fewest of the recordings.
    """

    sources: tuple[str, ...]
    names: tuple[str, ...]
    values: Array
    sigma: Array
    pooled: Array
    pooled_sigma: Array
    scatter: Array
    degrees_of_freedom: float

    @property
    def interval95(self) -> Array:
        """95 % intervals of the pooled values, c x 2."""
        half = student95(self.degrees_of_freedom) * self.pooled_sigma
        return np.column_stack([self.pooled - half, self.pooled + half])

    @property
    def apart(self) -> Array:
        """Each recording's value less what all others say, in sigmas of the difference, k x c."""
        weights = 1.0 / self.sigma**2
        total, rest = weights.sum(axis=0), weights.sum(axis=0) - weights
        others = (total * (weights * self.values).sum(axis=0) / total - weights * self.values) / rest
        return np.asarray((self.values - others) / np.sqrt(self.sigma**2 + 1.0 / rest))

    @property
    def bound(self) -> float:
        """Sigmas that none exceeds but with probability ``CHANCE``, all together (Bonferroni)."""
        from scipy.special import stdtrit

        return float(stdtrit(max(self.degrees_of_freedom, 1.0), 1.0 - 0.5 * CHANCE / self.values.size))

    @property
    def odd(self) -> tuple[tuple[str, str, float], ...]:
        """Recordings that differ from the others beyond ``bound``: recording, parameter, sigmas; the worst first.

        Of each parameter the worst one: what it pulls along is not told.
        """
        apart = self.apart
        worst = [(int(np.argmax(np.abs(apart[:, c]))), c) for c in range(len(self.names))]
        far = [(self.sources[k], self.names[c], float(apart[k, c])) for k, c in worst]
        return tuple(sorted((one for one in far if abs(one[2]) > self.bound), key=lambda one: -abs(one[2])))


def compared(passports: Sequence[Passport]) -> Compared:
    """Parameters by several passports, side by side.

    Raises:
        InputError: if they are of other robots or recipes, or there are fewer than two.
    """
    if len(passports) < 2:
        raise InputError("one recording: give two or more to compare")
    for other in passports[1:]:
        passports[0].check_alike(other)
    estimates = [free_estimate(answered(passport)) for passport in passports]
    return side_by_side([passport.name for passport in passports], estimates)


def side_by_side(sources: Sequence[str], estimates: Sequence[Estimate]) -> Compared:
    """Independent estimates of the same parameters, and what they say together.

    Raises:
        InputError: if they are of different parameters.
    """
    first = estimates[0]
    if any(estimate.names != first.names for estimate in estimates):
        raise InputError("the recordings show different parameters: nothing can be compared")
    values = np.array([estimate.values for estimate in estimates])
    sigma = np.maximum(np.array([estimate.sigma for estimate in estimates]), np.finfo(float).tiny ** 0.25)
    weights = 1.0 / sigma**2
    pooled_values = (weights * values).sum(axis=0) / weights.sum(axis=0)
    scatter = (weights * (values - pooled_values) ** 2).sum(axis=0) / (len(values) - 1)
    wide = np.sqrt(np.maximum(scatter, 1.0) / weights.sum(axis=0))
    degrees = min(estimate.degrees_of_freedom for estimate in estimates)
    return Compared(tuple(sources), first.names, values, sigma, pooled_values, wide, scatter, degrees)
