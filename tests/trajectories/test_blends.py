"""Moves at constant speed with parabolic blends: the law of LSPB, and what it becomes in the limit."""

import numpy as np
import pytest
from dynident.common.errors import InputError
from dynident.model import load_robot
from dynident.trajectories import BlendedPoints, BlendShape, JointBounds, PointToPoint, Trapezoid, ViaPoints
from dynident.trajectories.motions.blend_times import BlendTimes, FixedTimes, FreeTimes
from dynident.trajectories.motions.blends import FreeBlends
from hypothesis import given, settings
from hypothesis import strategies as st

ROBOT = load_robot("rx90")
BOUNDS = JointBounds.of(ROBOT)
FIXED = (1.0, 0.7, 1.3)
POINTS = np.array([[0.0, 1.0], [1.0, 0.5], [0.8, -0.5], [-1.0, 0.0]])
PLAN = BlendedPoints(POINTS, np.array([1.0, 0.8, 1.2]), np.array([0.4, 0.3, 0.6, 0.5]))


def families() -> dict[str, FreeBlends]:
    start = np.array([0.3, -0.4, 0.5, 1.0, 0.2, -1.0])
    return {
        "free": BlendShape(6).family(ROBOT, BOUNDS),
        "one move": BlendShape(2).family(ROBOT, BOUNDS),
        "fixed": BlendShape(4, fixed=FIXED).family(ROBOT, BOUNDS),
        "from a pose": BlendShape(4).family(ROBOT, BOUNDS, start=start),
        "fixed, from a pose": BlendShape(4, fixed=FIXED).family(ROBOT, BOUNDS, start=start),
    }


def test_textbook_times_and_speeds() -> None:
    """Craig's formulas for the first, an inner and the last move, and the corners that are cut."""
    (t1, t2, t3), (b0, b1, b2, b3) = PLAN.durations, PLAN.blends
    step = np.diff(POINTS, axis=0)
    assert np.allclose(PLAN.speeds, [step[0] / (t1 - 0.5 * b0), step[1] / t2, step[2] / (t3 - 0.5 * b3)])
    assert np.allclose(PLAN.straight, [t1 - b0 - 0.5 * b1, t2 - 0.5 * (b1 + b2), t3 - b3 - 0.5 * b2])
    for k, t in ((1, t1), (2, t1 + t2)):
        missed = PLAN.at(np.array([t]))[0][0] - POINTS[k]
        assert np.allclose(missed, PLAN.blends[k] * (PLAN.speeds[k] - PLAN.speeds[k - 1]) / 8.0)
    q, qd, _ = PLAN.at(np.array([0.0, PLAN.duration]))
    assert np.allclose(q, POINTS[[0, -1]])
    assert np.abs(qd).max() < 1e-12


@pytest.mark.parametrize("name", families())
def test_position_and_speed_are_continuous(name: str) -> None:
    """Position is the integral of speed, and speed that of an acceleration with two levels a move."""
    family = families()[name]
    plan = family.plan(family.random(np.random.default_rng(3)))
    t = np.linspace(0.0, plan.duration, 100_001)
    q, qd, qdd = plan.at(t)
    strongest = np.abs(qdd).max()
    assert np.abs(np.diff(q, axis=0) - 0.5 * (qd[1:] + qd[:-1]) * t[1]).max() < strongest * t[1] ** 2
    assert (np.abs(np.diff(qd, axis=0)) <= strongest * t[1] * (1.0 + 1e-6)).all()
    assert np.abs(q[0] + np.cumsum(qd, axis=0)[-1] * t[1] - q[-1]).max() < 1e-3
    steps = np.flatnonzero(np.abs(np.diff(qdd[:-1], axis=0)).max(axis=1) > 1e-9)
    assert len(steps) == 2 * (len(plan.points) - 1)
    assert np.abs(qd[[0, -1]]).max() < 1e-9
    assert not np.any(plan.at(np.array([-0.1, plan.duration + 0.1]))[1:]), "at rest before and after"


@pytest.mark.parametrize("name", families())
@pytest.mark.parametrize("finer", [1, 7])
def test_the_plan_is_what_was_sampled(name: str, finer: int) -> None:
    """Samples in order of time, both sides of every step; the trapezoidal rule is exact for the speeds."""
    family = families()[name]
    x = family.random(np.random.default_rng(0))
    plan, samples = family.plan(x), family.sample(x, finer)
    parts = len(samples.weight) // (2 * len(plan.points) - 1)
    weight = samples.weight.reshape(-1, parts)
    begin = np.concatenate([[0.0], np.cumsum(weight.sum(axis=1))])
    assert begin[-1] == pytest.approx(plan.duration)
    t = (begin[:-1, None] + np.diff(begin)[:, None] * np.linspace(0.0, 1.0, parts)).ravel()
    q, qd, qdd = plan.at(t)
    inside = np.ones(len(t), dtype=bool)
    inside[parts - 1 :: parts] = inside[::parts] = False
    assert np.allclose(samples.q, q, atol=1e-12)
    assert np.allclose(samples.qd, qd, atol=1e-9)
    assert np.allclose(samples.qdd[inside], qdd[inside], atol=1e-8)
    moved = np.einsum("ki,kij->j", weight, samples.qd.reshape(-1, parts, ROBOT.n))
    assert np.allclose(moved, plan.points[-1] - plan.points[0])


