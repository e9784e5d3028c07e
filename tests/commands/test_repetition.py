"""Repeated experiments: bias, spread and coverage of estimators that are known."""

import numpy as np
import pytest
from dynident.estimation import Estimate
from dynident.estimation.fit.estimate import Fit
from dynident.examples.paper.repetition import Answer, Repetition, answer_of


def answers(count: int, sigma: float, half: float, bias: float = 0.0) -> list[Answer]:
    draw = np.random.default_rng(0)
    truth = np.array([1.0, -2.0])
    rows = []
    for _ in range(count):
        values = truth + bias + sigma * draw.standard_normal(2)
        rows.append(Answer(("a", "b"), truth, values, values - half, values + half, np.full(2, sigma)))
    return rows


def test_known_errors_are_found() -> None:
    repetition = Repetition.of(answers(4000, sigma=0.1, half=0.196, bias=0.05))
    assert np.allclose(repetition.bias, 0.05, atol=0.01)
    assert np.allclose(repetition.spread, 0.1, rtol=0.05)
    assert np.allclose(repetition.rms, np.hypot(0.1, 0.05), rtol=0.05)
    assert repetition.within("b", 0.025) == pytest.approx(0.3829 - 0.038, abs=0.04)


def test_intervals_of_two_sigma_hold_in_95_percent() -> None:
    assert np.allclose(Repetition.of(answers(4000, 0.1, 0.196)).coverage, 0.95, atol=0.015)


def test_one_experiment_has_no_spread() -> None:
    assert np.isnan(Repetition.of(answers(1, 0.1, 0.2)).spread).all()


def test_answers_of_different_parameters_are_refused() -> None:
    first, second = answers(2, 0.1, 0.2)
    with pytest.raises(ValueError, match="different parameters"):
        Repetition.of([first, second._replace(names=("a", "c"))])


def test_without_robust_intervals_the_formula_answers() -> None:
    fit = Fit(np.ones(1), np.ones(1), (10,))
    estimate = Estimate(("a",), np.array([2.0]), np.array([[0.04]]), 1e6, fit, np.ones(1))
    answer = answer_of(estimate, np.array([2.1]))
    assert (answer.high - answer.low)[0] == pytest.approx(2 * 1.96 * 0.2, rel=1e-3)
    assert answer.sigma[0] == pytest.approx(0.2)
