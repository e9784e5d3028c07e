"""Errors of the drive gains: the same as rescaled recordings, through every method."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import (
    Estimate,
    Gains,
    LongMotion,
    Settings,
    ShortMotion,
    identify,
    payload_estimate,
    payload_problem,
)
from dynident.estimation.equations.equations import PAYLOAD, Equations, merged
from dynident.estimation.fit.estimate import error_model
from dynident.estimation.fit.least_squares import weighted
from dynident.estimation.fit.own_equations import base_problem
from dynident.estimation.payload.methods import METHODS as SOLVERS
from dynident.estimation.payload.result import PayloadEstimate, constrain_payload
from dynident.estimation.payload.weighing import difference_weighing
from dynident.model import InertialParameters, Motion, Processing, Recording, Robot, Spring, base_parameters
from dynident.trajectories import Simulator
from numpy.typing import ArrayLike

Recordings = Callable[[ArrayLike], tuple[Recording, Recording]]
METHODS = (1, 2, 3, 4)
MOTORS = [1, 4, 5]  # counted from 0; the last two of the RX90 are coupled, a spring acts on the first


def gain_sensitivity(equations: Equations, weights: Array) -> Array:
    """Derivatives of the weighted solution by each motor's relative error."""
    derivatives = weighted(equations, weights).gain_sensitivity
    assert derivatives is not None
    return derivatives


def rescaled_torque(robot: Robot, torque: Array, factors: ArrayLike) -> Array:
    """Torques of the joints with each motor's times its factor; (9) written out."""
    G = np.eye(6)
    if robot.coupling is not None:
        G[4, 5] = 1.0
    return np.asarray(torque @ np.linalg.inv(G).T * np.asarray(factors) @ G.T)


def sprung(simulator: Simulator, joint: int) -> Simulator:
    """A copy of the robot with a gravity spring on a joint."""
    robot = simulator.robot
    spring = Spring(joint, 6000.0, 0.15, (0.08, 0.35), np.pi / 2)
    return Simulator(replace(robot, drives=replace(robot.drives, spring=spring)))


@pytest.fixture(scope="module", params=["rx90", "ur10e", "sprung"])
def arm(
    request: pytest.FixtureRequest,
    simulated: Callable[[str], Simulator],
    wander: Callable[..., Motion],
    payload: InertialParameters,
) -> tuple[Simulator, Recordings]:
    """A simulator, and noisy recordings without and with payload whose torques are scaled motor by motor."""
    simulator = sprung(simulated("rx90"), 2) if request.param == "sprung" else simulated(request.param)
    noise, motion = [0.5] * 6, wander(6, 4, points=14)

    def recordings(factors: ArrayLike) -> tuple[Recording, Recording]:
        pair = [simulator.record(motion, body, noise, [9, k]) for k, body in enumerate((None, payload))]
        bare, loaded = (
            replace(recording, torque=rescaled_torque(simulator.robot, recording.torque, factors))
            for recording in pair
        )
        return bare, loaded

    return simulator, recordings


def problem_of(arm: tuple[Simulator, Recordings], factors: ArrayLike) -> LongMotion:
    bare, loaded = arm[1](factors)
    return payload_problem(arm[0].robot, [loaded], [bare], settings=Settings(robust=False))


def sensitivity(estimate: Estimate) -> Array:
    """The derivatives that come with a result."""
    assert estimate.gain_sensitivity is not None
    return estimate.gain_sensitivity


def changed(motor: int, step: float) -> Array:
    return np.asarray(1.0 + step * np.eye(6)[motor])


def brute(solve: Callable[[Array], Array], step: float = 1e-5) -> Array:
    """Central differences by rescaled recordings, columns ``MOTORS``."""
    return np.column_stack([(solve(changed(j, step)) - solve(changed(j, -step))) / (2 * step) for j in MOTORS])


@pytest.fixture(scope="module")
def problem(arm: tuple[Simulator, Recordings]) -> LongMotion:
    return problem_of(arm, np.ones(6))


