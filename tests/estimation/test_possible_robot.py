"""Robots that can exist: nearest to the base parameters, nearest to a prior, and who decides each number."""

from collections.abc import Callable
from dataclasses import replace
from math import pi
from pathlib import Path

import cvxpy
import numpy as np
import pytest
from dynident import model
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import Estimate, MassBounds, PossibleBody
from dynident.estimation.equations.observer import Observer, recorded, used
from dynident.estimation.fit.estimate import Fit
from dynident.estimation.fit.linear_problem import weighted
from dynident.estimation.possible.constraints import PSEUDO_INERTIA, ConeProgram, solve_cone
from dynident.estimation.possible.robot import RobotProgram, hidden_directions, solve_constrained_base
from dynident.estimation.possible.whole_robot import (
    BODY_NUMBERS,
    RobotPrior,
    WholeRobot,
    has_prior,
    origins,
    robot_prior,
    solve_constrained_prior,
    whole_robot,
)
from dynident.model.frames import bodies_in_link_frames
from dynident.tests.model.urdf_files import dressed_urdf
from dynident.trajectories import Simulator, random_via_points

NOTHING = Fit(np.ones(1), np.ones(1), (1,))
Parameters = Callable[[model.Robot, int], dict[str, float]]


def noisy_estimate(
    base: model.BaseParameters, truth: Array, seed: int, size: float = 0.2, mixing: float = 0.0
) -> Estimate:
    """Base parameters with independent errors, or with such as are mixed with each other."""
    draw, n = np.random.default_rng(seed), len(truth)
    sigma, errors = size * (np.abs(truth) + 0.1) * draw.uniform(0.2, 1.0, n), draw.standard_normal(n)
    root = sigma[:, None] * (np.eye(n) + mixing * draw.standard_normal((n, n)) / np.sqrt(n))
    return Estimate(base.columns, truth + root @ errors, root @ root.T, np.inf, NOTHING, np.ones(1))


SHARED = (("IA5", "IA6"), ("FV5", "FVM6"), ("FV6", "FVM6"))
"""Parameters that hold a share of rotor 6, and that share."""


@pytest.fixture(scope="module")
def rx90_base(rx90: model.Robot) -> model.BaseParameters:
    return model.base_parameters(rx90)


@pytest.mark.parametrize("seed", range(5))
def test_some_robot_exists(
    rx90: model.Robot, rx90_base: model.BaseParameters, random_parameters: Parameters, seed: int
) -> None:
    """The robot holds every rule exactly and has the base parameters returned."""
    truth = rx90_base.value(random_parameters(rx90, seed))
    estimate = noisy_estimate(rx90_base, truth, seed, 0.5, 0.3)
    result = solve_constrained_base(rx90, rx90_base, estimate)
    for link in range(1, 7):
        ten = np.array([result.parameters[f"{kind}{link}"] for kind in model.INERTIAL])
        assert PossibleBody().violation(ten) <= 0.0
    kinds = ("IA", "FV", "FS", "FVM", "FSM")
    assert min(v for name, v in result.parameters.items() if name.rstrip("0123456789") in kinds) >= 0.0
    assert all(result.parameters[whole] >= result.parameters[part] for whole, part in SHARED)
    assert result.values == pytest.approx(rx90_base.value(result.parameters), rel=1e-12)
    error = result.values - estimate.values
    assert result.chi2_rise == pytest.approx(error @ np.linalg.solve(estimate.covariance, error), rel=1e-6)
    assert bool(result.active) == (result.chi2_rise > 1e-6)
    truth_error = truth - estimate.values
    assert result.chi2_rise <= truth_error @ np.linalg.solve(estimate.covariance, truth_error)


def test_the_nearest_robot_is_that_of_cvxpy(
    rx90: model.Robot, rx90_base: model.BaseParameters, random_parameters: Parameters
) -> None:
    """The problem written plainly, link by link, gives the same."""
    estimate = noisy_estimate(rx90_base, rx90_base.value(random_parameters(rx90, 7)), 7, 0.5, 0.3)
    result = solve_constrained_base(rx90, rx90_base, estimate)
    x = cvxpy.Variable(len(rx90_base.standard))
    place = rx90_base.standard.index
    rules = [x[place(whole)] >= x[place(part)] for whole, part in SHARED]
    for link in range(1, 7):
        ten = [x[place(f"{kind}{link}")] for kind in model.INERTIAL]
        rules.append(sum(v * J for v, J in zip(ten, PSEUDO_INERTIA, strict=True)) >> 0)
    kinds = ("IA", "FV", "FS", "FVM", "FSM")
    rules += [x[k] >= 0 for k, name in enumerate(rx90_base.standard) if name.rstrip("0123456789") in kinds]
    R = np.linalg.inv(np.linalg.cholesky(estimate.covariance))
    distance = cvxpy.norm(R @ (rx90_base.grouping @ x - estimate.values))
    problem = cvxpy.Problem(cvxpy.Minimize(distance), rules)
    problem.solve(solver="CLARABEL")
    assert result.chi2_rise == pytest.approx(problem.value**2, rel=1e-5)
    moved = (rx90_base.grouping @ x.value - result.values) / estimate.sigma
    assert np.abs(moved).max() < 1e-3


