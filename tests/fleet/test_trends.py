"""A fleet's nights: what was put in is found, where nothing was put in little is said, and the page shows it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.apps import fleet, report
from dynident.apps.fleet import Stored
from dynident.apps.fleet.alarms import alarm_of, bound_of, steps_of
from dynident.apps.fleet.nights import MASS, arm_of
from dynident.apps.fleet.series import LAST, Scatter, Series, scatter_of
from dynident.apps.fleet.trends import drift_of, fleet_of
from dynident.apps.logs.read import read_recording
from dynident.apps.report.documents import fleet_document
from dynident.apps.report.provenance import Provenance, now
from dynident.common.errors import InputError
from dynident.estimation import identify
from dynident.estimation.fit.least_squares import weighted
from dynident.model import load_robot
from dynident.model.regressors import payload_columns
from dynident.tests.fleet.drawing import drawn, noise_of
from dynident.tests.frozen.inputs import unpack
from scipy.stats import norm

NIGHTS = 14


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Stored:
    place = tmp_path_factory.mktemp("given")
    unpack(place)
    robot = load_robot("rx90")
    result = identify(robot, [read_recording(place / "rx_arm_unloaded.csv", robot)])
    return Stored.of("a.csv", robot, result.base, result.problem, {})


@pytest.fixture(scope="module")
def history(recording: Stored) -> fleet.Fleet:
    """Three arms: friction of joint 2 larger by half since three nights; a payload that was not told; neither."""
    draw, base = np.random.default_rng(3), recording.base
    values, noise = weighted(recording.equations).values, 0.2 * noise_of(recording)
    lump = base.effect_of(payload_columns(recording.robot))[:, 9]
    arms = []
    for arm in ("worn", "laden", "still"):
        nights = []
        for night in range(NIGHTS):
            now_values = np.array(values)
            if arm == "worn" and night >= NIGHTS - 3:
                now_values[base.columns.index("FS2")] *= 1.5
            mass = "2" if arm == "laden" and night == 5 else "0"
            if arm == "laden" and night in (5, NIGHTS - 1):
                now_values = now_values + 2.0 * lump
            about = {
                "arm": arm,
                "day": f"2026-01-{night + 1:02d}",
                "temperature": f"{20 + night % 4}",
                "payload": mass,
            }
            nights.append(drawn(recording, now_values, noise, draw, f"{arm}{night}", about))
        arms.append(arm_of(nights[::-1]))
    return fleet_of(arms)


def test_what_changed_is_named_and_nothing_else(history: fleet.Fleet) -> None:
    assert {(alarm.arm, alarm.quantity) for alarm in history.alarms} == {("worn", "FS2"), ("laden", MASS)}
    worn = next(alarm for alarm in history.alarms if alarm.arm == "worn")
    laden = next(alarm for alarm in history.alarms if alarm.arm == "laden")
    assert (worn.since, worn.new) == (NIGHTS - 3, False)
    assert abs(worn.step - 0.5) < 4.0 * worn.sigma
    assert (laden.since, laden.new) == (NIGHTS - 1, True)
    assert abs(laden.step - 2.0) < 4.0 * laden.sigma


def test_a_payload_that_was_told_is_no_change(history: fleet.Fleet) -> None:
    laden = next(arm for arm in history.arms if arm.name == "laden")
    night = laden.nights[5]
    assert night.told == 2.0
    assert abs(night.numbers[MASS].value) < 5.0 * night.numbers[MASS].sigma


def test_the_page_names_it(history: fleet.Fleet, tmp_path: Path) -> None:
    page = report.fleet_page(history, {"bad.csv": "time runs back"}, Provenance("dynident", now()))
    report.write_report(tmp_path / "fleet.html", page)
    text = (tmp_path / "fleet.html").read_text()
    assert all(words in text for words in ("worn", "laden", "still", "Coulomb friction 2", "time runs back"))
    document = fleet_document(history, {"bad.csv": "time runs back"})
    assert [alarm.new for alarm in document.alarms] == [alarm.new for alarm in history.alarms]
    assert len(document.last) == len(history.series)


def test_drawn_equations_spread_as_their_covariance(recording: Stored) -> None:
    """Mean and standard deviation of the estimates of drawn recordings, against the formula's."""
    draw, values, noise = np.random.default_rng(0), weighted(recording.equations).values, noise_of(recording)
    weights = 1.0 / noise
    recordings = [drawn(recording, values, noise, draw, "x", {}) for _ in range(60)]
    estimates = [weighted(sample.equations, weights) for sample in recordings]
    spread = np.std([estimate.values for estimate in estimates], axis=0, ddof=1) / estimates[0].sigma
    sigma = float(np.sqrt(np.mean(spread**2)))
    rows, effective, c = recording.equations.equations, sum(recording.equations.effective_rows), len(values)
    assert abs(sigma / np.sqrt((effective - c) / (rows - c)) - 1.0) < 0.1
    off = (np.mean([estimate.values for estimate in estimates], axis=0) - values) / estimates[0].sigma
    assert np.abs(off).max() < 5.0 / np.sqrt(60.0)


