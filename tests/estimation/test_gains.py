"""Drive gains from currents: the truth within the stated sigma, of coupled drives too; mistakes are named."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs.read import read_recording
from dynident.apps.results import read_stored_gains
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.common.schema import write_json
from dynident.estimation import GainsResult, Settings, Verdict, answer_gains
from dynident.estimation.answers.gains import gain_problem, gauss_newton, known_mass, rests_on
from dynident.estimation.diagnosis.engine import States, System
from dynident.estimation.diagnosis.evidence import KNOWN_WELL
from dynident.estimation.equations.equations import Equations
from dynident.model import (
    InertialParameters,
    Motion,
    Processing,
    Recording,
    Robot,
    Spring,
    load_robot,
    robot_names,
    with_stand_in,
)
from dynident.model.friction import PAPER, Friction
from dynident.tests.estimation.conftest import Change, counted_backwards, on_torque, scaled
from dynident.trajectories import Simulator, random_via_points
from msgspec import structs

BODY = InertialParameters.from_com(6.0, [0.03, 0.12, 0.06], np.diag([0.03, 0.04, 0.02]))
ASKED = np.array([12.37, 9.96, 10.44, 10.37, 10.37])
"""Gains of joints 2 to 6 of the real arm, established independently [N·m/A]."""


def test_gravity_decides_what_a_gain_rests_on() -> None:
    def gravity_acts(robot: Robot) -> list[bool]:
        return [text.startswith("gravity") for text in rests_on(robot)]

    assert gravity_acts(load_robot("ur10e")) == [False, True, True, True, True, True]
    wall = replace(load_robot("ur10e"), gravity=(-9.81, 0.0, 0.0))
    assert gravity_acts(wall) == [True] * 6
    assert gravity_acts(wall.with_friction((*PAPER, Friction("FL")))) == [True] * 6


@pytest.mark.long
def test_ur10e_gains(recordings: Path) -> None:
    """The controller's own are up to 3.5 % off these: passing them through would not do."""
    robot = load_robot("ur10e")
    unit_gains = (1.0,) * 6
    pair = [
        read_recording(recordings / "ur10e" / f"{name}.csv.gz", robot, unit_gains)
        for name in ("unloaded", "loaded_2.805kg")
    ]
    result = answer_gains(gain_problem(robot, pair[:1], pair[1:], known_mass(2.805)))
    gains = result.drive_gains
    for values in (gains.values, gains.without_constraints):
        assert np.abs(np.asarray(values)[1:] / ASKED - 1.0).max() < 0.025
    assert gains.identified == (False, True, True, True, True, True)
    assert "keep the maker's gain" in str(gains.rests_on)
    assert result.working.payloads[0].min_pseudo_inertia_eigenvalue > -1e-7
    assert result.to_dict()["relative_residual"]["all"] < 0.042


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
        problem = gain_problem(robot, [bare], [loaded], known_mass(6.0), settings=Settings(COUPLED))
        same = problem.posed_by(np.array(problem.posed_with))[0].loaded
        assert all(map(np.allclose, same.factors, problem.posed[0].loaded.factors))
        gains = answer_gains(replace(problem, deletions=() if seed else problem.deletions)).drive_gains
        formula, robust = (np.array(x) for x in (gains.relative_sigma_formula, gains.relative_sigma_robust))
        assert gains.values == pytest.approx(MOTOR_TRUTH, rel=0.02)
        assert formula.max() < 0.01
        errors.append(np.log(gains.values / MOTOR_TRUTH) / formula)
        if not seed:
            assert (robust / formula).min() > 0.4
            assert (robust / formula).max() < 2.5
    assert 0.3 < np.sqrt(np.mean(np.square(errors))) < 1.7
    assert np.abs(errors).max() < 4.5


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


@cache
def invented_arm(name: str) -> Robot:
    """A shipped robot with parameters to simulate with."""
    return with_stand_in(load_robot(name))


