"""A hose or cable that pulls at the tool: what the recordings show of it, and what nothing can.

A pull that changes with the place of the tool leaves residuals that no payload explains. A constant one that points
up is a lighter payload to the last digit: only weighing the payload, or taking the hose off, shows it.
"""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from dynident.benchmarks import invented
from dynident.common.arrays import Array
from dynident.estimation import answer_payload, identify_payload, payload_problem
from dynident.model import InertialParameters, Recording
from dynident.model.kinematics import forward_kinematics
from dynident.trajectories import Simulator, random_via_points

ROBOT = invented.robot("ur10e")
BODY = InertialParameters.from_com(5.0, [0.01, 0.03, 0.08], np.diag([0.03, 0.03, 0.02]))
NOISE = (4.0, 5.0, 2.5, 0.8, 0.8, 0.5)
G = 9.81


@pytest.fixture(scope="module")
def pair() -> tuple[Recording, Recording]:
    """Without and with payload, 20 s of one motion."""
    simulator = Simulator(ROBOT)
    motion = random_via_points(ROBOT, 12, seed=3).motion(100.0)
    return first(simulator.record(motion, None, NOISE, 1)), first(simulator.record(motion, BODY, NOISE, 2))


def first(recording: Recording) -> Recording:
    own = recording.t < 20.0
    speeds = None if recording.qd is None else recording.qd[own]
    return replace(recording, t=recording.t[own], q=recording.q[own], qd=speeds, torque=recording.torque[own])


def pulled(recording: Recording, stiffness: float, end: Array, constant: Array) -> Recording:
    """A recording with the force ``stiffness`` (end - p) + ``constant`` [N] at the origin p of frame n."""
    q = ca.SX.sym("q", ROBOT.n)
    _, p = forward_kinematics(ROBOT)(q)
    force = stiffness * (ca.DM(end) - p) + ca.DM(constant)
    torque = ca.Function("torque", [q], [ca.jacobian(p, q).T @ force])  # what the motors need not do
    return replace(recording, torque=recording.torque - np.array(torque.map(len(recording.t))(recording.q.T)).T)


def test_a_constant_pull_upwards_is_a_lighter_payload(pair: tuple[Recording, Recording]) -> None:
    """By F/g, with no more residual than before: not knowable, as the page on verdicts says."""
    bare, heavy = pair
    free, hung = (
        identify_payload(payload_problem(ROBOT, [loaded], [bare], robust=False), 1)
        for loaded in (heavy, pulled(heavy, 0.0, np.zeros(3), np.array([0.0, 0.0, 10.0])))
    )
    assert free.mass - hung.mass == pytest.approx(10.0 / G, rel=0.02)
    assert hung.estimate.fit.relative == pytest.approx(free.estimate.fit.relative, rel=0.2)


@pytest.mark.long
def test_a_spring_to_the_side_is_refused(pair: tuple[Recording, Recording]) -> None:
    """10 N/m to a point beside the arm, 2 to 23 N; without it this pair is good, see ``test_guards``."""
    bare, heavy = pair
    spring = pulled(heavy, 10.0, np.array([1.0, 0.0, 0.5]), np.zeros(3))
    verdict = answer_payload(payload_problem(ROBOT, [spring], [bare], robust=True)).verdict
    assert verdict.level == "do_not_use"