def test_negative_friction_is_named(
    rx90: model.Robot, rx90_base: model.BaseParameters, random_parameters: Parameters
) -> None:
    values = rx90_base.value(random_parameters(rx90, 3))
    values[rx90_base.columns.index("FV3")] = -0.5
    estimate = replace(noisy_estimate(rx90_base, values, 3, 0.5, 0.3), values=values)
    result = solve_constrained_base(rx90, rx90_base, estimate)
    assert result.active[0].description == "FV3 >= 0"
    assert dict(zip(rx90_base.columns, result.values, strict=True))["FV3"] == pytest.approx(0.0, abs=1e-6)


def test_a_program_without_an_attained_least_value_is_closed() -> None:
    """A body with a first moment of at least 1 has as little mass as its extent is large: none is the least."""
    only = np.eye(10)
    program = ConeProgram(only[9:], np.zeros(1), only[6:7], -np.ones(1), only[None])
    closed, _ = solve_cone(program, [(1e5, 100.0)])
    assert np.linalg.norm(closed) <= 100.0 * (1.0 + 1e-6)
    assert 0.0 < closed[9] < 0.05
    assert model.InertialParameters(closed).min_pseudo_inertia_eigenvalue > -1e-6


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("budget", [0.01, 1.0, 10.0])
def test_the_budget_is_met(
    rx90: model.Robot, rx90_base: model.BaseParameters, random_parameters: Parameters, seed: int, budget: float
) -> None:
    """chi2 lies the budget above the constrained minimum, and everything is what it says."""
    estimate = noisy_estimate(rx90_base, rx90_base.value(random_parameters(rx90, seed)), seed)
    prior = robot_prior(rx90)
    result = solve_constrained_prior(rx90, rx90_base, estimate, prior, budget)
    least = solve_constrained_base(rx90, rx90_base, estimate).chi2_rise
    assert result.chi2_rise - least == pytest.approx(budget, rel=1e-6)
    error = rx90_base.value(result.parameters) - estimate.values
    assert result.chi2_rise == pytest.approx(error @ np.linalg.solve(estimate.covariance, error), rel=1e-6)
    for link, body in enumerate(prior.bodies, start=1):
        ten = np.array([result.parameters[f"{kind}{link}"] for kind in model.INERTIAL])
        assert PossibleBody().violation(ten) < 0.0
        ratio = model.InertialParameters(ten).pseudo_inertia @ np.linalg.inv(body.pseudo_inertia)
        distance = -np.log(np.linalg.det(ratio)) + np.trace(ratio) - 4.0
        assert result.distances[link - 1] == pytest.approx(distance, rel=1e-6, abs=1e-9)
    kinds = ("IA", "FV", "FS", "FVM", "FSM")
    assert min(v for name, v in result.parameters.items() if name.rstrip("0123456789") in kinds) >= 0.0
    assert result.parameters["IA5"] >= result.parameters["IA6"]


TWO_LINKS = model.Robot(
    "two", (model.Joint(), model.Joint(alpha=-pi / 2, d=0.3)), drives=model.Drives(offsets=True)
)


