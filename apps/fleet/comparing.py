"""Comparisons: recordings of one robot side by side, an arm's last night with those before, arms with their twins.

Of each recording of an arm friction, payload and drive scales are found while the rest is fixed from all of them. A
series is one such quantity of one arm, night by night. Its last night is compared with the median of the nights
before, by their median absolute deviation and the night's own error. This robust z does not move by a few changed
nights before.
"""

from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from ...common import Array, InputError
from ...common.schema import Document, Matrix, Vector
from ...estimation import PAYLOAD, Equations, Estimate, weighted
from ...estimation.equations.equations import merged
from ...estimation.fit.covariance import student95
from ...estimation.fit.linear_problem import LinearProblem
from ...estimation.payload.methods import jackknifed
from ...estimation.results.parts import Number
from ...model.drives import parameter_kind
from ...model.friction import is_friction
from ...model.regressors import payload_columns
from .reduction import Log, Stored

TINY = np.finfo(float).tiny ** 0.25  # no standard deviation of anything measured is smaller
CHANCE = 1e-3  # probability that recordings of one and the same thing are said to differ
MASS = "mass"  # the payload's mass less what the controller was told [kg], as a quantity of a night
FEWEST = 8  # nights before the last one that tell what is usual; of fewer a median absolute deviation says little
CHANGED = 5.0
"""z beyond which a change is told: a quiet series exceeds it once in 60 nights by 8 before, in 2,000 by 30."""
_MAD = 1.4826  # standard deviations a median absolute deviation is of
_RELATIVE = ("FS", "FV", "FSM", "FVM")  # kinds of parameters that are taken over their own median
_CLEARLY = 4.0  # sigmas: such a change of the mass is taken for one


class OddDocument(Document, frozen=True):
    """A recording that differs from all others in a parameter, in standard deviations of the difference."""

    recording: str
    parameter: str
    sigmas: float


class Compared(Document, frozen=True, eq=False):
    """Parameters by k recordings, one beside the other: k x c, of all recordings together c each.

    Attributes:
        pooled: by all recordings, weighted by their variances; its intervals are wider where the scatter is more
            than the sigmas say.
        scatter: chi2 of the values about the pooled one over its degrees of freedom.
        apart: each recording's value less what all others say, in sigmas of the difference.
        bound: sigmas that none exceeds but with probability ``CHANCE``, all together (Bonferroni).
        odd: recordings beyond it, the worst first; of each parameter the worst: what it pulls along is not told.
    """

    recordings: tuple[str, ...]
    parameters: tuple[str, ...]
    values: Matrix
    sigma: Matrix
    pooled: Vector
    pooled_interval95: Matrix
    scatter: Vector
    apart: Matrix
    bound: float
    odd: tuple[OddDocument, ...]


def side_by_side(recordings: Sequence[str], estimates: Sequence[Estimate]) -> Compared:
    """Compare independent estimates of the same parameters."""
    names, degrees = estimates[0].names, min(estimate.degrees_of_freedom for estimate in estimates)
    if any(estimate.names != names for estimate in estimates):
        raise InputError("the recordings show different parameters: nothing can be compared")
    values = np.array([estimate.values for estimate in estimates])
    sigma = np.maximum(np.array([estimate.sigma for estimate in estimates]), TINY)
    weights = sigma**-2.0
    total, others = weights.sum(axis=0), weights.sum(axis=0) - weights
    pooled = (weights * values).sum(axis=0) / total
    scatter = (weights * (values - pooled) ** 2).sum(axis=0) / (len(values) - 1)
    half = student95(degrees) * np.sqrt(np.maximum(scatter, 1.0) / total)
    by_others = (total * pooled - weights * values) / others
    apart = (values - by_others) / np.sqrt(sigma**2 + 1.0 / others)
    bound = float(stdtrit(max(degrees, 1.0), 1.0 - 0.5 * CHANCE / values.size))
    # Only the worst one is named, which may pull others along; of two, which lie equally far apart, the first.
    worst = [(k, c, float(apart[k, c])) for c, k in enumerate(np.argmax(np.round(np.abs(apart), 6), axis=0))]
    worst.sort(key=lambda each: -abs(each[2]))
    odd = tuple(OddDocument(recordings[k], names[c], z) for k, c, z in worst if abs(z) > bound)
    interval95 = np.column_stack([pooled - half, pooled + half])
    return Compared(tuple(recordings), names, values, sigma, pooled, interval95, scatter, apart, bound, odd)


