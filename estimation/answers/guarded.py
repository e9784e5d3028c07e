"""Why intervals are wider than residuals say, and what is taken out of the payload."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..diagnosis.checks.joints import disagreement
from ..diagnosis.checks.loaded import MOVED
from ..diagnosis.loaded_rows import Scale, scales, scales_of_known
from ..diagnosis.nuisances import Bursts, Nuisance, Tilt, bursts, nuisances, tilt
from ..diagnosis.rivals import Rival, rivals
from ..diagnosis.states import states_of
from ..diagnosis.thinned import thinned_problem
from ..fit.drive_gains import Gains
from ..payload.by_joints import ByJoints, payload_by_joints
from ..payload.problem import PayloadProblem
from ..payload.repeats import moved, reaching, widened
from ..payload.result import PayloadEstimate
from .payload_answer import preference


class Guarded(NamedTuple):
    """What was looked at beside the methods.

    ``by_joints``: the payload as single joints see it; ``disagreement``: factor on every interval; ``scales`` of
    the loaded torques; ``rivals``: other ways to take the recordings; ``bursts``, ``tilt`` and ``nuisances``: what
    else is in the torques.
    """

    by_joints: ByJoints
    disagreement: float
    scales: tuple[Scale, ...]
    rivals: tuple[Rival, ...]
    bursts: Bursts | None
    tilt: Tilt | None
    nuisances: tuple[Nuisance, ...]


def guarded(
    problem: PayloadProblem, free: Sequence[PayloadEstimate], gains: Gains | None
) -> tuple[list[PayloadEstimate], Guarded]:
    """Estimates less what a tilt does, whose intervals allow for joints that disagree and for bursts."""
    n, short = problem.robot.n, problem.short is not None
    best = min(free, key=preference)
    states = states_of(problem.source) if problem.source is not None else None
    system = thinned_problem(problem, states)
    by_joints = payload_by_joints(problem, best.estimate.weights)
    told = gains.covariance(n) if gains is not None else np.zeros((n, n))
    leaning = tilt(system) if system is not None else None
    outside = bursts(system) if system is not None else None
    scaled = scales(problem, best.estimate.weights) if not short else ()
    if system is not None and problem.unloaded is None and problem.known is not None:
        scaled = scales_of_known(system)
    seen = Guarded(
        by_joints,
        disagreement(by_joints, told, few=short),
        scaled,
        rivals(problem.robot, states),
        outside,
        leaning,
        nuisances(system) if system is not None else (),
    )
    return [_allowing(estimate, seen, best) for estimate in free], seen


def _allowing(estimate: PayloadEstimate, seen: Guarded, best: PayloadEstimate) -> PayloadEstimate:
    """One estimate for what was seen; ``best``: the one to be used."""
    if seen.tilt is not None and not estimate.from_scale:
        estimate = moved(estimate, *seen.tilt.change(estimate.method))
    outside = seen.bursts
    if outside is not None and 9 in best.places and abs(outside.change[9]) > MOVED * abs(best.ten[9]):
        estimate = reaching(estimate, outside.change)
    return widened(estimate, seen.disagreement)
