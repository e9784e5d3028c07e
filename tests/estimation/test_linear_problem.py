"""Roles of columns: known ones and held ones against least squares written out."""

from dataclasses import replace

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.estimation.equations.equations import Equations
from dynident.estimation.fit.linear_problem import Known, LinearProblem, SoftPrior

NAMES = ("A", "B", "C", "D")
TRUTH = np.array([1.0, -2.0, 0.5, 3.0])
WEIGHTS = np.array([2.0, 0.5])


def rows(seed: int) -> Array:
    """[W Y] of one joint with noise."""
    draw = np.random.default_rng(seed)
    W = draw.standard_normal((40, 4))
    return np.column_stack([W, W @ TRUTH + 0.1 * draw.standard_normal(40)])


EQUATIONS = Equations(NAMES, (rows(0), rows(1)), (40, 40), (40.0, 40.0))
STACKED = np.vstack([w * rows(k) for k, w in enumerate(WEIGHTS)])


def by_hand(A: Array, y: Array) -> Array:
    return np.asarray(np.linalg.lstsq(A, y, rcond=None)[0])


def test_a_column_held_tightly_is_zero_and_held_loosely_is_free() -> None:
    """The equation of a held column is one row more, its sigma the row's unit."""
    for sigma, expected in (
        (1e-7, by_hand(STACKED[:, :3], STACKED[:, 4])),
        (1e7, by_hand(STACKED[:, :4], STACKED[:, 4])[:3]),
        (0.3, by_hand(np.vstack([STACKED[:, :4], [[0, 0, 0, 1 / 0.3]]]), np.append(STACKED[:, 4], 0.0))[:3]),
    ):
        problem = LinearProblem(EQUATIONS, NAMES[:3], soft={"D": SoftPrior(sigma)})
        assert problem.values(WEIGHTS) == pytest.approx(expected, abs=1e-9)
        assert problem.solved(WEIGHTS).values == pytest.approx(expected, abs=1e-9)


def test_what_a_held_column_lasts_is_its_influence() -> None:
    """The values move by as much as the level they are held at; no block of time shows that level."""
    sigma = 0.3
    problem = LinearProblem(EQUATIONS, NAMES[:3], soft={"D": SoftPrior(sigma)})
    A = np.vstack([STACKED[:, :4], [[0, 0, 0, 1 / sigma]]])
    moved = by_hand(A, np.append(0.0 * STACKED[:, 4], 1.0 / sigma))[:3]
    assert problem.lasting(WEIGHTS) == pytest.approx(sigma**2 * np.outer(moved, moved), rel=1e-9)


def test_a_held_column_counts_for_as_much_as_rows_that_remember_allow() -> None:
    """Data that are worth four times less leave the prior four times the weight; it errs no more than it did."""
    sigma, doubled = 0.3, np.vstack([STACKED[:, :4], [[0, 0, 0, 2.0 / 0.3]]])
    problem = LinearProblem(EQUATIONS, NAMES[:3], soft={"D": SoftPrior(sigma, 4.0)})
    assert problem.values(WEIGHTS) == pytest.approx(by_hand(doubled, np.append(STACKED[:, 4], 0.0))[:3], abs=1e-9)
    moved = by_hand(doubled, np.append(0.0 * STACKED[:, 4], 2.0 / sigma))[:3]
    assert problem.lasting(WEIGHTS) == pytest.approx(sigma**2 * np.outer(moved, moved), rel=1e-9)


def test_errors_that_remember_by_hand() -> None:
    """The sandwich: each joint's errors by their own size, as much larger in variance as their memory says."""
    x = by_hand(STACKED[:, :4], STACKED[:, 4])
    inverse, middle = np.linalg.inv(STACKED[:, :4].T @ STACKED[:, :4]), np.zeros((4, 4))
    memory = (3.0, 7.0)
    for k, weight in enumerate(WEIGHTS):
        W, Y = rows(k)[:, :4], rows(k)[:, 4]
        size = float(np.sum((Y - W @ x) ** 2)) / (40 * (1.0 - 4 / 80))
        middle += memory[k] * weight**4 * size * W.T @ W
    covariance = LinearProblem(EQUATIONS, NAMES).sandwich(WEIGHTS, memory)
    assert covariance == pytest.approx(inverse @ middle @ inverse, rel=1e-9)


def test_known_columns_bring_their_covariance_and_their_gains() -> None:
    C = np.diag([0.04, 0.09])
    own = np.array([[0.1, 0.2], [0.3, 0.4]])
    known = Known(NAMES[2:], TRUTH[2:], C, 0.5 * C, gain_sensitivity=lambda: own)
    problem = LinearProblem(EQUATIONS, NAMES[:2], (known,))
    estimate = problem.estimate(WEIGHTS)
    left = STACKED[:, 4] - STACKED[:, 2:4] @ TRUTH[2:]
    assert estimate.values == pytest.approx(by_hand(STACKED[:, :2], left))
    P = np.linalg.lstsq(STACKED[:, :2], STACKED[:, 2:4], rcond=None)[0]
    exact = LinearProblem(EQUATIONS, NAMES[:2], (known._replace(covariance=0.0 * C),)).estimate(WEIGHTS)
    assert estimate.covariance - exact.covariance == pytest.approx(P @ C @ P.T)
    assert problem.lasting(WEIGHTS) == pytest.approx(0.5 * P @ C @ P.T)
    assert estimate.gain_sensitivity is not None
    for joint in range(2):
        louder = [factor.copy() for factor in EQUATIONS.factors]
        louder[joint][:, -1] *= 2.0
        moved_known = known._replace(values=known.values + own[:, joint])
        changed = LinearProblem(replace(EQUATIONS, factors=tuple(louder)), NAMES[:2], (moved_known,))
        step = changed.values(WEIGHTS) - estimate.values
        assert estimate.gain_sensitivity[:, joint] == pytest.approx(step, abs=1e-9)
    blind = LinearProblem(EQUATIONS, NAMES[:2], (known._replace(gain_sensitivity=lambda: None),))
    assert blind.estimate(WEIGHTS).gain_sensitivity is None
