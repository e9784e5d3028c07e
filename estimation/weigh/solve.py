"""Least squares on a weighing problem: the parameters that it determines, and no others."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import least_squares
from ...model.visibility import PayloadVisibility, Resolved
from ..equations.names import PAYLOAD
from ..equations.problem import ReducedProblem, merged
from ..fit.drive_gains import NOT_TOLD, GainErrors, scaled_torque
from ..fit.estimate import Estimate, fit
from ..fit.least_squares import joint_weights, solve, weighted
from ..fit.robust import jackknife
from ..payload.by_joints import ByJoints, JointEquations, joints_view
from ..possible.constraints import KnownMass
from .problem import WeighProblem
from .run import HeldOffsets


@dataclass(frozen=True, eq=False)
class WeighEstimate:
    """The determined parameters of a payload.

    Attributes:
        estimate: of those of ``PAYLOAD`` that are determined, the scale's share included where the mass is not
            visible; with robust standard deviations where there are enough blocks.
        places: where they stand among the ten.
        without_robust: why there are no robust standard deviations.
        from_scale: whether the mass is the scale's, not the torques'.
    """

    estimate: Estimate
    places: tuple[int, ...]
    without_robust: str
    from_scale: bool

    def unexplained(self, torque_rms: Array) -> Array:
        """Each joint's error over its torque with payload (rms), shape (n,); nan for joints that were held."""
        rows = np.array(self.estimate.fit.rows, dtype=float)
        torque = np.where((rows > 0) & (torque_rms > 0.0), torque_rms, np.nan)
        return np.asarray(self.estimate.fit.error_norms / np.sqrt(np.maximum(rows, 1.0)) / torque)

    @property
    def complete(self) -> bool:
        """Whether all ten are determined."""
        return len(self.places) == len(PAYLOAD)

    @property
    def ten(self) -> Array:
        """The ten, nan where not determined, shape (10,)."""
        values = np.full(len(PAYLOAD), np.nan)
        values[list(self.places)] = self.estimate.values
        return values


class _Solver:
    """The least-squares problem with its weights; the same for the whole and for parts of it."""

    def __init__(self, problem: WeighProblem, scale: KnownMass | None, visibility: PayloadVisibility) -> None:
        self.known, self.scale = problem.known, scale
        self.robot = problem.known.names if problem.known is not None else ()
        self.names = tuple(PAYLOAD[k] for k in visibility.chosen)
        self.resolved: Resolved = visibility.resolved(scale is not None)

    def own(self, whole: ReducedProblem) -> ReducedProblem:
        """The equations in the visible columns alone, the robot's torque moved to the left."""
        if self.known is None:
            return whole.select(self.names)
        both, k = whole.select((*self.robot, *self.names)), len(self.robot)
        chi = self.known.values
        factors = tuple(np.column_stack([f[:, k:-1], f[:, -1] - f[:, :k] @ chi]) for f in both.factors)
        return ReducedProblem(self.names, factors, both.rows, both.effective_rows)

    def values(self, whole: ReducedProblem, weights: Array) -> Array:
        """The determined parameters."""
        return self.told(weighted(self.own(whole), weights).values)

    def told(self, theta: Array) -> Array:
        """Parameters from the visible columns' values, and the scale."""
        mass = self.scale.mass if self.scale is not None else 0.0
        return np.asarray(self.resolved.A @ theta + self.resolved.b * mass)

    def estimate(self, whole: ReducedProblem) -> tuple[Estimate, Array]:
        """With the formula's covariance; and the part of it that is the robot's and the scale's."""
        own = self.own(whole)
        ordinary = solve(own.stacked(), own.columns, own.equations, sum(own.effective_rows))
        weights = joint_weights(own, ordinary.values)
        solution = solve(own.stacked(weights), own.columns, own.equations, sum(own.effective_rows))
        A, b = self.resolved.A, self.resolved.b
        shared = np.outer(b, b) * (self.scale.sigma**2 if self.scale is not None else 0.0)
        dof = solution.degrees_of_freedom
        if self.known is not None:
            factor = whole.select((*self.robot, *self.names)).stacked(weights)
            k = len(self.robot)
            P = A @ least_squares(factor[:, k:-1], factor[:, :k])
            shared = shared + P @ _known_covariance(self.known) @ P.T
            dof = min(dof, self.known.degrees_of_freedom)
        estimate = Estimate(
            names=tuple(PAYLOAD[k] for k in self.resolved.places),
            values=self.told(solution.values),
            covariance=A @ solution.covariance @ A.T + shared,
            degrees_of_freedom=dof,
            fit=fit(own, solution.values),
            weights=weights,
        )
        return estimate, shared

    def of_offsets(self, whole: ReducedProblem, weights: Array, held: HeldOffsets) -> Array:
        """Covariance from constant torques that are not zero; alike in all recordings, to be safe."""
        if not held.joints:
            return np.zeros((len(self.resolved.places),) * 2)
        factor, k = whole.select((*self.names, *held.columns)).stacked(weights), len(self.names)
        P = self.resolved.A @ least_squares(factor[:, :k], factor[:, k:-1])
        return np.asarray(P @ held.covariance @ P.T)


