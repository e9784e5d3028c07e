"""Mistakes in recordings for drive gains are named; good ones are answered at the level that their sigma says."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import answer_gains
from dynident.estimation.answers.gains import DriveGains
from dynident.estimation.diagnosis.engine import System
from dynident.estimation.diagnosis.evidence import KNOWN_WELL
from dynident.estimation.diagnosis.states import States
from dynident.estimation.gains.known_load import KnownLoad, Mountings, known_mass
from dynident.estimation.gains.problem import gain_problem
from dynident.model import InertialParameters, Motion, Recording, Robot, load_robot, robot_names, with_stand_in
from dynident.trajectories import Simulator, random_via_points

Change = Callable[[Recording], Recording]


@cache
def arm(name: str) -> Robot:
    """A shipped robot with parameters to simulate with."""
    return with_stand_in(load_robot(name))


@cache
def simulator(name: str) -> Simulator:
    return Simulator(arm(name))


def weight(name: str, seed: int, share: float = 0.7) -> InertialParameters:
    """A weight of a share of what the arm carries, off the flange's axis."""
    draw = np.random.default_rng([seed, 3])
    mass = share * min(arm(name).rated_payload, 10.0)
    com = [draw.uniform(0.05, 0.12), draw.uniform(-0.05, 0.05), draw.uniform(0.05, 0.12)]
    return InertialParameters.from_com(mass, com, mass * np.diag([0.004, 0.005, 0.003]))


def truth(name: str, seed: int) -> Array:
    """Gains [N·m/A]."""
    return np.random.default_rng([seed, 5]).uniform(5.0, 60.0, arm(name).n)


def moved(name: str, seed: int, points: int = 14) -> Motion:
    rate = 250.0 if name in ("rx90", "tx40") else 100.0
    return random_via_points(arm(name), points, seed, 0.6, 0.5).motion(rate)


def recorded(
    name: str, motion: Motion, load: InertialParameters | None, seed: Sequence[int], noise: float = 0.05
) -> Recording:
    """Currents with white noise, a share of each."""
    robot, exact = arm(name), simulator(name).record(motion, load)
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


def answered(name: str, bare: Recording, heavy: Recording, mass: float, robot: Robot | None = None) -> DriveGains:
    load = known_mass(mass)
    return answer_gains(gain_problem(robot or load_robot(name), [bare], [heavy], load=load), load)


def said(name: str, bare: Recording, heavy: Recording, mass: float, robot: Robot | None = None) -> tuple[str, str]:
    """The level of the answer, or "refused"; and why."""
    try:
        verdict = answered(name, bare, heavy, mass, robot).verdict
    except InputError as error:
        return "refused", str(error)
    return verdict.level, "; ".join(verdict.reasons)


def on_current(change: Callable[[Array], Array]) -> Change:
    return lambda r: replace(r, torque=change(np.array(r.torque)))


def scaled(factor: float, joint: int | None = None) -> Change:
    """All currents, or one joint's, times a factor."""

    def change(current: Array) -> Array:
        current[:, slice(None) if joint is None else joint - 1] *= factor
        return current

    return on_current(change)


def exchanged(i: int, j: int) -> Change:
    """Two columns of currents that changed places."""

    def change(current: Array) -> Array:
        current[:, [i - 1, j - 1]] = current[:, [j - 1, i - 1]]
        return current

    return on_current(change)


def counted_backwards(joint: int) -> Change:
    def change(r: Recording) -> Recording:
        sign = np.ones(r.q.shape[1])
        sign[joint - 1] = -1.0
        return replace(r, q=r.q * sign, torque=r.torque * sign)

    return change


QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def expected(gains: DriveGains) -> str:
    known = gains.larger_relative_sigma <= KNOWN_WELL
    return "use" if known.all() else "identified_only" if known.any() else "do_not_use"


def check_good(name: str, seed: int, noise: float) -> None:
    bare, heavy, mass = pair(name, seed, noise)
    gains = answered(name, bare, heavy, mass)
    assert gains.verdict.level == expected(gains), gains.verdict.reasons
    error = np.log(gains.values / truth(name, seed)) / gains.larger_relative_sigma
    assert np.abs(error).max() < 4.5


@pytest.mark.parametrize("name", ["irb120", pytest.param("rx90", marks=pytest.mark.long)])
def test_good_recordings_are_answered(name: str) -> None:
    check_good(name, 1, 0.05)


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "noise"), [*((name, 0.05) for name in robot_names()), *product(("irb120", "rx90"), (0.02, 0.1))]
)
def test_good_recordings_of_every_arm_are_answered(name: str, noise: float) -> None:
    """None is refused, and none spoken against."""
    check_good(name, int(1000 * noise), noise)


Mistake = Callable[[Recording, Recording, float], tuple[Recording, Recording, float]]


