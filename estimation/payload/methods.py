"""The paper's four methods by number: which equations each solves, and which of their columns it takes as known."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain
from typing import Protocol

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model.drives import FRICTION, parameter_kind
from ..equations.equations import PAYLOAD, Equations
from ..equations.observer import PATH
from ..fit.essential import Elimination, StopRule, eliminate
from ..fit.estimate import Estimate
from ..fit.linear_problem import Held, Known, LinearProblem
from ..fit.robust import FEW, RobustCovariance, jackknifed, naming_blocks
from ..possible.constraints import KnownMass
from .friction import with_changes
from .from_change import from_change
from .loaded_scale import with_scale
from .path import known_path
from .problem import FORMULA_ONLY, PayloadProblem
from .result import PayloadEstimate, in_payload_frame


class Posed(Protocol):
    """What a method makes of the recordings: a problem that is solved for given weights of the joints."""

    def solved(self, weights: Array | None = None) -> Estimate:
        """The parameters asked for; weights are estimated unless they are given."""

    def values(self, weights: Array) -> Array:
        """Values of the parameters alone."""

    def without_blocks(self, weights: Array, pairs: Sequence[tuple[int, int]]) -> Array:
        """Values without blocks of time with and without payload, one row for each of ``left_out``."""

    def lasting(self, weights: Array) -> Array:
        """Covariance that no block of time shows."""

    def remembered(self, weights: Array, inflation: Sequence[float]) -> Array:
        """Covariance where each joint's errors remember."""


Method = Callable[[PayloadProblem], Posed]


def from_robot(
    problem: PayloadProblem, free_friction: bool = False, names: Sequence[str] | None = None
) -> LinearProblem:
    """Method 1, (22) and (23): the loaded recording minus what the robot alone would need.

    The covariance accounts for that of the robot's parameters: C_L = s^2 (W_L' W_L)^-1 + P C P' with
    P = W_L^+ W. Of a robot that was identified on another day, friction may differ within limits.

    Args:
        problem: with ``unloaded`` or ``known``.
        free_friction: estimate friction anew from the loaded recording, for friction that depends on load.
        names: of the payload's parameters; ``problem.chosen`` by default.
    """
    robot = problem.robot_known
    if free_friction:
        robot = _part(robot, [k for k, name in enumerate(robot.names) if parameter_kind(name) not in FRICTION])
    scaled, near = with_scale(problem.loaded, {}, problem.scale)
    if problem.known is None:
        return _posed(problem, scaled, (robot,), names, near)
    if free_friction or not problem.corrected:
        return _posed(problem, scaled, (robot, *_levels(problem)), names, near)
    loaded, roles = with_changes(scaled, problem.friction)
    posed = _posed(problem, loaded, _levels(problem), names)
    return replace(posed, held={**near, **roles}, prior=problem.robot_prior)


def from_difference(problem: PayloadProblem, names: Sequence[str] | None = None) -> LinearProblem:
    """Method 3, (29): Y_T - Y_wL, the torques with and without payload on one trajectory.

    Friction under load may differ from the robot's own within limits; of a short motion the joints' constant
    torques are known to be near zero.
    """
    if problem.difference is None:
        raise InputError(f"method 3 cannot be used: {problem.without_difference}")
    equations, path = problem.difference, known_path(problem.difference.columns, problem.robot.n)
    if problem.short is None:
        there = (*PAYLOAD, PATH, *problem.friction)
        equations = equations.select([name for name in equations.columns if name in there])
    return _posed(problem, equations, (*_levels(problem), *path), names, problem.friction)


def _levels(problem: PayloadProblem) -> tuple[Known, ...]:
    """What friction is held at in a short motion."""
    return (problem.short.held.known,) if problem.short is not None else ()


def _posed(
    problem: PayloadProblem,
    equations: Equations,
    known: tuple[Known, ...],
    names: Sequence[str] | None,
    roles: Mapping[str, Held] | None = None,
) -> LinearProblem:
    """Equations in the payload's frame, of its parameters ``names`` alone."""
    payload_names = problem.chosen if names is None else tuple(names)
    columns = [name for name in equations.columns if name in payload_names or name not in PAYLOAD]
    # Beside the robot's torque the payload's own is what the joints of a short motion are compared by.
    alone = problem.short is not None
    posed = in_payload_frame(problem.robot, equations).select(columns)
    return LinearProblem(posed, payload_names, known, roles or {}, alone=alone)


def global_fit(problem: PayloadProblem, names: Sequence[str] = PAYLOAD) -> LinearProblem:
    """Method 4, (30): all recordings at once; the robot's parameters are common to both, friction within limits."""
    scaled, near = with_scale(problem.loaded, {}, problem.scale)
    loaded, roles = with_changes(in_payload_frame(problem.robot, scaled), problem.friction)
    return LinearProblem(problem.beside(loaded), tuple(names), held={**near, **roles}, shown=loaded)


def selected(problem: PayloadProblem, names: Sequence[str]) -> LinearProblem:
    """Method 4 with some parameters of robot and payload only, the others zero."""
    return LinearProblem(problem.both.select(names), tuple(names))


METHODS: dict[int, Method] = {1: from_robot, 2: from_change, 3: from_difference, 4: global_fit}
"""The paper's methods by number."""


def method_of(number: int, free_friction: bool = False) -> Method:
    """The method by its number; the first may estimate friction anew under load."""
    return partial(from_robot, free_friction=free_friction) if number == 1 else METHODS[number]


