"""Recordings that live in a file and are worked on stretch by stretch give the numbers of those held whole."""

import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.common.paged import ROWS, empty
from dynident.estimation import answer_payload, identify, payload_problem
from dynident.estimation.signals.alignment import aligned
from dynident.estimation.signals.filtering import lowpass, measurement, on_grid, slopes
from dynident.estimation.signals.plausibility import check_recordings
from dynident.model import InertialParameters, Motion, Processing, Recording, base_parameters
from dynident.trajectories import Simulator
from scipy.interpolate import PchipInterpolator
from scipy.signal import butter, sosfiltfilt

SETTINGS = Processing(rate=100.0, cutoff=8.0, decimate=4, slow_fraction=0.01)


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Everything counts as long: files for all arrays, stretches of 501 rows, pieces of 64 equations."""
    monkeypatch.setattr("dynident.common.paged.LARGE", 1000)
    monkeypatch.setattr("dynident.common.paged.ROWS", 501)
    monkeypatch.setattr("dynident.estimation.signals.filtering.ROWS", 501)
    monkeypatch.setattr("dynident.estimation.equations.observer._PIECE", 64)
    monkeypatch.setattr("dynident.estimation.equations.reduction._ROWS", 64)


@pytest.fixture(scope="module")
def pair(
    simulated: Callable[[str], Simulator], wander: Callable[..., Motion], payload: InertialParameters
) -> list[Recording]:
    """Without and with payload, noise, uneven time, on clocks that differ."""
    motion, recordings = wander(6, 4, points=40, rate=125.0), []
    for k, load in enumerate((None, payload)):
        exact = simulated("ur10e").record(motion, load, [1.0] * 6, k)
        jitter = np.random.default_rng(k).uniform(-0.001, 0.001, len(exact.t))
        recordings.append(Recording(exact.t + jitter + 1.3 * k, exact.q, exact.torque, motion.qd, f"log {k}"))
    return recordings


def test_the_filter_is_scipys(short: None) -> None:
    signals = np.cumsum(np.random.default_rng(0).standard_normal((3000, 4)), axis=0)
    sos = butter(4, 0.08, output="sos")
    theirs = sosfiltfilt(sos, signals, axis=0)
    assert np.abs(lowpass(signals, 0.01, 4.0, "log") - theirs).max() < 1e-12 * np.abs(theirs).max()
    assert np.array_equal(slopes(signals, 0.01), np.gradient(signals, 0.01, axis=0))


def test_interpolation_is_that_of_all_samples(short: None, pair: list[Recording]) -> None:
    recording = pair[0]
    for count in (200, 4000):
        t = np.linspace(recording.t[0], recording.t[-1], count)
        resampled = on_grid(recording, t)
        assert np.allclose(resampled.q, PchipInterpolator(recording.t, recording.q, axis=0)(t), rtol=0, atol=1e-14)
        assert np.allclose(
            resampled.torque, PchipInterpolator(recording.t, recording.torque, axis=0)(t), rtol=1e-12
        )


def test_identification(
    simulated: Callable[[str], Simulator], pair: list[Recording], request: pytest.FixtureRequest
) -> None:
    """Values, formula's and robust deviations, essential parameters, validation."""
    robot = simulated("ur10e").robot
    whole = identify(robot, pair[:1], SETTINGS, pair[:1], robust=True)
    request.getfixturevalue("short")
    parts = identify(robot, pair[:1], SETTINGS, pair[:1], robust=True)
    a, b = whole.estimate, parts.estimate
    assert np.abs((a.values - b.values) / a.sigma).max() < 1e-8
    assert b.sigma == pytest.approx(a.sigma, rel=1e-9)
    assert a.robust is not None
    assert b.robust is not None
    assert b.robust.sigma == pytest.approx(a.robust.sigma, rel=1e-7)
    assert parts.essential == whole.essential
    assert parts.problem.rows == whole.problem.rows
    assert whole.validation is not None
    assert parts.validation is not None
    assert parts.validation.relative == pytest.approx(whole.validation.relative, rel=1e-9)


