"""A payload by a short motion: the parameters that it determines, and no others."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model.visibility import PayloadVisibility
from ..equations.equations import PAYLOAD, Equations
from ..fit.estimate import fit
from ..fit.linear_problem import LinearProblem
from ..fit.robust import jackknife
from ..possible.constraints import KnownMass
from .by_joints import ByJoints, joints_view
from .result import PayloadEstimate
from .short_motion import WeighProblem


def solve_weighing(problem: WeighProblem, scale: KnownMass | None = None) -> PayloadEstimate:
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
    places, A, by_mass = visibility.resolved(used is not None)
    names = tuple(PAYLOAD[k] for k in visibility.chosen)
    mass, by_scale = (used.mass, used.sigma**2) if used is not None else (0.0, 0.0)

    def posed(equations: Equations) -> LinearProblem:
        return problem.posed(equations, names)

    def told(equations: Equations) -> Array:
        return np.asarray(A @ posed(equations).values(estimate.weights) + by_mass * mass)

    whole = posed(problem.problem)
    visible = whole.solved()
    visible = replace(visible, fit=fit(whole.unknown, visible.values))
    estimate = visible.mapped(A, [PAYLOAD[k] for k in places], by_mass * mass)
    shared = by_scale * np.outer(by_mass, by_mass)
    estimate, reason = replace(estimate, covariance=estimate.covariance + shared), ""
    try:
        robust = jackknife(told, [problem.without_blocks], estimate.values, problem.block_length)
        # No block of time shows what is known from elsewhere.
        lasting = shared + A @ whole.lasting(estimate.weights) @ A.T
        estimate = replace(estimate, robust=replace(robust, covariance=robust.covariance + lasting))
    except InputError as error:
        reason = str(error)
    return PayloadEstimate(problem.method, estimate, problem.robot.payload_frame, reason, used is not None)


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


def weigh_by_joints(problem: WeighProblem, weights: Array) -> ByJoints:
    """The mass as groups of the moving joints see it, all ten unknown and the scale left out."""

    def parts() -> list[list[LinearProblem]]:
        return [[problem.posed(part) for part in problem.without_blocks]]

    return joints_view(problem.posed(problem.problem), parts, weights, groups_of(problem.joints), problem.joints)


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
