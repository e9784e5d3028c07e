"""The constrained payload by another solver, and what its multipliers say."""

from dataclasses import replace

import cvxpy
import numpy as np
import pytest
from dynident.estimation import (
    CentreOfMassInBox,
    Estimate,
    InEllipsoid,
    KnownMass,
    MassBounds,
    build_constrained,
    solve_constrained,
)
from dynident.estimation.possible.constraints import Constraint
from dynident.tests.estimation.estimates import SETS, TABLES, random_estimate


@pytest.mark.parametrize("errors", ["independent", "correlated"])
@pytest.mark.parametrize("rules", SETS.values(), ids=SETS)
def test_cvxpy_agrees_under(rules: list[Constraint], errors: str) -> None:
    estimate = TABLES[1] if errors == "independent" else correlated(TABLES[1])
    result = solve_constrained(estimate, rules)
    problem, values, _ = build_constrained(estimate, rules)
    problem.solve(solver="CLARABEL")
    assert np.abs((values.value - result.values) / estimate.sigma).max() < 1e-3
    for rule in rules:
        if not isinstance(rule, KnownMass):
            assert rule.violation(result.values) <= 1e-7
    assert result.min_pseudo_inertia_eigenvalue >= 0.0


@pytest.mark.parametrize("seed", range(30))
def test_cvxpy_agrees_on_random_problems(seed: int) -> None:
    estimate = random_estimate(seed)
    problem, values, _ = build_constrained(estimate)
    problem.solve(solver="CLARABEL")
    moved = (values.value - solve_constrained(estimate).values) / estimate.sigma
    assert np.abs(moved).max() < 1e-3


def correlated(estimate: Estimate) -> Estimate:
    """A covariance of these sigmas with correlations up to 0.9."""
    draw = np.random.default_rng(4).standard_normal((10, 12))
    C = draw @ draw.T
    scale = estimate.sigma / np.sqrt(np.diag(C))
    return replace(estimate, covariance=C * np.outer(scale, scale))


def test_users_add_their_own_to_cvxpy() -> None:
    """A constraint that the package lacks: the centre of mass on the z axis."""
    problem, values, pseudo_inertia = build_constrained(TABLES[1])
    own = cvxpy.Problem(problem.objective, [*problem.constraints, values[6:8] == 0.0])
    own.solve(solver="CLARABEL")
    assert own.value > np.sqrt(solve_constrained(TABLES[1]).chi2_rise)
    assert np.abs(values.value[6:8]).max() < 1e-8
    assert np.linalg.eigvalsh(pseudo_inertia.value)[0] > -1e-6


def test_active_constraints_are_named_by_weight() -> None:
    result = solve_constrained(TABLES[1], [MassBounds(8.0, 9.0), CentreOfMassInBox([-1] * 3, [1] * 3)])
    assert result.active[0].constraint == MassBounds(8.0, 9.0)
    assert CentreOfMassInBox([-1] * 3, [1] * 3) not in [active.constraint for active in result.active]
    assert result.p_value < 1e-6


def test_an_ellipsoid_in_the_wrong_frame_is_exposed() -> None:
    """The solver finds an optimum all the same; the rise tells, and the list of active constraints names it."""
    wrong = InEllipsoid([0.0, 0.0, -0.1], [0.1, 0.1, 0.12])
    result = solve_constrained(TABLES[1], [wrong])
    assert result.status == "Solved"
    assert result.p_value < 1e-6
    assert wrong in [active.constraint for active in result.active]
    assert wrong.violation(TABLES[1].values) > 0.0
    assert result.chi2_rise > 100.0 * solve_constrained(TABLES[1]).chi2_rise


def test_multiplier_is_the_price_of_a_bound() -> None:
    """d chi2 / d bound by finite difference; the scaled unit of mass is the mass of the estimate."""
    prices = [solve_constrained(TABLES[1], [MassBounds(high=7.1 + step)]).chi2_rise for step in (-1e-3, 1e-3)]
    slope = (prices[0] - prices[1]) / 2e-3 * TABLES[1]["M_L"]
    active = {type(a.constraint): a.multiplier for a in solve_constrained(TABLES[1], [MassBounds(high=7.1)]).active}
    assert active[MassBounds] == pytest.approx(slope, rel=1e-3)