def test_one_move_is_the_trapezoid_at_rest() -> None:
    points, T, ramp = np.array([[0.1, -0.4], [1.3, 0.2]]), np.array([1.5]), 0.2
    rest = ViaPoints(points, T, segment=Trapezoid(ramp))
    blended = BlendedPoints(points, T, np.full(2, ramp * T[0]))
    t = np.linspace(0.0, 1.5, 400)[1:-1]
    for value, expected in zip(blended.at(t), rest.at(t), strict=True):
        assert np.allclose(value, expected, atol=1e-12)
    assert blended.rests


def test_points_given_twice_are_trapezoids_at_rest() -> None:
    """Where two points are the same the arm comes to rest; the time between them is theirs, one half of it each."""
    points, T, ramp = POINTS, np.array([1.0, 0.8, 1.2]), 0.25
    rest = ViaPoints(points, T, segment=Trapezoid(ramp))
    ramps = ramp * T
    doubled = np.repeat(points, [1, 2, 2, 1], axis=0)
    blends = np.repeat(ramps, 2)
    wait = 0.5 * (blends[1:-1:2] + blends[2:-1:2])
    moves = T - 0.5 * (blends[::2] + blends[1::2])
    moves[[0, -1]] += 0.5 * blends[[0, -1]]
    durations = np.insert(moves, [1, 2], wait)
    blended = BlendedPoints(doubled, durations, blends)
    assert blended.duration == pytest.approx(rest.duration)
    t = np.linspace(0.0, rest.duration, 3001)[1:-1]
    t = t[np.abs(t[:, None] - np.cumsum(T)).min(axis=1) > 1e-9]
    for value, expected in zip(blended.at(t)[:2], rest.at(t)[:2], strict=True):
        assert np.allclose(value, expected, atol=1e-9)


def test_it_is_the_controllers_motion_without_smoothing() -> None:
    """``PointToPoint`` adds ramps whose acceleration rises and falls; less and less of that comes to the same."""
    between = PLAN.durations.copy()
    between[[0, -1]] -= 0.5 * PLAN.blends[[0, -1]]
    t, errors = np.linspace(0.0, PLAN.duration, 777), []
    for smoothing in (0.1, 0.01, 0.001):
        smooth = PointToPoint(POINTS, between, PLAN.blends, 1.0, smoothing)
        assert smooth.duration == pytest.approx(PLAN.duration)
        errors.append(max(np.abs(a - b).max() for a, b in zip(smooth.at(t)[:2], PLAN.at(t)[:2], strict=True)))
    assert errors[0] > 5.0 * errors[1] > 25.0 * errors[2]
    assert errors[2] < 2e-3


@pytest.mark.parametrize("times", [FreeTimes(5, (0.1, 3.0)), FreeTimes(2, (0.1, 3.0)), FixedTimes(np.array(FIXED))])
@given(data=st.data())
@settings(max_examples=30, deadline=None)
def test_blends_fit_whatever_the_numbers(times: BlendTimes, data: st.DataObject) -> None:
    """Anywhere within the bounds; and moves keep their shortest and longest durations, or the fixed ones."""
    shares = data.draw(st.lists(st.floats(0.0, 1.0), min_size=len(times.low), max_size=len(times.low)))
    timing = times.of(times.low + np.array(shares) * (times.high - times.low))
    points = np.arange(float(len(timing.blends)))[:, None]
    plan = BlendedPoints(points, timing.durations, timing.blends)
    assert (plan.straight > 0.0).all()
    assert np.allclose(plan.straight, timing.straight)
    if isinstance(times, FixedTimes):
        assert np.allclose(timing.durations, FIXED)
    else:
        assert (timing.durations >= 0.1 * (1.0 - 1e-9)).all()
        assert (timing.durations <= 3.0 * (1.0 + 1e-9)).all()


@pytest.mark.parametrize("name", families())
def test_a_random_start_keeps_the_limits(name: str) -> None:
    family = families()[name]
    for seed in range(5):
        samples = family.sample(family.random(np.random.default_rng(seed)), 3)
        assert np.abs(samples.qd / BOUNDS.speed).max() < 0.9
        assert np.abs(samples.qdd / BOUNDS.acceleration).max() < 0.9
        assert (BOUNDS.low < samples.q).all()
        assert (samples.q < BOUNDS.high).all()


def test_slower_is_the_same_way() -> None:
    family = families()["free"]
    x = family.random(np.random.default_rng(1))
    slow, fast = family.sample(family.eased(x, 1.25, 1.0)), family.sample(x)
    assert np.allclose(slow.q, fast.q)
    assert np.allclose(slow.qdd, fast.qdd / 1.25**2)


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(
        InputError, match=r"move 2 takes 0\.4 s, 0\.1 s less than its blends of 0\.4 and 0\.6 s need"
    ):
        BlendedPoints(POINTS, np.array([1.0, 0.4, 1.0]), np.array([0.2, 0.4, 0.6, 0.2]))
    with pytest.raises(ValueError, match="positive blends"):
        BlendedPoints(POINTS, np.ones(3), np.array([0.2, 0.0, 0.2, 0.2]))
    with pytest.raises(InputError, match="1 via points"):
        BlendShape(1).family(ROBOT, BOUNDS)
    with pytest.raises(InputError, match="need 3 positive ones"):
        BlendShape(4, fixed=(1.0, 2.0)).family(ROBOT, BOUNDS)