def excess(estimate: Estimate, robust: Array | None) -> Array:
    """Ratio of the standard deviations that recordings are compared by to the formula's, shape (c,).

    From a dozen blocks the jackknife (``robust``) knows no single standard deviation well, but well how much larger
    than the formula's they are on the whole. The larger of its own and of the formula's, so scaled, is taken.
    """
    if robust is None:
        return np.ones(len(estimate.values))
    ratio = robust / np.maximum(estimate.sigma, TINY)
    return np.maximum(ratio, max(1.0, float(np.sqrt(np.mean(ratio**2)))))


def widened(estimate: Estimate, ratio: Array) -> Estimate:
    """An estimate of so many times the standard deviations, without errors of the gains: all share them."""
    C = estimate.covariance * np.outer(ratio, ratio)
    return replace(estimate, covariance=C, robust=None, gain_covariance=None)


class Drift(NamedTuple):
    """An arm's quantity over d nights."""

    days: tuple[str, ...]  # ISO dates or times, d
    changes: Array  # each night less what is usual, shape (d,)
    relative: bool  # changes are ratios to what is usual
    spread: float  # standard deviation of the last change where nothing changed: of the nights before, and its own


class Series(Document, frozen=True):
    """A quantity of an arm on its last night, and what the ``nights`` before say; ``working``: its ``Drift``.

    Attributes:
        quantity: a friction ("FS2"), ``MASS``, or "scale 2", by which share a drive's torque is larger than on the
            whole.
        sigma: the last night's own standard deviation.
        usual: the median of the nights before.
        z: the last change over the drift's ``spread``; null with fewer than ``FEWEST`` nights before.
    """

    arm: str
    quantity: str
    day: str
    value: Number
    sigma: Number
    usual: Number
    nights: int
    z: Number

    @staticmethod
    def of_nights(arm: str, quantity: str, days: tuple[str, ...], values: Array, sigma: Array) -> "Series":
        """Compare the last of d nights with those before."""
        before, relative = len(values) - 1, quantity[:5] not in (MASS, "scale")
        relative = relative and parameter_kind(quantity) in _RELATIVE
        usual = float(np.median(values[:-1] if before else values))
        size = max(abs(usual), 1e-12) if relative else 1.0
        changes = (values - usual) / size
        scatter = _MAD * float(np.median(np.abs(changes[:-1]))) if before else 0.0
        spread = max(float(np.hypot(scatter, sigma[-1] / size)), TINY)
        z = float(changes[-1]) / spread if before >= FEWEST else None
        last = Series(arm, quantity, days[-1], float(values[-1]), float(sigma[-1]), usual, before, z)
        return last.made_by(Drift(days, changes, relative, spread))


@dataclass(frozen=True)
class Arm:
    """An arm by all of its recordings."""

    name: str
    days: tuple[str, ...]  # of its nights, ISO
    told: tuple[float, ...]  # mass that the controller was told each night [kg]
    series: tuple[Series, ...]
    pooled: Estimate  # its base parameters by the nights with the payload it was told most often


class Fleet(Document, frozen=True):
    """Last nights of arms of one type, by name; ``working``: the arms, and their inertial parameters side by side.

    Attributes:
        changed: those of ``last`` with z beyond ``threshold``, the clearest first.
        odd: arms that differ from their twins; none of fewer than three.
    """

    arms: tuple[str, ...]
    first_day: str
    threshold: float
    changed: tuple[Series, ...]
    last: tuple[Series, ...]
    odd: tuple[OddDocument, ...]
    refused: tuple[Log, ...]


