"""Visibility of a payload in torques: known cases, and against the rank of the torques themselves."""

from collections.abc import Sequence

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.model import INERTIAL, InertialParameters, Robot, load_robot, payload_regressor
from dynident.model.inertia import payload_spread
from dynident.model.kernel.kernel import Kernel
from dynident.model.visibility import payload_visibility

POSES = {"ur10e": (0.0, -60.0, 90.0, -110.0, -80.0, 10.0), "rx90": (0.0, -45.0, 90.0, 10.0, 45.0, 0.0)}


def shown(name: str, joints: Sequence[int]) -> dict[str, str]:
    visibility = payload_visibility(
        load_robot(name), [np.radians(POSES[name])], joints, [float(np.radians(30.0))] * len(joints)
    )
    return {kind: str(how) for kind, how in visibility.parameters.items()}


def test_a_spherical_wrist_does_not_weigh() -> None:
    """On the RX90 the axes of joints 4 to 6 meet in the frame's origin: nine of ten, and no mass in any of them."""
    assert shown("rx90", (4, 5, 6)) == dict.fromkeys(INERTIAL, "yes") | {"M": "no"}


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


def monte_carlo(x: Array, C: Array) -> tuple[Array, Array]:
    draw = np.random.default_rng(2).multivariate_normal(x, C, 5_000)
    bodies = [InertialParameters(sample) for sample in draw]
    return np.std([b.com for b in bodies], axis=0), np.std([b.inertia_com for b in bodies], axis=0)


@pytest.mark.parametrize(
    "sizes", [(3e-4, 3e-4, 3e-3), (1e-6, 2e-3, 1e-4), (1e-6, 1e-5, 2e-2)], ids=["inertia", "first moments", "mass"]
)
def test_spread_of_derived_numbers_against_draws(sizes: tuple[float, float, float]) -> None:
    """Whichever of the ten is the uncertain one: the inertia at the centre of mass takes errors of all."""
    x = InertialParameters.from_com(3.0, [0.02, -0.03, 0.1], np.diag([0.02, 0.03, 0.015])).vector
    L = np.random.default_rng(3).standard_normal((10, 10)) * np.repeat(sizes, (6, 3, 1))[:, None]
    spread = payload_spread(x, L @ L.T, range(10))
    com, inertia = monte_carlo(x, L @ L.T)
    assert spread.com == pytest.approx(com, rel=0.05)
    assert spread.inertia_com == pytest.approx(inertia, rel=0.05)


def test_spread_of_what_hangs_on_a_missing_number_is_infinite() -> None:
    x = InertialParameters.from_com(3.0, [0.02, -0.03, 0.1], np.diag([0.02, 0.03, 0.015])).vector
    places = [5, 6, 7, 9]  # ZZ, MX, MY, M
    spread = payload_spread(x, 1e-6 * np.eye(4), places)
    assert np.isfinite(spread.com).tolist() == [True, True, False]
    assert np.isfinite(spread.moments).tolist() == [False, False, True]
    assert not np.isfinite(payload_spread(x, np.eye(3), [5, 6, 7]).mass)
