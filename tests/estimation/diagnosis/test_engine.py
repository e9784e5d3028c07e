"""The least-squares engine of diagnosis against plain least squares, over all arms whose drives are single."""

from dataclasses import replace

import numpy as np
import pytest
from dynident.estimation.diagnosis.engine import System
from dynident.estimation.diagnosis.states import States
from dynident.model import load_robot, robot_names
from dynident.tests.estimation.gains import made

SINGLE = [name for name in robot_names() if not (load_robot(name).coupling or load_robot(name).spring)]


@pytest.mark.parametrize("name", SINGLE)
def test_scales_of_the_joints_torques_are_found(name: str) -> None:
    """Torques wrong by up to half leave no more than right ones, and as much as plain least squares leaves."""
    robot, currents = load_robot(name), made.recorded(name, made.moved(name, 3), None, (3, 0))
    recording = replace(currents, torque=currents.torque * made.truth(name, 3))
    right = System.of(robot, States.of(recording, robot.processing))
    factors = np.exp(np.random.default_rng(5).uniform(-0.4, 0.4, robot.n))
    wrong = replace(right, torque=right.torque * factors[:, None])
    weights = right.weights / factors
    fit, plain = wrong.fit_with_scales(weights), wrong.fit(weights)
    left = float(np.sum(fit.errors() ** 2))
    assert left <= float(np.sum(right.fit(right.weights).errors() ** 2))
    assert 1.1 * left < float(np.sum(plain.errors() ** 2))
    rows = (weights[:, None] * wrong.keep)[:, None] * wrong.columns * fit.scales[:, None, None]
    A, b = np.hstack(list(rows)).T, (weights[:, None] * wrong.keep * wrong.torque).ravel()
    assert left == pytest.approx(float(np.sum((b - A @ np.linalg.lstsq(A, b)[0]) ** 2)), rel=1e-6)