@pytest.mark.parametrize("friction", [0.5, -0.5])
def test_the_robot_nearest_to_a_prior_is_that_of_cvxpy(random_parameters: Parameters, friction: float) -> None:
    """Least distance within the budget, written plainly: log det and all, friction at its bound or not."""
    base = model.base_parameters(TWO_LINKS)
    estimate = noisy_estimate(base, base.value(random_parameters(TWO_LINKS, 3)), 3)
    values = estimate.values.copy()
    values[base.columns.index("FV2")] = friction
    estimate = replace(estimate, values=values)
    prior = robot_prior(TWO_LINKS, 12.0)
    result = solve_constrained_prior(TWO_LINKS, base, estimate, prior)
    x = cvxpy.Variable(len(base.standard))
    distance, rules = 0.0, [x[k] >= 0 for k, name in enumerate(base.standard) if name[:2] in ("IA", "FV", "FS")]
    for link, body in enumerate(prior.bodies, start=1):
        # In the prior's own coordinates, which leaves the distance as it is.
        root = np.linalg.inv(np.linalg.cholesky(body.pseudo_inertia))
        ten = [x[base.standard.index(f"{kind}{link}")] for kind in model.INERTIAL]
        J = sum(v * (root @ unit @ root.T) for v, unit in zip(ten, PSEUDO_INERTIA, strict=True))
        distance += cvxpy.trace(J) - cvxpy.log_det(J) - 4.0
    R = np.diag(1.0 / estimate.sigma)
    limit = cvxpy.sum_squares(R @ (base.grouping @ x - estimate.values)) <= result.nearest.chi2_rise + 1.0
    problem = cvxpy.Problem(cvxpy.Minimize(distance), [*rules, limit])
    problem.solve(solver="CLARABEL")
    assert sum(result.distances) == pytest.approx(problem.value, rel=1e-4)
    moved = (base.grouping @ x.value - result.values) / estimate.sigma
    assert np.abs(moved).max() < 2e-3
    masses = [result.parameters[f"M{link}"] for link in (1, 2)]
    assert masses == pytest.approx([x.value[base.standard.index(f"M{link}")] for link in (1, 2)], rel=1e-3)
    assert [holding.description for holding in result.active] == (["FV2 >= 0"] if friction < 0.0 else [])


def test_exact_data_of_the_prior_give_the_prior(rx90: model.Robot, rx90_base: model.BaseParameters) -> None:
    data = Simulator(rx90).measure(random_via_points(rx90, 14, seed=0).motion(100.0))
    estimate = weighted(recorded(Observer(rx90, rx90_base.columns), [used(data, model.Processing())])[0])
    result = solve_constrained_prior(rx90, rx90_base, estimate, robot_prior(rx90))
    assert result.status == "prior"
    assert result.weight == np.inf
    assert max(result.distances) < 1e-12
    assert result.parameters == pytest.approx(dict(rx90.parameters), rel=1e-5, abs=1e-5)


def test_units_of_length_do_not_matter(random_parameters: Parameters) -> None:
    """Metres or millimetres: the same robot (kg, mm, s give N·mm / 1000 and so on)."""

    def scaled(robot: model.Robot, size: float) -> model.Robot:
        joints = tuple(replace(joint, d=size * joint.d, r=size * joint.r) for joint in robot.joints)
        return replace(robot, joints=joints, gravity=(0.0, 0.0, -9.81 * size))

    robot = model.load_robot("rx90")
    results = []
    for size in (1.0, 1e3):
        there = scaled(robot, size)
        base = model.base_parameters(there)
        units = units_of(base.standard, size)
        truth = base.value({k: v * units[k] for k, v in random_parameters(robot, 5).items()})
        plain = noisy_estimate(base, truth / [units[name] for name in base.columns], 5)
        factor = np.array([units[name] for name in base.columns])
        estimate = replace(
            plain, values=plain.values * factor, covariance=plain.covariance * np.outer(factor, factor)
        )
        own = [
            [robot.parameters[f"{kind}{link}"] * units[f"{kind}{link}"] for kind in model.INERTIAL]
            for link in range(1, 7)
        ]
        prior = RobotPrior(tuple(model.InertialParameters(np.array(ten)) for ten in own), "test")
        nearest = solve_constrained_prior(there, base, estimate, prior)
        values = {name: value / units[name] for name, value in nearest.parameters.items()}
        results.append((nearest, values))
    (first, metres), (second, millimetres) = results
    origin, same = first.origins, second.origins
    assert second.chi2_rise == pytest.approx(first.chi2_rise, rel=1e-6)
    assert second.weight == pytest.approx(first.weight, rel=1e-4)
    assert second.distances == pytest.approx(first.distances, rel=1e-4, abs=1e-7)
    assert millimetres == pytest.approx(metres, rel=1e-3, abs=1e-5)
    assert {name: o.kind for name, o in same.items()} == {name: o.kind for name, o in origin.items()}
    assert [o.share for o in same.values()] == pytest.approx([o.share for o in origin.values()], abs=1e-9)


def units_of(names: tuple[str, ...], size: float) -> dict[str, float]:
    """Factor of each parameter when lengths are counted ``size`` times."""
    powers = {**dict.fromkeys(model.INERTIAL[:6], 2), **dict.fromkeys(model.INERTIAL[6:9], 1), "M": 0}
    return {name: size ** powers.get(name.rstrip("0123456789"), 2) for name in names}