@pytest.fixture(scope="module")
def rescaled(arm: tuple[Simulator, Recordings]) -> dict[bytes, LongMotion]:
    """The problem for some motors' torque up and down."""
    factors = [changed(j, step) for j in MOTORS for step in (1e-5, -1e-5)]
    return {factor.tobytes(): problem_of(arm, factor) for factor in factors}


@pytest.mark.parametrize("method", METHODS)
def test_it_is_what_rescaled_recordings_give(
    problem: LongMotion, rescaled: dict[bytes, LongMotion], method: int
) -> None:
    """To 1e-6 of each parameter's own size.

    They add up to the payload, which a common error scales, unless there is a spring.
    """
    solver, estimate = SOLVERS[method], payload_estimate(problem, method).estimate
    J = sensitivity(estimate)
    assert problem.unloaded is not None
    robot_weights = weighted(problem.unloaded).weights

    def solved(factors: Array) -> Array:
        variant = replace(rescaled[factors.tobytes()])
        assert variant.unloaded is not None
        vars(variant)["bare"] = weighted(variant.unloaded, robot_weights)
        return solver(variant).solved(estimate.weights).values

    expected = brute(solved)
    size = np.linalg.norm(expected, axis=1)[:, None]
    assert (np.abs(J[:, MOTORS] - expected) < 1e-6 * size).all()
    if problem.robot.spring is None:
        assert (np.abs(J.sum(axis=1) - estimate.values) < 1e-6 * size[:, 0]).all()


def test_a_stored_robot_brings_its_own_errors(arm: tuple[Simulator, Recordings], problem: LongMotion) -> None:
    """Method 1 by stored parameters is as sensitive as by the recording they came from; without, it is refused."""
    bare, _ = arm[1](np.ones(6))
    known = identify(arm[0].robot, [bare], Settings(robust=False)).estimate
    later = replace(problem, unloaded=None, difference=None, known=known)
    both = [sensitivity(payload_estimate(p, 1).estimate) for p in (problem, later)]
    assert both[1] == pytest.approx(both[0], rel=1e-5, abs=1e-8)
    old = replace(later, known=replace(known, gain_sensitivity=None))
    with pytest.raises(InputError, match="identify the robot again"):
        constrain_payload(payload_estimate(old, 1), gains=Gains((0.02,)))


def test_a_robots_parameters_by_rescaled_recordings(problem: LongMotion, rescaled: dict[bytes, LongMotion]) -> None:
    assert problem.unloaded is not None
    estimate = weighted(problem.unloaded)
    J = gain_sensitivity(problem.unloaded, estimate.weights)
    if problem.robot.spring is None:
        assert J.sum(axis=1) == pytest.approx(estimate.values, rel=1e-8, abs=1e-10)

    def solved(factors: Array) -> Array:
        bare = rescaled[factors.tobytes()].unloaded
        assert bare is not None
        return weighted(bare, estimate.weights).values

    expected = brute(solved)
    assert (np.abs(J[:, MOTORS] - expected) < 1e-6 * np.linalg.norm(expected, axis=1)[:, None]).all()


@pytest.mark.parametrize("joint", [5, 6])
def test_a_spring_on_a_coupled_joint(
    simulated: Callable[[str], Simulator], wander: Callable[..., Motion], joint: int
) -> None:
    """What joint 5 feels of motor 6 is without the spring on joint 6; decimated, as equations are used."""
    robot, processing = sprung(simulated("rx90"), joint).robot, Processing(decimate=4)
    recording, base = Simulator(robot).record(wander(6, 4), None, [0.5] * 6, [9, 0]), base_parameters(robot)

    def reduced(factors: Array) -> Equations:
        scaled = replace(recording, torque=rescaled_torque(robot, recording.torque, factors))
        return base_problem(robot, base, [scaled], Settings(processing, robust=False))

    weights = weighted(reduced(np.ones(6))).weights
    expected = brute(lambda factors: weighted(reduced(factors), weights).values)
    J = gain_sensitivity(reduced(np.ones(6)), weights)[:, MOTORS]
    assert (np.abs(J - expected) < 1e-6 * np.linalg.norm(expected, axis=1)[:, None]).all()


