"""Intervals over possible payloads: the same by CVXPY, in every frame and unit, and they hold the truth."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import cvxpy
import numpy as np
import pytest
from dynident.apps.commands.demo import PAYLOAD as PAPER_PAYLOAD
from dynident.common.arrays import Array
from dynident.estimation import (
    PAYLOAD,
    CentreOfMassInBox,
    Estimate,
    InEllipsoid,
    KnownMass,
    MassBounds,
    solve_constrained,
)
from dynident.estimation.fit.estimate import Fit
from dynident.estimation.possible.constraints import PSEUDO_INERTIA, Constraint
from dynident.estimation.possible.intervals import WIDENING, Intervals, profile_intervals
from dynident.model import InertialParameters

NOTHING = Fit(np.ones(1), np.ones(1), (1,))
DOF = 40.0
T = 2.0210753903062715  # Student's 97.5 % point of 40 degrees, from a table
DISC = PAPER_PAYLOAD
CUBE = InertialParameters.from_com(7.0, [0.02, -0.01, 0.15], 0.05 * np.eye(3))
SIGMA = np.array([0.01, 0.004, 0.004, 0.01, 0.005, 0.004, 0.006, 0.006, 0.008, 0.03])


def near(body: InertialParameters, seed: int) -> Estimate:
    """A body as it would be identified, errors correlated up to 0.9."""
    draw = np.random.default_rng(seed)
    root = draw.standard_normal((10, 12))
    root *= (SIGMA / np.linalg.norm(root, axis=1))[:, None]
    return Estimate(PAYLOAD, body.vector + root @ draw.standard_normal(12), root @ root.T, DOF, NOTHING, np.ones(1))


def in_cvxpy(estimate: Estimate, constraints: Sequence[Constraint]) -> tuple[Any, list[Any]]:
    """The ten in units of sigma, and the set, written down anew from its definition."""
    u = cvxpy.Variable(10)
    x = cvxpy.multiply(estimate.sigma, u)
    J = cvxpy.reshape(PSEUDO_INERTIA.reshape(10, 16).T @ x, (4, 4), order="C")
    rules = [J >> 0]
    correlation = estimate.covariance / np.outer(estimate.sigma, estimate.sigma)
    W = np.linalg.inv(np.linalg.cholesky(correlation))
    distance = cvxpy.sum_squares(W @ (u - estimate.values / estimate.sigma))
    for constraint in constraints:
        if isinstance(constraint, KnownMass):
            distance += ((x[9] - constraint.mass) / constraint.sigma) ** 2
        else:
            rules.append(constraint.rows[0] @ x + constraint.rows[1] >= 0)
    nearest = cvxpy.Problem(cvxpy.Minimize(distance), rules).solve(solver="CLARABEL")
    return x, [*rules, distance <= nearest + WIDENING * T**2]


CASES: dict[str, tuple[InertialParameters, list[Constraint]]] = {
    "disc": (DISC, []),
    "cube": (CUBE, []),
    "box": (DISC, [CentreOfMassInBox([-0.1, -0.1, 0.0], [0.1, 0.1, 0.1425])]),
    "ellipsoid and bounds": (DISC, [InEllipsoid([0.0, 0.0, 0.13], [0.12, 0.12, 0.05]), MassBounds(6.99, 7.5)]),
    "weighed": (CUBE, [KnownMass(7.02, 0.02)]),
}


@pytest.mark.parametrize(("body", "constraints"), CASES.values(), ids=CASES)
def test_cvxpy_finds_the_same_ends(body: InertialParameters, constraints: list[Constraint]) -> None:
    """The ten; com by Dinkelbach's method; the largest inertia at the com, which is a concave maximum."""
    estimate = near(body, 3)
    intervals = profile_intervals(solve_constrained(estimate, constraints))
    x, rules = in_cvxpy(estimate, constraints)

    def largest(objective: Any) -> float:
        value = cvxpy.Problem(cvxpy.Maximize(objective), rules).solve(solver="CLARABEL")
        return float(value)

    for k, sigma in enumerate(estimate.sigma):
        assert intervals.parameters[k, 0] == pytest.approx(-largest(-x[k] / sigma) * sigma, abs=2e-4 * sigma)
        assert intervals.parameters[k, 1] == pytest.approx(largest(x[k] / sigma) * sigma, abs=2e-4 * sigma)
    for axis in (0, 2):
        ratio = 0.0
        for _ in range(4):
            largest(100.0 * (x[6 + axis] - ratio * x[9]))
            ratio = float(x.value[6 + axis] / x.value[9])
        assert intervals.com[axis, 1] == pytest.approx(ratio, abs=1e-6)
    for k, place, others in ((0, 0, (7, 8)), (2, 5, (6, 7))):
        squares = cvxpy.quad_over_lin(cvxpy.hstack([x[o] for o in others]), x[9])
        highest = largest(100.0 * (x[place] - squares)) / 100.0
        assert intervals.inertia_com[k, k, 1] == pytest.approx(highest, abs=2e-3 * estimate.sigma[place])