def series(draw: np.random.Generator, days: int = 40, step: float = 0.0, since: int = 35) -> Series:
    """Scatter of 3 % with a memory of .5, own errors of 1 %, 1 % a kelvin."""
    x, warm = np.empty(days), draw.normal(scale=3.0, size=days)
    x[0] = draw.normal()
    for d in range(1, days):
        x[d] = 0.5 * x[d - 1] + np.sqrt(0.75) * draw.normal()
    values = 0.03 * x + 0.01 * draw.normal(size=days) + 0.01 * warm + step * (np.arange(days) >= since)
    return Series("a", "FS1", True, 1.0, np.arange(float(days)), values, np.full(days, 0.01), warm)


def test_scatter_is_measured_whatever_a_few_arms_do() -> None:
    draw = np.random.default_rng(1)
    scatter = scatter_of([series(draw, step=0.5 * (k < 3)) for k in range(40)])
    assert abs(scatter.sigma - 0.03) < 0.004
    assert abs(scatter.memory - 0.5) < 0.15
    assert abs(scatter.per_kelvin - 0.01) < 5.0 * scatter.per_kelvin_sigma + 1e-4


def test_the_share_of_a_kelvin_is_as_sure_as_the_median_of_the_arms_slopes() -> None:
    """Normal slopes: their median's standard deviation is sqrt(pi / 2) times that of their mean."""
    draw = np.random.default_rng(2)
    days, warm = np.arange(12.0), draw.normal(scale=3.0, size=12)
    slopes = draw.normal(0.01, 0.002, 2000)
    arms = [Series("a", "FS1", True, 1.0, days, slope * warm, np.full(12, 1e-6), warm) for slope in slopes]
    expected = np.sqrt(0.5 * np.pi / len(arms)) * 0.002
    assert scatter_of(arms).per_kelvin_sigma == pytest.approx(expected, rel=0.08)


def test_a_drift_is_told_for_thirty_days() -> None:
    """The slope of a straight line, and as sure, where the scatter is white."""
    days = np.arange(40.0)
    line = Series("a", "FS1", True, 1.0, days, 0.3 + 0.002 * days, np.full(40, 0.03), np.zeros(40))
    drift = drift_of(line, Scatter(0.04, 0.0, 1.0, 0.0, 0.0))
    assert drift is not None
    assert drift.per_month == pytest.approx(30.0 * 0.002)
    assert drift.sigma == pytest.approx(30.0 * 0.05 / np.sqrt(np.sum((days - days.mean()) ** 2)))


