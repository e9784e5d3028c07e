"""Errors of the drive gains in the robot's parameters, and in payloads weighed with them: counted once."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.report.sections.evidence import gain_error_notes
from dynident.apps.report.sections.robot import robot_table
from dynident.apps.results import read_stored_robot
from dynident.common.schema import write_json
from dynident.estimation import (
    Estimate,
    Gains,
    Settings,
    answer_payload,
    identify,
    payload_estimate,
    payload_problem,
)
from dynident.estimation.fit.drive_gains import usual_gains
from dynident.estimation.fit.estimate import error_model
from dynident.estimation.payload.result import constrain_payload
from dynident.estimation.possible.robot import solve_constrained_base
from dynident.model import InertialParameters, Motion, Processing, Recording, Robot, load_robot, robot_names
from dynident.model.friction import PAPER
from dynident.trajectories import Simulator
from numpy.typing import NDArray

GAINS = Gains((0.02,))
SETTINGS = Processing(decimate=4)
NOISE = np.array([3.0, 3.0, 2.0, 1.0, 1.0, 0.7])
RUNS = 20
Record = Callable[[int, float], Recording]


@pytest.fixture(scope="module", params=["ur10e", "rx90"])
def source(request: pytest.FixtureRequest, simulated: Callable[[str], Simulator]) -> Simulator:
    """The RX90's drives 5 and 6 are coupled."""
    return simulated(request.param)


@pytest.fixture(scope="module")
def robot(source: Simulator) -> Robot:
    return load_robot(source.robot.name)


@pytest.fixture(scope="module")
def recorders(
    source: Simulator, wander: Callable[..., Motion], payload: InertialParameters
) -> tuple[Record, Record]:
    """Without payload, and another motion with it: run -> recording whose gains are off by that run's errors."""

    def recorder(body: InertialParameters | None, seed: int) -> Record:
        motion = wander(6, seed, points=20)
        exact, coupling = source.measure(motion, body).torque, source.robot.coupling

        def record(run: int, size: float = 0.02) -> Recording:
            errors = size * np.random.default_rng([5, run]).standard_normal(6)
            noisy = exact + NOISE * np.random.default_rng([seed, run]).standard_normal(exact.shape)
            motors = (1.0 + errors) * (coupling.motor_torques(noisy) if coupling else noisy)
            torque = coupling.joint_torques(motors) if coupling else motors
            return Recording(motion.t, motion.q, torque, motion.qd, f"motion {seed}", gain_sigma=0.0)

        return record

    return recorder(None, 3), recorder(payload, 4)


def test_intervals_hold_what_wrong_gains_do(
    source: Simulator, robot: Robot, recorders: tuple[Record, Record], payload: InertialParameters
) -> None:
    """A stored robot and a payload have the same errors: counted once they cover, left out they do not."""
    hits: dict[str, list[NDArray[np.bool_]]] = {"robot": [], "robot exact": [], "payload": [], "payload exact": []}
    for run in range(RUNS):
        bare, loaded = (record(run, 0.02) for record in recorders)
        identification = identify(robot, [bare], Settings(SETTINGS, robust=False, friction=PAPER), gains=GAINS)
        estimate, truth = identification.estimate, identification.base.value(dict(source.robot.parameters))
        assert estimate.interval95_with_gains is not None
        for name, ends in (("robot", estimate.interval95_with_gains), ("robot exact", estimate.interval95)):
            hits[name].append((ends[:, 0] <= truth) & (truth <= ends[:, 1]))
        problem = payload_problem(robot, [loaded], [], estimate, Settings(SETTINGS, robust=False))
        free = payload_estimate(problem, 1)
        for name, gains in (("payload", GAINS), ("payload exact", None)):
            model = error_model(free.estimate, gains)
            hits[name].append(np.abs(model.values - payload.vector)[6:] <= 2.0 * model.sigma[6:])
    share = {name: np.mean(inside, axis=0) for name, inside in hits.items()}
    assert 0.92 < share["robot"].mean() < 0.99, share["robot"]
    assert share["robot"].min() > 0.7
    assert share["robot exact"].mean() < 0.85
    assert share["payload"].mean() > 0.88, share["payload"]
    assert share["payload exact"][3] < 0.5


def test_a_stored_robots_error_is_not_an_error_of_its_own(robot: Robot, recorders: tuple[Record, Record]) -> None:
    """Robot and payload apart would be several times less sure of the mass: 2 % of the robot's torques."""
    bare, loaded = (record(0, 0.0) for record in recorders)
    known = identify(robot, [bare], Settings(SETTINGS, robust=False, friction=PAPER), gains=GAINS).estimate
    assert known.covariance_by_gains is not None

    def mass_sigma(known: Estimate, gains: Gains | None) -> float:
        problem = payload_problem(robot, [loaded], [], known, Settings(SETTINGS, robust=False))
        return float(constrain_payload(payload_estimate(problem, 1), gains=gains).sigma[9])

    once, plain = mass_sigma(known, GAINS), mass_sigma(known, None)
    bare_known = replace(known, gain_covariance=None)
    assert mass_sigma(bare_known, GAINS) == once  # the robot's own share is not added again
    assert mass_sigma(bare_known, None) == plain
    twice = replace(bare_known, covariance=known.covariance + known.covariance_by_gains)
    assert mass_sigma(twice, GAINS) > 2.5 * once
    assert once > 3.0 * plain


