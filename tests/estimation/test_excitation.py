"""Excitation against sigmas, and against regression of every column on the others."""

import numpy as np
import pytest
from dynident.apps.commands.demo import PAYLOAD as PAPER_PAYLOAD
from dynident.common.arrays import Array
from dynident.estimation import PAYLOAD, Settings, answer_payload, payload_problem
from dynident.estimation.equations.equations import Equations
from dynident.estimation.equations.observer import Observer
from dynident.estimation.fit.least_squares import excitation, weighted
from dynident.estimation.signals.filtering import measurement
from dynident.model import Processing, base_parameters, load_robot
from dynident.trajectories import RX90_NOISE, Simulator, random_via_points


def test_signal_and_own_part_of_each_column() -> None:
    """The part of a column that others cannot imitate, by an explicit regression on the dense equations."""
    robot = load_robot("rx90")
    base = base_parameters(robot)
    recording = Simulator(robot).record(random_via_points(robot, 8, seed=3).motion(100.0), None, RX90_NOISE, [3])
    processing = Processing()
    observation = Observer(robot, base.columns).observe(measurement(recording, processing), processing)
    factors = tuple(
        np.asarray(np.linalg.qr(np.column_stack(pair), "r"))
        for pair in zip(observation.W, observation.Y, strict=True)
    )
    rows = tuple(len(Y) for Y in observation.Y)
    problem = Equations(base.columns, factors, rows, tuple(map(float, rows)))
    estimate = weighted(problem)
    signals = excitation(problem, estimate)
    assert signals.names == base.columns
    assert np.allclose(signals.independent, np.abs(estimate.values) / estimate.sigma, rtol=1e-6)
    W = np.vstack([w * part for w, part in zip(estimate.weights, observation.W, strict=True)])
    for k in (0, 7, 20, 53):
        assert signals.share[k] == pytest.approx(_own(W, k), rel=1e-6)
    assert (signals.share <= 1.0 + 1e-9).all()


def _own(W: Array, k: int) -> float:
    others = np.delete(W, k, axis=1)
    scaled = others / np.linalg.norm(others, axis=0)
    rest = W[:, k] - scaled @ np.linalg.lstsq(scaled, W[:, k], rcond=None)[0]
    return float(np.linalg.norm(rest) / np.linalg.norm(W[:, k]))


@pytest.mark.long
def test_robot_and_payload_together() -> None:
    robot = load_robot("rx90")
    simulator, motion = Simulator(robot), random_via_points(robot, 8, seed=4).motion(100.0)
    bare = simulator.record(motion, None, RX90_NOISE, [4, 0])
    loaded = simulator.record(motion, PAPER_PAYLOAD, RX90_NOISE, [4, 1])
    problem = payload_problem(robot, [loaded], [bare], settings=Settings(robust=False))
    signals = answer_payload(problem, (4,)).excitation
    assert signals is not None
    assert signals.names == (*problem.base.columns, *PAYLOAD)
    assert signals.independent[-1] > 30.0, "the mass is well seen"
    assert problem.unloaded is not None
    alone = payload_problem(robot, [loaded], known=weighted(problem.unloaded), settings=Settings(robust=False))
    assert answer_payload(alone, (1,)).excitation is None
