"""The robot nearest to a prior that the data allow."""

from collections.abc import Callable
from dataclasses import replace
from math import pi
from pathlib import Path

import cvxpy
import numpy as np
import pytest
from dynident.apps.logs.read import read_recording
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import Estimate, MassBounds, PossibleBody, Settings, identify
from dynident.estimation.equations.observer import Observer
from dynident.estimation.equations.reduction import reduced_measurement
from dynident.estimation.fit.estimate import Fit
from dynident.estimation.fit.least_squares import weighted
from dynident.estimation.possible.constraints import PSEUDO_INERTIA
from dynident.estimation.possible.prior import (
    PriorRobot,
    RobotPrior,
    has_prior,
    robot_prior,
    solve_constrained_prior,
)
from dynident.estimation.possible.robot import hidden_directions, solve_constrained_base
from dynident.estimation.possible.whole_robot import origins
from dynident.model import (
    INERTIAL,
    BaseParameters,
    Drives,
    InertialParameters,
    Joint,
    Processing,
    Robot,
    base_parameters,
    load_robot,
)
from dynident.trajectories import Simulator, random_via_points

NOTHING = Fit(np.ones(1), np.ones(1), (1,))
Parameters = Callable[[Robot, int], dict[str, float]]


def noisy_estimate(base: BaseParameters, truth: Array, seed: int, size: float = 0.2) -> Estimate:
    """Base parameters with independent errors."""
    draw = np.random.default_rng(seed)
    sigma = size * (np.abs(truth) + 0.1) * draw.uniform(0.2, 1.0, len(truth))
    values = truth + sigma * draw.standard_normal(len(truth))
    return Estimate(base.columns, values, np.diag(sigma**2), np.inf, NOTHING, np.ones(1))


@pytest.fixture(scope="module")
def rx90_base(rx90: Robot) -> BaseParameters:
    return base_parameters(rx90)


def divergence(P: Array, P0: Array) -> float:
    ratio = P @ np.linalg.inv(P0)
    return float(-np.log(np.linalg.det(ratio)) + np.trace(ratio) - 4.0)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("budget", [0.01, 1.0, 10.0])
