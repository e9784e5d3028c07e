"""Ranges of what data do not determine alone: nothing that fits the data and can exist lies outside them."""

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.estimation import Estimate
from dynident.estimation.fit import Fit
from dynident.estimation.fit.robust import student95
from dynident.estimation.possible import cylinder_prior, origins, parameter_ranges, solve_constrained_prior
from dynident.estimation.possible.constraints import PSEUDO_INERTIA
from dynident.estimation.possible.robot import RobotProgram
from dynident.model import BaseParameters, Robot, base_parameters, load_robot, robot_names, with_stand_in

QUICK = ("rx90", "panda")
ARMS = [pytest.param(name, marks=[] if name in QUICK else [pytest.mark.long]) for name in robot_names()]
T95 = student95(np.inf)


def measured(base: BaseParameters, truth: Array, level: float, away: float) -> Estimate:
    """An estimate with errors of norm ``away`` in standard deviations, a share ``level`` of each parameter."""
    values = base.grouping @ truth
    sigma = level * (np.abs(values) + 0.1)
    errors = np.random.default_rng(3).standard_normal(len(values))
    values = values + away * sigma * errors / np.linalg.norm(errors)
    fit = Fit(np.ones(1), np.ones(1), (1,))
    return Estimate(base.columns, values, np.diag(sigma**2), np.inf, fit, np.ones(1))


def can_exist(problem: RobotProgram, points: Array) -> Array:
    """Whether, in each row, no link has a negative pseudo-inertia and no drive breaks its rules."""
    links = np.linalg.eigvalsh(np.einsum("mlk,kij->mlij", points[:, np.array(problem.links)], PSEUDO_INERTIA))
    drives = points / problem.scale @ problem.rules.A.T + problem.rules.b
    return np.asarray((links >= 0.0).all(axis=(1, 2)) & (drives >= 0.0).all(axis=1))


def furthest(problem: RobotProgram, starts: Array, steps: Array) -> Array:
    """The points along lines that just can exist, at most 100 steps away."""
    low, high = np.zeros(len(starts)), np.full(len(starts), 100.0)
    for _ in range(20):
        middle = 0.5 * (low + high)
        inside = can_exist(problem, starts + middle[:, None] * steps)
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return np.asarray(starts + low[:, None] * steps)


def wandering(problem: RobotProgram, base: BaseParameters, start: Array) -> Array:
    """Robots with the base parameters of one: 50 walks of 20 random ways, each to its end, then some way back."""
    rng = np.random.default_rng(5)
    hidden = np.linalg.svd(base.grouping * problem.scale)[2][len(base.columns) :]
    here, points = np.tile(start, (50, 1)), []
    for _ in range(20):
        steps = rng.standard_normal((len(here), len(hidden))) @ hidden * problem.scale
        ends = furthest(problem, here, steps)
        here = here + 0.9 * rng.random((len(here), 1)) * (ends - here)
        points.append(ends)
    return np.concatenate(points)


def setting(name: str) -> tuple[Robot, BaseParameters, Array]:
    """An arm, its base parameters, and its true standard parameters."""
    robot = with_stand_in(load_robot(name))
    base = base_parameters(robot)
    return robot, base, np.array([robot.parameters[standard] for standard in base.standard])


@pytest.mark.parametrize("name", ARMS)
def test_what_can_exist_and_fits_the_data_lies_inside(name: str) -> None:
    """The true robot, what is written of it, and robots that no motion tells from it."""
    robot, base, truth = setting(name)
    estimate = measured(base, truth, level=0.05, away=0.9 * T95)
    ranges = parameter_ranges(robot, base, estimate)
    assert set(ranges.parameters) == {
        k for k, origin in origins(robot, base).items() if origin.kind != "identified"
    }
    places = [base.standard.index(standard) for standard in ranges.parameters]
    low, high = np.array(list(ranges.parameters.values())).T
    nearest = solve_constrained_prior(robot, base, estimate, cylinder_prior(robot, 20.0)).parameters
    problem = RobotProgram.of(robot, base, estimate, None)
    moved = wandering(problem, base, truth)
    points = np.vstack([truth, [nearest[standard] for standard in base.standard], moved])[:, places]
    rounding = 1e-4 * problem.scale[places]
    assert (points >= low - rounding).all()
    assert (points <= high + rounding).all()
    half_low, half_high = 0.5 * (points[1] + low), 0.5 * (points[1] + high)
    assert ((points < half_low) | (points > half_high)).any(), "ranges half as long would pass too"


@pytest.mark.parametrize("name", QUICK)
def test_what_the_data_determine_has_its_interval(name: str) -> None:
    """Where the bounds of what can exist are far, the range is the 95 % interval; nowhere is it longer."""
    robot, base, truth = setting(name)
    estimate = measured(base, truth, level=1e-3, away=0.0)
    determined = [standard for standard, origin in origins(robot, base).items() if origin.kind == "identified"]
    ranges = parameter_ranges(robot, base, estimate, determined).parameters
    weights = np.linalg.lstsq(base.grouping.T, np.eye(len(truth)), rcond=None)[0]
    sigma = dict(zip(base.standard, np.sqrt(np.diag(weights.T @ estimate.covariance @ weights)), strict=True))
    shares = np.array([(ranges[k][1] - ranges[k][0]) / (2.0 * T95 * sigma[k]) for k in determined])
    assert shares.max() < 1.01
    assert np.median(shares) == pytest.approx(1.0, abs=0.01)
