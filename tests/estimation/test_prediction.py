"""Predicted torques against the reduced problem's residuals and the simulated truth; autocorrelation."""

from dataclasses import replace

import numpy as np
import pytest
from dynident.apps.commands.demo import PAYLOAD
from dynident.estimation import Settings, answer_payload, identify, payload_problem
from dynident.estimation.answers.system import robot_prediction
from dynident.estimation.fit.blocks import autocorrelation
from dynident.estimation.fit.estimate import fit
from dynident.estimation.fit.own_equations import base_problem
from dynident.model import Recording, load_robot
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points

ROBOT = load_robot("rx90")
QUIET = tuple(0.1 * sigma for sigma in RX90_NOISE)


def recorded(seed: int, loaded: int) -> Recording:
    motion = random_via_points(ROBOT, 8, seed=seed).motion(250.0)
    return Simulator(ROBOT).record(motion, PAYLOAD if loaded else None, QUIET, [seed, loaded])


def test_residuals_are_those_of_the_fit() -> None:
    """By W of the held-out recording, and by its triangular factor."""
    used, second = recorded(0, False), recorded(1, False)
    result = identify(ROBOT, [used], Settings(robust=False), validation=[second])
    prediction = robot_prediction(result.robot, result.base, result.estimate.values, second, ROBOT.processing, True)
    (same,) = result.predictions
    assert np.array_equal(same.measured[0], prediction.measured[0])
    assert same.held_out
    assert result.validation is not None
    assert np.allclose(prediction.relative_per_joint, result.validation.relative_per_joint, rtol=1e-6)
    settings, values = Settings(ROBOT.processing, robust=False), result.estimate.values
    check = base_problem(result.robot, result.base, [second], settings, fitted=values)
    assert np.allclose(prediction.relative_per_joint, fit(check, values).relative_per_joint, rtol=1e-6)
    assert prediction.worst == int(np.argmax(result.validation.relative_per_joint))
    assert prediction.held_out
    assert not prediction.loaded


def test_payload_explains_loaded_torques() -> None:
    bare, loaded, bare_again, fresh = (recorded(seed, load) for seed, load in ((0, 0), (0, 1), (1, 0), (1, 1)))
    answer = answer_payload(
        payload_problem(ROBOT, [loaded], [bare], settings=Settings(robust=False)), held_out=[bare_again]
    )
    first, second = answer.predictions
    assert (first.held_out, first.loaded, second.held_out, second.loaded) == (True, False, False, True)
    held_out = answer.prediction(fresh, True)
    with_payload = held_out.relative_per_joint
    without = replace(held_out, curves={"bare": held_out.curves["predicted without payload"]}).relative_per_joint
    assert (with_payload < 0.1).all()
    assert without[1] > 5.0 * with_payload[1], "joint 2 carries it"


def test_autocorrelation_of_known_series() -> None:
    rng, n, a = np.random.default_rng(0), 40_000, 0.8
    white = rng.standard_normal(n)
    series = np.empty(n)
    series[0] = white[0]
    for k in range(1, n):
        series[k] = a * series[k - 1] + white[k]
    t = np.arange(n) * np.float64(0.01)
    rho = autocorrelation(t, series, 0.01, 5)
    assert rho == pytest.approx(a ** np.arange(6), abs=0.03)
    mask = rng.random(n) < 0.7
    assert autocorrelation(t[mask], series[mask], 0.01, 5) == pytest.approx(rho, abs=0.03)
    assert autocorrelation(t, 0.0 * series, 0.01, 2).tolist() == [1.0, 0.0, 0.0]
    assert autocorrelation(t[:0], series[:0], 0.01, 2).tolist() == [1.0, 0.0, 0.0]
