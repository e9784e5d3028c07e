"""Rows at an end at which the arm is in full motion are left out; an arm at rest there loses none."""

from collections.abc import Callable

import numpy as np
import pytest
from dynident.estimation import Settings, identify
from dynident.estimation.signals.rows import inner_samples, used_rows
from dynident.model import Motion, Processing, Recording, base_parameters
from dynident.trajectories import Simulator

SETTINGS = Processing(cutoff=10.0)


def moved(begin: float, end: float, seconds: float = 20.0) -> Motion:
    """One joint from a speed to a speed by way of 1 rad/s, another one still but for noise."""
    t = 0.01 * np.arange(round(100 * seconds) + 1)
    qd = np.interp(t, [0.0, 0.5, seconds - 0.5, seconds], [begin, 1.0, 1.0, end])
    still = 1e-3 * np.random.default_rng(0).standard_normal(len(t))
    speeds = np.column_stack([qd, np.clip(still, -1.5e-3, 1.5e-3)])
    q, qdd = np.cumsum(speeds, axis=0) * 0.01, np.gradient(speeds, 0.01, axis=0)
    return Motion(np.asarray(t, dtype=np.float64), q, speeds, np.asarray(qdd, dtype=np.float64))


@pytest.mark.parametrize(
    ("begin", "end", "lost"),
    [(0.05, 0.05, (0, 0)), (0.5, 0.05, (30, 0)), (0.05, -0.5, (0, 30)), (1.0, 1.0, (30, 30))],
)
def test_full_motion_at_an_end(begin: float, end: float, lost: tuple[int, int]) -> None:
    """Three periods of 10 Hz are 30 samples."""
    moving = inner_samples(moved(begin, end), SETTINGS)
    inside = np.flatnonzero(moving)
    assert (inside[0], len(moving) - 1 - inside[-1]) == lost
    assert moving[inside[0] : inside[-1] + 1].all()


def test_a_short_recording_loses_little() -> None:
    moving = inner_samples(moved(1.0, 1.0, 2.0), SETTINGS)
    assert len(moving) - moving.sum() in (20, 21)  # 5 % at either end


def test_without_a_filter_nothing_is_lost() -> None:
    assert inner_samples(moved(1.0, 1.0), Processing()).all()


def test_a_jog_to_the_start_gives_no_rows() -> None:
    """Fast as it is: half a second of motion, a pause of one second, then the recording proper."""
    motion = moved(0.05, 0.05)
    speeds = np.array(motion.qd)
    speeds[:50], speeds[50:150] = 0.5, 0.0
    rows = used_rows(Motion(motion.t, motion.q, speeds, motion.qdd), Processing())
    assert not rows[:150].any()
    assert rows[150:, 0].all()


def test_the_larger_bound_of_share_and_speed_counts() -> None:
    motion = moved(1.0, 1.0)
    fastest = np.abs(motion.qd).max(axis=0)
    for share, speed in (
        (0.1, 0.0),
        (0.0, 0.05),
        (0.1, 0.05),
        (0.001, tuple(0.02 * (j + 1) for j in range(motion.n))),
    ):
        rows = used_rows(motion, Processing(slow_fraction=share, slow_speed=speed))
        least = np.maximum(share * fastest, speed)
        assert (np.abs(motion.qd)[rows] >= np.broadcast_to(least, rows.shape)[rows]).all()
        assert not rows[np.abs(motion.qd) < least].any()
        assert rows[(np.abs(motion.qd) >= least) & used_rows(motion, Processing())].all()


def test_a_log_cut_in_the_middle_of_the_motion(simulated: Callable[[str], Simulator]) -> None:
    """A cut log's parts are recordings of one identification; where they are cut the filter knows no neighbours."""
    simulator = simulated("ur10e")
    draw, t = np.random.default_rng(5), 0.01 * np.arange(6000)
    w, phase = 2 * np.pi * draw.uniform(0.05, 0.5, (5, 6)), draw.uniform(0.0, 6.0, (5, 6))
    angle, a = w * t[:, None, None] + phase, 0.25
    q, qd, qdd = (a * np.sin(angle)).sum(1), (a * w * np.cos(angle)).sum(1), -(a * w**2 * np.sin(angle)).sum(1)
    motion = Motion(*(np.asarray(values, dtype=np.float64) for values in (t, q, qd, qdd)))
    whole = simulator.record(motion, None, [1.0] * 6, 0)
    parts = [
        Recording(whole.t[cut] - whole.t[cut][0], whole.q[cut], whole.torque[cut], None, f"part {k}")
        for k, cut in enumerate((slice(0, 2500), slice(2500, 6000)))
    ]
    robot = simulator.robot
    truth = base_parameters(robot).value(simulator.robot.parameters)
    settings = Processing(cutoff=8.0, decimate=4, slow_fraction=0.02)
    for recordings in ([whole], parts):
        estimate = identify(robot, recordings, Settings(settings, robust=False)).estimate
        assert np.sqrt(np.mean(((estimate.values - truth) / estimate.sigma) ** 2)) < 1.6
