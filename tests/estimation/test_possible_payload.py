"""Constrained payloads: each constraint, the nearest body that can exist, conflicts, and the intervals."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import cvxpy
import numpy as np
import pytest
from dynident.apps.commands.simulate import PAYLOAD as PAPER_PAYLOAD
from dynident.apps.report.sections.payload import method_notes
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import (
    PAYLOAD,
    CentreOfMassInBox,
    Estimate,
    InEllipsoid,
    KnownMass,
    LongMotion,
    MassBounds,
    PossibleBody,
    SolverError,
    answer_payload,
    build_constrained,
    payload_problem,
    solve_constrained,
)
from dynident.estimation.fit.estimate import Fit, error_model
from dynident.estimation.possible import payload as possible_payload
from dynident.estimation.possible.constraints import PSEUDO_INERTIA, Constraint
from dynident.estimation.possible.intervals import THIN, WIDENING, Intervals, profile_intervals, thin_directions
from dynident.examples.paper.printed import Printed, paper_tables
from dynident.model import InertialParameters, Motion
from dynident.trajectories import Simulator

NOTHING = Fit(np.ones(1), np.ones(1), (1,))


def estimate_of(values: Array, covariance: Array, names: tuple[str, ...] = PAYLOAD) -> Estimate:
    return Estimate(names, values, covariance, np.inf, NOTHING, np.ones(1))


def random_estimate(seed: int) -> Estimate:
    """Grams to tonnes, millimetres to metres, every second one a thin body; errors of 0.1 to 30 %, correlated."""
    draw = np.random.default_rng(seed)
    mass, length = 10.0 ** draw.uniform(-3, 3), 10.0 ** draw.uniform(-3, 0.5)
    points = draw.uniform(-1.0, 1.0, (3 + 3 * (seed % 2), 3)) * length
    second = points.T @ points * mass / len(points)
    inertia = np.trace(second) * np.eye(3) - second
    moments = mass * points.mean(axis=0)
    truth = np.concatenate([inertia[np.triu_indices(3)], moments, [mass]])
    size = np.array([mass * length**2] * 6 + [mass * length] * 3 + [mass])
    root = 10.0 ** draw.uniform(-3, -0.5) * size[:, None] * draw.standard_normal((10, 12)) / np.sqrt(12)
    return estimate_of(truth + root @ draw.standard_normal(12), root @ root.T)


def printed(rows: dict[str, Printed]) -> Estimate:
    """A published table; its sigma taken as independent."""
    sigma = np.array([row.two_sigma / 2.0 for row in rows.values()])
    values = np.array([row.value for row in rows.values()])
    return estimate_of(values, np.diag(sigma**2), tuple(f"{kind}_L" for kind in rows))


TABLES = {1: printed(paper_tables().table1), 2: printed(paper_tables().table2)}
ELLIPSOID = InEllipsoid([0.0, 0.0, 0.1], [0.1, 0.08, 0.09])
SETS: dict[str, list[Constraint]] = {
    "possible": [],
    "mass bounds": [MassBounds(7.1, 7.19)],
    "weighed": [KnownMass(7.18, 0.01)],
    "centre of mass": [CentreOfMassInBox([-0.1, -0.1, 0.0], [0.1, 0.1, 0.134])],
    "ellipsoid": [ELLIPSOID],
    "together": [MassBounds(7.1, 7.19), KnownMass(7.18, 0.01), ELLIPSOID, CentreOfMassInBox([-1] * 3, [1] * 3)],
}

Cloud = Callable[[Array, Array], InertialParameters]
ROTATION = np.linalg.qr(np.random.default_rng(5).standard_normal((3, 3)))[0]
CENTRE, SEMI_AXES = np.array([0.05, -0.1, 0.2]), np.array([0.1, 0.2, 0.3])


def test_centre_of_mass_in_box(cloud: Cloud) -> None:
    rule = CentreOfMassInBox([-0.1, -0.1, 0.0], [0.1, 0.1, 0.3])
    ends = np.array([[0.5, 0.0, 0.1], [-0.5, 0.0, 0.1]])
    assert rule.violation(cloud(np.array([1.0, 1.0]), ends).vector) < 0.0
    assert rule.violation(cloud(np.array([2.0, 1.0]), ends).vector) > 0.0


def ellipsoid_points(count: int, radius: float, seed: int) -> Array:
    """Points of a scaled ellipsoid's surface."""
    directions = np.random.default_rng(seed).standard_normal((count, 3))
    directions *= radius / np.linalg.norm(directions, axis=1)[:, None]
    return np.asarray(CENTRE + directions * SEMI_AXES @ ROTATION.T)


