"""Least squares on the currents: what it states of its own errors where rows are few."""

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation.equations.equations import Equations
from dynident.estimation.gains.current_side import current_weights, gauss_newton

GAINS = np.array([2.0, 0.5, 1.3])
"""k_j [A/(N·m)]."""
X = np.array([1.0, -0.7, 0.4, 1.0])
"""Parameters; the last is known and sets the scale."""
ROWS = 4
"""Of each joint: 12 rows for 6 unknowns."""
SIGMA = 1e-3
DRAWS = 500


def problem(seed: int, rows: int = ROWS, effective: float = 1.0) -> Equations:
    """One motion with other noise; ``effective``: share of the rows whose noise counts as independent."""
    W = np.random.default_rng(0).standard_normal((len(GAINS), rows, len(X)))
    noise = SIGMA * np.random.default_rng((1, seed)).standard_normal((len(GAINS), rows))
    factors = tuple(np.column_stack([own, k * own @ X + e]) for own, k, e in zip(W, GAINS, noise, strict=True))
    counts = (rows,) * len(GAINS)
    return Equations(("A", "B", "C", "M_L"), factors, counts, tuple(effective * count for count in counts))


def fitted(equations: Equations) -> tuple[Array, Array]:
    """ln K less the truth, and its stated covariance."""
    fit = gauss_newton(equations, np.ones(len(GAINS)), range(3), np.array([0.0, 0.0, 0.0, 1.0]))
    return -np.log(fit.k / GAINS), fit.covariance


def test_stated_variance_of_few_rows_is_the_scatter() -> None:
    """The residual of 12 rows and 6 unknowns is half as large as the noise: divided by 12 it would state half."""
    fits = [fitted(problem(seed)) for seed in range(DRAWS)]
    scatter = np.cov(np.array([errors for errors, _ in fits]).T)
    stated = np.mean([covariance for _, covariance in fits], axis=0)
    assert np.diag(stated) == pytest.approx(np.diag(scatter), rel=0.2)
    assert stated == pytest.approx(scatter, abs=0.2 * np.diag(scatter).max())


def test_rows_that_are_not_independent_count_for_less() -> None:
    """(12 - 6) / (9 - 6): the same residual, twice the variance."""
    _, full = fitted(problem(0))
    _, three_quarters = fitted(problem(0, effective=0.75))
    assert three_quarters == pytest.approx(2.0 * full, rel=1e-9)


def test_as_many_unknowns_as_rows_are_refused() -> None:
    with pytest.raises(InputError, match="too few samples for 6 unknowns"):
        fitted(problem(0, effective=0.5))


def test_weights_of_few_rows_are_those_of_the_noise() -> None:
    """Six rows and four parameters of each joint's own: the residual of two degrees of freedom."""
    variances = [1.0 / current_weights(problem(seed, rows=6)) ** 2 for seed in range(DRAWS)]
    assert np.mean(variances, axis=0) == pytest.approx(SIGMA**2, rel=0.2)