def in_both(change: Change) -> Mistake:
    return lambda bare, heavy, mass: (change(bare), change(heavy), mass)


def in_loaded(change: Change) -> Mistake:
    return lambda bare, heavy, mass: (bare, change(heavy), mass)


def same_twice(bare: Recording, heavy: Recording, mass: float) -> tuple[Recording, Recording, float]:
    return bare, replace(scaled(1.0005)(bare), source="loaded"), mass


MISTAKES: dict[str, tuple[Mistake, str]] = {
    "loaded on another scale": (in_loaded(scaled(1.06)), "with payload are on another scale"),
    "one gain off in one recording": (in_loaded(scaled(1.15, 3)), "drive gains"),
    "a mass ten times too large": (lambda bare, heavy, mass: (bare, heavy, 10.0 * mass), "that this arm carries"),
    "recordings exchanged": (lambda bare, heavy, mass: (heavy, bare, mass), "with and without the payload look"),
    "currents exchanged": (in_both(exchanged(2, 3)), "torques of joints 2 and 3 are exchanged"),
    "currents exchanged in one": (in_loaded(exchanged(2, 3)), "torques of joints 2 and 3 are exchanged"),
    "joint counted backwards": (in_both(counted_backwards(4)), "joint 4 "),
    "all currents negative": (in_both(scaled(-1.0)), "turn its sign"),
    "one recording twice": (same_twice, "the payload does not show in the currents"),
}
"""A change of the recordings or the mass, and what is then said.

Joint 4 of the Panda counted backwards leaves its range, and is refused before any fit. The gain of one joint
in one recording shows as a scale on small arms, as a joint that weighs otherwise on large ones.
"""


BY_KIND = {
    "rx90": (
        "loaded on another scale",
        "one gain off in one recording",
        "currents exchanged",
        "joint counted backwards",
    ),
    "ur10e": ("one gain off in one recording", "joint counted backwards"),
    "panda": ("loaded on another scale", "joint counted backwards"),
}
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
    assert f"joint {joint} never moves" in why


def several(masses: tuple[float, ...], stated_masses: tuple[float, ...], mounting: tuple[int, ...]) -> DriveGains:
    """Gains by weights of some masses, each mounted a quarter turn farther, and what was told of them [kg]."""
    name, motion = "irb120", moved("irb120", 1, 10)
    first, turn, bodies = weight(name, 1), np.eye(3), list[InertialParameters]()
    for mass in masses:
        bodies.append(InertialParameters(first.moved(turn, [0.0, 0.0, 0.0]).vector * (mass / first.mass)))
        turn = QUARTER @ turn
    logs = [recorded(name, motion, body, (1, k)) for k, body in enumerate((None, *bodies))]
    loads = [known_mass(mass) for mass in stated_masses]
    problem = gain_problem(load_robot(name), logs[:1], logs[1:], load=loads, mounting=mounting)
    return answer_gains(problem, loads)


@pytest.mark.long
def test_two_weights_tell_a_mass_that_is_wrong() -> None:
    right = several((2.0, 1.0), (2.0, 1.0), (1, 2))
    assert right.verdict.level == expected(right), right.verdict.reasons
    wrong = several((2.0, 1.0), (2.0, 1.1), (1, 2))
    assert wrong.verdict.level == "do_not_use"
    assert any("the weights do not go together" in reason for reason in wrong.verdict.reasons)


@pytest.mark.long
def test_a_weight_mounted_anew_has_a_centre_of_mass_for_each_mounting() -> None:
    gains = several((2.0, 2.0), (2.0, 2.0), (4, 2))
    first, second = gains.payloads
    assert second.com == pytest.approx(QUARTER @ first.com, abs=0.03)
    assert np.abs(np.log(gains.values / truth("irb120", 1)) / gains.larger_relative_sigma).max() < 4.5
    assert gains.mountings.names == (4, 2)


@pytest.mark.parametrize("numbers", [(1,), (1, 2, 3)])
def test_another_count_of_mountings_is_refused(numbers: tuple[int, ...]) -> None:
    with pytest.raises(InputError, match=r"for 2 loaded recordings: give one number for each.*1,2,2"):
        Mountings.of(numbers, 2, 2)


def test_one_centre_of_mass_does_not_hold_in_two_mountings() -> None:
    with pytest.raises(InputError, match="cannot hold in several mountings"):
        Mountings.of((1, 2), 2, 2).loads(KnownLoad(mass=2.0, com=(0.0, 0.0, 0.1)))


SINGLE = [name for name in robot_names() if not (load_robot(name).coupling or load_robot(name).spring)]


@pytest.mark.parametrize("name", SINGLE)
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
    assert left == pytest.approx(float(np.sum((b - A @ np.linalg.lstsq(A, b)[0]) ** 2)), rel=1e-6)
