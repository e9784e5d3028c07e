"""Families of motions: exact derivatives, rest at both ends, what the values promise."""

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.model import load_robot
from dynident.trajectories import Fourier, FourierShape, JointBounds, NearShape, Trapezoid, ViaPointShape
from dynident.trajectories.design.floor import FreeStates
from dynident.trajectories.design.goal import Shape
from dynident.trajectories.motions.family import Family, Samples
from dynident.trajectories.motions.via_points import FreeViaPoints

ROBOT = load_robot("rx90")
BOUNDS = JointBounds.of(ROBOT)
POSE = np.array([0.3, -0.4, 0.5, 1.0, 0.2, -1.0])

FIXED = (1.0, 0.7, 1.3)
STEPS = ("trapezoid", "triangle", "fixed trapezoid from a pose")
"""Their accelerations have steps."""


def families() -> dict[str, Family]:
    start = tuple(POSE.tolist())
    shapes: dict[str, Shape] = {
        "passing": ViaPointShape(5),
        "resting": ViaPointShape(4, passing=False),
        "from a pose": ViaPointShape(4, start=start),
        "fixed": ViaPointShape(4, fixed=FIXED),
        "trapezoid": ViaPointShape(4, passing=False, segment=Trapezoid(0.3)),
        "triangle": ViaPointShape(3, passing=False, segment=Trapezoid(0.5)),
        "fixed trapezoid from a pose": ViaPointShape(
            4, passing=False, segment=Trapezoid(), fixed=FIXED, start=start
        ),
        "fourier": FourierShape(3, 6.0),
        "fourier from a pose": FourierShape(4, 8.0, start=start),
        "near": NearShape(POSE[None], (2, 5), np.array([0.5, 0.4]), 4.0),
        "near two poses": NearShape(np.array([POSE, 0.5 * POSE]), (2, 5), np.array([0.5, 0.4]), 9.0),
    }
    by_name = {name: shape.family(ROBOT, BOUNDS) for name, shape in shapes.items()}
    return by_name | {"states": FreeStates(BOUNDS, 7)}


@pytest.fixture(params=families())
def family(request: pytest.FixtureRequest) -> Family:
    return families()[request.param]


def somewhere(family: Family, seed: int = 0) -> Array:
    """Away from rest in the via points."""
    draw = np.random.default_rng(seed)
    x = family.random(draw) + 0.1 * draw.standard_normal(family.size)
    return np.asarray(np.clip(x, family.low, family.high))


def test_pullback_is_the_derivative_of_each_state(family: Family) -> None:
    """Every state by itself: what it does not depend on has no slope."""
    x, draw, step = somewhere(family), np.random.default_rng(2), 1e-5
    samples, direction = family.sample(x), draw.standard_normal(family.size)
    ahead, behind = family.sample(x + step * direction), family.sample(x - step * direction)
    for field in range(1, 4):
        difference = (ahead[field] - behind[field]) / (2.0 * step)
        for row in draw.integers(len(samples.q), size=20):
            for joint in range(samples.q.shape[1]):
                slope = Samples.zeros(samples)
                slope[field][row, joint] = 1.0
                derivative = family.pullback(x, slope) @ direction
                assert derivative == pytest.approx(difference[row, joint], abs=1e-6 * np.abs(difference).max())


def test_weights_are_pulled_back_too(family: Family) -> None:
    x, draw, step = somewhere(family), np.random.default_rng(3), 1e-6
    samples = family.sample(x)
    seed = draw.standard_normal(samples.weight.shape)
    slope = Samples(seed, *(np.zeros_like(samples.q) for _ in range(3)))
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
    for value, slope in ((motion.q, motion.qd), (motion.qd, motion.qdd)):
        difference = np.gradient(value, motion.t, axis=0)
        assert np.abs(difference - slope)[5:-5].max() < 1e-2 * np.abs(slope).max()
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
    assert isinstance(family.segment, Trapezoid)
    x = somewhere(family)
    plan, r = family.plan(x), family.segment.ramp
    step, T = np.diff(plan.points, axis=0), plan.durations[:, None]
    for finer in (1, 10):
        weight, q, qd, qdd = family.sample(x, finer)
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
    plan = Fourier(np.array([0.1]), np.array([[1.0, -1.0]]), np.array([[0.5, -0.25]]), 4.0)
    motion = plan.motion(10.0)
    w, t = 2 * np.pi / 4.0, motion.t
    q = 0.1 + np.sin(w * t) / w - np.sin(2 * w * t) / (2 * w)
    q += -0.5 * np.cos(w * t) / w + 0.25 * np.cos(2 * w * t) / (2 * w)
    assert np.allclose(motion.q[:, 0], q)
    assert len(t) == 41