def test_saved_equations_keep_what_motors_share(problem: LongMotion, tmp_path: Path) -> None:
    """Read back, and merged with themselves, they are as sensitive as before."""
    assert problem.unloaded is not None
    problem.unloaded.save(tmp_path / "p.npz")
    read = Equations.load(tmp_path / "p.npz")
    assert len(read.shared) == bool(problem.robot.coupling) + bool(problem.robot.spring)
    weights = weighted(read).weights
    J = gain_sensitivity(problem.unloaded, weights)
    for equations in (read, merged([read, problem.unloaded])):
        assert gain_sensitivity(equations, weights) == pytest.approx(J, rel=1e-6, abs=1e-9 * np.abs(J).max())
    if read.shared:
        with pytest.raises(ValueError, match="different coupled drives"):
            merged([read, replace(read, shared=())])


@pytest.mark.long
def test_a_weighing_by_rescaled_recordings(arm: tuple[Simulator, Recordings]) -> None:
    """Each motor's error alone, offsets and weights held as they were."""
    simulator, recordings = arm

    def weighing(factors: ArrayLike) -> ShortMotion:
        bare, loaded = recordings(factors)
        return difference_weighing(simulator.robot, [loaded], [bare])

    problem = weighing(np.ones(6))
    payload, motion = payload_estimate(problem, 3), problem
    assert payload.complete

    def solved(factors: Array) -> Array:
        runs = weighing(factors).runs
        equations = merged(motion.held.friction_free(run.equations) for run in runs).select(PAYLOAD)
        return weighted(equations, payload.estimate.weights).values

    expected = brute(solved)
    for motor, column in zip(MOTORS, expected.T, strict=True):
        gains = Gains(0.01 * np.eye(6)[motor])
        C = error_model(payload.estimate, gains).covariance - error_model(payload.estimate).covariance
        assert pytest.approx(1e-4 * np.outer(column, column), rel=1e-4, abs=1e-6 * np.abs(C).max()) == C


def test_common_and_own_errors(problem: LongMotion) -> None:
    """A common error widens the mass by its share of it; one number stands for six; both add up."""
    free = payload_estimate(problem, 4)

    def sigma(gains: Gains | None) -> Array:
        return constrain_payload(free, gains=gains).sigma

    alone = sigma(None)
    assert alone == pytest.approx(free.estimate.sigma)
    common = sigma(Gains(common=0.03))
    J = sensitivity(free.estimate)
    share = free.mass if problem.robot.spring is None else abs(J[9].sum())
    assert np.sqrt(common[9] ** 2 - alone[9] ** 2) == pytest.approx(0.03 * share, rel=1e-6)
    assert sigma(Gains((0.02,))) == pytest.approx(sigma(Gains((0.02,) * 6)))
    own = 0.02 * np.linalg.norm(J, axis=1)
    both = sigma(Gains((0.02,), 0.03))
    assert both**2 == pytest.approx(common**2 + own**2, rel=1e-6)


def test_intervals_hold_a_payload_whose_gains_are_wrong(
    arm: tuple[Simulator, Recordings], payload: InertialParameters
) -> None:
    """Gains 2 to 4 % off: the mass is missed without, held with their uncertainty."""
    wrong = problem_of(arm, [1.03, 1.04, 1.02, 1.04, 1.03, 1.03])
    for method in METHODS:
        free: PayloadEstimate = payload_estimate(wrong, method)
        ends = [constrain_payload(free, gains=g).intervals.parameters[9] for g in (None, Gains((0.01,), 0.03))]
        assert not ends[0][0] <= payload.mass <= ends[0][1]
        assert ends[1][0] <= payload.mass <= ends[1][1]


@pytest.mark.parametrize("sigmas", [(-0.01,), (1.0,), (), (float("nan"),)])
def test_what_is_no_uncertainty_is_refused(sigmas: tuple[float, ...]) -> None:
    with pytest.raises(InputError, match="drive gains"):
        Gains(sigmas)


def test_as_many_as_joints() -> None:
    with pytest.raises(InputError, match="2 uncertainties of drive gains for 6 joints"):
        Gains((0.01, 0.02)).covariance(6)