def test_the_budget_is_met(
    rx90: Robot, rx90_base: BaseParameters, random_parameters: Parameters, seed: int, budget: float
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
        ten = np.array([result.parameters[f"{kind}{link}"] for kind in INERTIAL])
        assert PossibleBody().violation(ten) < 0.0
        distance = divergence(InertialParameters(ten).pseudo_inertia, body.pseudo_inertia)
        assert result.distances[link - 1] == pytest.approx(distance, rel=1e-6, abs=1e-9)
    kinds = ("IA", "FV", "FS", "FVM", "FSM")
    assert min(v for name, v in result.parameters.items() if name.rstrip("0123456789") in kinds) >= 0.0
    assert result.parameters["IA5"] >= result.parameters["IA6"]


def test_a_larger_budget_brings_it_nearer(
    rx90: Robot, rx90_base: BaseParameters, random_parameters: Parameters
) -> None:
    estimate = noisy_estimate(rx90_base, rx90_base.value(random_parameters(rx90, 9)), 9)
    far = [
        sum(solve_constrained_prior(rx90, rx90_base, estimate, robot_prior(rx90), budget).distances)
        for budget in (0.1, 1.0, 10.0, 100.0)
    ]
    assert far == sorted(far, reverse=True)


TWO_LINKS = Robot("two", (Joint(), Joint(alpha=-pi / 2, d=0.3)), drives=Drives(offsets=True))


@pytest.mark.parametrize("friction", [0.5, -0.5])
def test_cvxpy_agrees(random_parameters: Parameters, friction: float) -> None:
    """Least distance within the budget, written plainly: log det and all, friction at its bound or not."""
    base = base_parameters(TWO_LINKS)
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
        ten = [x[base.standard.index(f"{kind}{link}")] for kind in INERTIAL]
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


def test_exact_data_of_the_prior_give_the_prior(rx90: Robot, rx90_base: BaseParameters) -> None:
    data = Simulator(rx90).measure(random_via_points(rx90, 14, seed=0).motion(100.0))
    estimate = weighted(reduced_measurement(Observer(rx90, rx90_base.columns), data, Processing()))
    result = solve_constrained_prior(rx90, rx90_base, estimate, robot_prior(rx90))
    assert result.status == "prior"
    assert result.weight == np.inf
    assert max(result.distances) < 1e-12
    assert result.parameters == pytest.approx(dict(rx90.parameters), rel=1e-5, abs=1e-5)


def test_units_of_length_do_not_matter(random_parameters: Parameters) -> None:
    """Metres or millimetres: the same robot (kg, mm, s give N·mm / 1000 and so on)."""

    def scaled(robot: Robot, size: float) -> Robot:
        joints = tuple(replace(joint, d=size * joint.d, r=size * joint.r) for joint in robot.joints)
        return replace(robot, joints=joints, gravity=(0.0, 0.0, -9.81 * size))

    robot = load_robot("rx90")
    results = []
    for size in (1.0, 1e3):
        there = scaled(robot, size)
        base = base_parameters(there)
        units = units_of(base.standard, size)
        truth = base.value({k: v * units[k] for k, v in random_parameters(robot, 5).items()})
        plain = noisy_estimate(base, truth / [units[name] for name in base.columns], 5)
        factor = np.array([units[name] for name in base.columns])
        estimate = replace(
            plain, values=plain.values * factor, covariance=plain.covariance * np.outer(factor, factor)
        )
        own = [
            [robot.parameters[f"{kind}{link}"] * units[f"{kind}{link}"] for kind in INERTIAL]
            for link in range(1, 7)
        ]
        prior = RobotPrior(tuple(InertialParameters(np.array(ten)) for ten in own), "test")
        nearest = solve_constrained_prior(there, base, estimate, prior)
        values = {name: value / units[name] for name, value in nearest.parameters.items()}
        results.append((nearest, values, origins(there, base)))
    (first, metres, origin), (second, millimetres, same) = results
    assert second.chi2_rise == pytest.approx(first.chi2_rise, rel=1e-6)
    assert second.weight == pytest.approx(first.weight, rel=1e-4)
    assert second.distances == pytest.approx(first.distances, rel=1e-4, abs=1e-7)
    assert millimetres == pytest.approx(metres, rel=1e-3, abs=1e-5)
    assert {name: o.kind for name, o in same.items()} == {name: o.kind for name, o in origin.items()}
    assert [o.share for o in same.values()] == pytest.approx([o.share for o in origin.values()], abs=1e-9)


def units_of(names: tuple[str, ...], size: float) -> dict[str, float]:
    """Factor of each parameter when lengths are counted ``size`` times."""
    powers = {**dict.fromkeys(INERTIAL[:6], 2), **dict.fromkeys(INERTIAL[6:9], 1), "M": 0}
    return {name: size ** powers.get(name.rstrip("0123456789"), 2) for name in names}


def test_who_decides_on_the_rx90(rx90: Robot, rx90_base: BaseParameters) -> None:
    by_name = origins(rx90, rx90_base)
    assert {name for name, o in by_name.items() if o.kind == "prior"} == set(rx90_base.unidentifiable)
    assert by_name["MZ2"].decided_by() == "prior"
    assert (by_name["MX2"].kind, by_name["MX2"].base) == ("combination", ("MX2R",))
    assert by_name["M3"].base == ("ZZ1R", "XX2R", "ZZ2R", "MX2R")
    assert by_name["M3"].decided_by() == "prior within ZZ1R, XX2R, ZZ2R, MX2R"
    assert (by_name["M1"].decided_by(), by_name["XY3"].decided_by()) == ("prior", "data")
    assert by_name["M1"] == ((), 0.0)
    for name in ("XY3", "IA3", "FV1", "FSM6", "MX6", "ZZ6"):
        assert (by_name[name].kind, by_name[name].share) == ("identified", 1.0)


def test_identified_is_what_no_hidden_direction_moves(robot: Robot) -> None:
    """A step that changes no torque leaves identified parameters alone; some such step moves each of the others."""
    base = base_parameters(robot)
    still = np.ones(len(base.standard), dtype=bool)
    null = np.linalg.svd(base.grouping)[2][len(base.chosen) :]
    still[np.abs(null).max(axis=0) > 1e-9] = False
    kinds = np.array([o.kind == "identified" for o in origins(robot, base).values()])
    assert (kinds == still).all()
    hidden = hidden_directions(base)
    assert len(hidden) == len(base.standard) - len(base.chosen)
    assert set(base.unidentifiable) == {text for text in hidden if " " not in text}


def test_hidden_directions_change_no_torque(rx90: Robot, rx90_base: BaseParameters) -> None:
    for text in hidden_directions(rx90_base):
        change = dict.fromkeys(rx90_base.standard, 0.0)
        sign, size = 1.0, 1.0
        for word in text.split():
            if word in "+-":
                sign, size = (1.0 if word == "+" else -1.0), 1.0
            elif word in change:
                change[word] = sign * size
            else:
                size = float(word)
        assert np.abs(rx90_base.value(change)).max() < 1e-6, text


def test_total_mass_bounds(rx90: Robot, rx90_base: BaseParameters, random_parameters: Parameters) -> None:
    """Nothing is lost where there is room; a bound below what the data need is named."""
    estimate = noisy_estimate(rx90_base, rx90_base.value(random_parameters(rx90, 3)), 3)
    free = solve_constrained_base(rx90, rx90_base, estimate)
    wide = solve_constrained_base(rx90, rx90_base, estimate, MassBounds(1.0, 1e4))
    assert wide.chi2_rise == pytest.approx(free.chi2_rise, rel=1e-4, abs=1e-6)
    assert 1.0 <= sum(wide.parameters[f"M{j}"] for j in range(1, 7)) <= 1e4
    tight = solve_constrained_base(rx90, rx90_base, estimate, MassBounds(0.0, 2.0))
    assert tight.chi2_rise > free.chi2_rise + 1.0
    assert "total mass <= 2 kg" in [holding.description for holding in tight.active]
    assert sum(tight.parameters[f"M{j}"] for j in range(1, 7)) == pytest.approx(2.0, rel=1e-5)
    near = solve_constrained_prior(rx90, rx90_base, estimate, robot_prior(rx90), 1.0, MassBounds(0.0, 40.0))
    assert sum(near.parameters[f"M{j}"] for j in range(1, 7)) <= 40.0 + 1e-4
    assert "total mass <= 40 kg" in [holding.description for holding in near.active]
    assert near.chi2_rise - near.nearest.chi2_rise == pytest.approx(1.0, rel=1e-6)


def test_cylinders(rx90: Robot) -> None:
    prior = robot_prior(rx90, 100.0)
    assert sum(body.mass for body in prior.bodies) == pytest.approx(100.0, rel=1e-12)
    radius = 0.08 * 0.9
    arm, wrist = prior.bodies[1], prior.bodies[5]
    assert arm.com == pytest.approx([0.225, 0.0, 0.0])
    assert arm.mass / wrist.mass == pytest.approx((0.45 + 2.0 * radius) / (2.0 * radius))
    principal = np.diag(arm.inertia_com)
    assert principal[0] == pytest.approx(arm.mass * radius**2 / 2.0)
    assert principal[1:] == pytest.approx([arm.mass * (3 * radius**2 + (0.45 + 2 * radius) ** 2) / 12.0] * 2)
    assert all(body.min_pseudo_inertia_eigenvalue > 0.0 for body in prior.bodies)


def test_where_the_prior_comes_from(rx90: Robot, rx90_base: BaseParameters) -> None:
    assert "robot file of rx90" in robot_prior(rx90).source
    assert robot_prior(rx90).bodies[2].mass == rx90.parameters["M3"]
    assert "50 kg" in robot_prior(rx90, 50.0).source
    tx40 = load_robot("tx40")
    assert tx40.mass is not None
    assert sum(body.mass for body in robot_prior(tx40).bodies) == pytest.approx(0.5 * tx40.mass)
    assert robot_prior(tx40).source.endswith("50 % of the maker's 27 kg, which holds the base")
    assert "holds the base (assumed: " in robot_prior(load_robot("ur10e")).source
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


def test_every_kind_of_robot(robot: Robot, random_parameters: Parameters) -> None:
    """Sliding joints, offsets, springs, coupling."""
    base = base_parameters(robot)
    estimate = noisy_estimate(base, base.value(random_parameters(robot, 1)), 1)
    result = solve_constrained_prior(robot, base, estimate, robot_prior(robot, 20.0))
    assert result.chi2_rise - result.nearest.chi2_rise == pytest.approx(1.0, rel=1e-6)
    assert min(result.min_eigenvalues) > 0.0


@pytest.mark.parametrize(("name", "file", "mass"), [("ur10e", "ur10e/unloaded", 30.0), ("tx40", "tx40/tx40", 25.0)])
def test_real_robots(recordings: Path, name: str, file: str, mass: float) -> None:
    robot = load_robot(name)
    gains = (11.976, 11.976, 9.839, 10.763, 10.757, 10.680) if name == "ur10e" else None
    identification = identify(
        robot, [read_recording(recordings / f"{file}.csv.gz", robot, gains)], Settings(robust=False)
    )
    result: PriorRobot = solve_constrained_prior(
        robot, identification.base, identification.estimate, robot_prior(robot, mass)
    )
    assert result.chi2_rise - result.nearest.chi2_rise == pytest.approx(1.0, rel=1e-6)
    assert min(result.min_eigenvalues) > 0.0
    assert result.distances[0] < 1e-6  # no motion shows link 1 but for ZZ1, which IA1 takes
    assert all(0.05 < result.parameters[f"M{link}"] < 20.0 for link in range(1, 7))
