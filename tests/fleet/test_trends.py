"""A fleet's nights: what was put in is found, where nothing was put in little is said, and the page shows it."""

from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from dynident.apps.fleet.comparing import CHANGED, FEWEST, MASS, Fleet, Series, arm_of, fleet_of, side_by_side
from dynident.apps.fleet.reduction import Log, Stored
from dynident.apps.logs.read import read_recording
from dynident.apps.report.blocks import page_html
from dynident.apps.report.sections.recordings import fleet_report
from dynident.estimation import Estimate, identify
from dynident.estimation.fit.linear_problem import weighted
from dynident.model import load_robot
from dynident.model.regressors import payload_columns
from dynident.tests.fleet.conftest import drawn, noise_of
from dynident.tests.frozen.inputs import unpack

NIGHTS = 14


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Stored:
    place = tmp_path_factory.mktemp("given")
    unpack(place)
    robot = load_robot("rx90")
    result = identify(robot, [read_recording(place / "rx_arm_unloaded.csv", robot)])
    return Stored(Log("a.csv"), robot, result.base, result.problem)


@pytest.fixture(scope="module")
def history(recording: Stored) -> Fleet:
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
            log = Log(f"{arm}{night}", arm, f"2026-01-{night + 1:02d}", mass)
            nights.append(drawn(recording, now_values, noise, draw, log))
        arms.append(arm_of(nights[::-1]))
    return fleet_of(arms, [Log("bad.csv", reason="time runs back")])


def test_what_changed_is_named_and_nothing_else(history: Fleet) -> None:
    worn, laden = sorted(history.changed, key=lambda line: line.arm, reverse=True)
    assert (worn.arm, worn.quantity) == ("worn", "FS2")
    assert (laden.arm, laden.quantity) == ("laden", MASS)
    assert abs(worn.working.changes[-1] - 0.5) < 4.0 * worn.working.spread
    assert abs(laden.working.changes[-1] - 2.0) < 4.0 * laden.working.spread
    sizes = [abs(line.z or 0.0) for line in history.changed]
    assert sizes == sorted(sizes, reverse=True)


def test_the_page_names_it(history: Fleet, tmp_path: Path) -> None:
    (tmp_path / "fleet.html").write_text(page_html(fleet_report(history), "dynident"), "utf-8")
    text = (tmp_path / "fleet.html").read_text()
    assert all(words in text for words in ("worn", "laden", "still", "Coulomb friction 2", "time runs back"))
    drift = text[text.index("All arms, the largest drift first") :]
    worn, laden = ({line.arm: line for line in history.changed}[arm] for arm in ("worn", "laden"))
    order = ["worn", "laden", "still"] if abs(worn.z or 0.0) > abs(laden.z or 0.0) else ["laden", "worn", "still"]
    assert sorted(order, key=drift.index) == order, "the arm that drifted most comes first"
    assert f"FS2 {worn.z:+.1f}" in drift
    assert f"{laden.z:+.1f}" in drift


def series(values: np.ndarray, own: float) -> Series:
    """Values of as many nights, each with an error of its own."""
    days = tuple(f"2026-01-{k + 1:02d}" for k in range(len(values)))
    return Series.of_nights("a", "OFF1", days, values, np.full(len(values), own))


def test_z_is_the_distance_from_the_median_in_robust_standard_deviations() -> None:
    before = np.array([-4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 99.0])
    scatter = 1.4826 * 2.0
    assert series(np.append(before, 30.0), 0.0).z == pytest.approx(30.0 / scatter)
    assert series(np.append(before, 30.0), 4.0).z == pytest.approx(30.0 / np.hypot(scatter, 4.0))
    assert series(np.append(np.zeros(9), 3.0), 0.5).z == pytest.approx(6.0), "the night's own error is the floor"


@pytest.mark.parametrize(
    ("nights", "rate"), [(FEWEST, 1.0 / 60.0), pytest.param(30, 1.0 / 2000.0, marks=pytest.mark.long)]
)
def test_quiet_series_are_told_as_seldom_as_stated(nights: int, rate: float) -> None:
    draw, quiet = np.random.default_rng(1), 40_000
    told = sum(abs(series(draw.normal(size=nights + 1), 0.0).z or 0.0) > CHANGED for _ in range(quiet))
    assert abs(told - rate * quiet) < 5.0 * np.sqrt(rate * quiet)


def test_a_recording_is_compared_with_the_mean_of_all_others() -> None:
    draw = np.random.default_rng(2)
    values, sigma = draw.normal(size=(5, 4)), draw.uniform(0.1, 2.0, (5, 4))
    estimates = [
        SimpleNamespace(names=tuple("ABCD"), values=own, sigma=spread, degrees_of_freedom=50.0)
        for own, spread in zip(values, sigma, strict=True)
    ]
    both = side_by_side("abcde", cast("list[Estimate]", estimates))
    pooled = np.average(values, axis=0, weights=sigma**-2)
    assert both.scatter == pytest.approx((((values - pooled) / sigma) ** 2).sum(axis=0) / 4)
    for k in range(5):
        others, weights = (np.delete(each, k, axis=0) for each in (values, sigma**-2))
        error = np.sqrt(sigma[k] ** 2 + 1.0 / weights.sum(axis=0))
        apart = (values[k] - np.average(others, axis=0, weights=weights)) / error
        assert both.apart[k] == pytest.approx(apart, rel=1e-9)
