"""What recordings suffer from: every level has its size, every draw its seed, none leaves them exact."""

from dataclasses import replace

import numpy as np
import pytest
from dynident.model import Motion, load_robot
from dynident.trajectories import Disturbances, Experiment, Task, plan_point_to_point, run_experiment
from dynident.trajectories.motions.via_points import random_points
from dynident.trajectories.simulation.disturbances import (
    RX90_DISTURBANCES,
    RX90_SLOW_NOISE,
    draw_friction,
    draw_robot_errors,
    no_disturbances,
    record,
    relative_disturbances,
)

RX90 = load_robot("rx90")
T = np.arange(200_000) / 250.0
STILL = Motion(T, np.outer(np.sin(T), np.ones(6)), np.zeros((len(T), 6)), np.zeros((len(T), 6)))
ZERO = np.zeros((len(T), 6))


def noise(disturbances: Disturbances, seed: int = 0) -> np.ndarray:
    _, gains = draw_robot_errors(disturbances, seed)
    return np.asarray(record(STILL, ZERO, disturbances, gains, [seed, 0]).torque)


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


def test_encoder_and_gains() -> None:
    levels = replace(no_disturbances(6), encoder=1e-3, gain_error=0.02)
    _, gains = draw_robot_errors(levels, 5)
    recording = record(STILL, ZERO + 10.0, levels, gains, [5, 0])
    assert np.abs(recording.q - STILL.q).max() == pytest.approx(0.5e-3, rel=0.01)
    assert np.allclose(recording.q / 1e-3, np.round(recording.q / 1e-3))
    assert np.allclose(recording.torque, 10.0 * gains)
    assert 0.0 < np.abs(gains - 1.0).max() < 0.1
    many = np.array([draw_robot_errors(levels, seed)[1] for seed in range(500)])
    assert many.std() == pytest.approx(0.02, rel=0.05)


@pytest.fixture(scope="module")
def tasks() -> list[Task]:
    reference = plan_point_to_point(RX90, random_points(RX90, 3, 0))
    return [Task("a", reference), Task("b", reference)]


@pytest.fixture(scope="module")
def experiment(tasks: list[Task]) -> Experiment:
    return run_experiment(RX90, tasks, RX90_DISTURBANCES, seed=7)


@pytest.mark.long
def test_the_same_seed_gives_the_same_recordings(tasks: list[Task], experiment: Experiment) -> None:
    same = run_experiment(RX90, tasks, RX90_DISTURBANCES, seed=7)
    reseeded = run_experiment(RX90, tasks, RX90_DISTURBANCES, seed=8)
    for a, b, c in zip(experiment.runs, same.runs, reseeded.runs, strict=True):
        assert np.array_equal(a.recording.torque, b.recording.torque)
        assert np.array_equal(a.recording.q, b.recording.q)
        assert not np.array_equal(a.recording.torque, c.recording.torque)
    first, two = experiment.runs
    assert not np.array_equal(first.recording.torque, two.recording.torque)


def test_without_disturbances_recordings_are_exact(tasks: list[Task]) -> None:
    run = run_experiment(RX90, tasks[:1], no_disturbances(6)).runs[0]
    assert np.array_equal(run.recording.torque, run.exact.torque)
    assert np.array_equal(run.recording.q, run.exact.motion.q)
    assert run.friction == pytest.approx({name: RX90.parameters[name] for name in run.friction}, rel=1e-9)


def test_recorded_again_is_what_would_have_been_recorded(tasks: list[Task], experiment: Experiment) -> None:
    wrong = replace(RX90_SLOW_NOISE, gain_error=0.02)
    again, direct = experiment.again(wrong), run_experiment(RX90, tasks, wrong, seed=7)
    for a, b in zip(again.runs, direct.runs, strict=True):
        assert np.array_equal(a.recording.torque, b.recording.torque)
    with pytest.raises(ValueError, match="friction acts on the moving robot"):
        experiment.again(replace(RX90_DISTURBANCES, friction=0.5))


def test_levels_can_be_scaled_and_are_checked() -> None:
    assert relative_disturbances(np.array([100.0, 10.0]), 0.1).white == (10.0, 1.0)
    with pytest.raises(ValueError, match="one number per joint"):
        Disturbances((1.0,), (0.0, 0.0), (0.0,))
    with pytest.raises(ValueError, match="must not be negative"):
        replace(RX90_DISTURBANCES, friction=-0.1)
    with pytest.raises(ValueError, match="must be positive"):
        replace(RX90_DISTURBANCES, slow_memory=0.0)