def test_parameters_say_what_they_owe_to_the_gains(robot: Robot, recorders: tuple[Record, Record]) -> None:
    bare = recorders[0](1, 0.02)
    exact, identification = (
        identify(robot, [bare], Settings(SETTINGS), gains=g) for g in (None, Gains(common=0.03))
    )
    estimate = identification.estimate
    assert estimate.sigma_by_gains == pytest.approx(0.03 * np.abs(estimate.values), rel=1e-6)
    assert estimate.total_sigma == pytest.approx(np.hypot(estimate.larger_sigma, 0.03 * np.abs(estimate.values)))
    assert np.array_equal(exact.estimate.total_sigma, exact.estimate.larger_sigma)
    assert np.array_equal(estimate.covariance, exact.estimate.covariance)
    assert exact.estimate.sigma_by_gains is exact.estimate.interval95_with_gains is None
    assert estimate.robust is not None
    assert estimate.interval95_with_gains is not None
    half = (estimate.interval95_with_gains[:, 1] - estimate.interval95_with_gains[:, 0]) / 2.0
    total = np.hypot(estimate.robust.sigma, 0.03 * np.abs(estimate.values))
    assert half == pytest.approx(estimate.robust.quantile95 * total)
    part = identification.elimination.estimate
    assert part.sigma_by_gains == pytest.approx(0.03 * np.abs(part.values), rel=1e-6)
    headings = [list(robot_table(result.result).headings) for result in (exact, identification)]
    assert "by gains" not in headings[0]
    assert "by gains" in headings[1]
    notes = [
        " ".join(gain_error_notes(result.result.processing, result.gains)) for result in (exact, identification)
    ]
    assert "Drive gains are taken as exact: no residual shows their errors" in notes[0]
    motor = "motor" if robot.coupling else "joint"
    assert f"include errors of the drive gains: 0 % per {motor} and 3 % common to all joints" in notes[1]


def test_stored_robot_keeps_the_gains_uncertainty(
    robot: Robot, recorders: tuple[Record, Record], tmp_path: Path
) -> None:
    """Read back, the distance of the nearest robot that can exist is the same, gains included."""
    gains = Gains((0.02,), 0.01, (1e-4 * np.eye(6)).tolist())
    result = identify(robot, [recorders[0](2, 0.02)], Settings(SETTINGS, robust=False), gains=gains)
    path = tmp_path / "robot.json"
    write_json(path, result.result)
    stored = read_stored_robot(path)
    assert stored.gains == gains
    assert stored.estimate.covariance_by_gains == pytest.approx(result.estimate.covariance_by_gains)
    model = error_model(result.estimate)
    assert error_model(stored.estimate).covariance == pytest.approx(model.covariance)
    assert result.estimate.covariance_by_gains is not None
    assert model.covariance == pytest.approx(result.estimate.covariance + result.estimate.covariance_by_gains)
    assert np.array_equal(error_model(model).covariance, model.covariance)
    exact = replace(result.estimate, gain_covariance=None)
    rises = [solve_constrained_base(result.robot, result.base, e).chi2_rise for e in (stored.estimate, exact)]
    assert rises[0] <= rises[1]


@pytest.mark.parametrize("name", robot_names())
def test_gains_of_which_nothing_is_said_have_usual_errors(name: str) -> None:
    """What recordings say comes first; the least sure of them counts."""
    robot = load_robot(name)
    silent = Recording(np.arange(3.0), np.zeros((3, robot.n)), np.zeros((3, robot.n)))
    exact, stated = replace(silent, gain_sigma=0.0), replace(silent, gain_sigma=0.005)
    usual = {"motor": 0.02, "link": 0.01}[robot.drives.side]
    assert usual_gains(robot, [exact, exact]) is None
    assert usual_gains(robot, [exact, stated]) == Gains((0.005,))
    assert usual_gains(robot, [exact, silent]) == usual_gains(robot, []) == Gains((usual,), assumed=True)
    assert usual_gains(robot, [replace(silent, gain_sigma=0.05), silent]) == Gains((0.05,))
    assert usual_gains(robot, [replace(silent, gains=(1.0,) * robot.n)]) == Gains((0.02,), assumed=True)


def test_an_answer_allows_for_gains_of_which_nothing_is_said(
    robot: Robot, recorders: tuple[Record, Record], tmp_path: Path
) -> None:
    """Robot and payload carry the usual errors, as if they were given; a line says so."""
    pair = [record(1, 0.0) for record in recorders]
    silent = [replace(recording, gain_sigma=None) for recording in pair]
    known, usual = (identify(robot, [bare], Settings(SETTINGS)) for bare in (pair[0], silent[0]))
    assert known.gains is None
    assert usual.gains == Gains((0.02,), assumed=True)
    given = identify(robot, [pair[0]], Settings(SETTINGS), gains=Gains((0.02,)))
    assert np.array_equal(usual.estimate.total_sigma, given.estimate.total_sigma)
    each = "motor" if robot.coupling else "joint"
    (line,) = gain_error_notes(usual.result.processing, usual.gains)
    assert line.endswith(f": 2 % per {each}, as is usual: nothing is said of them (--gain-sigma).")
    write_json(tmp_path / "robot.json", usual.result)
    assert read_stored_robot(tmp_path / "robot.json").gains == usual.gains


@pytest.mark.parametrize("error", [0.0, 0.02])
def test_what_is_assumed_of_gains_shortens_no_interval(
    error: float, robot: Robot, recorders: tuple[Record, Record]
) -> None:
    """Whether joints agree or disagree, by any method."""
    exact = [record(1, error) for record in recorders]
    silent = [replace(recording, gain_sigma=None) for recording in exact]
    each = []
    for bare, heavy in (exact, silent):
        answer = answer_payload(payload_problem(robot, [heavy], [bare], settings=Settings(SETTINGS)))
        each.append({one.method: float(one.sigma[9]) for one in answer.constrained})
    assert each[0].keys() == each[1].keys()
    for method, sigma in each[0].items():
        assert each[1][method] > sigma
