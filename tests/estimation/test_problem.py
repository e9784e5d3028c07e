"""The reduced problem holds what the rows hold; least squares against NumPy's and the formulas."""

from collections.abc import Callable

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.common.linear import RANK_TOLERANCE
from dynident.estimation.equations.equations import Equations, checked, merged
from dynident.estimation.equations.observer import Observation
from dynident.estimation.equations.reduction import reduced
from dynident.estimation.fit.essential import eliminate
from dynident.estimation.fit.estimate import Estimate, fit
from dynident.estimation.fit.least_squares import weighted
from hypothesis import given, settings
from hypothesis import strategies as st

NAMES = ("a", "b", "c", "d")


def ordinary(problem: Equations) -> Estimate:
    """Ordinary least squares (16)."""
    return weighted(problem, np.ones(len(problem.rows)))


def observation(
    seed: int, rows: tuple[int, ...] = (300, 200), noise: float = 0.1, bandwidth: float = 1.0
) -> Observation:
    draw = np.random.default_rng(seed)
    W = tuple(draw.standard_normal((r, 4)) * [1.0, 10.0, 0.1, 1.0] for r in rows)
    truth = np.array([1.0, -2.0, 30.0, 0.0])
    Y = tuple(w @ truth + noise * (k + 1) * draw.standard_normal(len(w)) for k, w in enumerate(W))
    return Observation(NAMES, W, Y, tuple(np.arange(float(r)) for r in rows), bandwidth)


@given(st.integers(0, 1000), st.integers(5, 5000))
@settings(max_examples=30, deadline=None)
def test_reduction_keeps_norms_and_products(seed: int, rows: int) -> None:
    data = observation(seed, (rows, 7))
    problem = reduced(data)
    for factor, W, Y in zip(problem.factors, data.W, data.Y, strict=True):
        whole = np.column_stack([W, Y])
        assert factor.shape[0] <= 5 or rows == 7
        assert np.allclose(
            factor.T @ factor, whole.T @ whole, rtol=1e-10, atol=1e-9 * np.abs(whole).max() ** 2 * rows
        )


def test_order_of_rows_does_not_matter_and_merging_is_stacking() -> None:
    data = observation(0)
    order = np.random.default_rng(1).permutation(300)
    shuffled = Observation(NAMES, (data.W[0][order], data.W[1]), (data.Y[0][order], data.Y[1]), data.t, 1.0)
    halves = [
        Observation(
            NAMES, tuple(w[s] for w in data.W), tuple(y[s] for y in data.Y), tuple(t[s] for t in data.t), 1.0
        )
        for s in (slice(None, 90), slice(90, None))
    ]
    whole = weighted(reduced(data))
    for again in (weighted(reduced(shuffled)), weighted(merged(reduced(half) for half in halves))):
        assert np.allclose(whole.values, again.values, rtol=1e-10, atol=1e-12)
        assert np.allclose(whole.covariance, again.covariance, rtol=1e-8)
        assert whole.fit.rows == again.fit.rows


def test_ordinary_least_squares_and_its_statistics() -> None:
    """(16)-(21), written out on the full matrices."""
    data = observation(2)
    W, Y = np.vstack(data.W), np.concatenate(data.Y)
    estimate = ordinary(reduced(data))
    x = np.linalg.lstsq(W, Y, rcond=None)[0]
    variance = np.sum((Y - W @ x) ** 2) / (len(Y) - 4)
    C = variance * np.linalg.inv(W.T @ W)
    assert np.allclose(estimate.values, x)
    assert np.allclose(estimate.covariance, C)
    assert np.allclose(estimate.sigma, np.sqrt(np.diag(C)))
    assert np.allclose(estimate.relative_sigma_percent, 100 * np.sqrt(np.diag(C)) / np.abs(x))
    assert estimate.fit.relative == pytest.approx(np.linalg.norm(Y - W @ x) / np.linalg.norm(Y))


def test_weighted_least_squares() -> None:
    """Weights from the ordinary residual of each joint."""
    data = observation(3)
    problem = reduced(data)
    x = ordinary(problem).values
    weights = problem.joint_weights(x)
    spread = [np.linalg.norm(Y - W @ x) / np.sqrt(len(Y)) for W, Y in zip(data.W, data.Y, strict=True)]
    assert weights[0] / weights[1] == pytest.approx(spread[1] / spread[0])
    W = np.vstack([w * weight for w, weight in zip(data.W, weights, strict=True)])
    Y = np.concatenate([y * weight for y, weight in zip(data.Y, weights, strict=True)])
    assert np.allclose(weighted(problem).values, np.linalg.lstsq(W, Y, rcond=None)[0])


