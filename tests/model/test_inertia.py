"""One body in all its views."""

from collections.abc import Callable
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.model import INERTIAL, InertialParameters
from dynident.model.inertia import gradients, skew
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False, allow_subnormal=False)


def vectors(size: float) -> st.SearchStrategy[Array]:
    return arrays(np.float64, 3, elements=numbers(-size, size))


@st.composite
def clouds(draw: st.DrawFn) -> tuple[Array, Array]:
    """Masses [kg] and points [m]: from a single point to eight, also in a line or a plane."""
    count = draw(st.integers(1, 8))
    masses = draw(arrays(np.float64, count, elements=numbers(1e-3, 10.0)))
    return masses, draw(arrays(np.float64, (count, 3), elements=numbers(-1.0, 1.0)))


@st.composite
def rotations(draw: st.DrawFn) -> Array:
    """Rotation matrices by Rodrigues' formula."""
    x, y, z = draw(vectors(1.0))
    angle = draw(numbers(-np.pi, np.pi))
    axis = np.array([x, y, z]) / max(float(np.linalg.norm([x, y, z])), 1e-3)
    axis = axis if abs(np.linalg.norm(axis) - 1.0) < 1e-9 else np.array([0.0, 0.0, 1.0])
    K = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K)


Cloud = tuple[Array, Array]
Sums = Callable[[Array, Array], InertialParameters]


@given(points=clouds())
def test_pseudo_inertia_is_the_sum_over_points(cloud: Sums, points: Cloud) -> None:
    """Sum of m [p; 1] [p; 1]': never negative, and the ten are direct sums too."""
    masses, places = points
    body = cloud(masses, places)
    homogeneous = np.column_stack([places, np.ones(len(masses))])
    expected = homogeneous.T @ (masses[:, None] * homogeneous)
    np.testing.assert_allclose(body.pseudo_inertia, expected, atol=1e-12 * masses.sum())
    assert body.min_pseudo_inertia_eigenvalue >= -1e-13 * masses.sum()


@given(points=clouds(), rotation=rotations(), origin=vectors(2.0))
def test_moved_is_the_sum_over_moved_points(cloud: Sums, points: Cloud, rotation: Array, origin: Array) -> None:
    masses, places = points
    moved = cloud(masses, places).moved(rotation, origin)
    expected = cloud(masses, places @ rotation.T + origin)
    np.testing.assert_allclose(moved.vector, expected.vector, atol=1e-12 * masses.sum())


@given(points=clouds())
def test_from_com_is_the_inverse(cloud: Sums, points: Cloud) -> None:
    body = cloud(*points)
    again = InertialParameters.from_com(body.mass, body.com, body.inertia_com)
    np.testing.assert_allclose(again.vector, body.vector, atol=1e-13 * body.mass)


@given(points=clouds())
def test_centre_of_mass_form_is_the_sum_about_it(cloud: Sums, points: Cloud) -> None:
    masses, places = points
    body = cloud(masses, places)
    com = masses @ places / masses.sum()
    np.testing.assert_allclose(body.com, com, atol=1e-13)
    about = cloud(masses, places - com).inertia
    np.testing.assert_allclose(body.inertia_com, about, atol=1e-12 * masses.sum())


def test_views_agree_with_names() -> None:
    """XY is the entry of the inertia matrix, in the order of (6)."""
    body = InertialParameters(np.arange(1.0, 11.0))
    assert body.named("6") == {f"{kind}6": float(k) for k, kind in enumerate(INERTIAL, start=1)}
    np.testing.assert_array_equal(body.inertia, [[1, 2, 3], [2, 4, 5], [3, 5, 6]])
    np.testing.assert_array_equal(body.first_moments, [7, 8, 9])
    assert body.mass == 10.0
    np.testing.assert_array_equal(skew([1, 2, 3]) @ [4, 5, 6], np.cross([1, 2, 3], [4, 5, 6]))


