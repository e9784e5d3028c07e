"""Base parameters: the paper's for the RX90, and what must hold for every robot."""

from dataclasses import replace
from string import ascii_letters

import numpy as np
import pytest
from dynident.model import Drives, Robot, base_parameters, regressor, standard_columns, standard_regressor
from dynident.model.base.rank import leftmost_independent, random_states, stacked_regressor
from dynident.model.regressors import payload_columns

Groupings = dict[str, dict[str, float]]
INERTIAL_ONLY = Drives(rotor_inertia=False, friction=False)
WITH_ROTORS = Drives(rotor_inertia=True, friction=False)


def with_drives(robot: Robot, drives: Drives) -> Robot:
    return replace(robot, drives=drives)


@pytest.mark.parametrize(
    ("drives", "count"), [(INERTIAL_ONLY, 36), (WITH_ROTORS, 40), (None, 54)], ids=["rigid", "rotors", "friction"]
)
def test_number_on_the_rx90(rx90: Robot, drives: Drives | None, count: int) -> None:
    """36 without rotors; 40 with them; N_b = 54 with the 14 friction parameters (section II.D)."""
    assert len(base_parameters(with_drives(rx90, drives) if drives else rx90).columns) == count


def test_rank_is_not_a_matter_of_tolerance(rx90: Robot) -> None:
    """The singular values fall off a cliff after the 40th."""
    robot = with_drives(rx90, WITH_ROTORS)
    sizes = np.linalg.svd(stacked_regressor(robot, *random_states(robot, 72, seed=3)), compute_uv=False)
    assert sizes[39] > 1e-3 * sizes[0]
    assert sizes[40] < 1e-14 * sizes[0]


@pytest.mark.parametrize("drives", [WITH_ROTORS, None], ids=["rotors", "all drives"])
def test_groupings_of_the_rx90(rx90: Robot, groupings: Groupings, drives: Drives | None) -> None:
    """Every relation of (12), every factor, every sign; nothing is grouped into the other parameters."""
    base = base_parameters(with_drives(rx90, drives) if drives else rx90)
    assert len(groupings) == 15
    for name, column, row in zip(base.names, base.columns, base.grouping, strict=True):
        grouping = {base.standard[k]: row[k] for k in np.flatnonzero(row)}
        assert grouping == pytest.approx(groupings.get(name, {column: 1.0}), abs=1e-10), name


def test_unidentifiable_on_the_rx90(rx90: Robot, groupings: Groupings) -> None:
    """Unidentifiable parameters are neither base parameters nor in any relation of (12)."""
    grouped = {name for factors in groupings.values() for name in factors}
    base = base_parameters(rx90)
    effective = grouped | set(base.columns)
    assert base.unidentifiable == tuple(name for name in base.standard if name not in effective)
    assert set(base.unidentifiable) == {
        *("XX1", "XY1", "XZ1", "YY1", "YZ1", "MX1", "MY1", "MZ1", "M1", "MZ2", "M2")
    }  # fmt: skip


def test_grouped_regressor(robot: Robot) -> None:
    """W_s = W_base G on states that played no part in finding G."""
    base = base_parameters(robot)
    W = stacked_regressor(robot, *random_states(robot, 100, seed=99))
    rebuilt = W[:, base.chosen] @ base.grouping
    assert np.abs(rebuilt - W).max() <= 1e-10 * np.abs(W).max()
    assert np.linalg.matrix_rank(W) == len(base.columns)


def test_seed_does_not_matter(robot: Robot) -> None:
    """Other random states give the same names and the same groupings."""
    first = base_parameters(robot, seed=0)
    for seed in range(1, 8):
        second = base_parameters(robot, seed)
        assert second.columns == first.columns
        assert second.unidentifiable == first.unidentifiable
        np.testing.assert_allclose(second.grouping, first.grouping, atol=1e-9)


def test_values_are_those_of_the_grouping(rx90: Robot, groupings: Groupings) -> None:
    base = base_parameters(rx90)
    values = dict(zip(base.names, base.value(rx90.parameters), strict=True))
    for name, factors in groupings.items():
        by_hand = sum(factor * rx90.parameters[standard] for standard, factor in factors.items())
        assert values[name] == pytest.approx(by_hand, abs=1e-10)
    with pytest.raises(KeyError):
        base.value({"XX1": 1.0})


def test_payload_is_determined(shipped: Robot) -> None:
    """Method 2 can find all ten: the map from the payload to base parameters has rank 10."""
    base = base_parameters(shipped)
    effect = base.effect_of(payload_columns(shipped))
    sizes = np.linalg.svd(effect, compute_uv=False)
    assert effect.shape == (len(base.columns), 10)
    assert sizes[-1] > 1e-2 * sizes[0]


def test_offsets_add_one_column_a_joint(shipped: Robot) -> None:
    names = [base_parameters(shipped.with_offsets(offsets)).names for offsets in (False, True)]
    assert set(names[1]) - set(names[0]) == {f"OFF{j}" for j in range(1, shipped.n + 1)}
    assert len(names[1]) == len(names[0]) + shipped.n


def test_leftmost_columns_are_chosen() -> None:
    a, b = np.random.default_rng(0).normal(size=(2, 20))
    W = np.column_stack([np.zeros(20), a, -3.0 * a, b, a + b, 1e-12 * np.arange(20.0)])
    assert leftmost_independent(W) == [1, 3]
    assert leftmost_independent(np.zeros((4, 3))) == []
    assert leftmost_independent(np.eye(2, 5) + 1.0) == [0, 1]


def test_choice_does_not_hang_on_rounding() -> None:
    """Powers of x are nearly dependent: orthogonalised once, their sum would seem to be something new."""
    powers = np.linspace(0.0, 1.0, 50)[:, None] ** np.arange(11)
    W = np.column_stack([powers, powers.sum(axis=1)])
    assert leftmost_independent(W) == list(range(11))


def test_zeros_by_geometry_are_not_stored(rx90: Robot) -> None:
    """Exact right angles leave 139 entries in the rigid base regressor; friction, rotors, coupling 21 more."""
    rigid = with_drives(rx90, INERTIAL_ONLY)
    for robot, entries in ((rigid, 139), (rx90, 160)):
        assert regressor(robot, base_parameters(robot).columns).nnz_out(0) == entries


def test_joints_do_not_feel_links_before_them(robot: Robot) -> None:
    rows, columns = standard_regressor(robot).sparsity_out(0).get_triplet()
    links = [int(name.lstrip(ascii_letters)) for name in standard_columns(robot)]
    assert all(row + 1 <= links[column] for row, column in zip(rows, columns, strict=True))