@cache
def simulator(name: str) -> Simulator:
    return Simulator(invented_arm(name))


def weight(name: str, seed: int, share: float = 0.7) -> InertialParameters:
    """A weight of a share of what the arm carries, off the flange's axis."""
    draw = np.random.default_rng([seed, 3])
    mass = share * min(invented_arm(name).rated_payload, 10.0)
    com = [draw.uniform(0.05, 0.12), draw.uniform(-0.05, 0.05), draw.uniform(0.05, 0.12)]
    return InertialParameters.from_com(mass, com, mass * np.diag([0.004, 0.005, 0.003]))


def truth(name: str, seed: int) -> Array:
    """Gains [N·m/A]."""
    return np.random.default_rng([seed, 5]).uniform(5.0, 60.0, invented_arm(name).n)


def moved(name: str, seed: int, points: int = 14) -> Motion:
    rate = 250.0 if name in ("rx90", "tx40") else 100.0
    return random_via_points(invented_arm(name), points, seed, 0.6, 0.5).motion(rate)


def recorded(
    name: str, motion: Motion, load: InertialParameters | None, seed: Sequence[int], noise: float = 0.05
) -> Recording:
    """Currents with white noise, a share of each."""
    robot, exact = invented_arm(name), simulator(name).record(motion, load)
    motors = robot.coupling.motor_torques(exact.torque) if robot.coupling else exact.torque
    currents = motors / truth(name, seed[0])
    size = noise * np.sqrt(np.mean(currents**2, axis=0))
    drawn = np.random.default_rng([*seed, 7]).standard_normal(currents.shape)
    return Recording(motion.t, motion.q, currents + size * drawn, None, "loaded" if load else "unloaded")


def pair(name: str, seed: int, noise: float = 0.05, points: int = 14) -> tuple[Recording, Recording, float]:
    """Without and with the weight on one motion, and the weight's mass [kg]."""
    motion, load = moved(name, seed, points), weight(name, seed)
    bare, heavy = (recorded(name, motion, body, (seed, k), noise) for k, body in enumerate((None, load)))
    return bare, heavy, load.mass


def answered(name: str, bare: Recording, heavy: Recording, mass: float, robot: Robot | None = None) -> GainsResult:
    return answer_gains(gain_problem(robot or load_robot(name), [bare], [heavy], known_mass(mass)))


def said(name: str, bare: Recording, heavy: Recording, mass: float, robot: Robot | None = None) -> tuple[str, str]:
    """The level of the answer, or "refused"; and why."""
    try:
        verdict = answered(name, bare, heavy, mass, robot).judged
    except InputError as error:
        return "refused", str(error)
    return verdict.level, "; ".join(verdict.reasons)


def exchanged(i: int, j: int) -> Change:
    """Two columns of currents that changed places."""

    def change(current: Array) -> Array:
        current[:, [i - 1, j - 1]] = current[:, [j - 1, i - 1]]
        return current

    return on_torque(change)


QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def expected(gains: GainsResult) -> str:
    known = np.array(gains.drive_gains.relative_sigma) <= KNOWN_WELL
    return "use" if known.all() else "identified_only" if known.any() else "do_not_use"


def errors_in_sigma(gains: GainsResult, true: Array) -> Array:
    """The errors of ln K over their reported standard deviations."""
    return np.asarray(np.log(gains.drive_gains.values / true) / np.array(gains.drive_gains.relative_sigma))