def test_decimated_rows_count_less() -> None:
    """With a bandwidth of 0.8, sigma is as from 0.8 times as many rows."""
    full, shared = ordinary(reduced(observation(4))), ordinary(reduced(observation(4, bandwidth=0.8)))
    assert np.allclose(full.values, shared.values)
    ratio = np.sqrt((500 - 4) / (400 - 4))
    assert np.allclose(shared.sigma, ratio * full.sigma)


def test_units_of_parameters_do_not_matter() -> None:
    data = observation(5)
    factors = np.array([1.0, 1e-3, 1e4, 7.0])
    scaled = Observation(NAMES, tuple(w * factors for w in data.W), data.Y, data.t, 1.0)
    a, b = weighted(reduced(data)), weighted(reduced(scaled))
    assert np.allclose(a.values, b.values * factors, rtol=1e-9)
    assert np.allclose(a.sigma, b.sigma * factors, rtol=1e-9)
    assert reduced(data).condition_numbers()[1] == pytest.approx(reduced(scaled).condition_numbers()[1])


def test_condition_numbers() -> None:
    data = observation(6)
    W = np.vstack(data.W)
    raw, scaled = reduced(data).condition_numbers()
    assert raw == pytest.approx(np.linalg.cond(W))
    assert scaled == pytest.approx(np.linalg.cond(W / np.linalg.norm(W, axis=0)))


def deficient(change: Callable[[Array], Array]) -> Equations:
    data = observation(7)
    return reduced(Observation(NAMES, tuple(change(w) for w in data.W), data.Y, data.t, 1.0))


def test_rank_deficient_data_are_refused_with_the_directions_named() -> None:
    def copied(w: Array) -> Array:
        return np.column_stack([w[:, 0], w[:, 1], 2.0 * w[:, 1], w[:, 3]])

    def silent(w: Array) -> Array:
        return w * [1.0, 1.0, 1.0, 0.0]

    with pytest.raises(InputError, match=r"1 of 4 directions undetermined, in b, c:"):
        ordinary(deficient(copied))
    with pytest.raises(InputError, match=r"1 of 4 directions undetermined, in d:"):
        ordinary(deficient(silent))
    assert deficient(copied).condition_numbers() == (np.inf, np.inf)


def test_fewer_samples_than_parameters_are_refused() -> None:
    with pytest.raises(InputError, match="3 equations for 4 parameters: fewer samples"):
        ordinary(reduced(observation(8, (2, 1))))
    with pytest.raises(InputError, match="too few samples"):
        ordinary(reduced(observation(8, (3, 1))))


def test_validation_is_the_residual_on_other_data() -> None:
    x = ordinary(reduced(observation(9))).values
    second = observation(10)
    check = fit(reduced(second), x)
    errors = [np.linalg.norm(Y - W @ x) for W, Y in zip(second.W, second.Y, strict=True)]
    assert np.allclose(check.error_norms, errors)
    assert np.allclose(check.relative_per_joint, errors / np.array([np.linalg.norm(Y) for Y in second.Y]))


def test_selecting_columns() -> None:
    data = observation(11)
    x = ordinary(reduced(data).select(("c", "a"))).values
    W = np.vstack(data.W)[:, [2, 0]]
    assert np.allclose(x, np.linalg.lstsq(W, np.concatenate(data.Y), rcond=None)[0])


def test_essential_parameters_leave_out_what_the_torques_do_not_show() -> None:
    problem = reduced(observation(12, noise=0.5))
    assert eliminate(problem, weighted(problem)).essential == ("a", "b", "c")


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    truth = np.array([1.0, -2.0, 30.0, 0.0])
    hits = []
    for seed in range(400):
        interval = weighted(reduced(observation(seed, (60, 50)))).interval95
        hits.append((interval[:, 0] <= truth) & (truth <= interval[:, 1]))
    assert 0.93 <= np.mean(hits) <= 0.97


@pytest.mark.parametrize("decades", range(1, 13))
def test_rank_is_a_matter_of_singular_values(decades: int) -> None:
    """Whatever shortcut is taken for triangles that are clearly well determined."""
    draw = np.random.default_rng(decades)
    U, V = (np.linalg.qr(draw.standard_normal((12, 12)))[0] for _ in range(2))
    R = np.linalg.qr(U * np.logspace(0.0, -decades, 12) @ V)[1]
    names, Y = tuple(f"x{k}" for k in range(12)), np.zeros((12, 1))
    singular = np.linalg.svd(R / np.linalg.norm(R, axis=0), compute_uv=False)
    if singular[-1] < RANK_TOLERANCE * singular[0]:
        with pytest.raises(InputError, match="undetermined"):
            checked(np.hstack([R, Y]), names, 100, 100.0)
    else:
        checked(np.hstack([R, Y]), names, 100, 100.0)
        checked(np.hstack([R[::-1], Y]), names, 100, 100.0)
