"""What is wrong with recordings for drive gains is named; good ones are answered at the level their sigma says."""

from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.estimation import answer_gains
from dynident.estimation.answers.gains import DriveGains
from dynident.estimation.diagnosis.evidence import KNOWN_WELL
from dynident.estimation.gains.known_load import KnownLoad, Mountings, known_mass
from dynident.estimation.gains.problem import gain_problem
from dynident.model import InertialParameters, Motion, Recording, load_robot, robot_names
from dynident.tests.estimation.gains import made

QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def expected(gains: DriveGains) -> str:
    known = gains.larger_relative_sigma <= KNOWN_WELL
    return "use" if known.all() else "identified_only" if known.any() else "do_not_use"


def check_good(name: str, seed: int, noise: float) -> None:
    bare, heavy, mass = made.pair(name, seed, noise)
    gains = made.answered(name, bare, heavy, mass)
    assert gains.verdict.level == expected(gains), gains.verdict.reasons
    error = np.log(gains.values / made.truth(name, seed)) / gains.larger_relative_sigma
    assert np.abs(error).max() < 4.5


@pytest.mark.parametrize("name", ["irb120", pytest.param("rx90", marks=pytest.mark.long)])
def test_good_recordings_are_answered(name: str) -> None:
    check_good(name, 1, 0.05)


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "noise"),
    [*((name, 0.05) for name in robot_names()), *product(("irb120", "rx90"), (0.02, 0.1))],
)
def test_good_recordings_of_every_arm_are_answered(name: str, noise: float) -> None:
    """None is refused, and none spoken against."""
    check_good(name, int(1000 * noise), noise)


Mistake = Callable[[Recording, Recording, float], tuple[Recording, Recording, float]]


def in_both(change: made.Change) -> Mistake:
    return lambda bare, heavy, mass: (change(bare), change(heavy), mass)


def in_loaded(change: made.Change) -> Mistake:
    return lambda bare, heavy, mass: (bare, change(heavy), mass)


def same_twice(bare: Recording, heavy: Recording, mass: float) -> tuple[Recording, Recording, float]:
    return bare, replace(made.scaled(1.0005)(bare), source="loaded"), mass


MISTAKES: dict[str, tuple[Mistake, str]] = {
    "loaded on another scale": (in_loaded(made.scaled(1.06)), "with payload are on another scale"),
    "one gain off in one recording": (in_loaded(made.scaled(1.15, 3)), "drive gains"),
    "a mass ten times too large": (lambda bare, heavy, mass: (bare, heavy, 10.0 * mass), "that this arm carries"),
    "recordings exchanged": (lambda bare, heavy, mass: (heavy, bare, mass), "with and without the payload look"),
    "currents exchanged": (in_both(made.exchanged(2, 3)), "torques of joints 2 and 3 are exchanged"),
    "currents exchanged in one": (in_loaded(made.exchanged(2, 3)), "torques of joints 2 and 3 are exchanged"),
    "joint counted backwards": (in_both(made.counted_backwards(4)), "joint 4 "),
    "all currents negative": (in_both(made.scaled(-1.0)), "turn its sign"),
    "one recording twice": (same_twice, "the payload does not show in the currents"),
}
"""What is done to the recordings or the mass, and what is then said.

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
    level, why = made.said(name, *change(*made.pair(name, 1)))
    assert level in ("do_not_use", "refused"), why
    assert words in why


@pytest.mark.long
def test_contact_is_not_used() -> None:
    bare, heavy, mass = made.pair("ur10e", 1)
    level, why = made.said("ur10e", bare, made.struck(heavy), mass)
    assert level == "do_not_use"
    assert "with payload unexplained" in why


@pytest.mark.parametrize("joint", [1, 4])
def test_a_joint_that_does_not_move_is_named(joint: int) -> None:
    motion, load = made.moved("irb120", 1), made.weight("irb120", 1)
    q, qd, qdd = (np.array(x) for x in (motion.q, motion.qd, motion.qdd))
    q[:, joint - 1], qd[:, joint - 1], qdd[:, joint - 1] = q[0, joint - 1], 0.0, 0.0
    still = Motion(motion.t, q, qd, qdd)
    bare, heavy = (made.recorded("irb120", still, body, (1, k)) for k, body in enumerate((None, load)))
    level, why = made.said("irb120", bare, heavy, load.mass)
    assert level == "refused"
    assert f"joint {joint} never moves" in why


@pytest.mark.long
def test_one_weights_mass_is_taken_on_trust() -> None:
    """10 % on the mass are 10 % on every gain, and no more residual: nothing but the scale knows it."""
    bare, heavy, mass = made.pair("irb120", 1)
    right, wrong = (made.answered("irb120", bare, heavy, factor * mass) for factor in (1.0, 1.1))
    assert np.log(wrong.values / right.values) == pytest.approx(np.log(1.1), abs=1e-4)
    assert wrong.logarithms.fit.relative == pytest.approx(right.logarithms.fit.relative, rel=1e-3)
    assert wrong.verdict.level == right.verdict.level


def several(masses: tuple[float, ...], stated_masses: tuple[float, ...], mounting: tuple[int, ...]) -> DriveGains:
    """Gains by weights of some masses, each mounted a quarter turn farther, and what was told of them [kg]."""
    name, motion = "irb120", made.moved("irb120", 1, 10)
    first, turn, bodies = made.weight(name, 1), np.eye(3), list[InertialParameters]()
    for mass in masses:
        bodies.append(InertialParameters(first.moved(turn, [0.0, 0.0, 0.0]).vector * (mass / first.mass)))
        turn = QUARTER @ turn
    logs = [made.recorded(name, motion, body, (1, k)) for k, body in enumerate((None, *bodies))]
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
    assert np.abs(np.log(gains.values / made.truth("irb120", 1)) / gains.larger_relative_sigma).max() < 4.5
    assert gains.mountings.names == (4, 2)


@pytest.mark.parametrize("numbers", [(1,), (1, 2, 3)])
def test_another_count_of_mountings_is_refused(numbers: tuple[int, ...]) -> None:
    with pytest.raises(InputError, match=r"for 2 loaded recordings: give one number for each.*1,2,2"):
        Mountings.of(numbers, 2, 2)


def test_one_centre_of_mass_does_not_hold_in_two_mountings() -> None:
    with pytest.raises(InputError, match="cannot hold in several mountings"):
        Mountings.of((1, 2), 2, 2).loads(KnownLoad(mass=2.0, com=(0.0, 0.0, 0.1)))
