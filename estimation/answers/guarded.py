"""Why intervals are wider than residuals say, and what is taken out of the payload."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...model import Robot
from ..diagnosis.beside import in_the_torques
from ..diagnosis.checks.joints import disagreement
from ..diagnosis.checks.loaded import MOVED
from ..diagnosis.evidence import Sampled
from ..diagnosis.loaded_rows import Scale, scales, scales_of_states
from ..diagnosis.nuisances import Bursts, Nuisance, Tilt, bursts
from ..diagnosis.pull import Pull
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
    the loaded torques; ``rivals``: other ways to take the recordings; ``bursts``, ``tilt``, ``nuisances`` and
    ``pulls``: what else is in the torques.
    """

    by_joints: ByJoints
    disagreement: float
    scales: tuple[Scale, ...]
    rivals: tuple[Rival, ...]
    bursts: Bursts | None
    tilt: Tilt | None
    nuisances: tuple[Nuisance, ...]
    pulls: tuple[Pull, ...]


def guarded(
    problem: PayloadProblem, free: Sequence[PayloadEstimate], gains: Gains | None, known: Sampled | None = None
) -> tuple[list[PayloadEstimate], Guarded]:
    """Estimates less what a tilt does, whose intervals allow for joints that disagree and for bursts."""
    best = min(free, key=preference)
    guards = looked_at(problem, best, gains) if known is None else _remembered(problem, best, gains, known)
    return [_allowing(estimate, guards) for estimate in free], guards


def looked_at(
    problem: PayloadProblem, best: PayloadEstimate, gains: Gains | None, description: Robot | None = None
) -> Guarded:
    """Look at what no residual of a method shows.

    Args:
        best: the estimate to be used.
        gains: with whose errors joints may disagree.
        description: the robot as it was given, where gains are what is asked for: its rivals are tried, with gains
            of their own; the problem's own by default.
    """
    weights = best.estimate.weights
    states = states_of(problem.source) if problem.source is not None else None
    system = thinned_problem(problem, states)
    by_joints = payload_by_joints(problem, weights)
    return Guarded(
        by_joints,
        _disagreement(problem, by_joints, gains),
        scales(problem, weights) if problem.unloaded is not None else scales_of_states(system),
        rivals(description or problem.robot, states, free_gains=description is not None),
        _mattering(bursts(system), best) if system is not None else None,
        *(in_the_torques(system) if system is not None else (None, (), ())),
    )


def _remembered(problem: PayloadProblem, best: PayloadEstimate, gains: Gains | None, known: Sampled) -> Guarded:
    """What equations show, and what the samples showed when they were there."""
    weights, short = best.estimate.weights, problem.short is not None
    by_joints = payload_by_joints(problem, weights)
    return Guarded(
        by_joints,
        _disagreement(problem, by_joints, gains),
        known.scales if short or problem.unloaded is None else scales(problem, weights),
        known.rivals,
        known.bursts,
        known.tilt,
        known.nuisances,
        known.pulls,
    )


def _disagreement(problem: PayloadProblem, by_joints: ByJoints, gains: Gains | None) -> float:
    n = problem.robot.n
    gain_covariance = gains.covariance(n) if gains is not None else np.zeros((n, n))
    return disagreement(by_joints, gain_covariance, few=problem.short is not None)


def _mattering(outside: Bursts | None, best: PayloadEstimate) -> Bursts | None:
    """Bursts without which the mass is another one; stretches that stand out by chance move it by less."""
    if outside is None or 9 not in best.places:
        return None
    chance = 2.0 * float(best.estimate.sigma[best.places.index(9)])
    return outside if abs(outside.change[9]) > max(MOVED * abs(best.ten[9]), chance) else None


def _allowing(estimate: PayloadEstimate, guards: Guarded) -> PayloadEstimate:
    """One estimate for what was seen."""
    if guards.tilt is not None and not estimate.from_scale:
        estimate = moved(estimate, *guards.tilt.change(estimate.method))
    if guards.bursts is not None:
        estimate = reaching(estimate, guards.bursts.change)
    return widened(estimate, guards.disagreement)