def solve_weighing(problem: WeighProblem, scale: KnownMass | None = None) -> WeighEstimate:
    """The parameters that the recordings determine, with standard deviations.

    Where the mass is not visible, a scale makes the other parameters follow from the visible sums; where it is, the
    scale takes no part here. Nothing that the torques leave open is filled in.

    Args:
        problem: the recordings.
        scale: the payload was weighed.

    Raises:
        InputError: "mass not visible" if neither shows the mass; if nothing else is determined either.
    """
    visibility = problem.visibility
    check_mass(visibility, scale is not None)
    used = None if visibility.mass_visible else scale
    solver = _Solver(problem, used, visibility)
    estimate, shared = solver.estimate(problem.problem)
    reason = ""
    try:
        robust = jackknife(
            lambda part: solver.values(part, estimate.weights),
            [deletions(problem)],
            estimate.values,
            problem.block_length,
        )
        # No block of time shows these.
        lasting = shared + solver.of_offsets(problem.problem, estimate.weights, problem.held)
        estimate = replace(estimate, robust=replace(robust, covariance=robust.covariance + lasting))
    except InputError as error:
        reason = str(error)
    return WeighEstimate(estimate, solver.resolved.places, reason, used is not None)


def check_mass(visibility: PayloadVisibility, weighed: bool) -> None:
    """Refuse recordings that do not show the mass, unless it is known.

    Raises:
        InputError: "mass not visible".
    """
    if visibility.mass_visible or weighed:
        return
    joints = ", ".join(map(str, visibility.joints))
    sums = visibility.combination("M")
    why = f"only in {sums}" if sums else "not at all"
    raise InputError(
        f"mass not visible: the torques of joint {joints} show it {why}; move another joint as well, or weigh the "
        "payload and give --mass and --mass-sigma"
    )


def deletions(problem: WeighProblem) -> Iterator[ReducedProblem]:
    """The whole without each block of time.

    Raises:
        InputError: if there are fewer than two blocks.
    """
    runs = problem.runs
    if sum(len(run.blocks) for run in runs) < 2 or any(len(run.blocks) < 2 for run in runs):
        raise InputError("robust standard deviations need two blocks of time at least: record longer")
    for k, run in enumerate(runs):
        others = [other.problem for i, other in enumerate(runs) if i != k]
        for block in range(len(run.blocks)):
            yield merged([*others, run.without_block(block)])


def weigh_gain_covariance(
    problem: WeighProblem, found: WeighEstimate, scale: KnownMass | None, gains: GainErrors
) -> Array:
    """Covariance from errors of the drive gains; the result is linear in each motor's torque.

    Raises:
        InputError: if stored robot parameters came without what they owe to each motor's torque.
    """
    solver = _Solver(problem, scale if found.from_scale else None, problem.visibility)
    weights, n = found.estimate.weights, problem.robot.n
    J = np.zeros((len(found.places), n))
    for j in range(n):
        known = solver.known
        if known is not None:
            if known.gain_sensitivity is None:
                raise InputError(NOT_TOLD)
            solver.known = replace(known, values=known.values + known.gain_sensitivity[:, j])
        J[:, j] = solver.values(scaled_torque(problem.problem, j, 2.0), weights) - found.estimate.values
        solver.known = known
    return np.asarray(J @ gains.covariance(n) @ J.T)


def weigh_by_joints(problem: WeighProblem, weights: Array) -> ByJoints:
    """The mass as groups of the moving joints see it, all ten unknown and the scale left out."""

    def equations(whole: ReducedProblem) -> JointEquations:
        known = problem.known
        rows = whole.effective_rows
        if known is None:
            held = problem.held
            ten, offsets = whole.select(PAYLOAD).factors, whole.select(held.columns).factors
            payload = tuple(w * f for w, f in zip(weights, ten, strict=True))
            taken = tuple(w * f[:, :-1] for w, f in zip(weights, offsets, strict=True))
            return JointEquations(payload, taken, held.covariance, rows, True)
        k = len(known.names)
        scaled = [w * f for w, f in zip(weights, whole.factors, strict=True)]
        rest = tuple(np.column_stack([f[:, k:-1], f[:, -1] - f[:, :k] @ known.values]) for f in scaled)
        return JointEquations(rest, tuple(f[:, :k] for f in scaled), _known_covariance(known), rows, True)

    def parts() -> list[list[JointEquations]]:
        return [[equations(part) for part in deletions(problem)]]

    return joints_view(equations(problem.problem), parts, groups_of(problem.joints), problem.joints)


def _known_covariance(known: Estimate) -> Array:
    """Of a robot's parameters: the one that allows for errors that last, where it was stored."""
    return known.robust.covariance if known.robust is not None else known.covariance


def groups_of(joints: Sequence[int]) -> tuple[tuple[int, ...], ...]:
    """Every moving joint alone; then the arm's, those from the elbow on, the wrist's, and all together."""
    alone = [(joint,) for joint in joints]
    parts = [
        tuple(j for j in joints if j <= 3),
        tuple(j for j in joints if j >= 3),
        tuple(j for j in joints if j >= 4),
        tuple(joints),
    ]
    return tuple(dict.fromkeys([*alone, *(part for part in parts if len(part) > 1)]))
