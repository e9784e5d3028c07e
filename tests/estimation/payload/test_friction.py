"""Friction under load that is not quite the robot's own, within limits."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from dynident.benchmarks import invented
from dynident.common.arrays import Array
from dynident.estimation import FRICTION_CHANGE, Estimate, LongMotion, Settings, payload_estimate, payload_problem
from dynident.estimation.fit.covariance import student95
from dynident.estimation.fit.linear_problem import SoftPrior
from dynident.estimation.payload.methods import METHODS, combined, global_fit
from dynident.estimation.payload.under_load import friction_changes
from dynident.model import InertialParameters, Recording
from dynident.tests.estimation.diagnosis.made import fit_of
from dynident.trajectories import Simulator, random_via_points
from scipy.signal import lfilter

LOAD = InertialParameters.from_com(5.0, [0.01, -0.02, 0.1], np.diag([0.03, 0.03, 0.02]))
NAME = "ur10e"
SEEDS = 3


def remembering(shape: tuple[int, ...], draw: np.random.Generator) -> Array:
    """Noise of variance one that forgets in 20 samples."""
    return np.asarray(lfilter([np.sqrt(1.0 - 0.95**2)], [1.0, -0.95], draw.standard_normal(shape), axis=0))


@cache
def recordings(seed: int, change: float) -> tuple[Recording, Recording]:
    """A motion without and with payload; each joint's friction changes by that share (1 sigma) in between."""
    robot, draw = invented.robot(NAME), np.random.default_rng([seed, 5])
    motion = random_via_points(robot, 7, seed).motion(100.0)
    moved: dict[str, float] = {
        name: value * (1.0 + change * draw.standard_normal())
        for name, value in robot.parameters.items()
        if name.startswith(("FS", "FV"))
    }
    pair = []
    for k, (arm, load) in enumerate(
        ((robot, None), (replace(robot, parameters={**robot.parameters, **moved}), LOAD))
    ):
        recording = Simulator(arm).record(motion, load, None, source=str(k))
        size = 0.02 * np.sqrt(np.mean(recording.torque**2, axis=0))
        noise = size * remembering(recording.torque.shape, draw)
        pair.append(replace(recording, torque=recording.torque + noise))
    return pair[0], pair[1]


def problem_of(seed: int, change: float, share: float) -> LongMotion:
    bare, loaded = recordings(seed, change)
    return payload_problem(invented.robot(NAME), [loaded], [bare], settings=Settings(friction_change=share))


def weighed(change: float, share: float) -> tuple[Array, Array]:
    """Errors of method 4's mass and halves of its intervals over the seeds, as shares of it."""
    errors, halves = [], []
    for seed in range(SEEDS):
        estimate = payload_estimate(problem_of(seed, change, share), 4).estimate
        assert estimate.robust is not None
        errors.append(estimate["M_L"] / LOAD.mass - 1.0)
        halves.append(student95(estimate.robust.degrees_of_freedom) * estimate.robust.sigma[9] / LOAD.mass)
    return np.array(errors), np.array(halves)


@pytest.mark.long
def test_friction_that_changed_moves_the_mass_less_and_is_in_the_interval() -> None:
    plain, _ = weighed(0.1, 0.0)
    errors, halves = weighed(0.1, FRICTION_CHANGE)
    assert np.sqrt(np.mean(errors**2)) < 0.8 * np.sqrt(np.mean(plain**2))
    assert (np.abs(errors) < halves).all()


@pytest.mark.long
def test_friction_that_did_not_change_costs_little() -> None:
    plain, before = weighed(0.0, 0.0)
    errors, halves = weighed(0.0, FRICTION_CHANGE)
    assert np.median(halves) < 1.25 * np.median(before)  # wholly free 2.4 times
    assert np.abs(errors - plain).max() < 0.5 * np.median(before)
    assert (np.abs(errors) < halves).all()


def test_without_a_change_it_is_the_papers_method() -> None:
    problem = problem_of(0, 0.1, 0.0)
    assert not problem.friction
    estimate = METHODS[4](problem).solved()
    assert estimate["M_L"] == pytest.approx(combined(problem)["M_L"])
    # As narrow as can be told, the change is none.
    tight = global_fit(problem_of(0, 0.1, FRICTION_CHANGE))
    tight = replace(tight, soft=dict.fromkeys(tight.soft, SoftPrior(1e-9)))
    assert tight.solved(estimate.weights).values == pytest.approx(estimate.values, rel=1e-5)


def test_how_far_each_friction_may_change() -> None:
    names = ("ZZ1", "FS1", "FV1", "OFF1", "FS2", "FV2", "OFF2", "FSM2")
    values = np.array([1.0, -10.0, 5.0, 0.3, 0.0, 4.0, 0.0, 2.0])
    robot = Estimate(names, values, np.eye(8), 100.0, fit_of(0.05), np.ones(6))
    changes = friction_changes(robot, (4.0, 9.0), 0.2)
    assert {name: change.sigma for name, change in changes.items()} == pytest.approx(
        {"FS1": 2.0, "FV1": 1.0, "FV2": 0.8, "FSM2": 0.4, "OFF1": 0.12, "OFF2": 0.12}
    )
    assert {change.inflation for name, change in changes.items() if name.endswith("2")} == {9.0}
    assert friction_changes(robot, (4.0, 9.0), 0.0) == {}
