"""The real UR10e pair: its verdict, and wrong inputs made from it."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs.read import read_recording
from dynident.common.errors import InputError
from dynident.estimation import PayloadAnswer, answer_payload, payload_problem
from dynident.model import Recording, load_robot
from dynident.tests.selection import every

GAINS = (11.976, 11.976, 9.839, 10.763, 10.757, 10.680)
MASS = 2.805
Pair = tuple[Recording, Recording]


@pytest.fixture(scope="module")
def pair(recordings: Path) -> Pair:
    """Recordings without and with the payload."""
    names = ("unloaded", "loaded_2.805kg")
    bare, loaded = (
        read_recording(recordings / "ur10e" / f"{name}.csv.gz", load_robot("ur10e"), GAINS) for name in names
    )
    return bare, loaded


def answered(bare: Recording, loaded: Recording, robot: str = "ur10e") -> PayloadAnswer:
    return answer_payload(payload_problem(load_robot(robot), [loaded], [bare]))


def told(bare: Recording, loaded: Recording) -> str:
    """The error, or the reasons not to use anything."""
    try:
        judged = answered(bare, loaded).verdict
    except InputError as error:
        return str(error)
    assert judged.level == "do_not_use"
    return " ".join(judged.reasons)


@pytest.fixture(scope="module")
def answer(pair: Pair) -> PayloadAnswer:
    return answered(*pair)


def test_the_pair_gives_mass_and_centre_of_mass_without_a_conflict(answer: PayloadAnswer) -> None:
    assert answer.verdict.level == "mass_and_com_only"
    assert "inertia: not measured well enough" in answer.verdict.reasons[-1]
    assert not any(payload.conflict for payload in answer.constrained)
    assert min(payload.p_value for payload in answer.constrained) > 0.05
    assert abs(answer.recommended.mass / MASS - 1.0) < 0.015


def test_the_pairs_joints_do_not_weigh_the_same(answer: PayloadAnswer) -> None:
    """Drive gains or friction: joint 4 sees some 7 % more than joints 2 and 3; joints 5 and 6 see no mass.

    The intervals, wider by the joints' shares, allow for it.
    """
    mass = {group.joints: group.mass for group in answer.by_joints.masses}
    arm, wrist = mass[1, 2, 3], mass[4, 5, 6]
    assert arm is not None
    assert wrist is not None
    assert 0.04 < (wrist - arm) / MASS < 0.08
    assert mass[5,] is None
    assert mass[6,] is None
    low, high = answer.mass_interval
    assert low < MASS < high
    assert not any("weigh the same" in reason for reason in answer.verdict.reasons)


def scaled(joint: int, factor: float) -> Callable[[Recording], Recording]:
    size = np.ones(6)
    size[joint - 1] = factor
    return lambda r: replace(r, torque=r.torque * size)


def late(r: Recording) -> Recording:
    return replace(r, torque=np.column_stack([np.interp(r.t - 0.2, r.t, channel) for channel in r.torque.T]))


def exchanged(r: Recording) -> Recording:
    order = [0, 2, 1, 3, 4, 5]
    assert r.qd is not None
    return replace(r, q=r.q[:, order], qd=r.qd[:, order], torque=r.torque[:, order])


def degrees(r: Recording) -> Recording:
    assert r.qd is not None
    return replace(r, q=np.degrees(r.q), qd=np.degrees(r.qd))


def only_speeds_in_degrees(r: Recording) -> Recording:
    assert r.qd is not None
    return replace(r, qd=np.degrees(r.qd))


WRONG = {
    "gain 3 twice too large": (scaled(3, 2.0), "joint 3 shows 1.9"),
    "gain 4 halved": (scaled(4, 0.5), "joint 4 shows 0.5"),
    "sign of torque 2": (scaled(2, -1.0), "the sign of the torque of joint 2 is wrong"),
    "torque 0.2 s late": (late, "torque lags position by about 0.2"),
    "joints 2 and 3 exchanged": (exchanged, "joints 2 and 3 are exchanged"),
    "degrees": (degrees, "degrees"),
    "speeds in degrees": (only_speeds_in_degrees, "degrees per second"),
    "milliampere": (lambda r: replace(r, torque=1000.0 * r.torque), "N·m/A"),
    "dead channel": (scaled(5, 0.0), "dead"),
}


@pytest.mark.parametrize("name", every(4, WRONG))
def test_wrong_inputs_from_the_pair_are_named(pair: Pair, name: str) -> None:
    spoil, words = WRONG[name]
    bare, loaded = pair
    assert words in told(spoil(bare), spoil(loaded))


@pytest.mark.long
def test_a_swapped_pair_is_named(pair: Pair) -> None:
    bare, loaded = pair
    assert "swapped" in " ".join(answered(loaded, bare).verdict.reasons)


def test_another_robot_is_named(pair: Pair) -> None:
    bare, loaded = pair
    with pytest.raises(InputError, match="outside the range"):
        answered(bare, loaded, "tx40")