@pytest.mark.long
def test_no_body_of_the_set_lies_outside() -> None:
    """The inertia's search is local: no possible body within the distance, of 20,000 drawn, is beyond its ends."""
    estimate = near(DISC, 3)
    result = solve_constrained(estimate)
    ends = profile_intervals(result).inertia_com
    W = np.linalg.inv(np.linalg.cholesky(estimate.covariance))
    q = result.chi2_rise + WIDENING * T**2
    draw = np.random.default_rng(0)
    directions = draw.standard_normal((20_000, 10))
    directions *= np.sqrt(q) / np.linalg.norm(directions, axis=1)[:, None] * draw.uniform(0, 1, (20_000, 1)) ** 0.05
    bodies = [InertialParameters(x) for x in estimate.values + directions @ np.linalg.inv(W).T]
    inside = [body for body in bodies if body.physically_consistent]
    assert len(inside) > 500
    inertias = np.array([body.inertia_com for body in inside])
    assert (inertias >= ends[..., 0] - 1e-9).all()
    assert (inertias <= ends[..., 1] + 1e-9).all()
    assert ((inertias.max(axis=0) - inertias.min(axis=0)) > 0.5 * np.ptp(ends, axis=-1)).all()


def test_without_active_constraint_they_are_the_usual_ones() -> None:
    estimate = near(CUBE, 1)
    estimate = replace(estimate, covariance=1e-4 * estimate.covariance, values=CUBE.vector)
    intervals = profile_intervals(solve_constrained(estimate))
    half = np.sqrt(WIDENING) * T * estimate.sigma
    assert (
        np.abs(intervals.parameters - CUBE.vector[:, None] - half[:, None] * [-1.0, 1.0]).max() < 1e-3 * half.min()
    )
    h, m = slice(6, 9), 9
    gradient = np.zeros((3, 10))
    gradient[:, h], gradient[:, m] = np.eye(3) / CUBE.mass, -CUBE.com / CUBE.mass
    sigma = np.sqrt(np.diag(gradient @ estimate.covariance @ gradient.T))
    assert np.ptp(intervals.com, axis=1) == pytest.approx(2.0 * np.sqrt(WIDENING) * T * sigma, rel=1e-3)


def linear(change: Callable[[Array], Array]) -> Array:
    return np.column_stack([change(unit) for unit in np.eye(10)])


def ends_of(body: InertialParameters, estimate: Estimate, map10: Array) -> Intervals:
    moved = replace(estimate, values=map10 @ estimate.values, covariance=map10 @ estimate.covariance @ map10.T)
    return profile_intervals(solve_constrained(moved))


@pytest.mark.parametrize("seed", [3, 5])
def test_units_and_frames_do_not_matter(seed: int) -> None:
    """Millimetres and grams scale the intervals; mass and principal moments are the same from any other frame."""
    estimate = near(DISC, seed)
    plain = ends_of(DISC, estimate, np.eye(10))
    units = np.array([1e9] * 6 + [1e6] * 3 + [1e3])
    in_units = ends_of(DISC, estimate, np.diag(units))
    assert np.abs(in_units.parameters / units[:, None] - plain.parameters).max() < 1e-5
    assert in_units.com / 1e3 == pytest.approx(plain.com, abs=1e-6)
    assert in_units.principal_moments / 1e9 == pytest.approx(plain.principal_moments, abs=1e-5)
    turn = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))[0]
    turn *= np.linalg.det(turn)
    moved = ends_of(DISC, estimate, linear(lambda x: InertialParameters(x).moved(turn, [0.1, -0.2, 0.05]).vector))
    assert moved.parameters[9] == pytest.approx(plain.parameters[9], abs=1e-4)
    assert moved.principal_moments == pytest.approx(plain.principal_moments, abs=1e-4)


def test_a_payload_that_may_weigh_nothing_has_no_com() -> None:
    estimate = near(CUBE, 1)
    faint = replace(estimate, values=1e-3 * estimate.values)
    intervals = profile_intervals(solve_constrained(faint))
    assert intervals.parameters[9, 0] == pytest.approx(0.0, abs=1e-6)
    assert np.isinf(intervals.com).all()
    assert np.isinf(intervals.principal_moments).all()