def test_identified_is_what_no_hidden_direction_moves(robot: model.Robot) -> None:
    """A step that changes no torque leaves identified parameters alone; some such step moves each of the others."""
    base = model.base_parameters(robot)
    still = np.ones(len(base.standard), dtype=bool)
    null = np.linalg.svd(base.grouping)[2][len(base.chosen) :]
    still[np.abs(null).max(axis=0) > 1e-9] = False
    kinds = np.array([o.kind == "identified" for o in origins(robot, base)])
    assert (kinds == still).all()
    hidden = hidden_directions(base)
    assert len(hidden) == len(base.standard) - len(base.chosen)
    assert set(base.unidentifiable) == {text for text in hidden if " " not in text}


def test_total_mass_bounds(
    rx90: model.Robot, rx90_base: model.BaseParameters, random_parameters: Parameters
) -> None:
    """Nothing is lost where there is room; a bound below what the data need is named."""
    estimate = noisy_estimate(rx90_base, rx90_base.value(random_parameters(rx90, 3)), 3)
    free = solve_constrained_base(rx90, rx90_base, estimate)
    wide = solve_constrained_base(rx90, rx90_base, estimate, MassBounds(1.0, 1e4))
    assert wide.chi2_rise == pytest.approx(free.chi2_rise, rel=1e-4, abs=1e-6)
    assert 1.0 <= sum(wide.parameters[f"M{j}"] for j in range(1, 7)) <= 1e4
    tight = solve_constrained_base(rx90, rx90_base, estimate, MassBounds(0.0, 2.0))
    assert tight.chi2_rise > free.chi2_rise + 1.0
    (paid,) = (holding.multiplier for holding in tight.active if holding.description == "total mass <= 2 kg")
    around = (MassBounds(0.0, 2.0 + step) for step in (-2e-3, 2e-3))
    less, more = (solve_constrained_base(rx90, rx90_base, estimate, bounds).chi2_rise for bounds in around)
    unit = RobotProgram.of(rx90, rx90_base, estimate, None).scale[9]
    assert paid == pytest.approx((less - more) / 4e-3 * unit, rel=1e-3)
    assert sum(tight.parameters[f"M{j}"] for j in range(1, 7)) == pytest.approx(2.0, rel=1e-5)
    near = solve_constrained_prior(rx90, rx90_base, estimate, robot_prior(rx90), 1.0, MassBounds(0.0, 40.0))
    assert sum(near.parameters[f"M{j}"] for j in range(1, 7)) <= 40.0 + 1e-4
    assert "total mass <= 40 kg" in [holding.description for holding in near.active]
    assert near.chi2_rise - near.nearest.chi2_rise == pytest.approx(1.0, rel=1e-6)


def test_where_the_prior_comes_from(rx90: model.Robot, rx90_base: model.BaseParameters) -> None:
    assert "robot file of rx90" in robot_prior(rx90).source
    assert robot_prior(rx90).bodies[2].mass == rx90.parameters["M3"]
    assert "50 kg" in robot_prior(rx90, 50.0).source
    tx40 = model.load_robot("tx40")
    assert tx40.mass is not None
    assert sum(body.mass for body in robot_prior(tx40).bodies) == pytest.approx(0.5 * tx40.mass)
    assert robot_prior(tx40).source.endswith("50 % of the maker's 27 kg, which holds the base")
    unsure = replace(tx40, sources={**tx40.sources, "mass": "assumed: by hearsay"})
    assert "holds the base (assumed: by hearsay" in robot_prior(unsure).source
    with pytest.raises(InputError, match="--prior-mass"):
        robot_prior(replace(tx40, mass=None))
    assert [has_prior(robot) for robot in (rx90, tx40, replace(tx40, mass=None))] == [True, True, False]
    some = {name: value for name, value in rx90.parameters.items() if name != "YZ4"}
    with pytest.raises(InputError, match="YZ4 missing"):
        robot_prior(replace(rx90, parameters=some))
    with pytest.raises(InputError, match="prior of link 4"):
        robot_prior(replace(rx90, parameters={**rx90.parameters, "M4": 0.0}))
    with pytest.raises(InputError, match="must be positive"):
        robot_prior(rx90, 0.0)
    estimate = noisy_estimate(rx90_base, np.ones(54), 0)
    with pytest.raises(InputError, match="a prior of 2 links for the 6"):
        solve_constrained_prior(rx90, rx90_base, estimate, robot_prior(TWO_LINKS, 3.0))
    with pytest.raises(InputError, match="budget 0"):
        solve_constrained_prior(rx90, rx90_base, estimate, robot_prior(rx90), 0.0)