def usable_methods(problem: PayloadProblem) -> tuple[int, ...]:
    """Methods for which the problem holds what they need."""
    bare = problem.unloaded is not None
    one_scale = problem.scale is None  # changes and differences know of no other
    usable = {
        1: bare or problem.known is not None,
        2: bare and one_scale,
        3: problem.difference is not None and one_scale,
        4: bare,
    }
    return tuple(method for method, there in usable.items() if there)


def identify_payload(
    problem: PayloadProblem, method: int, free_friction: bool = False, scale: KnownMass | None = None
) -> PayloadEstimate:
    """Estimate the payload by one method; with robust standard deviations if the problem has blocks of time.

    Of a short motion what it determines, and nothing filled in.

    Args:
        method: 1 robot known (22)-(23), 2 change of the base parameters (24)-(28), 3 torque difference (29),
            4 robot and payload together (30).
        free_friction: method 1 only: estimate friction anew under load.
        scale: the payload was weighed; it counts here only where a short motion does not show the mass.

    Raises:
        InputError: if the problem lacks what the method needs; "mass not visible" if nothing shows it.
        KeyError: for another method.
    """
    short, frame = problem.short, problem.robot.payload_frame
    by_scale = short is not None and short.needed(scale) is not None
    estimate, reason = with_robust(problem, method_of(method, free_friction))
    if short is not None:
        estimate = short.resolved(estimate, scale)
    return PayloadEstimate(method, estimate, frame, reason, by_scale)


def combined(problem: PayloadProblem) -> Estimate:
    """Robot and payload parameters of (30), columns base, then ``PAYLOAD``."""
    return selected(problem, problem.loaded.columns).solved()


def essential_combined(problem: PayloadProblem, rule: StopRule | None = None) -> Elimination:
    """Essential parameters of robot and payload (in frame n) together, as in Table 2."""
    return eliminate(problem.both, combined(problem), rule)


def with_robust(problem: PayloadProblem, method: Method, estimate: Estimate | None = None) -> tuple[Estimate, str]:
    """What a method gives, with its robust covariance; without, and why, where there is none.

    Args:
        estimate: its result, where it is there already; its weights are kept.
    """
    posed = method(problem)
    estimate = posed.solved() if estimate is None else estimate
    if not problem.loaded.leave_one_out:
        return estimate, problem.no_blocks
    try:
        return replace(estimate, robust=_robust(problem, posed, estimate)), ""
    except InputError as error:
        return estimate, str(error)


def _robust(problem: PayloadProblem, posed: Posed, estimate: Estimate) -> RobustCovariance:
    """By the delete-a-block jackknife, weights fixed at those of the result; with few blocks by memory."""
    length = problem.loaded.block_length
    try:
        groups = problem.left_out
        with naming_blocks(length):
            values = posed.without_blocks(estimate.weights, list(chain.from_iterable(groups)))
    except InputError:
        if problem.short is not None or not problem.inflation:
            raise
        return by_memory(problem, posed, estimate, None)
    ends = np.cumsum([len(group) for group in groups])[:-1]
    robust = jackknifed(np.split(values, ends), estimate.values, length)
    whole = _with_lasting(problem, posed, estimate, robust)
    if problem.few or (problem.corrected and robust.degrees_of_freedom + 1 < FEW):
        return by_memory(problem, posed, estimate, replace(whole, blocks=robust.blocks))
    return whole


def _with_lasting(
    problem: PayloadProblem, posed: Posed, estimate: Estimate, robust: RobustCovariance
) -> RobustCovariance:
    """The jackknife's, and what no block shows.

    A robot that was identified earlier adds its own robust covariance, propagated: its blocks were left out one at
    a time as well.
    """
    share = posed.lasting(estimate.weights)
    if not share.any():
        return robust  # the method does without anything known earlier
    widened = replace(robust, covariance=robust.covariance + share)
    own = problem.known.robust if problem.known is not None else None
    if problem.known is not None and own is None and problem.short is None:
        raise InputError(FORMULA_ONLY)
    if own is None:
        return widened
    return RobustCovariance(
        widened.covariance,
        robust.blocks + own.blocks,
        min(robust.degrees_of_freedom, own.degrees_of_freedom),
        max(robust.block_length, own.block_length),
    )


def by_memory(
    problem: PayloadProblem, posed: Posed, estimate: Estimate, robust: RobustCovariance | None = None
) -> RobustCovariance:
    """Robust covariance by how much each joint's errors remember; the jackknife counts where it is larger.

    Of a robot that the recordings correct the jackknife is left out: a few seconds say next to nothing of it.

    Args:
        problem: with the inflation of each joint's errors.
        posed: what the method makes of it.
        robust: the jackknife's, of few blocks; None without.
    """
    covariance = posed.remembered(estimate.weights, problem.inflation)
    if robust is not None and not problem.corrected:
        wider = np.maximum(robust.sigma / np.sqrt(np.diag(covariance)), 1.0)
        covariance = covariance * np.outer(wider, wider)
    blocks, degrees = robust.blocks if robust is not None else 0, max(int(estimate.degrees_of_freedom), 1)
    return RobustCovariance(covariance, blocks, degrees, problem.loaded.block_length, by_memory=True)


def _part(known: Known, places: Sequence[int]) -> Known:
    """Some of the parameters that are known."""
    own = list(places)

    def derivatives() -> Array | None:
        every = known.gain_sensitivity()
        return every[own] if every is not None else None

    def without_blocks() -> Array | None:
        every = known.left_out()
        return every[:, own] if every is not None else None

    return known._replace(
        names=tuple(known.names[k] for k in places),
        values=known.values[own],
        covariance=known.covariance[own][:, own],
        lasting=known.lasting[own][:, own],
        gain_sensitivity=derivatives,
        left_out=without_blocks,
    )
