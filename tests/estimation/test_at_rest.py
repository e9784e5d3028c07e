"""Weighing at rest: the mass on every arm, what spoils it, and a drift that the order of recordings takes off."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from dynident.benchmarks import static
from dynident.common.arrays import Array
from dynident.estimation import Settings, weigh_at_rest
from dynident.model import robot_names
from dynident.tests.selection import cases

Spoil = Callable[[static.Arm, Array, Array], Array]


@pytest.fixture(autouse=True)
def _uncompiled(monkeypatch: pytest.MonkeyPatch) -> None:
    """A compiler takes longer than a few rows by NumPy."""
    monkeypatch.setenv("DYNIDENT_NO_COMPILER", "1")


@pytest.mark.parametrize("name", cases(robot_names(), lambda name: name in ("rx90", "ur10e")))
def test_mass_within_its_interval_on_every_arm(name: str) -> None:
    arm = static.arm(name, 1)
    error, sigma, low, high = static.weighed(arm, "AB", 0)
    expected = 100.0 * arm.sigma / arm.payload.mass
    assert abs(error) < 4.0 * sigma
    assert low < error < high
    assert 0.5 * expected < sigma < 2.5 * expected


def swings(arm: static.Arm, t: Array, torque: Array) -> Array:
    payload = arm.torques[1] - arm.torques[0]
    return np.asarray(torque + 0.1 * payload * np.sin(2.0 * np.pi * 1.3 * t)[:, None])


def brakes(arm: static.Arm, t: Array, torque: Array) -> Array:
    return torque * (np.abs(arm.motion.qd) > 1e-9).any(axis=1, keepdims=True)


GUARDS: dict[str, tuple[Spoil | None, str]] = {
    "one side": (None, "pose 1, 2, 3, 4, 5, 6, 7, 8 is reached from one side only"),
    "swing": (swings, "the payload swings: at rest the torque of joint 2 oscillates at 1."),
    "brake": (brakes, "a brake holds the arm"),
}


@pytest.mark.parametrize("guard", GUARDS)
def test_what_spoils_a_weighing_at_rest_is_named_not_answered(guard: str) -> None:
    spoil, reason = GUARDS[guard]
    arm = static.arm("panda", 1, both_sides=spoil is not None)
    loaded, unloaded = arm.recordings("AB", 0)
    if spoil:
        loaded = [replace(own, torque=spoil(arm, own.t, own.torque)) for own in loaded]
    verdict = weigh_at_rest(arm.robot, loaded, unloaded).verdict
    assert verdict.level == "do_not_use"
    assert any(reason in text for text in verdict.reasons)


def test_joints_that_are_named_alone_weigh_at_rest() -> None:
    arm = static.arm("ur10e", 1)
    loaded, unloaded = arm.recordings("AB", 0)
    result = weigh_at_rest(arm.robot, loaded, unloaded, settings=Settings(joints=(2, 3, 5)))
    assert result.joints == (2, 3, 5)
    assert abs(result.mass.value - arm.payload.mass) < 4.0 * result.mass.sigma


def test_unloaded_loaded_loaded_unloaded_takes_a_drift_off() -> None:
    arm = static.arm("panda", 1)
    alone, both = (abs(static.weighed(arm, order, 0, scatter=0.0)[0]) for order in ("AB", "ABBA"))
    assert both < alone / 5.0
    loaded, unloaded = arm.recordings("ABBA", 0)
    standing = weigh_at_rest(arm.robot, loaded, unloaded).standing
    assert standing
    assert standing.drift
    assert standing.drift.ratio == pytest.approx(0.0, abs=1e-9)
    assert standing.order == "unloaded, loaded, loaded, unloaded by their clock"