def test_every_kind_of_robot(robot: model.Robot, random_parameters: Parameters) -> None:
    """Sliding joints, offsets, springs, coupling."""
    base = model.base_parameters(robot)
    estimate = noisy_estimate(base, base.value(random_parameters(robot, 1)), 1)
    result = solve_constrained_prior(robot, base, estimate, robot_prior(robot, 20.0))
    assert result.chi2_rise - result.nearest.chi2_rise == pytest.approx(1.0, rel=1e-6)
    assert min(result.min_eigenvalues) > 0.0


def exact(base: model.BaseParameters, values: dict[str, float], sigma: float = 0.1) -> Estimate:
    """Base parameters as they are, each with the same standard deviation."""
    C, unit = sigma**2 * np.eye(len(base.columns)), np.ones(1)
    return Estimate(base.columns, base.value(values), C, np.inf, Fit(unit, unit, (1,)), unit)


def numbers(robot: model.Robot, names: tuple[str, ...], x: Array) -> Array:
    """All links' body numbers, one after the other."""
    values = []
    for body in bodies_in_link_frames(robot, dict(zip(names, x.tolist(), strict=True))).values():
        values += [body.mass, *body.com, *body.inertia_com[np.triu_indices(3)]]
    return np.array(values)


def check(robot: model.Robot, values: dict[str, float]) -> WholeRobot:
    """Labels against differences of the numbers themselves along every hidden direction and parameter."""
    base = model.base_parameters(robot)
    x = np.array([values[name] for name in base.standard])
    result = whole_robot(robot, values, "a table", base, exact(base, values))
    labels = [label for link in result.links for label in link.numbers.values()]
    np.testing.assert_allclose([label.value for label in labels], numbers(robot, base.standard, x), rtol=1e-12)

    def differences(directions: Array) -> Array:
        step = 1e-6
        ends = [[numbers(robot, base.standard, x + s * v) for s in (step, -step)] for v in directions]
        return np.array([(high - low) / (2.0 * step) for high, low in ends]).T

    hidden = np.linalg.svd(base.grouping)[2][len(base.chosen) :]
    by_hidden, by_one = np.abs(differences(hidden)).max(axis=1), differences(np.eye(len(x)))
    largest = np.abs(by_one).max(axis=1)
    for label, moved, gradient, size in zip(labels, by_hidden, by_one, largest, strict=True):
        part = {
            base.names[i] for i in np.flatnonzero(np.abs(base.grouping[:, np.abs(gradient) > 1e-7 * size]).any(1))
        }
        assert set(label.origin.base) == part
        assert (label.origin.kind == "prior") == (not part)
        assert (label.origin.kind == "identified") == (moved < 1e-7 * size)
        assert (label.origin.share == 1.0) == (label.origin.kind == "identified")
    by_base = differences(np.asarray(np.linalg.pinv(base.grouping).T, dtype=float))
    for label, slopes in zip(labels, by_base, strict=True):
        assert (label.sigma is None) == (label.origin.kind != "identified")
        if label.sigma is not None and label.interval is not None:
            assert label.sigma == pytest.approx(0.1 * np.linalg.norm(slopes), rel=1e-5, abs=1e-12)
            assert np.subtract(label.interval, label.value) == pytest.approx(
                [-1.96 * label.sigma, 1.96 * label.sigma], rel=1e-3, abs=1e-9
            )
    own = dict(zip(base.standard, origins(robot, base), strict=True))
    by_name = {name: label for link in result.links for name, label in link.parameters.items()}
    assert {name: label.origin for name, label in by_name.items()} == own
    assert {name: label.value for name, label in by_name.items()} == values
    return result


def test_labels_of_every_kind_of_robot(robot: model.Robot, random_parameters: Parameters) -> None:
    result = check(robot, random_parameters(robot, 2))
    assert all(tuple(link.numbers) == BODY_NUMBERS for link in result.links)
    kinds = {label.origin.kind for link in result.links for label in link.numbers.values()}
    assert "combination" in kinds


def test_in_the_frames_of_a_urdf(tmp_path: Path, random_parameters: Parameters) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(dressed_urdf(model.load_robot("irb120"), seed=1), encoding="utf-8")
    robot = model.load_robot(path)
    assert robot.links is not None
    result = check(robot, random_parameters(robot, 4))
    assert [link.link for link in result.links] == list(robot.links.names)
