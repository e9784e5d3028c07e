"""Drive gains from currents: the truth within the stated sigma, simulated, real, and of coupled drives."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs.read import read_recording
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import Settings, answer_gains
from dynident.estimation.equations.equations import Equations
from dynident.estimation.gains.current_side import gauss_newton
from dynident.estimation.gains.known_load import known_mass
from dynident.estimation.gains.problem import GainProblem, free_gains, gain_problem, gravity_acts, rests_on
from dynident.model import InertialParameters, Motion, Processing, Recording, Robot, Spring, load_robot
from dynident.model.friction import PAPER, Friction
from dynident.trajectories import Simulator

TRUTH = np.array([11.5, 12.4, 9.9, 10.4, 10.3, 10.1])
NOISE = np.array([0.5, 0.5, 0.3, 0.15, 0.15, 0.1])
"""A."""
SETTINGS = Processing(decimate=4)
BODY = InertialParameters.from_com(6.0, [0.03, 0.12, 0.06], np.diag([0.03, 0.04, 0.02]))
ASKED = np.array([12.37, 9.96, 10.44, 10.37, 10.37])
"""Gains of joints 2 to 6 of the real arm, established independently [N·m/A]."""


@pytest.fixture(scope="module")
def currents(simulated: Callable[[str], Simulator], wander: Callable[..., Motion]) -> Callable[[int], GainProblem]:
    """The problem of a simulated UR10e pair with white noise on the currents."""
    simulator = simulated("ur10e")
    motion = wander(6, 3, points=20, rate=100.0)
    exact = [simulator.measure(motion, load).torque / TRUTH for load in (None, BODY)]

    @cache
    def problem(seed: int, scale: float = 1.0) -> GainProblem:
        draw = np.random.default_rng(seed)
        noisy = [i + scale * NOISE * draw.standard_normal(i.shape) for i in exact]
        pair = [Recording(motion.t, motion.q, i, motion.qd, f"log {k}") for k, i in enumerate(noisy)]
        return gain_problem(load_robot("ur10e"), pair[:1], pair[1:], Settings(SETTINGS))

    return problem


def test_gains_without_a_block_are_those_of_all_but_for_chance(currents: Callable[..., GainProblem]) -> None:
    problem, loads = currents(0), [known_mass(6.0)]
    whole = free_gains(problem.equations, problem.weights, loads).k
    deletions = [left for group in problem.deletions for left in group]
    assert deletions
    for left in deletions:
        assert free_gains(left, problem.weights, loads).k == pytest.approx(whole, rel=0.1)


def test_gravity_decides_what_a_gain_rests_on() -> None:
    assert gravity_acts(load_robot("ur10e")) == (False, True, True, True, True, True)
    wall = replace(load_robot("ur10e"), gravity=(-9.81, 0.0, 0.0))
    assert gravity_acts(wall) == (True,) * 6
    assert gravity_acts(wall.with_friction((*PAPER, Friction("FL")))) == (True,) * 6


@pytest.mark.long
def test_ur10e_gains(recordings: Path) -> None:
    """The controller's own are up to 3.5 % off these: passing them through would not do."""
    robot = load_robot("ur10e")
    unit_gains = (1.0,) * 6
    pair = [
        read_recording(recordings / "ur10e" / f"{name}.csv.gz", robot, unit_gains)
        for name in ("unloaded", "loaded_2.805kg")
    ]
    gains = answer_gains(gain_problem(robot, pair[:1], pair[1:]), known_mass(2.805))
    assert np.abs(gains.values[1:] / ASKED - 1.0).max() < 0.025
    assert np.abs(gains.free_values[1:] / ASKED - 1.0).max() < 0.025
    assert gains.identified == (False, True, True, True, True, True)
    assert "keep the maker's gain" in str(gains.result.drive_gains.rests_on)
    assert gains.payloads[0].min_pseudo_inertia_eigenvalue > -1e-7
    assert gains.logarithms.fit.relative < 0.042


MOTOR_TRUTH = np.array([40.0, 45.0, 38.0, 20.0, 18.0, 12.0])
"""N·m/A, of the motors on the joint side."""
SPRINGS = {
    "none": None,
    "stiff": Spring(2, 6000.0, 0.15, (0.08, 0.35), np.pi / 2),
    "ideal": Spring(2, 6000.0, 0.0, (0.08, 0.35), np.pi / 2),
}
COUPLED = Processing(decimate=5, slow_fraction=0.02)
Currents = Callable[[str, str, int], tuple[Robot, list[Recording]]]


def arm(name: str, spring: str) -> Robot:
    robot = load_robot(name)
    return replace(robot, drives=replace(robot.drives, spring=SPRINGS[spring]))


@pytest.fixture(scope="module")
def motor_currents(wander: Callable[..., Motion]) -> Currents:
    """Recordings of motor currents without and with the payload, white noise of 2 %."""

    def pair(name: str, spring: str, seed: int) -> tuple[Robot, list[Recording]]:
        robot = arm(name, spring)
        assert robot.coupling is not None
        simulator, moved = Simulator(replace(robot, parameters=load_robot("rx90").parameters)), wander(6, 3, 40)
        middle = np.mean([joint.limits.position for joint in robot.joints], axis=1) * (name == "tx40")
        motion = Motion(moved.t, moved.q + middle, moved.qd, moved.qdd)
        draw = np.random.default_rng(seed)
        recordings = []
        for k, load in enumerate((None, BODY)):
            exact = robot.coupling.motor_torques(simulator.measure(motion, load).torque) / MOTOR_TRUTH
            noise = 0.02 * np.sqrt(np.mean(exact**2, axis=0)) * draw.standard_normal(exact.shape)
            recordings.append(Recording(motion.t, motion.q, exact + noise, motion.qd, f"log {k}"))
        return robot, recordings

    return pair


