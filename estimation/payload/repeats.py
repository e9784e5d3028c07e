"""Repeats: several recordings of one payload, their spread, their drift, and what both mean for the answer."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Self

import numpy as np
from msgspec import UNSET, UnsetType

from ...common import Document, InputError, decomposed
from ..fit.covariance import birge
from ..fit.estimate import error_model
from ..possible.payload import rise_p_value
from .methods import PayloadProblem, payload_estimate
from .pairs import Order
from .short_motion import ShortMotion

_DRIFTS = 0.05  # probability below which a trend is called a drift


class Repeats(Document, frozen=True):
    """Masses [kg] of single recordings, how much more they scatter than they should, and how they drift."""

    sources: tuple[str, ...]  # in the order they were given
    masses: tuple[float | None, ...]  # nan where a recording alone does not show it
    sigmas: tuple[float | None, ...]
    spread: float | None  # standard deviation from recording to recording; nan with fewer than two
    excess: float  # by how much they scatter more than their own sigmas say (Birge ratio), at least 1
    drift_per_recording: float | None  # from one to the next; None with fewer than three
    drift_sigma: float | None
    drifts: bool  # steadily, which a payload does not: the drives warm up, or a gain drifts
    order: str | UnsetType = UNSET  # of the recordings, where it takes a drift off that is linear in time

    @classmethod
    def made(
        cls, sources: Sequence[str], masses: Sequence[float], sigmas: Sequence[float], order: Order | None = None
    ) -> Self:
        """Compute from the mass of each recording and its standard deviation; a drift changes sign with gaps."""
        k = np.flatnonzero(np.isfinite(masses))
        seen, own = np.array(masses)[k], np.array(sigmas)[k]
        text, at = (order.text, order.gaps[k]) if order is not None and order.gaps.size else ("", k)
        step, sigma, taken_off = None, None, np.zeros(len(k))
        if len(k) > (1 if text else 2):  # slope over the recordings' numbers, and its deviation by their scatter
            A = np.column_stack([np.ones(len(k)), at]) / own[:, None]
            parts = decomposed(A)
            slope = parts.solution(seen / own)
            left = float(np.sum((seen / own - A @ slope) ** 2)) / max(len(k) - 2, 1)
            taken_off = slope[1] * at if text else taken_off
            step, sigma = float(slope[1]), float(np.sqrt((parts.covariance * max(left, 1.0))[1, 1]))
        return cls(
            tuple(sources),
            tuple(masses),
            tuple(sigmas),
            spread=float(np.std(seen, ddof=1)) if len(k) > 1 else float("nan"),
            excess=birge(seen - taken_off, own),
            drift_per_recording=step,
            drift_sigma=sigma,
            drifts=not text
            and bool(sigma and step and rise_p_value((step / sigma) ** 2, 1, float(len(k) - 2)) < _DRIFTS),
            order=text or UNSET,
        )


def repeats_of(problem: PayloadProblem) -> Repeats | None:
    """Identify each recording of a short motion singly, or each pair of a long one by method 3.

    None of a single one, of a short motion if the mass is the scale's, of a long one if no order takes a drift off.
    """
    source, runs = problem.source, problem.runs
    if len(runs) < 2:
        return None
    order, each, method = Order.of(source.loaded, source.unloaded), list[PayloadProblem](), 3
    if isinstance(problem, ShortMotion):
        method = problem.method
        if problem.visibility.mass_visible:
            each = [replace(problem, runs=(run,)) for run in runs]
    elif order.gaps.size == len(runs):
        loaded, unloaded = problem.loaded.whole, problem.unloaded and problem.unloaded.whole
        each = [replace(problem, loaded=loaded, unloaded=unloaded, difference=run) for run in runs]
    if not each:
        return None
    masses, sigmas = ([float("nan")] * len(runs) for _ in range(2))
    for k, own in enumerate(each):
        with suppress(InputError):  # one recording alone may not do
            estimate = payload_estimate(own, method)
            if not estimate.from_scale and 9 in estimate.indices:
                model = error_model(estimate.estimate)
                masses[k], sigmas[k] = model["M_L"], float(model.sigma[model.names.index("M_L")])
    return Repeats.made([recording.source for recording in source.loaded], masses, sigmas, order)