def test_ellipsoid_tells_inside_from_outside(cloud: Cloud) -> None:
    rule = InEllipsoid(CENTRE, SEMI_AXES, ROTATION)
    for seed in range(50):
        masses = np.random.default_rng(seed).uniform(0.1, 1.0, 5)
        assert rule.violation(cloud(masses, ellipsoid_points(5, 0.99, seed)).vector) < 0.0
        assert rule.violation(cloud(masses, ellipsoid_points(5, 1.01, seed)).vector) > 0.0


@pytest.mark.parametrize(("table", "chi2"), [(1, 0.16), (2, 0.62)])
def test_nearest_possible_payload_costs_nothing(table: int, chi2: float) -> None:
    result = solve_constrained(TABLES[table])
    assert result.chi2_rise == pytest.approx(chi2, abs=0.005)
    moved = result.values[[PAYLOAD.index(name) for name in result.free.names]] - result.free.values
    assert np.abs(moved / result.free.sigma).max() < 0.5
    assert result.body.physically_consistent
    assert [active.constraint for active in result.active] == [PossibleBody()]
    assert result.p_value > 0.98


def test_a_scale_pulls_the_mass() -> None:
    """Two independent measurements of one mass, weighted by their variances; chi2 of their difference."""
    values = InertialParameters.from_com(2.0, [0.1, 0.0, 0.2], np.diag([0.02, 0.02, 0.03])).vector
    free = estimate_of(values, np.diag(np.full(10, 1e-4)))
    result = solve_constrained(free, [KnownMass(2.03, 0.02)])
    assert result.body.mass == pytest.approx((2.0 / 1e-4 + 2.03 / 4e-4) / (1e4 + 2500.0))
    assert result.chi2_rise == pytest.approx(0.03**2 / 5e-4)


def test_rank_and_finiteness_are_checked_first() -> None:
    sigma = TABLES[1].sigma
    C = np.diag(sigma**2)
    C[8, 9] = C[9, 8] = sigma[8] * sigma[9]
    with pytest.raises(InputError, match="cannot separate MZ_L, M_L"):
        solve_constrained(replace(TABLES[1], covariance=C))
    with pytest.raises(InputError, match="not a covariance"):
        solve_constrained(replace(TABLES[1], covariance=np.diag(sigma**2 * ([1.0] * 9 + [0.0]))))
    with pytest.raises(InputError, match="not that of a payload"):
        solve_constrained(replace(TABLES[1], names=tuple(f"X{k}" for k in range(10))))


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
    assert result.body.min_pseudo_inertia_eigenvalue >= 0.0


@pytest.mark.parametrize("seed", range(30))
def test_cvxpy_agrees_on_random_problems(seed: int) -> None:
    """And no eigenvalue is negative, not even by rounding, in SI units; chi2 is that of the values returned."""
    estimate = random_estimate(seed)
    result, (problem, values, _) = solve_constrained(estimate), build_constrained(estimate)
    problem.solve(solver="CLARABEL")
    error = result.values - estimate.values
    assert np.abs((values.value - result.values) / estimate.sigma).max() < 1e-3
    assert np.linalg.eigvalsh(InertialParameters(result.values).pseudo_inertia)[0] >= 0.0
    distance = error @ np.linalg.solve(estimate.covariance, error)
    assert result.chi2_rise == pytest.approx(distance, rel=1e-3, abs=1e-6)


def correlated(estimate: Estimate) -> Estimate:
    """A covariance of these sigmas with correlations up to 0.9."""
    draw = np.random.default_rng(4).standard_normal((10, 12))
    C = draw @ draw.T
    scale = estimate.sigma / np.sqrt(np.diag(C))
    return replace(estimate, covariance=C * np.outer(scale, scale))


def test_multiplier_is_the_price_of_a_bound() -> None:
    """d chi2 / d bound by finite difference; the scaled unit of mass is the mass of the estimate."""
    prices = [solve_constrained(TABLES[1], [MassBounds(high=7.1 + step)]).chi2_rise for step in (-1e-3, 1e-3)]
    slope = (prices[0] - prices[1]) / 2e-3 * TABLES[1]["M_L"]
    active = {type(a.constraint): a.multiplier for a in solve_constrained(TABLES[1], [MassBounds(high=7.1)]).active}
    assert active[MassBounds] == pytest.approx(slope, rel=1e-3)


@pytest.fixture(scope="module")
def problem(
    simulated: Callable[[str], Simulator], wander: Callable[..., Motion], payload: InertialParameters
) -> LongMotion:
    """An RX90 with 7.025 kg, in blocks of time."""
    simulator = simulated("rx90")
    motion = wander(6, 4, points=20)
    noise = [3.0] * 6
    bare, loaded = (simulator.record(motion, body, noise, [9, k]) for k, body in enumerate((None, payload)))
    return payload_problem(simulator.robot, [loaded], [bare])


def by_method_4(problem: LongMotion) -> LongMotion:
    return replace(problem, settings=replace(problem.settings, methods=(4,)))


