"""A look at logs: right ones stay quiet, mistakes of unit, time and joints are named."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs.log_check import LogReport, check_log
from dynident.apps.logs.read import read_recording
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import Settings, identify
from dynident.estimation.fit.own_equations import hidden_by
from dynident.estimation.signals.recordings import still_joints
from dynident.model import Motion, Processing, Recording, Robot, load_robot
from dynident.trajectories import Simulator

NOISE = (2.0, 2.0, 1.0, 0.5, 0.5, 0.3)
SETTINGS = Processing(cutoff=10.0, decimate=4)
GEARS = np.array([100.0, 120.0, 90.0, 80.0, 70.0, 60.0])


@pytest.fixture(scope="module")
def log(simulated: Callable[[str], Simulator], wander: Callable[..., Motion]) -> Recording:
    """A simulated UR10e, as it should be."""
    motion = wander(6, 5, points=20)
    exact = simulated("ur10e").record(motion, None, NOISE, 1)
    return Recording(exact.t, exact.q, exact.torque, motion.qd, "log")


def look(recording: Recording, currents: bool = False) -> LogReport:
    return check_log(load_robot("ur10e"), recording, SETTINGS, currents)


def words(check: LogReport, *severities: str) -> str:
    return "\n".join(finding.text for finding in check.findings if finding.severity in severities)


@pytest.fixture(scope="module")
def good(log: Recording) -> LogReport:
    return look(log)


def test_a_good_log_is_quiet(good: LogReport) -> None:
    assert words(good, "error", "warning") == ""
    assert good.usable
    assert good.time is not None
    assert good.time.rate == pytest.approx(100.0, rel=1e-3)
    assert good.time.jitter < 1e-3
    assert all(joint.moves for joint in good.joints)
    assert all(joint.saturated == pytest.approx(1.0 / good.time.samples) for joint in good.joints)
    assert len(good.excitation) == 58
    assert good.relative_residual is not None
    assert good.relative_residual < 0.15


DEGREES = 180.0 / np.pi


def still(log: Recording) -> Recording:
    """Joint 4 does not move."""
    return replace(log, q=np.where(np.arange(6) == 3, 0.2, log.q), qd=speeds(log) * (np.arange(6) != 3))


def speeds(log: Recording) -> Array:
    assert log.qd is not None
    return log.qd


def late(log: Recording) -> Recording:
    torque = [np.interp(log.t - 0.1, log.t, channel) for channel in log.torque.T]
    return replace(log, torque=np.column_stack(torque))


SPOILT: dict[str, tuple[Callable[[Recording], Recording], str, str]] = {
    "degrees": (lambda log: replace(log, q=DEGREES * log.q, qd=DEGREES * speeds(log)), "error", "degrees"),
    "motor side": (
        lambda log: replace(log, q=GEARS * log.q, qd=GEARS * speeds(log), torque=log.torque / GEARS),
        "error", "motor",
    ),
    "currents as torque": (
        lambda log: replace(log, torque=log.torque / [12.4, 10, 10, 5, 5, 4]),
        "error", "look like motor-side torques, currents",
    ),
    "motor torque": (lambda log: replace(log, torque=log.torque / GEARS * 80), "error", "one scale"),
    "percent": (
        lambda log: replace(log, torque=100 * log.torque / [330, 330, 150, 56, 56, 56]), "error", "percent"
    ),
    "saturated": (
        lambda log: replace(log, torque=np.clip(log.torque, *np.quantile(log.torque, [0.02, 0.98], axis=0))),
        "error warning", "saturated",
    ),
    "coarse": (lambda log: replace(log, torque=np.round(log.torque / 20) * 20), "warning", "resolution of only"),
    "one joint still": (still, "warning", "Joint 4 never moves"),
    "no motion": (lambda log: replace(log, q=0 * log.q, qd=0 * speeds(log)), "error", "No joint ever moves"),
    "dead channel": (lambda log: replace(log, torque=log.torque * [1, 1, 0, 1, 1, 1]), "error", "dead"),
    "speeds halved": (lambda log: replace(log, qd=0.5 * speeds(log)), "error", "qd1 is 0.49"),
    "speeds turned": (lambda log: replace(log, qd=-speeds(log)), "error", "qd1 is -0.99"),
    "speeds in degrees": (lambda log: replace(log, qd=DEGREES * speeds(log)), "error", "degrees per second"),
    "jitter": (
        lambda log: replace(log, t=log.t + np.random.default_rng(0).uniform(-0.004, 0.004, log.t.shape)),
        "note", "Time steps vary",
    ),
    "other zero": (lambda log: replace(log, q=log.q + np.array([0, 0, 0, 8.0, 0, 0])), "error", "zero"),
    "short": (lambda log: Recording(log.t[:25], log.q[:25], log.torque[:25]), "error", "few"),
    "late": (late, "error warning", "lags position"),
    "turned": (
        lambda log: replace(log, torque=log.torque * [1, -1, 1, 1, 1, 1]),
        "error warning", "torque of joint 2 has the wrong sign for gravity",
    ),
}  # fmt: skip
"""Fault -> what is done to the log, how bad that is, words that must be said."""


@pytest.mark.parametrize("fault", SPOILT)
def test_what_is_wrong_is_told(log: Recording, fault: str) -> None:
    """In ``check`` and in ``identify`` alike."""
    spoil, severities, needed = SPOILT[fault]
    check = look(spoil(log))
    assert needed in words(check, *severities.split())
    assert check.usable == (not words(check, "error"))
    try:
        reasons = identify(load_robot("ur10e"), [spoil(log)], settings=Settings(SETTINGS)).verdict.reasons
    except InputError:
        assert words(check, "error", "warning")
    else:
        # That no robot can exist so is seen by the jackknife, which one look does without.
        known = [reason.lower() for reason in reasons if "no physical robot" not in reason]
        assert all(reason in words(check, "error", "warning").lower() for reason in known)


def test_currents_are_brought_to_one_scale(log: Recording, good: LogReport) -> None:
    """Currents of unknown gain: no word about scales, and the excitation is that of the torques."""
    gains = np.array([12.4, 10, 10, 10.5, 10, 9])
    check = look(replace(log, torque=log.torque / gains), currents=True)
    by_weight = re.findall(r"([\d.]+) at joint (\d)", words(check, "note"))
    assert {joint for _, joint in by_weight} >= {"2", "3"}
    assert all(0.5 < float(gain) / gains[int(joint) - 1] < 2.0 for gain, joint in by_weight)
    assert words(check, "error", "warning") == ""
    a, b = (np.array([e.relative_sigma_percent for e in c.excitation]) for c in (check, good))
    certain = b < 20.0
    assert certain.sum() > 20
    assert np.abs(a[certain] / b[certain] - 1.0).max() < 0.25


@pytest.mark.parametrize(("robot", "name"), [("ur10e", "ur10e/unloaded"), ("tx40", "tx40/tx40")])
def test_real_logs_are_usable(recordings: Path, robot: str, name: str) -> None:
    arm: Robot = load_robot(robot)
    currents = robot == "ur10e"
    recording = read_recording(recordings / f"{name}.csv.gz", arm, (1.0,) * 6 if currents else None)
    check = check_log(arm, recording, None, currents)
    assert words(check, "error", "warning") == ""
    assert check.relative_residual is not None
    assert check.relative_residual < 0.054


def test_a_joint_that_never_moves_is_named_with_its_parameters(rx90: Robot, wander: Callable[..., Motion]) -> None:
    free, others = wander(6, 0), np.arange(6) != 3
    motion = Motion(free.t, np.where(others, free.q, 0.4), free.qd * others, free.qdd * others)
    log, other = (Recording(each.t, each.q, np.array(each.q)) for each in (motion, wander(6, 1)))
    assert still_joints([log]) == (4,)
    assert still_joints([log, other]) == ()
    with pytest.raises(
        InputError, match=r"joint 4 does not move within its 11 s, and ZZ1R, .* and 14 more cannot be identified"
    ):
        identify(rx90, [Simulator(rx90).record(motion)], Settings(robust=False))


def test_what_a_still_joint_hides_is_what_data_do_not_determine(rx90: Robot) -> None:
    """On the RX90 joint 1 alone shows ZZ1R and its own friction."""
    hidden = hidden_by(rx90, (1,))
    assert {"ZZ1R", "FS1", "FV1"} <= set(hidden)
    assert not {"MX2R", "FS2", "IA3", "MX6"} & set(hidden)
