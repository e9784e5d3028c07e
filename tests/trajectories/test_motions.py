"""Motions and their families: derivatives exact, within the limits, at rest at the ends."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from dynident import trajectories
from dynident.common.arrays import Array
from dynident.model import Motion, load_robot
from dynident.tests.report.motions.motion_parsers import trapezoid_time
from dynident.trajectories.design.goal import Shape
from dynident.trajectories.motions.family import FreeStates, Samples
from dynident.trajectories.motions.planned import joined
from dynident.trajectories.motions.via_points import FreeViaPoints, random_points
from hypothesis import given, settings
from hypothesis import strategies as st

RX90 = load_robot("rx90")
LIMITS = [joint.limits for joint in RX90.joints]
TOP, STRONG = np.array([(limits.speed, limits.acceleration) for limits in LIMITS]).T


def peaks(motion: Motion) -> tuple[float, float]:
    """Largest share of a joint's speed and of its acceleration."""
    return float((np.abs(motion.qd) / TOP).max()), float((np.abs(motion.qdd) / STRONG).max())


def assert_derivatives(t: Array, *states: Array, share: float) -> None:
    for value, slope in pairwise(states):
        difference = np.gradient(value, t, axis=0)
        assert np.abs(difference - slope)[5:-5].max() < share * np.abs(slope).max()