def test_the_error_model_keeps_the_correlations(problem: LongMotion) -> None:
    estimate = answer_payload(by_method_4(problem)).estimates[0].estimate
    model = error_model(estimate)
    sigma = np.outer(estimate.sigma, estimate.sigma)
    assert model.covariance / np.outer(model.sigma, model.sigma) == pytest.approx(estimate.covariance / sigma)
    assert (model.values == estimate.values).all()


WRONG: dict[str, Constraint] = {
    "mass bound": MassBounds(high=6.0),
    "ellipsoid": InEllipsoid([0.0, 0.0, -0.2], [0.1, 0.1, 0.1]),
    "box": CentreOfMassInBox([0.2, -0.1, 0.0], [0.4, 0.1, 0.3]),
}


@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG)
def test_what_excludes_the_truth_is_named(problem: LongMotion, wrong: Constraint) -> None:
    """And a true constraint beside it is not blamed; no interval is told."""
    right = CentreOfMassInBox([-0.5] * 3, [0.5] * 3)
    answer = answer_payload(problem, constraints=[right, wrong])
    assert answer.verdict.level == "do_not_use"
    assert any(wrong.description in reason for reason in answer.verdict.reasons)
    for estimate in answer.constrained:
        against = [active.constraint for active in estimate.tested if active.conflict]
        assert wrong in against
        assert right not in against
        assert estimate.conflict
        assert np.isnan(estimate.intervals.parameters).all()
    notes = list(method_notes(answer.result))
    assert any(note.startswith("Contradicted by method 1, 2, 3, 4: " + wrong.description) for note in notes)
    assert notes[0].startswith("No intervals")


def test_no_body_at_all_is_an_error_that_names_the_constraints(problem: LongMotion) -> None:
    apart = [
        InEllipsoid([0.0, 0.0, -0.5], [0.1] * 3),
        CentreOfMassInBox([0.0] * 3, [0.3] * 3),
        MassBounds(5.0, 9.0),
    ]
    with pytest.raises(SolverError, match="no body holds all constraints") as caught:
        answer_payload(problem, constraints=apart)
    for constraint in apart:
        assert constraint.description in str(caught.value)


@pytest.mark.long
def test_a_true_constraint_is_rarely_called_a_conflict(problem: LongMotion, payload: InertialParameters) -> None:
    """A mass bound at the very truth contradicts 1 % of the data at most."""
    model = error_model(answer_payload(by_method_4(problem)).estimates[0].estimate)
    draw = np.random.default_rng(0)
    root = np.linalg.cholesky(model.covariance)
    called = 0
    for _ in range(300):
        scale = draw.chisquare(model.degrees_of_freedom) / model.degrees_of_freedom
        values = payload.vector + root @ draw.standard_normal(10)
        sample = replace(model, values=values, covariance=scale * model.covariance)
        rules: list[Constraint] = [PossibleBody(), MassBounds(high=payload.mass)]
        called += any(test.conflict for test in possible_payload.tested(solve_constrained(sample, rules)))
    assert called <= 6


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


def in_cvxpy(estimate: Estimate, constraints: Sequence[Constraint], widening: float) -> tuple[Any, list[Any]]:
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
    return x, [*rules, distance <= nearest + widening * T**2]


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
    result = solve_constrained(estimate, constraints)
    intervals, thin = profile_intervals(result), thin_directions(result)
    assert (thin > 1) == (body is DISC)
    of_inertia = in_cvxpy(estimate, constraints, THIN if thin > 1 else WIDENING)
    x, rules = of_inertia

    def largest(objective: Any) -> float:
        value = cvxpy.Problem(cvxpy.Maximize(objective), rules).solve(solver="CLARABEL")
        return float(value)

    for k, sigma in enumerate(estimate.sigma):
        if k == 6:
            x, rules = in_cvxpy(estimate, constraints, WIDENING)
        assert intervals.parameters[k, 0] == pytest.approx(-largest(-x[k] / sigma) * sigma, abs=2e-4 * sigma)
        assert intervals.parameters[k, 1] == pytest.approx(largest(x[k] / sigma) * sigma, abs=2e-4 * sigma)
    for axis in (0, 2):
        ratio = 0.0
        for _ in range(4):
            largest(100.0 * (x[6 + axis] - ratio * x[9]))
            ratio = float(x.value[6 + axis] / x.value[9])
        assert intervals.com[axis, 1] == pytest.approx(ratio, abs=1e-6)
    x, rules = of_inertia
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
    assert thin_directions(result) > 1
    q = result.chi2_rise + THIN * T**2
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
    units10 = [InertialParameters(unit).moved(turn, [0.1, -0.2, 0.05]).vector for unit in np.eye(10)]
    moved = ends_of(DISC, estimate, np.column_stack(units10))
    assert moved.parameters[9] == pytest.approx(plain.parameters[9], abs=1e-4)
    assert moved.principal_moments == pytest.approx(plain.principal_moments, abs=1e-4)