def fleet_of(arms: Sequence[Arm], refused: Sequence[Log] = ()) -> Fleet:
    """Compare each arm's last night with those before, and arms with each other; ``refused``: logs left out."""
    arms = sorted(arms, key=lambda arm: arm.name)
    names, last = tuple(arm.name for arm in arms), tuple(line for arm in arms for line in arm.series)
    # Friction and constant torques tell nothing of what an arm is made of.
    bodies = [arm.pooled.part([name for name in arm.pooled.names if not is_friction(name)]) for arm in arms]
    twins = side_by_side(names, bodies) if len(arms) >= 3 else None
    changed = tuple(line for line in sorted(last, key=farness, reverse=True) if farness(line) > CHANGED)
    first_day, odd = min(day for arm in arms for day in arm.days), twins.odd if twins is not None else ()
    return Fleet(names, first_day, CHANGED, changed, last, odd, tuple(refused)).made_by((arms, twins))


def farness(line: Series) -> float:
    """Size of z, zero where too few nights tell it."""
    return abs(line.z or 0.0)


def arm_of(recordings: Sequence[Stored]) -> Arm:
    """An arm by its recordings; refused where one does not name it and the day, or does not determine it."""
    for log in (recording.log for recording in recordings):
        if log.arm is None or log.day is None:
            raise InputError(f"{log.file}: its arm and day are not known: give --pattern to reduce")
    ordered = sorted(recordings, key=lambda recording: str(recording.log.day))
    arm, days = str(ordered[0].log.arm), tuple(str(recording.log.day) for recording in ordered)
    told = tuple(float(recording.log.payload or 0.0) for recording in ordered)
    usual = Counter(told).most_common(1)[0][0]
    same = [recording.equations for recording, mass in zip(ordered, told, strict=True) if mass == usual]
    whole = weighted(merged(equations.whole for equations in same))
    nights = [_night(recording, whole, usual - mass) for recording, mass in zip(ordered, told, strict=True)]
    values = {name: np.transpose([own[name] for own in nights]) for name in nights[0]}
    series = tuple(Series.of_nights(arm, name, days, *own) for name, own in values.items())
    return Arm(arm, days, told, series, widened(whole, compared_by(same[-1])[1]))


def _night(recording: Stored, whole: Estimate, usual: float) -> dict[str, tuple[float, float]]:
    """Value and standard deviation of each quantity by one recording.

    Friction and a change of payload are found together, then each drive's scale beside its friction. ``whole`` is
    by all recordings that were told the usual mass, which is ``usual`` [kg] more than what was told this night.
    """
    names, equations = whole.names, recording.equations
    frictions = [k for k, name in enumerate(names) if is_friction(name)]
    rest = np.array(whole.values)
    rest[frictions] = 0.0
    change = recording.base.effect_of(payload_columns(recording.robot))
    own = np.eye(len(names))
    columns = [*(names[k] for k in frictions), *PAYLOAD]
    fit = _fitted(equations.transformed(np.column_stack([own[:, frictions], change]), columns, rest))
    mass, sigma = fit["M_L"]
    quantities = {names[k]: fit[names[k]] for k in frictions} | {MASS: (usual + mass, sigma)}
    if abs(mass) > _CLEARLY * sigma:  # what hangs there is no drive's scale
        rest = rest + change @ np.array([fit[name][0] for name in PAYLOAD])
    for j in range(recording.robot.n):
        of_joint = [k for k in frictions if np.abs(equations.factors[j][:, k]).max(initial=0.0) > 0.0]
        M = np.column_stack([rest, own[:, of_joint]])
        scaled = equations.transformed(M, ["scale", *(names[k] for k in of_joint)], rest, [j])
        quantities[f"scale {j + 1}"] = _fitted(scaled)["scale"]
    return quantities


def _fitted(equations: Equations) -> dict[str, tuple[float, float]]:
    estimate, ratio = compared_by(equations)
    sigma = ratio * estimate.sigma
    return dict(zip(estimate.names, zip(estimate.values.tolist(), sigma.tolist(), strict=True), strict=True))


def compared_by(equations: Equations) -> tuple[Estimate, Array]:
    """An estimate and its ``excess``; by the jackknife, where there are enough blocks of time."""
    estimate, blocks, sigma = weighted(equations), len(equations.blocks), None
    if blocks > 1:
        robust = weighted(equations, equations.joint_weights(estimate.values))
        with suppress(InputError):
            every = [[(b, -1) for b in range(blocks)]]
            posed = LinearProblem(equations, equations.columns)
            sigma = jackknifed(posed, robust, every, equations.block_length).sigma
    return estimate, excess(estimate, sigma)