@pytest.mark.long
def test_payload(
    simulated: Callable[[str], Simulator], pair: list[Recording], request: pytest.FixtureRequest
) -> None:
    """All four methods, intervals, verdict."""
    robot = simulated("ur10e").robot

    def answer() -> tuple[list[np.ndarray], str, float]:
        problem = payload_problem(robot, pair[1:], pair[:1], None, SETTINGS, robust=True)
        result = answer_payload(problem)
        numbers = [estimate.estimate.values for estimate in result.estimates]
        spreads = [
            estimate.estimate.robust.sigma for estimate in result.estimates if estimate.estimate.robust is not None
        ]
        return [*numbers, *spreads], result.verdict.level, problem.pairs[0].lag

    whole, level, lag = answer()
    assert len(whole) == 8
    request.getfixturevalue("short")
    parts, same_level, same_lag = answer()
    assert same_level == level
    assert same_lag == pytest.approx(lag, abs=1e-12)
    assert lag == pytest.approx(1.3, abs=1e-4)
    for a, b in zip(whole, parts, strict=True):
        assert b == pytest.approx(a, rel=1e-6, abs=1e-9)


def test_the_lag_of_long_recordings(pair: list[Recording], monkeypatch: pytest.MonkeyPatch) -> None:
    """Only some samples of long recordings are compared."""
    whole = aligned(pair[0], pair[1], 100.0, 0.02)
    monkeypatch.setattr("dynident.estimation.signals.alignment._MOST", 500)
    thin = aligned(pair[0], pair[1], 100.0, 0.02)
    assert thin.lag != whole.lag
    assert thin.lag == pytest.approx(1.3, abs=2e-4)
    assert thin.rms_mismatch < 1.02 * whole.rms_mismatch


def with_column(recording: Recording, column: str, values: Array) -> Recording:
    q, torque = (
        values if column == kind else own for kind, own in (("q", recording.q), ("torque", recording.torque))
    )
    return Recording(recording.t, q, torque, values if column == "qd" else recording.qd, recording.source)


@pytest.mark.parametrize(
    ("column", "row", "value", "words"),
    [
        ("q", 1777, 50.0, "q3 reaches 50 rad"),
        ("torque", 2950, 1e6, "torque of joint 3 reaches 1e"),
        ("q", slice(1500, None), 1.1, "q3 jumps by"),
        ("torque", slice(None), 0.0, "channel is dead"),
        ("torque", slice(480, 530), 300.0, "stays at its extreme 300"),
        ("qd", slice(None), None, "times the slope of q3"),
    ],
)
def test_mistakes_are_found_in_every_stretch(
    short: None,
    simulated: Callable[[str], Simulator],
    pair: list[Recording],
    column: str,
    row: int | slice,
    value: float | None,
    words: str,
) -> None:
    recording = pair[0]
    changed = np.array(getattr(recording, column))
    changed[row, 2] = changed[row, 2] + value if words.startswith("q3 jumps") else value or 3.0 * changed[row, 2]
    if words == "channel is dead":
        changed[row, 2] = 0.0
    with pytest.raises(InputError, match=words):
        check_recordings(simulated("ur10e").robot, [with_column(recording, column, changed)])


def test_memory_does_not_hold_the_arrays() -> None:
    """Filtering a recording in a file takes a few stretches of rows, however long it is."""
    rows = 10 * ROWS
    t, q, torque = empty((rows,)), empty((rows, 6)), empty((rows, 6))
    t[:] = 0.001 * np.arange(rows)
    q[:], torque[:] = np.sin(t)[:, None], np.cos(t)[:, None]
    for array in (t, q, torque):
        array.setflags(write=False)
    tracemalloc.start()
    data = measurement(Recording(t, q, torque), Processing(cutoff=10.0))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert data.motion.qdd.shape == (rows, 6)
    assert peak < 0.75 * q.nbytes  # q, qd and qdd alone are three times q


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
        estimate = identify(robot, recordings, settings, robust=False).estimate
        assert np.sqrt(np.mean(((estimate.values - truth) / estimate.sigma) ** 2)) < 1.6
