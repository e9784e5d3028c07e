"""Base parameters: the paper's for the RX90, and what must hold for every robot."""

from dataclasses import replace
from string import ascii_letters

import numpy as np
import pytest
from dynident.model import Drives, Robot, base_parameters, standard_columns, standard_regressor
from dynident.model.base.rank import leftmost_independent, random_states, stacked_regressor
from dynident.model.regressors import payload_columns

Groupings = dict[str, dict[str, float]]
WITH_ROTORS = Drives(rotor_inertia=True, friction=())


def with_drives(robot: Robot, drives: Drives) -> Robot:
    return replace(robot, drives=drives)


@pytest.mark.parametrize("drives", [WITH_ROTORS, None], ids=["rotors", "all drives"])
def test_groupings_of_the_rx90(rx90: Robot, groupings: Groupings, drives: Drives | None) -> None:
    """Every relation of (12), every factor, every sign; nothing is grouped into the other parameters."""
    base = base_parameters(with_drives(rx90, drives) if drives else rx90)
    assert len(groupings) == 15
    for name, column, row in zip(base.names, base.columns, base.grouping, strict=True):
        grouping = {base.standard[k]: row[k] for k in np.flatnonzero(row)}
        assert grouping == pytest.approx(groupings.get(name, {column: 1.0}), abs=1e-10), name


def test_grouped_regressor(robot: Robot) -> None:
    """W_s = W_base G on states that played no part in finding G."""
    base = base_parameters(robot)
    W = stacked_regressor(robot, *random_states(robot, 100, seed=99))
    rebuilt = W[:, base.chosen] @ base.grouping
    assert np.abs(rebuilt - W).max() <= 1e-10 * np.abs(W).max()
    assert np.linalg.matrix_rank(W) == len(base.columns)


def test_payload_is_determined(shipped: Robot) -> None:
    """Method 2 can find all ten: the map from the payload to base parameters has rank 10."""
    base = base_parameters(shipped)
    effect = base.effect_of(payload_columns(shipped))
    sizes = np.linalg.svd(effect, compute_uv=False)
    assert effect.shape == (len(base.columns), 10)
    assert sizes[-1] > 1e-2 * sizes[0]


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


def test_joints_do_not_feel_links_before_them(robot: Robot) -> None:
    rows, columns = standard_regressor(robot).sparsity_out(0).get_triplet()
    links = [int(name.lstrip(ascii_letters)) for name in standard_columns(robot)]
    assert all(row + 1 <= links[column] for row, column in zip(rows, columns, strict=True))