@pytest.mark.parametrize(
    ("name", "noise"),
    [
        ("irb120", 0.05),
        *(pytest.param(name, 0.05, marks=pytest.mark.long) for name in robot_names()[::3]),
        *(pytest.param(*case, marks=pytest.mark.long) for case in product(("irb120", "rx90"), (0.02, 0.1))),
    ],
)
def test_good_recordings_are_answered(name: str, noise: float, tmp_path: Path) -> None:
    """None is refused, none spoken against; a file of gains is what was found, unless its verdict is against it."""
    bare, heavy, mass = pair(name, int(1000 * noise), noise)
    gains = answered(name, bare, heavy, mass)
    assert gains.judged.level == expected(gains), gains.judged.reasons
    assert np.abs(errors_in_sigma(gains, truth(name, int(1000 * noise)))).max() < 4.5
    write_json(tmp_path / "g.json", gains)
    read = read_stored_gains(tmp_path / "g.json")
    assert (read.errors, read.fingerprints) == (gains.errors, gains.fingerprints)
    assert np.array_equal(read.drive_gains.values, gains.drive_gains.values)
    write_json(tmp_path / "g.json", structs.replace(gains, verdict=Verdict("do_not_use", ("motor 3",))))
    with pytest.raises(InputError, match=r"do not use \(motor 3\)"):
        read_stored_gains(tmp_path / "g.json")


Mistake = Callable[[Recording, Recording, float], tuple[Recording, Recording, float]]


def in_both(change: Change) -> Mistake:
    return lambda bare, heavy, mass: (change(bare), change(heavy), mass)


def in_loaded(change: Change) -> Mistake:
    return lambda bare, heavy, mass: (bare, change(heavy), mass)


MISTAKES: dict[str, tuple[Mistake, str]] = {
    "loaded on another scale": (in_loaded(scaled(1.06)), "with payload; without this change"),
    "one gain off in one recording": (in_loaded(scaled(1.15, 3)), "drive gains"),
    "a mass ten times too large": (
        lambda bare, heavy, mass: (bare, heavy, 10.0 * mass),
        "exceeds the arm's rated payload",
    ),
    "recordings exchanged": (lambda bare, heavy, mass: (heavy, bare, mass), "with and without the payload look"),
    "currents exchanged": (in_both(exchanged(2, 3)), "torques of joints 2 and 3 are exchanged"),
    "currents exchanged in one": (in_loaded(exchanged(2, 3)), "torques of joints 2 and 3 are exchanged"),
    "joint counted backwards": (in_both(counted_backwards(4)), "joint 4 "),
    "all currents negative": (in_both(scaled(-1.0)), "turn its sign"),
    "one recording twice": (
        lambda bare, heavy, mass: (bare, replace(scaled(1.0005)(bare), source="loaded"), mass),
        "the payload does not show in the currents",
    ),
}
"""A change of the recordings or the mass, and what is then said.

Joint 4 of the Panda counted backwards leaves its range, and is refused before any fit. The gain of one joint
in one recording shows as a scale on small arms, as a joint that weighs otherwise on large ones.
"""


BY_KIND = {
    "rx90": ("loaded on another scale", "one gain off in one recording", "currents exchanged",
             "joint counted backwards"),
    "ur10e": ("one gain off in one recording", "joint counted backwards"),
    "panda": ("loaded on another scale", "joint counted backwards"),
}  # fmt: skip
"""Mistakes that show otherwise on coupled drives, on a large arm, and by sensors on the link side."""


@pytest.mark.parametrize(
    ("name", "mistake"),
    [
        *product(["irb120"], MISTAKES),
        *(pytest.param(name, own, marks=pytest.mark.long) for name, all_own in BY_KIND.items() for own in all_own),
    ],
)
def test_a_mistake_is_named_and_not_used(name: str, mistake: str) -> None:
    change, words = MISTAKES[mistake]
    level, why = said(name, *change(*pair(name, 1)))
    assert level in ("do_not_use", "refused"), why
    assert words in why


@pytest.mark.parametrize("joint", [1, 4])
def test_a_joint_that_does_not_move_is_named(joint: int) -> None:
    motion, load = moved("irb120", 1), weight("irb120", 1)
    q, qd, qdd = (np.array(x) for x in (motion.q, motion.qd, motion.qdd))
    q[:, joint - 1], qd[:, joint - 1], qdd[:, joint - 1] = q[0, joint - 1], 0.0, 0.0
    still = Motion(motion.t, q, qd, qdd)
    bare, heavy = (recorded("irb120", still, body, (1, k)) for k, body in enumerate((None, load)))
    level, why = said("irb120", bare, heavy, load.mass)
    assert level == "refused"
    assert f"joint {joint} does not move" in why