@given(st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_random_via_points_keep_the_limits(seed: int) -> None:
    motion = trajectories.random_via_points(RX90, 8, seed, speed=0.5).motion(500.0)
    low, high = np.array([limits.position for limits in LIMITS]).T
    assert (low <= motion.q).all()
    assert (motion.q <= high).all()
    speed, acceleration = peaks(motion)
    assert speed <= 0.5 * (1 + 1e-9)
    assert acceleration <= 1 + 1e-9


@given(
    seed=st.integers(0, 10_000),
    speed=st.floats(0.1, 1.0),
    acceleration=st.floats(0.1, 1.0),
    blend=st.floats(0.0, 1.0),
    smoothing=st.floats(0.05, 0.5),
)
def test_moves_from_point_to_point_keep_the_limits(
    seed: int, speed: float, acceleration: float, blend: float, smoothing: float
) -> None:
    """A blend cuts corners, it never goes beyond the points."""
    points = random_points(RX90, 8, seed)
    motion = trajectories.plan_point_to_point(RX90, points, speed, acceleration, blend, smoothing).motion(500.0)
    assert (points.min(axis=0) - 1e-9 <= motion.q).all()
    assert (motion.q <= points.max(axis=0) + 1e-9).all()
    fastest, strongest = peaks(motion)
    assert fastest <= speed * (1 + 1e-9)
    assert strongest <= acceleration * (1 + 1e-9)


@pytest.mark.parametrize("blend", [0.0, 0.3, 1.0])
def test_starts_and_ends_at_rest_and_derivatives_are_derivatives(blend: float) -> None:
    points = random_points(RX90, 6, 3)
    plan = trajectories.plan_point_to_point(RX90, points, blend=blend)
    t = np.linspace(0.0, plan.duration, 200_001)
    q, qd, qdd = plan.at(t)
    assert np.allclose(q[[0, -1]], points[[0, -1]], atol=1e-11)
    assert np.allclose(qd[[0, -1]], 0.0, atol=1e-11)
    assert np.allclose(qdd[[0, -1]], 0.0, atol=1e-9)
    assert_derivatives(t, q, qd, qdd, share=2e-3)
    beyond = plan.at(np.array([-1.0, plan.duration + 1.0]))
    assert np.allclose(beyond[0], points[[0, -1]], atol=1e-11)


def test_stops_run_each_move_by_its_own_law() -> None:
    """Speeds and accelerations reached in every move are its own; without smoothing it is a trapezoid's time."""
    points, draw = random_points(RX90, 6, 2), np.random.default_rng(0)
    speed, acceleration = draw.uniform(0.1, 1.0, (2, 5, 1))
    plan = trajectories.plan_point_to_point(RX90, points, speed, acceleration, blend=None)
    ends = np.concatenate([[0.0], np.cumsum(plan.durations + plan.ramps[:, 0])])
    assert plan.duration == pytest.approx(ends[-1])
    for k in range(5):
        t = np.linspace(ends[k], ends[k + 1], 20_001)
        q, qd, qdd = plan.at(t)
        assert np.allclose(q[[0, -1]], points[k : k + 2], atol=1e-9)
        assert np.allclose(qd[[0, -1]], 0.0, atol=1e-6)
        shares = np.array(peaks(Motion(t, q, qd, qdd))) / (speed[k, 0], acceleration[k, 0])
        assert shares.max() <= 1.0 + 1e-9
        assert shares[1] == pytest.approx(1.0, abs=1e-3)
    sharp = trajectories.plan_point_to_point(RX90, points, speed, acceleration, None, smoothing=1e-6)
    step = np.abs(np.diff(points, axis=0))
    times = [trapezoid_time(step[k], speed[k] * TOP, acceleration[k] * STRONG) for k in range(5)]
    assert sharp.duration >= sum(times) * (1.0 - 1e-9)
    assert sharp.duration == pytest.approx(sum(times), rel=0.05), "one law for all joints is hardly slower"
    first, *others = RX90.joints
    free = replace(RX90, joints=(replace(first, limits=replace(first.limits, acceleration=np.inf)), *others))
    with pytest.raises(ValueError, match="no speed or acceleration limit bounds a move"):
        trajectories.plan_point_to_point(free, np.outer([0.0, 1.0], np.eye(6)[0]), blend=None)


T = np.linspace(0.0, 2.0, 201)


def bump(t: Array) -> tuple[Array, Array, Array]:
    """(1 - cos)^2 and its derivatives: at rest at 0 and 2 s."""
    c, s, w, shape = np.cos(np.pi * t), np.sin(np.pi * t), np.pi, np.array([0.5, -0.3])
    q, qd = (1.0 - c) ** 2, 2.0 * w * s * (1.0 - c)
    qdd = 2.0 * w**2 * (c * (1.0 - c) + s**2)
    return np.outer(q, shape), np.outer(qd, shape), np.outer(qdd, shape)


@pytest.mark.parametrize(
    ("derivatives", "tolerances"), [(1, (1e-9, 1e-7, 1e-4)), (2, (1e-7, 1e-5, 5e-3)), (3, (1e-11, 1e-9, 1e-6))]
)
def test_between_samples_it_is_the_motion(derivatives: int, tolerances: tuple[float, ...]) -> None:
    """With positions alone, with speeds, and with accelerations too; it rests before and after."""
    q, qd, qdd = bump(T)
    trajectory = trajectories.SampledTrajectory(
        T + 5.0, q, qd if derivatives > 1 else None, qdd if derivatives > 2 else None
    )
    assert trajectory.duration == pytest.approx(2.0)
    fine = np.linspace(0.0, 2.0, 3001)
    for values, true, tolerance in zip(trajectory.at(fine), bump(fine), tolerances, strict=True):
        assert np.abs(values - true).max() < tolerance * np.abs(true).max()
    q, qd, qdd = trajectory.at(np.array([-1.0, 3.0]))
    assert np.allclose(q, bump(np.array([0.0, 2.0]))[0])
    assert not qd.any()
    assert not qdd.any()


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


def test_samples_within_the_limits_are_taken() -> None:
    motion = trajectories.plan_point_to_point(RX90, random_points(RX90, 4, 0), speed=1.0, acceleration=0.9).motion(
        250.0
    )
    trajectories.SampledTrajectory(motion.t, motion.q, motion.qd, motion.qdd).check_limits(RX90)


ROBOT = load_robot("rx90")
BOUNDS = trajectories.JointBounds.of(ROBOT)
POSE = np.array([0.3, -0.4, 0.5, 1.0, 0.2, -1.0])

FIXED = (1.0, 0.7, 1.3)
STEPS = ("trapezoid", "triangle", "fixed trapezoid from a pose")
"""Their accelerations have steps."""


def families() -> dict[str, Any]:
    start = tuple(POSE.tolist())
    shapes: dict[str, Shape] = {
        "passing": trajectories.ViaPointShape(5),
        "resting": trajectories.ViaPointShape(4, passing=False),
        "from a pose": trajectories.ViaPointShape(4, start=start),
        "fixed": trajectories.ViaPointShape(4, fixed=FIXED),
        "trapezoid": trajectories.ViaPointShape(4, passing=False, segment=trajectories.Trapezoid(0.3)),
        "triangle": trajectories.ViaPointShape(3, passing=False, segment=trajectories.Trapezoid(0.5)),
        "fixed trapezoid from a pose": trajectories.ViaPointShape(
            4, passing=False, segment=trajectories.Trapezoid(), fixed=FIXED, start=start
        ),
        "fourier": trajectories.FourierShape(3, 6.0),
        "fourier from a pose": trajectories.FourierShape(4, 8.0, start=start),
        "near": trajectories.NearShape(POSE[None], (2, 5), np.array([0.5, 0.4]), 4.0),
        "near two poses": trajectories.NearShape(np.array([POSE, 0.5 * POSE]), (2, 5), np.array([0.5, 0.4]), 9.0),
    }
    by_name = {name: shape.family(ROBOT, BOUNDS) for name, shape in shapes.items()}
    return by_name | {"states": FreeStates(BOUNDS, 7)}


@pytest.fixture(params=families())
def family(request: pytest.FixtureRequest) -> Any:
    return families()[request.param]


def somewhere(family: Any, seed: int = 0) -> Array:
    """Away from rest in the via points."""
    draw = np.random.default_rng(seed)
    x = family.random(draw) + 0.1 * draw.standard_normal(family.size)
    return np.asarray(np.clip(x, family.low, family.high))


def test_pullback_is_the_derivative_of_each_state(family: Any) -> None:
    """Every state by itself: what it does not depend on has no slope."""
    x, draw, step = somewhere(family), np.random.default_rng(2), 1e-5
    samples, direction = family.sample(x), draw.standard_normal(family.size)
    ahead, behind = family.sample(x + step * direction), family.sample(x - step * direction)
    for field in range(1, 4):
        difference = (ahead[field] - behind[field]) / (2.0 * step)
        for row in draw.integers(len(samples.q), size=20):
            for joint in range(samples.q.shape[1]):
                slope = Samples(*map(np.zeros_like, samples))
                slope[field][row, joint] = 1.0
                derivative = family.pullback(x, slope) @ direction
                assert derivative == pytest.approx(difference[row, joint], abs=1e-6 * np.abs(difference).max())


def test_weights_are_pulled_back_too(family: Any) -> None:
    x, draw, step = somewhere(family), np.random.default_rng(3), 1e-6
    samples = family.sample(x)
    seed = draw.standard_normal(samples.weight.shape)
    slope = Samples(*map(np.zeros_like, samples))._replace(weight=seed)
    direction = draw.standard_normal(family.size)
    change = family.sample(x + step * direction).weight - family.sample(x - step * direction).weight
    assert family.pullback(x, slope) @ direction == pytest.approx(seed @ change / (2.0 * step), rel=1e-6, abs=1e-8)


@pytest.mark.parametrize("name", [name for name in families() if name not in ("states", "near two poses", *STEPS)])
def test_the_plan_is_what_was_sampled_and_rests_at_its_ends(name: str) -> None:
    family = families()[name]
    x = somewhere(family)
    plan = family.plan(x)
    motion = plan.motion(2000.0)
    assert plan.duration == pytest.approx(family.sample(x).weight.sum())
    assert np.abs(motion.qd[0]).max() < 1e-12 * np.abs(motion.qd).max()
    assert np.abs(motion.qdd[0]).max() < 1e-12 * np.abs(motion.qdd).max()
    assert np.abs(motion.qd[-1]).max() < 0.01 * np.abs(motion.qd).max()
    assert_derivatives(motion.t, motion.q, motion.qd, motion.qdd, share=1e-2)
    if "pose" in name:
        assert np.allclose(motion.q[0], POSE, atol=1e-12)
    fine = family.sample(x, 10)
    assert np.allclose(fine.q.max(axis=0), motion.q.max(axis=0), atol=2e-3)
    assert np.allclose(fine.qdd.max(axis=0), motion.qdd.max(axis=0), rtol=2e-2, atol=0.05)


@pytest.mark.parametrize("name", STEPS)
def test_trapezoids_are_ramps_and_constant_speed(name: str) -> None:
    """Integrated over the samples' own times; peaks are sampled exactly, on the solver's grid already."""
    family = families()[name]
    assert isinstance(family, FreeViaPoints)
    assert isinstance(family.shape.segment, trajectories.Trapezoid)
    x = somewhere(family)
    plan, r = family.plan(x), family.shape.segment.ramp
    step, T = np.diff(plan.points, axis=0), plan.durations[:, None]
    for finer in (1, 10):
        weight, q, qd, qdd, *_ = family.sample(x, finer)
        shape = (len(T), -1, ROBOT.n)
        speed, acceleration = qd.reshape(shape), qdd.reshape(shape)
        assert weight.sum() == pytest.approx(plan.duration)
        assert np.allclose(np.abs(speed).max(axis=1), np.abs(step) / T / (1.0 - r))
        assert np.allclose(np.abs(acceleration).max(axis=1), np.abs(step) / T**2 / (r * (1.0 - r)))
        # Speeds are piecewise linear, so the trapezoidal rule is exact.
        assert np.allclose(np.einsum("ki,kij->kj", weight.reshape(len(T), -1), speed), step)
        assert np.abs(speed[:, [0, -1]]).max() < 1e-12
        levels = np.unique(np.round(acceleration[0, :, 0] / np.abs(acceleration[0, :, 0]).max(), 9))
        assert levels.tolist() == ([-1.0, 1.0] if name == "triangle" else [-1.0, 0.0, 1.0])
    t = np.linspace(0.0, plan.duration, 200_001)
    q, qd, qdd = plan.at(t)
    assert np.abs(np.gradient(q, t, axis=0) - qd).max() < 1e-3 * np.abs(qd).max()
    assert np.abs(np.cumsum(qdd, axis=0) * t[1] - qd).max() < 1e-3 * np.abs(qd).max()
    assert not np.any(plan.at(np.array([-0.1, plan.duration + 0.1]))[1:]), "at rest before and after"


@pytest.mark.parametrize("name", [name for name in families() if "fixed" in name])
def test_fixed_durations_stay(name: str) -> None:
    family = families()[name]
    assert isinstance(family, FreeViaPoints)
    draw = np.random.default_rng(4)
    x = family.random(draw)
    samples = family.sample(x)
    assert not family.free_duration
    assert np.abs(samples.qd / BOUNDS.speed).max() < 0.8, "a random start keeps the limits"
    assert np.abs(samples.qdd / BOUNDS.acceleration).max() < 0.8
    smaller = family.eased(x, 1.25, 1.0)
    for y in (x, smaller):
        assert np.array_equal(family.plan(y).durations, FIXED)
        assert family.sample(y).weight.sum() == pytest.approx(sum(FIXED))
    assert np.allclose(family.sample(smaller).qd, samples.qd / 1.25)
    assert np.allclose(family.sample(smaller).qdd, samples.qdd / 1.25)
    if "pose" in name:
        assert np.allclose(family.sample(smaller).q[0], POSE)


def test_a_fourier_series_is_the_sum_that_is_written() -> None:
    plan = trajectories.Fourier(np.array([[0.1]]), np.array([[[1.0, -1.0]]]), np.array([[[0.5, -0.25]]]), 4.0)
    motion = plan.motion(10.0)
    w, t = 2 * np.pi / 4.0, motion.t
    q = plan.offset[0, 0] + np.sin(w * t) / w - np.sin(2 * w * t) / (2 * w)
    q += -0.5 * np.cos(w * t) / w + 0.25 * np.cos(2 * w * t) / (2 * w)
    assert np.allclose(motion.q[:, 0], q)
    assert len(t) == 41