@pytest.mark.parametrize(
    ("name", "spring"),
    [
        *(pytest.param("rx90", spring, marks=pytest.mark.long) for spring in ("none", "stiff", "ideal")),
        ("tx40", "none"),
    ],
)
def test_one_gain_for_each_motor_within_its_sigma(motor_currents: Currents, name: str, spring: str) -> None:
    """One gain per motor, all of them known to 1 %; two draws of noise."""
    errors = []
    for seed in range(2):
        robot, (bare, loaded) = motor_currents(name, spring, seed)
        load = known_mass(6.0)
        problem = gain_problem(robot, [bare], [loaded], Settings(COUPLED), load=load)
        gains = answer_gains(replace(problem, deletions=() if seed else problem.deletions), load)
        assert gains.values == pytest.approx(MOTOR_TRUTH, rel=0.02)
        assert gains.logarithms.sigma.max() < 0.01
        errors.append(np.log(gains.values / MOTOR_TRUTH) / gains.logarithms.sigma)
        if not seed:
            assert gains.logarithms.robust is not None
            assert (gains.logarithms.robust.sigma / gains.logarithms.sigma).min() > 0.4
            assert (gains.logarithms.robust.sigma / gains.logarithms.sigma).max() < 2.5
    assert 0.3 < np.sqrt(np.mean(np.square(errors))) < 1.7
    assert np.abs(errors).max() < 4.5


def test_words_tell_what_a_gain_rests_on() -> None:
    robot = arm("rx90", "stiff")
    assert gravity_acts(robot) == (False, True, True, True, True, True)
    words = rests_on(robot)
    assert "inertia only" in words[0]
    assert "known spring" in words[1]
    assert words[4].endswith("(the torque of joint 5 less that of joint 6)")
    assert "turns with joints 5 and 6" in words[5]


def test_currents_of_coupled_drives_make_joint_torques(tmp_path: Path) -> None:
    """(9): joint 5 feels both motors."""
    path = tmp_path / "log.csv"
    names = ["t", *(f"{kind}{j}" for kind in ("q", "i") for j in range(1, 7))]
    rows = ["0,0,0,0,0,0,0,1,2,3,4,5,6", "0.01,0,0,0,0,0,0,1,2,3,4,5,7"]
    path.write_text("\n".join([",".join(names), *rows]) + "\n")
    recording = read_recording(path, load_robot("rx90"), (2.0,) * 5 + (10.0,))
    assert recording.torque.tolist() == [[2, 4, 6, 8, 70, 60], [2, 4, 6, 8, 80, 70]]
    coupling = load_robot("rx90").coupling
    assert coupling is not None
    assert coupling.motor_torques(recording.torque)[:, 4:].tolist() == [[10, 60], [10, 70]]


GAINS = np.array([2.0, 0.5, 1.3])
"""k_j [A/(N·m)]."""
X = np.array([1.0, -0.7, 0.4, 1.0])
"""Parameters; the last is known and sets the scale."""
ROWS = 4
"""Rows of each joint: 12 for 6 unknowns."""
SIGMA = 1e-3
DRAWS = 500


def problem(seed: int, rows: int = ROWS, effective: float = 1.0) -> Equations:
    """One motion with other noise; ``effective``: share of the rows whose noise counts as independent."""
    W = np.random.default_rng(0).standard_normal((len(GAINS), rows, len(X)))
    noise = SIGMA * np.random.default_rng((1, seed)).standard_normal((len(GAINS), rows))
    factors = tuple(np.column_stack([own, k * own @ X + e]) for own, k, e in zip(W, GAINS, noise, strict=True))
    counts = (rows,) * len(GAINS)
    return Equations(("A", "B", "C", "M_L"), factors, counts, tuple(effective * count for count in counts))


def fitted(equations: Equations) -> tuple[Array, Array]:
    """ln K less the truth, and its stated covariance."""
    fit = gauss_newton(equations, np.ones(len(GAINS)), range(3), np.array([0.0, 0.0, 0.0, 1.0]))
    return -np.log(fit.k / GAINS), fit.covariance


def test_stated_variance_of_few_rows_is_the_scatter() -> None:
    """The residual of 12 rows and 6 unknowns is half as large as the noise: divided by 12 it would state half."""
    fits = [fitted(problem(seed)) for seed in range(DRAWS)]
    scatter = np.cov(np.array([errors for errors, _ in fits]).T)
    stated = np.mean([covariance for _, covariance in fits], axis=0)
    assert np.diag(stated) == pytest.approx(np.diag(scatter), rel=0.2)
    assert stated == pytest.approx(scatter, abs=0.2 * np.diag(scatter).max())


def test_as_many_unknowns_as_rows_are_refused() -> None:
    with pytest.raises(InputError, match="too few samples for 6 unknowns"):
        fitted(problem(0, effective=0.5))