def several(masses: tuple[float, ...], stated_masses: tuple[float, ...], mounting: tuple[int, ...]) -> GainsResult:
    """Gains by weights of some masses, each mounted a quarter turn farther, and what was told of them [kg]."""
    name, motion = "irb120", moved("irb120", 1, 10)
    first, turn, bodies = weight(name, 1), np.eye(3), list[InertialParameters]()
    for mass in masses:
        bodies.append(InertialParameters(first.moved(turn, [0.0, 0.0, 0.0]).vector * (mass / first.mass)))
        turn = QUARTER @ turn
    logs = [recorded(name, motion, body, (1, k)) for k, body in enumerate((None, *bodies))]
    loads = [known_mass(mass) for mass in stated_masses]
    problem = gain_problem(load_robot(name), logs[:1], logs[1:], loads, mounting)
    return answer_gains(problem)


@pytest.mark.long
def test_two_weights_tell_a_mass_that_is_wrong() -> None:
    right = several((2.0, 1.0), (2.0, 1.0), (1, 2))
    assert right.judged.level == expected(right), right.judged.reasons
    wrong = several((2.0, 1.0), (2.0, 1.1), (1, 2))
    assert wrong.judged.level == "do_not_use"
    assert any("the known weights contradict" in reason for reason in wrong.judged.reasons)


@pytest.mark.long
def test_a_weight_mounted_anew_has_a_centre_of_mass_for_each_mounting() -> None:
    gains = several((2.0, 2.0), (2.0, 2.0), (4, 2))
    first, second = gains.working.payloads
    assert second.com == pytest.approx(QUARTER @ first.com, abs=0.03)
    assert np.abs(errors_in_sigma(gains, truth("irb120", 1))).max() < 4.5
    assert gains.working.mountings == (4, 2)


@pytest.mark.parametrize("numbers", [(1,), (1, 2, 3)])
def test_another_count_of_mountings_is_refused(numbers: tuple[int, ...]) -> None:
    bare, heavy, mass = pair("irb120", 1)
    with pytest.raises(InputError, match=r"for 2 loaded recordings: give one number for each.*1,2,2"):
        gain_problem(load_robot("irb120"), [bare], [heavy, heavy], known_mass(mass), numbers)


SINGLE = [name for name in robot_names() if not (load_robot(name).coupling or load_robot(name).spring)]


@pytest.mark.parametrize("name", SINGLE[::3])
def test_scales_of_the_joints_torques_are_found(name: str) -> None:
    """Torques wrong by up to half leave no more than right ones, and as much as plain least squares leaves."""
    robot, currents = load_robot(name), recorded(name, moved(name, 3), None, (3, 0))
    recording = replace(currents, torque=currents.torque * truth(name, 3))
    right = System.of(robot, States.of(recording, robot.processing))
    factors = np.exp(np.random.default_rng(5).uniform(-0.4, 0.4, robot.n))
    wrong = replace(right, torque=right.torque * factors[:, None])
    weights = right.weights / factors
    fit, plain = wrong.fit(weights, free_gains=True), wrong.fit(weights)
    left = float(weights**2 @ np.sum(fit.errors**2, axis=1))
    assert left <= float(right.weights**2 @ np.sum(right.fit(right.weights).errors ** 2, axis=1))
    assert 1.1 * left < float(weights**2 @ np.sum(plain.errors**2, axis=1))
    rows = (weights[:, None] * wrong.keep)[:, None] * wrong.columns * fit.scales[:, None, None]
    A, b = np.hstack(list(rows)).T, (weights[:, None] * wrong.keep * wrong.torque).ravel()
    assert left == pytest.approx(float(np.sum((b - A @ np.linalg.lstsq(A, b, rcond=None)[0]) ** 2)), rel=1e-6)
