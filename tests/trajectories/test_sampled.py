"""A trajectory file becomes a smooth motion through its samples, or is refused with the reason."""

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.model import Motion, load_robot
from dynident.trajectories import SampledTrajectory, plan_point_to_point
from dynident.trajectories.motions.sampled import joined
from dynident.trajectories.motions.via_points import random_points

RX90 = load_robot("rx90")
T = np.linspace(0.0, 2.0, 201)
SHAPE = np.array([0.5, -0.3])


def bump(t: Array) -> tuple[Array, Array, Array]:
    """(1 - cos)^2 and its derivatives: at rest at 0 and 2 s."""
    c, s, w = np.cos(np.pi * t), np.sin(np.pi * t), np.pi
    q, qd = (1.0 - c) ** 2, 2.0 * w * s * (1.0 - c)
    qdd = 2.0 * w**2 * (c * (1.0 - c) + s**2)
    return np.outer(q, SHAPE), np.outer(qd, SHAPE), np.outer(qdd, SHAPE)


@pytest.mark.parametrize("derivatives", [1, 2, 3])
def test_between_samples_it_is_the_motion(derivatives: int) -> None:
    """With positions alone, with speeds, and with accelerations too."""
    q, qd, qdd = bump(T)
    trajectory = SampledTrajectory(T + 5.0, q, qd if derivatives > 1 else None, qdd if derivatives > 2 else None)
    fine = np.linspace(0.0, 2.0, 3001)
    assert trajectory.duration == pytest.approx(2.0)
    tolerances = {1: (1e-9, 1e-7, 1e-4), 2: (1e-7, 1e-5, 5e-3), 3: (1e-11, 1e-9, 1e-6)}[derivatives]
    for values, true, tolerance in zip(trajectory.at(fine), bump(fine), tolerances, strict=True):
        assert np.abs(values - true).max() < tolerance * np.abs(true).max()


@pytest.mark.parametrize("rate", [50.0, 1000.0])
def test_sparse_samples_are_joined_to_the_motion(rate: float) -> None:
    """Every sample stays, none lies farther from the next than asked; dense ones are left as they are."""
    few = np.unique(np.concatenate([T[::5], [0.731, 1.999]]))
    motion = Motion(few + 3.0, *bump(few))
    dense = joined(motion, rate)
    stays = np.isin(dense.t, motion.t)
    assert stays.sum() == len(few)
    for own, more in zip((motion.q, motion.qd, motion.qdd), (dense.q, dense.qd, dense.qdd), strict=True):
        assert np.allclose(own, more[stays], atol=1e-12)
    assert np.diff(dense.t).max() <= (1.0 + 1e-5) / rate
    for values, true, tolerance in zip(
        (dense.q, dense.qd, dense.qdd), bump(dense.t - 3.0), (1e-6, 1e-5, 1e-3), strict=True
    ):
        assert np.abs(values - true).max() < tolerance * np.abs(true).max()
    assert joined(dense, rate) is dense


def test_it_rests_before_and_after() -> None:
    trajectory = SampledTrajectory(T, *bump(T))
    q, qd, qdd = trajectory.at(np.array([-1.0, 3.0]))
    assert np.allclose(q, bump(np.array([0.0, 2.0]))[0])
    assert not qd.any()
    assert not qdd.any()


def test_a_moving_start_is_refused() -> None:
    with pytest.raises(InputError, match=r"here\.csv: joint 1 moves at the start"):
        SampledTrajectory(T[50:], bump(T)[0][50:], source="here.csv")
    with pytest.raises(InputError, match="joint 1 moves at the end"):
        SampledTrajectory(T[:150], bump(T)[0][:150])
    with pytest.raises(InputError, match="3 samples"):
        SampledTrajectory(T[:3], bump(T)[0][:3])


def test_limits_are_checked() -> None:
    plan = plan_point_to_point(RX90, random_points(RX90, 4, 0), speed=1.0, acceleration=0.9)
    motion = plan.motion(250.0)
    SampledTrajectory(motion.t, motion.q, motion.qd, motion.qdd).check_limits(RX90)
    quick = SampledTrajectory(0.5 * motion.t, motion.q, 2.0 * motion.qd, 4.0 * motion.qdd, "q.csv")
    with pytest.raises(InputError, match=r"q.csv: joint \d goes beyond its (speed|acceleration) limit at"):
        quick.check_limits(RX90)
    with pytest.raises(InputError, match="beyond its position limit"):
        SampledTrajectory(10.0 * motion.t, 3.0 * motion.q).check_limits(RX90)