def test_a_night_without_temperature_counts_by_its_spread() -> None:
    """The others keep theirs; a hot night whose temperature nobody told is no change of friction."""
    draw = np.random.default_rng(8)
    lines = [series(draw) for _ in range(40)]
    untold = [
        replace(line, temperature=np.where(draw.random(40) < 0.2, np.nan, line.temperature)) for line in lines
    ]
    whole, partly = scatter_of(lines), scatter_of(untold)
    assert abs(partly.per_kelvin - whole.per_kelvin) < 0.1 * whole.per_kelvin
    assert abs(partly.kelvins - 3.0) < 0.3
    hot = replace(lines[0], values=lines[0].values + 0.1 * (np.arange(40) == 39))
    told_nothing = replace(hot, temperature=np.where(np.arange(40) == 39, np.nan, hot.temperature))
    errors = partly.errors_of(told_nothing)
    assert errors[-1] == pytest.approx(np.hypot(0.01, partly.per_kelvin * partly.kelvins / partly.own))
    assert np.array_equal(errors[:-1], hot.sigma[:-1])
    steps = [steps_of(line.days, partly.errors_of(line), partly) for line in (hot, told_nothing)]
    assert all(step is not None for step in steps)
    last = [step.sigma[-1] for step in steps if step is not None]
    assert last[1] > 1.2 * last[0], "a step of that night alone is less sure"
    nothing = scatter_of([replace(line, temperature=np.full(40, np.nan)) for line in lines])
    assert (nothing.per_kelvin, nothing.kelvins) == (0.0, 0.0)
    assert nothing.sigma > whole.sigma, "what nobody told is scatter"


def test_alarms_are_as_rare_as_stated() -> None:
    """With the scatter as measured; one quiet series in ten may newly be an alarm today, and some are."""
    draw, quiet = np.random.default_rng(2), 1000
    many = [series(draw, days=20) for _ in range(quiet)]
    scatter = scatter_of(many)
    bound = bound_of(many[0].days, many[0].sigma, scatter, 0.1)
    alarms = [alarm_of(line, scatter, bound) for line in many]
    assert 0.07 * quiet < sum(alarm is not None and alarm.new for alarm in alarms) < 0.14 * quiet


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.9])
@pytest.mark.parametrize("own", [0.0, 0.01, 0.1])
def test_a_bound_is_exceeded_as_often_as_stated(own: float, memory: float) -> None:
    """Newly, by the largest of the last days' steps; counted over many quiet series, scatter known."""
    days, rate, quiet = np.arange(30.0), 1e-3, 200_000
    nights, scatter = np.full(30, max(own, 1e-6)), Scatter(0.03, memory, 1.0, 0.0, 0.0)
    bound, draw = bound_of(days, nights, scatter, rate), np.random.default_rng(5)
    today, yesterday = steps_of(days, nights, scatter), steps_of(days[:-1], nights[:-1], scatter)
    assert today is not None
    assert yesterday is not None
    sizes = np.vstack([today.weights / today.sigma[:, None],
                       np.pad(yesterday.weights / yesterday.sigma[:, None], ((0, 0), (0, 1)))])  # fmt: skip
    root = np.linalg.cholesky(sizes @ scatter.covariance(days, nights) @ sizes.T + 1e-12 * np.eye(len(sizes)))
    beyond = np.abs(draw.standard_normal((quiet, len(root))) @ root.T) > bound
    new = beyond[:, : len(today.starts)].any(axis=1) & ~beyond[:, len(today.starts) :].any(axis=1)
    assert abs(new.sum() - rate * quiet) < 4.0 * np.sqrt(rate * quiet)
    assert bound < norm.isf(0.5 * rate / LAST)  # which is Bonferroni's


def test_an_arm_without_a_name_or_day_is_refused(recording: Stored) -> None:
    with pytest.raises(InputError, match="arm and day are not known"):
        arm_of([recording])
    alone = fleet_of([arm_of([replace(recording, about={"arm": "a", "day": "2026-01-01"})])])
    assert not alone.alarms
    assert alone.twins is None


def test_few_days_give_no_alarm() -> None:
    draw = np.random.default_rng(4)
    assert alarm_of(series(draw, days=8), scatter_of([series(draw) for _ in range(5)]), 0.0) is None
    late = alarm_of(series(draw, step=1.0, since=40 - LAST), scatter_of([series(draw) for _ in range(20)]), 4.0)
    assert late is not None
    assert late.since == 40 - LAST
