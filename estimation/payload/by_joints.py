"""Payload by single joints: the sharpest free test of drive gains, friction and description; and by recordings.

By torque differences (29) where there are pairs, otherwise by the loaded torques less the robot's (23). Several
recordings of one payload show how they scatter and how they drift.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from msgspec import UNSET, UnsetType
from scipy.linalg import block_diag

from ...common import Array, Brief, Document, Float, InputError, decomposed
from ..equations.equations import PAYLOAD
from ..fit.covariance import birge, jackknife, student95
from ..fit.estimate import error_model
from ..fit.linear_problem import LinearProblem
from ..possible.payload import rise_p_value
from .methods import PayloadProblem, from_difference, from_robot, payload_estimate
from .short_motion import ShortMotion

if TYPE_CHECKING:  # loaded where recordings repeat
    from .static import Order

_BLURRED = 0.05  # of noise in the torque that the other joints' payload predicts: above, a ratio says nothing
_HIDDEN = 1e-6  # fraction of the mass in undetermined directions above which it is not visible
_BLIND = 1e3  # sigma over the best group's above which a mass is not visible: one joint at rest hardly shows it
_DRIFTS = 0.05  # probability below which a trend is called a drift
WITHOUT_BLOCKS = 4.0
"""Factor on the formula's sigmas where no jackknife is possible: on real data up to 4.1 times too small."""


class JointsMass(Document, frozen=True):
    """Mass by the equations of some joints alone, all ten parameters of the payload unknown; gains as exact.

    ``share``: payload ratio of a single joint, 1 where its torque is what the other joints' payload demands; None
    where they tell it too badly.
    """

    joints: tuple[int, ...]
    visible: bool
    mass: float | None  # kg; None where they leave it undetermined, alone or together with others
    sigma: Float  # kg, the larger of the formula's, widened without blocks, and the jackknife's
    interval95: tuple[Float, Float] | None
    share: float | UnsetType | None = UNSET
    share_sigma: Float | UnsetType = UNSET

    @property
    def name(self) -> str:
        """Name the joints: "joint 3" or "joints 4-6"."""
        if len(self.joints) == 1:
            return f"joint {self.joints[0]}"
        if self.joints == tuple(range(self.joints[0], self.joints[-1] + 1)):
            return f"joints {self.joints[0]}-{self.joints[-1]}"
        return f"joints {', '.join(map(str, self.joints))}"


@dataclass(frozen=True, repr=False)
class ByJoints(Brief):
    """Mass and payload ratio by single joints."""

    masses: tuple[JointsMass, ...]  # by every joint alone, with its ratio, then by arm and wrist
    without: tuple[JointsMass, ...] = ()  # by all joints but one
    degrees_of_freedom: float = float("inf")  # of Student's t for the intervals

    @property
    def ratios(self) -> list[tuple[int, float, float]]:
        """Payload ratios that the others tell: joint, ratio, standard deviation."""
        return [
            (own.joints[0], own.share, own.share_sigma)
            for own in self.masses
            if isinstance(own.share, float) and isinstance(own.share_sigma, float)
        ]


def payload_by_joints(problem: PayloadProblem, weights: Array) -> ByJoints:
    """Estimate mass and ratio by joints, all that is shown unknown; weights, one a joint, matter within a group.

    Without blocks of time standard deviations are ``WITHOUT_BLOCKS`` times the formula's.
    """
    if isinstance(problem, ShortMotion):
        # A parameter that no joint shows has a column of rounding.
        shown = problem.visibility.base.grouping.any(axis=0)
        joints, whole = problem.joints, problem.posed([PAYLOAD[k] for k in np.flatnonzero(shown)])
        # The arm's joints together, those from the elbow on, the wrist's, and all.
        together = [[j for j in joints if low <= j <= high] for low, high in ((1, 3), (3, 99), (4, 99), (1, 99))]
    else:
        joints = tuple(range(1, problem.robot.n + 1))
        whole = from_difference(problem) if problem.difference is not None else from_robot(problem)
        together = [list(joints[:-3]), list(joints[-3:])] if len(joints) > 3 else []  # arm and wrist
    # What one joint shows does not correct the robot: its parameters stay as they are.
    whole = replace(whole, fixed=whole.given, prior=None)
    listed = dict.fromkeys([*((joint,) for joint in joints), *(tuple(own) for own in together if len(own) > 1)])
    without = [tuple(other for other in joints if other != joint) for joint in joints if len(joints) > 1]
    groups = [*listed, *without]
    values, variance, lasting = _numbers(whole, weights, groups, joints).T
    dof = float("inf")
    try:
        # Without each block with payload; then without each of those that the robot's parameters come from.
        parts = [whole.without_each()]
        for k, known in enumerate(whole.fixed):
            if known.left_out is not None:
                before, after = whole.fixed[:k], whole.fixed[k + 1 :]
                each = [(*before, known._replace(values=x), *after) for x in known.left_out()]
                parts.append([replace(whole, fixed=fixed) for fixed in each])
        # A number that the rest leaves undetermined counts as unchanged.
        anew = [np.array([_numbers(one, weights, groups, joints)[:, 0] for one in part]) for part in parts]
        left = [np.nan_to_num(np.where(np.isnan(numbers), values, numbers)) for numbers in anew]
        robust = jackknife(left, np.nan_to_num(values), 0.0)
        variance = np.maximum(variance, np.diag(robust.covariance) + lasting)
        dof = max(float(robust.degrees_of_freedom), 1.0)
    except InputError:  # too few blocks
        variance = WITHOUT_BLOCKS**2 * variance
    blind = variance > _BLIND**2 * np.nan_to_num(variance[: len(groups)], nan=np.inf).min()
    numbers = [None if np.isnan(value) else float(value) for value in np.where(blind, np.nan, values)]
    sigmas = np.sqrt(variance).tolist()
    # The first groups are the single joints, to which the ratios belong.
    ratios: list[tuple[Any, ...]] = [*zip(numbers[len(groups) :], sigmas[len(groups) :], strict=True)]
    every = zip(groups, numbers, sigmas, (student95(dof) * np.sqrt(variance)).tolist(), strict=False)
    masses = tuple(
        JointsMass(
            group, mass is not None, mass, sigma, None if mass is None else (mass - half, mass + half), *share
        )
        for (group, mass, sigma, half), share in zip(every, [*ratios, *[()] * len(groups)], strict=False)
    )
    return ByJoints(masses[: len(listed)], masses[len(listed) :], dof)


