"""Several recordings of one payload: their spread, their drift, and what both mean for the common answer."""

from dataclasses import dataclass, replace

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import decomposed
from ..fit.covariance import NORMAL95, birge, student95
from ..fit.estimate import error_model
from ..possible.constraints import KnownMass
from ..possible.payload import rise_p_value
from .methods import PayloadProblem, payload_estimate
from .result import PayloadEstimate
from .short_motion import ShortMotion

_DRIFTS = 0.05
"""Probability below which a trend is called a drift."""


@dataclass(frozen=True)
class Repeats:
    """The mass by each recording alone, in the order they were given.

    Attributes:
        sources: of the recordings.
        masses: [kg], shape (R,); nan where a recording alone does not show it.
        sigmas: their standard deviations [kg], shape (R,).
    """

    sources: tuple[str, ...]
    masses: tuple[float, ...]
    sigmas: tuple[float, ...]

    @property
    def seen(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Numbers (from 0), masses and standard deviations of the recordings that show the mass."""
        k = np.flatnonzero(np.isfinite(self.masses))
        return k, np.array(self.masses)[k], np.array(self.sigmas)[k]

    @property
    def spread(self) -> float:
        """Standard deviation from recording to recording [kg]; nan with fewer than two."""
        masses = self.seen[1]
        return float(np.std(masses, ddof=1)) if len(masses) > 1 else float("nan")

    @property
    def excess(self) -> float:
        """By how much they scatter more than their own standard deviations say (Birge ratio), at least 1."""
        _, masses, sigmas = self.seen
        return birge(masses, sigmas)

    @property
    def drift(self) -> tuple[float, float] | None:
        """Change from one recording to the next [kg], and its standard deviation; None with fewer than three."""
        k, masses, sigmas = self.seen
        if len(masses) < 3:
            return None
        A = np.column_stack([np.ones(len(k)), k]) / sigmas[:, None]
        parts = decomposed(A)
        slope = parts.solution(masses / sigmas)
        left = float(np.sum((masses / sigmas - A @ slope) ** 2)) / max(len(k) - 2, 1)
        C = parts.covariance * max(left, 1.0)
        return float(slope[1]), float(np.sqrt(C[1, 1]))

    @property
    def drifts(self) -> bool:
        """Whether the mass changes steadily, which a payload does not: the drives warm up, or a gain drifts."""
        drift = self.drift
        if drift is None:
            return False
        return rise_p_value((drift[0] / drift[1]) ** 2, 1, float(len(self.seen[0]) - 2)) < _DRIFTS

    def half_width(self) -> float:
        """Half of the 95 % interval of their mean by their scatter alone [kg]."""
        masses = self.seen[1]
        if len(masses) < 2:
            return float("nan")
        return student95(len(masses) - 1) * self.spread / float(np.sqrt(len(masses)))


def repeats_of(problem: PayloadProblem, scale: KnownMass | None) -> Repeats | None:
    """Each recording of a short motion alone; None with one recording, or where the mass is the scale's anyway."""
    if not isinstance(problem, ShortMotion) or len(problem.runs) < 2 or not problem.visibility.mass_visible:
        return None
    masses, sigmas = [], []
    for run in problem.runs:
        mass, sigma = float("nan"), float("nan")
        try:
            estimate = payload_estimate(replace(problem, runs=(run,)), problem.method, scale=scale)
        except InputError:
            pass  # one recording alone may not do
        else:
            if not estimate.from_scale and 9 in estimate.places:
                model = error_model(estimate.estimate)
                mass, sigma = model["M_L"], float(model.sigma[model.names.index("M_L")])
        masses.append(mass)
        sigmas.append(sigma)
    return Repeats(tuple(run.source for run in problem.runs), tuple(masses), tuple(sigmas))


def widened(estimate: PayloadEstimate, factor: float) -> PayloadEstimate:
    """With standard deviations ``factor`` times as large."""
    if factor == 1.0:
        return estimate
    robust = estimate.estimate.robust
    if robust is not None:
        robust = replace(robust, covariance=robust.covariance * factor**2)
    covariance = estimate.estimate.covariance * factor**2
    return replace(estimate, estimate=replace(estimate.estimate, covariance=covariance, robust=robust))


def reaching(estimate: PayloadEstimate, change: Array) -> PayloadEstimate:
    """With standard deviations that let the intervals reach values moved by a change of the ten, shape (10,)."""
    step = change / NORMAL95
    return moved(estimate, 0.0 * change, np.outer(step, step))


def moved(estimate: PayloadEstimate, change: Array, more: Array) -> PayloadEstimate:
    """With other values of the ten and a larger covariance: the changes, shapes (10,) and 10 x 10."""
    places, robust = list(estimate.places), estimate.estimate.robust
    more = more[np.ix_(places, places)]
    if robust is not None:
        robust = replace(robust, covariance=robust.covariance + more)
    widened_values = replace(
        estimate.estimate,
        values=estimate.estimate.values + change[places],
        covariance=estimate.estimate.covariance + more,
        robust=robust,
    )
    return replace(estimate, estimate=widened_values)
