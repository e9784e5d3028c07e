"""A look at logs: what is right stays quiet, each wrong one is told."""

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs.log_check import LogReport, check_log, smallest_step
from dynident.apps.logs.read import read_recording
from dynident.model import Motion, Processing, Recording, Robot, load_robot
from dynident.trajectories import Simulator

NOISE = (2.0, 2.0, 1.0, 0.5, 0.5, 0.3)
SETTINGS = Processing(cutoff=10.0, decimate=4)
UR10E = (11.976, 11.976, 9.839, 10.763, 10.757, 10.680)
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
    check = good
    assert words(check, "error", "warning") == ""
    assert check.usable
    assert check.time is not None
    assert check.time.rate == pytest.approx(100.0, rel=1e-3)
    assert check.time.jitter < 1e-3
    assert all(joint.moves for joint in check.joints)
    assert all(joint.saturated == pytest.approx(1.0 / check.time.samples) for joint in check.joints)
    assert len(check.excitation) == 58
    assert check.relative_residual is not None
    assert check.relative_residual < 0.15


@pytest.mark.long
def test_excitation_is_that_of_the_estimate(good: LogReport, simulated: Callable[[str], Simulator]) -> None:
    """Estimates lie within their stated sigma of the simulated robot's parameters."""
    from dynident.model import base_parameters, standard_columns

    robot = load_robot("ur10e")
    base = base_parameters(robot)
    truth = base.grouping @ np.array(
        [simulated("ur10e").robot.parameters[name] for name in standard_columns(robot)]
    )
    values = np.array([entry.value for entry in good.excitation])
    sigma = np.array([entry.relative_sigma_percent for entry in good.excitation]) / 100.0 * np.abs(values)
    assert 0.5 < np.mean(np.square((values - truth) / sigma)) < 2.5


def without_gravity(log: Recording, simulator: Simulator) -> Recording:
    still = np.zeros(log.q.shape)
    at_rest = simulator.measure(Motion(log.t, log.q, still, still)).torque
    bare = replace(simulator.robot, gravity=(0.0, 0.0, 0.0))
    friction = Simulator(bare).measure(Motion(log.t, log.q, still, still)).torque
    return replace(log, torque=log.torque - at_rest + friction)


def spoilt(log: Recording) -> dict[str, tuple[Recording, str, str]]:
    """What is wrong -> the log, how bad that is, words that must be said."""
    assert log.qd is not None
    degrees = 180.0 / np.pi
    cut = np.clip(log.torque, np.quantile(log.torque, 0.02, axis=0), np.quantile(log.torque, 0.98, axis=0))
    still = np.array(log.q)
    still[:, 3] = 0.2
    still_speed = np.array(log.qd)
    still_speed[:, 3] = 0.0
    draw = np.random.default_rng(0).uniform(-0.004, 0.004, log.t.shape)
    return {
        "degrees": (replace(log, q=degrees * log.q, qd=degrees * log.qd), "error", "degrees"),
        "motor side": (
            replace(log, q=GEARS * log.q, qd=GEARS * log.qd, torque=log.torque / GEARS),
            "error",
            "motor",
        ),
        "currents as torque": (replace(log, torque=log.torque / [12.4, 10, 10, 5, 5, 4]), "warning", "one scale"),
        "motor torque": (replace(log, torque=log.torque / GEARS * 80), "warning", "one scale"),
        "percent": (replace(log, torque=100 * log.torque / [330, 330, 150, 56, 56, 56]), "warning", "percent"),
        "saturated": (replace(log, torque=cut), "", "saturated"),
        "coarse": (replace(log, torque=np.round(log.torque / 20) * 20), "warning", "coarse"),
        "one joint still": (replace(log, q=still, qd=still_speed), "warning", "Joint 4 never moves"),
        "no motion": (replace(log, q=0 * log.q, qd=0 * log.qd), "error", "No joint ever moves"),
        "dead channel": (replace(log, torque=log.torque * [1, 1, 0, 1, 1, 1]), "error", "dead"),
        "speeds in degrees": (replace(log, qd=degrees * log.qd), "error", "degrees per second"),
        "jitter": (replace(log, t=log.t + draw), "note", "Time steps vary"),
        "other zero": (replace(log, q=log.q + np.array([0, 0, 0, 8.0, 0, 0])), "error", "zero"),
        "short": (Recording(log.t[:25], log.q[:25], log.torque[:25]), "error", "few"),
    }


CASES = (
    "degrees",
    "motor side",
    "currents as torque",
    "motor torque",
    "percent",
    "saturated",
    "coarse",
    "one joint still",
    "no motion",
    "dead channel",
    "speeds in degrees",
    "jitter",
    "other zero",
    "short",
)


@pytest.mark.parametrize("case", CASES)
def test_what_is_wrong_is_told(log: Recording, case: str) -> None:
    recording, severity, needed = spoilt(log)[case]
    check = look(recording)
    assert needed in words(check, *((severity,) if severity else ("error", "warning")))
    assert check.usable == (severity != "error" and not words(check, "error"))


def test_gravity_compensated_torque(log: Recording, simulated: Callable[[str], Simulator]) -> None:
    check = look(without_gravity(log, simulated("ur10e")))
    assert "no gravity" in words(check, "error")


def test_currents_are_brought_to_one_scale(log: Recording, good: LogReport) -> None:
    """Currents of unknown gain: no word about scales, and the excitation is that of the torques."""
    check = look(replace(log, torque=log.torque / [12.4, 10, 10, 10.5, 10, 9]), currents=True)
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


def test_quantum() -> None:
    values = np.round(np.random.default_rng(0).normal(size=1000), 2)
    assert smallest_step(values) == pytest.approx(0.01)
    assert smallest_step(np.random.default_rng(0).normal(size=1000)) == 0.0


@pytest.mark.parametrize(
    ("case", "needed"), [("late", "lags position"), ("turned", "sign of the torque of joint 2")]
)
def test_causes_are_told(log: Recording, case: str, needed: str) -> None:
    late = np.column_stack([np.interp(log.t - 0.1, log.t, channel) for channel in log.torque.T])
    torque = {"late": late, "turned": log.torque * [1, -1, 1, 1, 1, 1]}[case]
    assert needed in words(look(replace(log, torque=torque)), "error", "warning")


@pytest.mark.long
@pytest.mark.parametrize("name", ["unloaded", "validation_point_to_point"])
def test_real_torques_are_to_one_scale_and_real_currents_are_not(recordings: Path, name: str) -> None:
    """A formula for white noise is 4 to 5 standard deviations sure of joints 1 and 4 that are right."""
    robot = load_robot("ur10e")
    for gains, words_said in ((UR10E, False), ((1.0,) * 6, True)):
        recording = read_recording(recordings / f"ur10e/{name}.csv.gz", robot, gains)
        findings = check_log(robot, recording).findings
        assert any("one scale" in finding.text for finding in findings) == words_said


def test_a_short_recording_tells_no_scales() -> None:
    """The sensors of a real Gen3 are to one scale, of which 4.7 s tell nothing."""
    folder = os.environ.get("DYNIDENT_DATA")
    if not folder:
        pytest.skip("real recordings: set DYNIDENT_DATA to their folder")
    robot = load_robot(Path(folder) / "gen3/gen3.urdf")
    check = check_log(robot, read_recording(Path(folder) / "gen3/gen3_opti1.csv.gz", robot), robot.processing)
    assert "scale" not in words(check, "error", "warning")
