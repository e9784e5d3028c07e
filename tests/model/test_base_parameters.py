"""Base parameters: the paper's for the RX90, and what must hold for every robot."""

from string import ascii_letters

import numpy as np
from dynident.model import Robot, base_parameters, standard_columns, standard_regressor
from dynident.model.base.rank import leftmost_independent, random_states, stacked_regressor
from dynident.model.regressors import payload_columns


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
