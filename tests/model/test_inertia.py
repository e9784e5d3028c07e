"""One body in all its views, and what torques show of it."""

from collections.abc import Callable
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.model import INERTIAL, InertialParameters, Robot, load_robot, payload_regressor
from dynident.model.base import payload_visibility
from dynident.model.inertia import gradients, payload_spread, skew
from dynident.model.kernel.kernel import Kernel
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


POSES = {"ur10e": (0.0, -60.0, 90.0, -110.0, -80.0, 10.0), "rx90": (0.0, -45.0, 90.0, 10.0, 45.0, 0.0)}


def test_a_spherical_wrist_does_not_weigh() -> None:
    """On the RX90 the axes of joints 4 to 6 meet in the frame's origin: nine of ten, and no mass in any of them."""
    visibility = payload_visibility(load_robot("rx90"), [np.radians(POSES["rx90"])], (4, 5, 6), [0.5] * 3)
    shown = {kind: str(how) for kind, how in visibility.parameters.items()}
    assert shown == dict.fromkeys(INERTIAL, "yes") | {"M": "no"}


def test_two_axes_that_meet_hide_the_mass_in_sums() -> None:
    """On the UR10e those of joints 5 and 6 meet 117 mm behind the flange; a body moved there along is not seen."""
    visibility = payload_visibility(load_robot("ur10e"), [np.radians(POSES["ur10e"])], (5, 6), [0.5, 0.5])
    assert visibility.rank == 9
    assert not visibility.mass_visible
    assert visibility.combinations == ("XX - 0.01369 M", "YY - 0.01369 M", "MZ + 0.117 M")
    only = {kind for kind, how in visibility.parameters.items() if how == "only with a known mass"}
    assert only == {"XX", "YY", "MZ"}
    assert visibility.parameters["M"] == "only in combination"


def test_a_payload_moved_along_a_hidden_sum_changes_no_torque() -> None:
    """Independent of rank decisions: two bodies that differ in a hidden direction need the same torques."""
    robot = load_robot("ur10e")
    phi = Kernel(payload_regressor(robot))
    draw = np.random.default_rng(0)
    q = np.tile(np.radians(POSES["ur10e"]), (50, 1))
    qd, qdd = np.zeros((2, 50, 6))
    for j in (4, 5):
        q[:, j] += draw.uniform(-0.5, 0.5, 50)
        qd[:, j], qdd[:, j] = draw.uniform(-2.0, 2.0, (2, 50))
    W = np.zeros((50, 6, 10))
    W[:, phi.rows, phi.columns] = phi(q, qd, qdd).T
    hidden = np.zeros(10)
    hidden[[0, 3, 8, 9]] = 0.117**2, 0.117**2, -0.117, 1.0  # one more kilogram where the axes meet
    assert np.abs((W @ hidden)[:, 4:]).max() < 1e-12
    assert np.abs((W @ hidden)[:, :3]).max() > 1.0


def test_resolved_gives_back_what_made_the_torques() -> None:
    visibility = payload_visibility(load_robot("ur10e"), [np.radians(POSES["ur10e"])], (5, 6), [0.5, 0.5])
    x = InertialParameters.from_com(2.0, [0.01, 0.02, 0.1], np.diag([0.01, 0.02, 0.015])).vector
    places, A, b = visibility.resolved(mass_known=True)
    assert places == tuple(range(10))
    assert A @ (visibility.base.grouping @ x) + b * x[9] == pytest.approx(x, abs=1e-12)
    assert 9 not in visibility.resolved(mass_known=False)[0]


@pytest.mark.parametrize("joints", [(), (0,), (7,), (2, 2)])
def test_joints_that_the_robot_lacks(rx90: Robot, joints: tuple[int, ...]) -> None:
    with pytest.raises(InputError, match="numbers from 1 to 6"):
        payload_visibility(rx90, [np.zeros(6)], joints, [0.5] * len(joints))


@pytest.mark.parametrize(
    "sizes", [(3e-4, 3e-4, 3e-3), (1e-6, 2e-3, 1e-4), (1e-6, 1e-5, 2e-2)], ids=["inertia", "first moments", "mass"]
)
def test_spread_of_derived_numbers_against_draws(sizes: tuple[float, float, float]) -> None:
    """Whichever of the ten is the uncertain one: the inertia at the centre of mass takes errors of all."""
    x = InertialParameters.from_com(3.0, [0.02, -0.03, 0.1], np.diag([0.02, 0.03, 0.015])).vector
    L = np.random.default_rng(3).standard_normal((10, 10)) * np.repeat(sizes, (6, 3, 1))[:, None]
    spread = payload_spread(x, L @ L.T, range(10))
    bodies = [InertialParameters(one) for one in np.random.default_rng(2).multivariate_normal(x, L @ L.T, 5_000)]
    assert spread.com == pytest.approx(np.std([b.com for b in bodies], axis=0), rel=0.05)
    assert spread.inertia_com == pytest.approx(np.std([b.inertia_com for b in bodies], axis=0), rel=0.05)