def test_nothing_without_mass() -> None:
    nothing = InertialParameters(np.zeros(10))
    assert not nothing.physically_consistent
    with pytest.raises(ZeroDivisionError, match="no centre of mass"):
        _ = nothing.com


def test_values_are_checked_and_locked() -> None:
    given_values = np.ones(10)
    body = InertialParameters(given_values)
    given_values[0] = 5.0
    assert body.vector[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        body.vector[0] = 2.0
    with pytest.raises(FrozenInstanceError):
        body.vector = np.zeros(10)  # type: ignore[misc]
    with pytest.raises(ValueError, match=r"shape \(9,\), expected 10"):
        InertialParameters(np.ones(9))
    with pytest.raises(ValueError, match="not finite"):
        InertialParameters(np.full(10, np.nan))


def test_gradients_are_those_of_differences(random_bodies: Callable[[int, int], list[InertialParameters]]) -> None:
    """Gradients of the centre of mass and of the inertia about it, by each of the ten, are those of differences."""

    def values(x: Array) -> Array:
        body = InertialParameters(x)
        return np.concatenate([body.com, body.inertia_com[np.triu_indices(3)]])

    for body in random_bodies(3, 5):
        steps = 1e-6 * np.eye(10)
        slopes = [(values(body.vector + step) - values(body.vector - step)) / 2e-6 for step in steps]
        assert gradients(body.vector) == pytest.approx(np.column_stack(slopes), rel=1e-6, abs=1e-8)


@given(rotations(), arrays(np.float64, 3, elements=numbers(0.0, 1.0)), numbers(1e-3, 100.0), vectors(1.0))
def test_an_inertia_in_three_forms(R: Array, squares: Array, mass: float, com: Array) -> None:
    """Second moments that are not negative give an inertia that some body has; a diagonal is three moments."""
    J = R @ np.diag(squares) @ R.T
    inertia = np.trace(J) * np.eye(3) - J
    body = InertialParameters.from_com(mass, com, inertia)
    six = InertialParameters.from_com(mass, com, inertia[np.triu_indices(3)])
    np.testing.assert_allclose(body.vector, six.vector, atol=1e-12)
    moments = squares.sum() - squares
    three = InertialParameters.from_com(mass, com, moments)
    np.testing.assert_array_equal(three.vector, InertialParameters.from_com(mass, com, np.diag(moments)).vector)


@pytest.mark.parametrize(
    ("mass", "com", "inertia", "words"),
    [
        (-1.0, [0, 0, 0], [1, 1, 1], "mass -1 kg"),
        (0.0, [0, 0, 0], [1, 1, 1], "mass 0 kg"),
        (np.nan, [0, 0, 0], [1, 1, 1], "mass nan kg"),
        (1.0, [0, 0], [1, 1, 1], "give x, y, z"),
        (1.0, [0, 0, 0], 1.0, "give three moments, six entries"),
        (1.0, [0, 0, 0], [1, 1], "give three moments, six entries"),
        (1.0, [0, 0, 0], [1.0] * 9, "give three moments, six entries"),
        (1.0, [0, 0, 0], [[1, 1, 1]], "give three moments, six entries"),
        (1.0, [0, 0, 0], [[1, 0.2, 0], [0, 1, 0], [0, 0, 1]], "not symmetric"),
        (1.0, [0, 0, 0], [1, 1, 2.01], "no body has them"),
        (1.0, [0, 0, 0], [1, 1, -0.1], "no body has them"),
        (1.0, [0, 0, np.inf], [1, 1, 1], "not finite"),
        (1.0, [0, 0, 0], ["a", 1, 1], "numbers are needed"),
        (1.0, [0, 0, 0], [[1, 2, 3], [4]], "numbers are needed"),
    ],
)
def test_a_body_that_is_refused(mass: float, com: object, inertia: object, words: str) -> None:
    with pytest.raises(InputError, match=words):
        InertialParameters.from_com(mass, com, inertia)  # type: ignore[arg-type]
