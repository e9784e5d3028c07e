"""The regressor by NumPy alone equals the one of expressions, for every kind of joint and drive."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from dynident.model import Robot, load_robot, regressor, robot_names, standard_columns
from dynident.model.kinematics import forward_kinematics
from dynident.model.many_states import own_columns, point_at, regressor_at
from dynident.tests.model.random_robots import random_robot


def _sliding() -> Robot:
    robot = load_robot("irb120")
    second = replace(robot.joints[1], kind="prismatic", theta=0.3, r=0.2, d=0.1)
    return replace(robot, joints=(robot.joints[0], second, *robot.joints[2:]), gravity=(1.0, -2.0, -9.0))


ROBOTS = {name: load_robot(name) for name in robot_names()} | {"sliding": _sliding()}
RANDOM = {robot.name: robot for robot in map(random_robot, range(12))}


@pytest.mark.parametrize("name", ROBOTS | RANDOM)
def test_many_states_equal_one_after_the_other(name: str) -> None:
    robot = (ROBOTS | RANDOM)[name]
    columns = standard_columns(robot)
    states = np.random.default_rng(0).normal(size=(3, 7, robot.n))
    function = regressor(robot, columns)
    single = np.array([np.array(function(*state)) for state in zip(*states, strict=True)])
    many = regressor_at(robot, columns, *states)
    np.testing.assert_allclose(many.transpose(2, 0, 1), single, atol=1e-12)


@pytest.mark.parametrize("name", ROBOTS)
def test_a_point_of_the_last_link_is_where_kinematics_put_it(name: str) -> None:
    """Joints move it by the derivative of its place."""
    robot, point = ROBOTS[name], np.array([0.1, -0.2, 0.3])
    q = ca.SX.sym("q", robot.n)
    R, p = forward_kinematics(robot)(q)
    place = p + R @ ca.DM(point)
    function = ca.Function("place", [q], [place, ca.jacobian(place, q)])
    states = np.random.default_rng(2).normal(size=(5, robot.n))
    places, moved = point_at(robot, point, states)
    for k, state in enumerate(states):
        single = function(state)
        np.testing.assert_allclose(places[:, k], np.array(single[0])[:, 0], atol=1e-12)
        np.testing.assert_allclose(moved[:, :, k], np.array(single[1]), atol=1e-12)


@pytest.mark.parametrize("name", ["rx90", "ur10e", "iiwa14", "sliding"])
def test_its_own_columns_span_all_others(name: str) -> None:
    robot = ROBOTS[name]
    states = np.random.default_rng(1).normal(size=(3, 60, robot.n))

    def rank(columns: tuple[str, ...]) -> int:
        W = regressor_at(robot, columns, *states).transpose(2, 0, 1).reshape(-1, len(columns))
        return int(np.linalg.matrix_rank(W, rtol=1e-9))

    assert rank(own_columns(robot)) == rank(standard_columns(robot))
