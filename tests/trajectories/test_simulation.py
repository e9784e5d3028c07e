"""Simulated recordings: exact without noise, the same for the same seed, honest about what is missing."""

import numpy as np
import pytest
from dynident.examples.paper.printed import paper_tables
from dynident.model import InertialParameters, base_parameters, load_robot, regressor
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points
from dynident.trajectories.simulation.simulator import parameter_vector


@pytest.fixture(scope="module")
def simulator() -> Simulator:
    return Simulator(load_robot("rx90"))


def test_torques_follow_the_regressor(simulator: Simulator) -> None:
    """Newton-Euler against Phi chi of the base parameters, sample by sample."""
    robot = simulator.robot
    base = base_parameters(robot)
    phi, chi = regressor(robot, base.columns), base.value(robot.parameters)
    data = simulator.measure(random_via_points(robot, 4, 0).motion(20.0))
    for q, qd, qdd, torque in zip(data.motion.q, data.motion.qd, data.motion.qdd, data.torque, strict=True):
        assert np.allclose(np.asarray(phi(q, qd, qdd)) @ chi, torque, atol=1e-9 * np.abs(data.torque).max())


def test_a_payload_is_part_of_the_last_link(simulator: Simulator) -> None:
    body = InertialParameters.from_com(2.0, [0.1, 0.0, 0.2], 0.01 * np.eye(3))
    known = simulator.robot.parameters
    change = parameter_vector(simulator.robot, known, body) - parameter_vector(simulator.robot, known)
    assert np.count_nonzero(change) == np.count_nonzero(body.vector)
    assert change.sum() == pytest.approx(body.vector.sum())


def test_noise_has_its_level_and_its_seed(simulator: Simulator) -> None:
    motion = random_via_points(simulator.robot, 14, 0).motion(250.0)
    exact = simulator.record(motion)
    a, b, c = (simulator.record(motion, None, RX90_NOISE, seed) for seed in (1, 1, 2))
    assert np.array_equal(a.torque, b.torque)
    assert not np.array_equal(a.torque, c.torque)
    assert np.allclose((a.torque - exact.torque).std(axis=0), RX90_NOISE, rtol=0.03)


def test_the_simulated_robot_is_the_papers() -> None:
    """Base parameters of rx90.toml against the robot part of Table 2; YZ6 is told in the file."""
    robot = load_robot("rx90")
    base = base_parameters(robot)
    value = dict(zip(base.columns, base.value(robot.parameters), strict=True))
    for name, printed in paper_tables().table2_robot.items():
        if name != "YZ6":
            assert value[name] == pytest.approx(printed.value, abs=1e-6), name
