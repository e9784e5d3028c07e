"""Documents and tables: numbers survive, files are whole."""

import json
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.report.blocks import with_sigma
from dynident.apps.report.sections.estimates import sigma_notes
from dynident.common.schema import write_json
from dynident.estimation import PAYLOAD, Estimate
from dynident.estimation.fit.covariance import RobustCovariance
from dynident.estimation.fit.estimate import Fit
from dynident.estimation.payload.result import PayloadEstimate
from dynident.estimation.results.payload import FreeEstimate
from dynident.tests.report.written import written


def test_json_is_plain_and_whole(tmp_path: Path) -> None:
    path = tmp_path / "out.json"
    document = {"a": np.arange(3.0), "b": np.float64(1.5), "c": (1, None, float("nan")), "d": {"e": np.inf}}
    write_json(path, document)
    assert json.loads(path.read_text()) == {"a": [0.0, 1.0, 2.0], "b": 1.5, "c": [1, None, None], "d": {"e": None}}
    assert list(tmp_path.iterdir()) == [path]


def test_a_failed_write_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "out.json"
    write_json(path, {"good": 1})
    with pytest.raises(TypeError):
        write_json(path, {"bad": object()})
    assert json.loads(path.read_text()) == {"good": 1}
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("value", "sigma", "text"),
    [(1.23456, 0.0123, "1.235±0.012"), (-0.00012345, 1e-5, "-0.000123±0.000010"), (1234.5, 12.0, "1234±12"),
     (2.5, 0.0, "2.5"), (2.5, np.inf, "2.5")],
)  # fmt: skip
def test_values_have_two_digits_of_sigma(value: float, sigma: float, text: str) -> None:
    assert str(with_sigma(value, sigma)) == text


def estimated(method: int, robust: RobustCovariance | None, reason: str = "") -> PayloadEstimate:
    values = np.array([0.2, 0.0, 0.0, 0.2, 0.0, 0.1, 0.0, 0.0, 0.3, 3.0])
    norms = Fit(np.ones(6), np.full(6, 10.0), (50,) * 6)
    estimate = Estimate(PAYLOAD, values, 1e-4 * np.eye(10), 300.0, norms, np.ones(6), robust)
    return PayloadEstimate(method, estimate, "flange", reason)


def payload(method: int, robust: RobustCovariance | None, reason: str = "") -> FreeEstimate:
    return FreeEstimate.made(estimated(method, robust, reason))


def test_robust_standard_deviations_are_told_where_they_are() -> None:
    few = RobustCovariance(9e-4 * np.eye(10), 8, 7, 1.5)
    robust = written(payload(3, few))
    assert robust["sigma_robust"]["M"] == pytest.approx(0.03)
    assert robust["interval95_robust"]["M"] == pytest.approx([3.0 - 2.3646 * 0.03, 3.0 + 2.3646 * 0.03], abs=1e-5)
    assert (robust["robust"]["blocks"], robust["robust"]["degrees_of_freedom"]) == (8, 7)
    assert np.allclose(robust["com_sigma_robust"], 3.0 * np.asarray(robust["com_sigma"]))
    plain = written(payload(1, None, "too short"))
    assert (plain["sigma_robust"], plain["interval95_robust"], plain["com_sigma_robust"]) == (None, None, None)
    assert plain["robust"]["unavailable"] == "too short"

    notes = sigma_notes([payload(3, few), payload(1, None, "too short"), payload(4, None, "too short")])
    assert notes[0] == "± the larger of the formula's (17)-(19) and the block jackknife's standard deviation."
    assert "8 blocks of 1.5 s or more" in notes[1]
    assert "method 3 3.00." in notes[1]
    assert "record longer" in notes[2]
    assert notes[3:] == ["± of method 1, 4 by the formula alone: too short"]
    (plain_note,) = sigma_notes([payload(1, None)])
    assert "white torque noise" in plain_note