def _numbers(posed: LinearProblem, weights: Array, groups: Sequence[Sequence[int]], joints: Sequence[int]) -> Array:
    """Estimate the mass by groups of joints, then the payload ratio of joints, all from 1.

    A row a number: value, variance by the formula, and its between-session part; nan where undetermined.
    """
    unknown, given = posed.unknown.select(posed.wanted), posed.fixed
    taken = posed.equations.whole.select([name for group in given for name in group.names]).factors
    W_L = [w * factor for w, factor in zip(weights, unknown.factors, strict=True)]
    W = [w * factor[:, :-1] for w, factor in zip(weights, taken, strict=True)]
    # What an earlier identification's jackknife says counts instead of its formula.
    none, counted = np.zeros((0, 0)), [one.lasting if one.lasting.any() else one.covariance for one in given]
    covariance, between_sessions = block_diag(none, *counted), block_diag(none, *(one.lasting for one in given))
    rows = np.full((len(groups) + len(joints), 3), np.nan)
    for k, group in enumerate(groups):
        factor = np.vstack([W_L[j - 1] for j in group])
        parts, Y = decomposed(factor[:, :-1]), factor[:, -1]
        if posed.wanted[-1] != PAYLOAD[-1] or parts.hidden[-1] > _HIDDEN:  # the mass
            continue
        row, error = parts.inverse[-1], Y - factor[:, :-1] @ parts.solution(Y)
        spare = max(sum(unknown.effective_rows[j - 1] for j in group) - len(parts.singular), 1.0)
        # Errors of the parameters that were taken off carry over.
        gain = row @ np.vstack([W[j - 1] for j in group])
        own = float(error @ error) / spare * float(row @ row)
        rows[k] = row @ Y, own + gain @ covariance @ gain, gain @ between_sessions @ gain
    for k, joint in enumerate(joints, start=len(groups)):
        factor = np.vstack([other for j, other in enumerate(W_L, start=1) if j != joint])
        parts = decomposed(factor[:, :-1])
        if parts.hidden.max() > _HIDDEN:
            continue
        inverse, A, y = parts.inverse, W_L[joint - 1][:, :-1], W_L[joint - 1][:, -1]
        predicted = A @ (inverse @ factor[:, -1])
        # Errors of the others' payload are part of the error of what is predicted; large ones bias the ratio.
        noise = A @ inverse @ inverse.T @ A.T
        if not np.trace(noise) < _BLURRED * float(predicted @ predicted):
            continue
        # Generalised least squares of y = ratio predicted, errors of covariance 1 + noise.
        whitened = np.linalg.solve(np.eye(len(A)) + noise, predicted)
        size = float(whitened @ predicted)
        rows[k] = float(whitened @ y) / size, 1.0 / size, 0.0
    return rows


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
        cls, sources: Sequence[str], masses: Sequence[float], sigmas: Sequence[float], order: "Order | None" = None
    ) -> Self:
        """Compute from the mass of each recording and its standard deviation; a drift changes sign with gaps."""
        k = np.flatnonzero(np.isfinite(masses))
        seen, own = np.array(masses)[k], np.array(sigmas)[k]
        text, at = (order.text, order.gaps[k]) if order is not None and order.gaps.size else ("", k)
        step, sigma = None, None
        if len(k) > (1 if text else 2):  # slope over the recordings' numbers, and its deviation by their scatter
            line, C = np.polyfit(at, seen, 1, w=1.0 / own, cov="unscaled")
            left = float(np.sum(((seen - np.polyval(line, at)) / own) ** 2)) / max(len(k) - 2, 1)
            step, sigma = float(line[0]), float(np.sqrt(C[0, 0] * max(left, 1.0)))
        trend = not text and sigma and step and rise_p_value((step / sigma) ** 2, 1, float(len(k) - 2)) < _DRIFTS
        spread = float(np.std(seen, ddof=1)) if len(k) > 1 else float("nan")
        excess = birge(seen - (step * at if text and step else 0.0), own)
        given = tuple(sources), tuple(masses), tuple(sigmas)
        return cls(*given, spread, excess, step, sigma, bool(trend), text or UNSET)


def repeats_of(problem: PayloadProblem) -> Repeats | None:
    """Identify each recording of a short motion singly, or each pair of a long one by method 3.

    None of a single one, of a short motion if the mass is the scale's, of a long one if no order takes a drift off.
    """
    source, runs = problem.source, problem.runs
    if len(runs) < 2:
        return None
    from .static import Order

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
