"""Simulated recordings: the robot under its controller, disturbances by level and seed, exact without noise."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident import trajectories
from dynident.apps.commands.simulate import PAYLOAD
from dynident.apps.logs.read import read_recording
from dynident.apps.recordings import write_recording
from dynident.common.arrays import Array
from dynident.examples.paper.printed import paper_tables
from dynident.model import Motion, Robot, base_parameters, load_robot
from dynident.model.dynamics import SMOOTHING, dry_friction_names, smooth_dry_friction
from dynident.model.motion import Measurement
from dynident.trajectories.motions.via_points import random_points
from dynident.trajectories.simulation import (
    CONTROLLERS,
    RX90_DISTURBANCES,
    RX90_SLOW_NOISE,
    draw_friction,
    draw_robot_errors,
    no_disturbances,
    record,
    relative_disturbances,
)


def test_the_simulated_robot_is_the_papers() -> None:
    """Base parameters of rx90.toml against the robot part of Table 2; YZ6 is told in the file."""
    robot = load_robot("rx90")
    base = base_parameters(robot)
    value = dict(zip(base.columns, base.value(robot.parameters), strict=True))
    for name, printed in paper_tables().table2_robot.items():
        if name != "YZ6":
            assert value[name] == pytest.approx(printed.value, abs=1e-6), name


RX90 = load_robot("rx90")
T = np.arange(200_000) / 250.0
STILL = Motion(T, np.outer(np.sin(T), np.ones(6)), np.zeros((len(T), 6)), np.zeros((len(T), 6)))
ZERO = np.zeros((len(T), 6))


def noise(disturbances: trajectories.Disturbances, seed: int = 0) -> np.ndarray:
    _, gains = draw_robot_errors(disturbances, seed)
    return np.asarray(record(Measurement(STILL, ZERO), disturbances, gains, [seed, 0]).torque)


def correlation(x: np.ndarray, lag: int) -> float:
    return float(np.mean(x[lag:] * x[:-lag]) / np.mean(x * x))


def test_white_noise_has_its_level_and_no_memory() -> None:
    torque = noise(RX90_DISTURBANCES)
    assert np.allclose(torque.std(axis=0), RX90_DISTURBANCES.white, rtol=0.02)
    assert all(abs(correlation(torque[:, j], 1)) < 0.02 for j in range(6))


def test_slow_noise_has_its_level_and_its_memory() -> None:
    torque = noise(RX90_SLOW_NOISE)
    assert np.allclose(torque.std(axis=0), RX90_SLOW_NOISE.slow, rtol=0.15)
    for j in range(6):
        assert correlation(torque[:, j], 200) == pytest.approx(np.exp(-1.0), abs=0.08)


def test_friction_wanders_about_its_level() -> None:
    levels = draw_friction(RX90, RX90_DISTURBANCES, len(T), 250.0, [1, 2])
    mean = np.array([RX90.parameters[name] for name in ("FS1", "FS2", "FS3", "FS4", "FS5", "FS6", "FSM6")])
    assert np.allclose(levels.mean(axis=0), mean, rtol=0.03)
    assert np.allclose(levels.std(axis=0) / mean, RX90_DISTURBANCES.friction, rtol=0.15)
    assert correlation(levels[:, 0] - mean[0], 500) == pytest.approx(np.exp(-1.0), abs=0.12)
    constant = draw_friction(RX90, no_disturbances(6), 10, 250.0, [1, 2])
    assert np.array_equal(constant, np.tile(mean, (10, 1)))


def test_levels_are_shares_of_the_torque() -> None:
    levels = relative_disturbances(np.array([100.0, 10.0]), 0.1)
    assert (levels.white, levels.slow, levels.ripple) == ((10.0, 1.0), (0.0, 0.0), (5.0, 0.5))
    assert (levels.friction, levels.encoder) == (0.05, 1e-5)


def test_encoder_and_gains() -> None:
    levels = replace(no_disturbances(6), encoder=1e-3, gain_error=0.02)
    _, gains = draw_robot_errors(levels, 5)
    recording = record(Measurement(STILL, ZERO + 10.0), levels, gains, [5, 0])
    assert np.abs(recording.q - STILL.q).max() == pytest.approx(0.5e-3, rel=0.01)
    assert np.allclose(recording.q / 1e-3, np.round(recording.q / 1e-3))
    assert np.allclose(recording.torque, 10.0 * gains)
    assert 0.0 < np.abs(gains - 1.0).max() < 0.1
    many = np.array([draw_robot_errors(levels, seed)[1] for seed in range(500)])
    assert many.std() == pytest.approx(0.02, rel=0.05)


@pytest.fixture(scope="module")
def tasks() -> list[trajectories.Task]:
    reference = trajectories.plan_point_to_point(RX90, random_points(RX90, 3, 0))
    return [trajectories.Task("a", reference), trajectories.Task("b", reference)]


@pytest.fixture(scope="module")
def experiment(tasks: list[trajectories.Task]) -> trajectories.Experiment:
    return trajectories.run_experiment(RX90, tasks, RX90_DISTURBANCES, seed=7)


@pytest.mark.long
def test_the_same_seed_gives_the_same_recordings(
    tasks: list[trajectories.Task], experiment: trajectories.Experiment
) -> None:
    same = trajectories.run_experiment(RX90, tasks, RX90_DISTURBANCES, seed=7)
    reseeded = trajectories.run_experiment(RX90, tasks, RX90_DISTURBANCES, seed=8)
    for a, b, c in zip(experiment.runs, same.runs, reseeded.runs, strict=True):
        assert np.array_equal(a.recording.torque, b.recording.torque)
        assert np.array_equal(a.recording.q, b.recording.q)
        assert not np.array_equal(a.recording.torque, c.recording.torque)
    first, two = experiment.runs
    assert not np.array_equal(first.recording.torque, two.recording.torque)


def test_a_recording_is_read_back(experiment: trajectories.Experiment, tmp_path: Path) -> None:
    written = replace(experiment.runs[1].recording, gain_sigma=0.02)
    write_recording(tmp_path / "b.csv", written)
    read = read_recording(tmp_path / "b.csv", RX90)
    for name in ("t", "q", "torque"):
        assert np.allclose(getattr(read, name), getattr(written, name), rtol=1e-11, atol=1e-11)
    assert (read.gain_sigma, read.notes) == (0.02, ())


def test_without_disturbances_recordings_are_exact(tasks: list[trajectories.Task]) -> None:
    run = trajectories.run_experiment(RX90, tasks[:1], no_disturbances(6)).runs[0]
    assert np.array_equal(run.recording.torque, run.exact.torque)
    assert np.array_equal(run.recording.q, run.exact.motion.q)
    assert run.friction == pytest.approx({name: RX90.parameters[name] for name in run.friction}, rel=1e-9)


def test_recorded_again_is_what_would_have_been_recorded(
    tasks: list[trajectories.Task], experiment: trajectories.Experiment
) -> None:
    wrong = replace(RX90_SLOW_NOISE, gain_error=0.02)
    again, direct = experiment.again(wrong), trajectories.run_experiment(RX90, tasks, wrong, seed=7)
    for a, b in zip(again.runs, direct.runs, strict=True):
        assert np.array_equal(a.recording.torque, b.recording.torque)
    with pytest.raises(ValueError, match="friction acts on the moving robot"):
        experiment.again(replace(RX90_DISTURBANCES, friction=0.5))


WAVES = (8, 36)  # as in the demo: the code is compiled once for all tests


def motion(robot: Robot, seed: int, count: int = 4) -> trajectories.PointToPoint:
    return trajectories.plan_point_to_point(robot, random_points(robot, count, seed), 0.42, 0.5, 0.2)


def friction(robot: Robot) -> Array:
    return np.array([[robot.parameters[name] for name in dry_friction_names(robot)]])


def ripple(robot: Robot, amplitude: float) -> trajectories.Disturbances:
    return replace(no_disturbances(robot.n), ripple=(amplitude,) * robot.n, waves=WAVES)


def without_dry_friction(robot: Robot) -> Robot:
    return replace(robot, parameters=dict(robot.parameters) | dict.fromkeys(dry_friction_names(robot), 0.0))


def test_torques_are_those_of_the_inverse_model(rx90: Robot) -> None:
    """Forward dynamics by base parameters against Newton-Euler by standard ones, friction and ripple added."""
    payload, tasks = PAYLOAD, [trajectories.Task("", motion(rx90, 1), PAYLOAD)]
    experiment = trajectories.run_experiment(rx90, tasks, ripple(rx90, 2.0))
    data = experiment.runs[0].exact
    expected = trajectories.Simulator(without_dry_friction(rx90)).measure(data.motion, payload).torque.copy()
    dry = smooth_dry_friction(rx90, SMOOTHING)
    expected += [np.array(dry(qd, friction(rx90)[0]))[:, 0] for qd in data.motion.qd]
    for k, wave in enumerate(WAVES):
        expected -= 2.0 * np.sin(wave * data.motion.q + experiment.phases[:, k])
    assert np.abs(data.torque - expected).max() < 1e-9 * np.abs(expected).max()


def test_alone_as_in_lockstep(rx90: Robot) -> None:
    """Runs of different length and load do not know of each other."""
    levels = replace(ripple(rx90, 0.0), friction=0.1)
    runs = [
        trajectories.Task("", motion(rx90, 1)),
        trajectories.Task("", motion(rx90, 2, 3), PAYLOAD),
        trajectories.Task("", motion(rx90, 3, 2)),
    ]
    together = trajectories.run_experiment(rx90, runs, levels).runs
    for k, run in enumerate(together):
        other = [trajectories.Task("", motion(rx90, 4))] * k  # before it, for friction is drawn by a run's number
        alone = trajectories.run_experiment(rx90, [*other, runs[k]], levels).runs[k]
        assert np.array_equal(run.exact.torque, alone.exact.torque)
        assert np.array_equal(run.exact.motion.q, alone.exact.motion.q)
        assert np.array_equal(run.tracking_error, alone.tracking_error)


@pytest.mark.parametrize("kind", ["proportional", "gravity"])
@pytest.mark.parametrize("sag", [2e-3, 4e-3, 9e-3])
def test_without_integral_action_the_payload_pulls_the_arm_off_its_path(rx90: Robot, kind: str, sag: float) -> None:
    """The worst joint sags by what was asked for: a controller with an integral keeps within a hundredth of it."""
    reference, payload = motion(rx90, 0), PAYLOAD
    soft = CONTROLLERS[kind].sagging(rx90, payload, [reference], sag)
    runs = [trajectories.Task("", reference), trajectories.Task("", reference, payload)]
    found = trajectories.run_experiment(rx90, runs, ripple(rx90, 0.0), controller=soft).runs
    bare, loaded = (run.exact.motion.q for run in found)
    apart = np.sqrt(np.mean((loaded - bare) ** 2, axis=0))
    assert apart.max() == pytest.approx(sag, rel=0.2)


@pytest.mark.long
def test_a_robot_of_every_kind(
    prismatic: dict[str, Robot], random_parameters: Callable[[Robot, int], dict[str, float]]
) -> None:
    """Sliding joints, oblique gravity, offsets, coupling, spring: the motor torques are the inverse model's."""
    crooked = prismatic["crooked"]
    robot = replace(crooked, parameters=random_parameters(crooked, 0))
    t = np.linspace(0.0, 1.0, 101)
    bump = (1.0 - np.cos(2.0 * np.pi * t)) ** 2
    reference = trajectories.SampledTrajectory(t, 0.1 * np.outer(bump, np.linspace(1.0, -1.0, robot.n)))
    tasks = [trajectories.Task("", reference)]
    (run,) = trajectories.run_experiment(robot, tasks, ripple(robot, 0.0)).runs
    data = run.exact
    expected = trajectories.Simulator(without_dry_friction(robot)).measure(data.motion).torque.copy()
    dry = smooth_dry_friction(robot, SMOOTHING)
    expected += [np.array(dry(qd, friction(robot)[0]))[:, 0] for qd in data.motion.qd]
    assert np.abs(data.torque - expected).max() < 1e-8 * np.abs(expected).max()
    assert run.tracking_error.max() < 5e-3
