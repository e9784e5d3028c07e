"""Column-scaled least squares, rank and null space; filters and monotone cubics against scipy's."""

import numpy as np
import pytest
from dynident.common.linear import RANK_TOLERANCE, decomposed, one_thread, without
from dynident.common.recursion import butterworth, filtered
from scipy.signal import butter, sosfilt, sosfilt_zi
from threadpoolctl import threadpool_info, threadpool_limits

DRAW = np.random.default_rng(0)
A = DRAW.normal(size=(12, 5))
B = DRAW.normal(size=(12, 3))
UNITS = np.array([1e-6, 1.0, 1e5, 3.0, 1e-3])
DEPENDENT = np.column_stack([A, A @ DRAW.normal(size=(5, 2)), np.zeros(12)])
"""Rank 5 of eight columns, one of them zero."""


def test_solution_is_least_squares() -> None:
    assert decomposed(A).solution(B) == pytest.approx(np.linalg.solve(A.T @ A, A.T @ B), rel=1e-12)
    assert decomposed(A).solution(B[:, 0]) == pytest.approx(decomposed(A).solution(B)[:, 0], rel=1e-14)
    assert decomposed(A).inverse @ B == pytest.approx(decomposed(A).solution(B), rel=1e-12)
    assert decomposed(A).root @ decomposed(A).root.T == pytest.approx(np.linalg.inv(A.T @ A), rel=1e-12)


@pytest.mark.parametrize(
    "matrix", [A, DEPENDENT[:, :5] @ np.diag(UNITS), DEPENDENT], ids=["A", "units", "dependent"]
)
def test_parts_are_those_of_the_matrix(matrix: np.ndarray) -> None:
    parts = decomposed(matrix)
    rowspace = parts.root * parts.singular * parts.sizes[:, None]
    rebuilt = parts.range * parts.singular @ rowspace.T * parts.sizes
    assert np.abs(rebuilt - matrix).max(axis=0) == pytest.approx(0.0, abs=1e-13 * np.abs(matrix).max())
    basis = np.column_stack([rowspace, parts.null])
    assert basis @ basis.T == pytest.approx(np.eye(matrix.shape[1]), abs=1e-13)
    assert np.abs(matrix / parts.sizes @ parts.null).max(initial=0.0) < 1e-13


def test_units_of_the_columns_do_not_matter() -> None:
    units = np.append(UNITS, [1e7, 1e-9, 1e3])
    plain, scaled = decomposed(DEPENDENT), decomposed(DEPENDENT * units)
    assert len(scaled.singular) == len(plain.singular) == 5
    assert scaled.hidden == pytest.approx(plain.hidden, abs=1e-12)
    assert scaled.solution(B) * units[:, None] == pytest.approx(plain.solution(B), rel=1e-9, abs=1e-12)
    roots = scaled.root * units[:, None], plain.root
    assert roots[0] @ roots[0].T == pytest.approx(roots[1] @ roots[1].T, rel=1e-9, abs=1e-12)


def test_hidden_names_what_is_undetermined() -> None:
    twice = np.column_stack([A[:, :3], 1e4 * A[:, 2], np.zeros(12)])
    assert decomposed(twice).hidden == pytest.approx([0.0, 0.0, 0.5, 0.5, 1.0], abs=1e-12)
    assert decomposed(A).hidden == pytest.approx(np.zeros(5))


@pytest.mark.parametrize(("error", "expected"), [(4.0, 2), (0.25, 1)])
def test_rank_on_both_sides_of_the_tolerance(error: float, expected: int) -> None:
    """Two unit columns at an angle e have singular values sqrt(2) and e / sqrt(2)."""
    angle = 2.0 * error * RANK_TOLERANCE
    columns = np.array([[1.0, np.cos(angle)], [0.0, np.sin(angle)]])
    assert len(decomposed(columns * [1e-5, 1e5]).singular) == expected


def test_rest_is_at_right_angles_to_what_is_taken_out() -> None:
    rest = without(B, DEPENDENT * np.append(UNITS, [1.0, 1.0, 1.0]))
    assert A.T @ rest == pytest.approx(np.zeros((5, 3)), abs=1e-13)
    assert without(rest, A) == pytest.approx(rest, abs=1e-14)
    assert without(A @ B[:5], A) == pytest.approx(np.zeros((12, 3)), abs=1e-14)


def test_columns_of_rounding_count_as_zero() -> None:
    """Some rows hold next to nothing of a column that is large in the others."""
    whole = np.linalg.norm(np.vstack([A, B @ np.ones((3, 5))]), axis=0)
    exact = A * [1.0, 0.0, 1.0, 0.0, 1.0]
    rounded = exact + 1e-16 * np.random.default_rng(1).normal(size=A.shape)
    assert len(decomposed(rounded).singular) == 5
    assert len(decomposed(rounded, whole).singular) == len(decomposed(exact).singular) == 3
    assert decomposed(rounded, whole).solution(B) == pytest.approx(decomposed(exact).solution(B), abs=1e-12)


SIGNALS = np.random.default_rng(0).standard_normal((400, 3)).cumsum(axis=0)


@pytest.mark.parametrize("cutoff", [0.01, 0.1, 0.5, 0.95])
@pytest.mark.parametrize("order", [2, 4, 6])
def test_scipy_filters_alike(order: int, cutoff: float) -> None:
    sections = butterworth(order, cutoff)
    sos = butter(order, cutoff, output="sos")
    settled = sosfilt_zi(sos)[:, :, None] * SIGNALS[0]
    theirs, _ = sosfilt(sos, SIGNALS, axis=0, zi=settled)
    assert np.abs(filtered(sections, SIGNALS, SIGNALS[0]) - theirs).max() < 1e-11 * np.abs(theirs).max()


def test_estimation_has_one_thread_whatever_the_caller_has() -> None:
    def threads() -> list[int]:
        return [pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"]

    with threadpool_limits(2, "blas"):
        before = threads()
        assert set(one_thread()(threads)()) == {1}
        assert threads() == before


def test_overlapping_calls_give_the_threads_back_when_the_last_one_ends() -> None:
    def threads() -> set[int]:
        return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}

    with threadpool_limits(2, "blas"):
        before, first, second = threads(), one_thread(), one_thread()
        first.__enter__()
        second.__enter__()
        first.__exit__(None, None, None)
        assert threads() == {1}
        second.__exit__(None, None, None)
        assert threads() == before
