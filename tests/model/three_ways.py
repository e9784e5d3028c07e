"""Rules, local transfers and QR on one robot, and by how much they differ."""

from collections import Counter
from typing import NamedTuple

import numpy as np
from dynident.common.arrays import Array
from dynident.common.linear import RANK_TOLERANCE
from dynident.model import Robot, closed_form_base_parameters, standard_columns
from dynident.model.base.grouping import moves
from dynident.model.base.parameters import BaseParameters
from dynident.model.base.rank import STATES_PER_JOINT, base_parameters_of, left_residuals, random_states
from dynident.model.many_states import regressor_at
from dynident.tests.model.local_transfers import local_transfer_base_parameters


class Comparison(NamedTuple):
    """How one robot came out.

    Attributes:
        names: whether all three give the same names in the same order.
        grouping: largest difference between two of the three groupings.
        model: largest of ||W - W_base G|| / ||W|| over the three.
        rejected: largest residual of a column that QR rejects, relative to the largest column.
        accepted: smallest residual of a column that QR accepts.
        rules: how often each rule was applied; empty without gravity.
    """

    names: bool
    grouping: float
    model: float
    rejected: float
    accepted: float
    rules: Counter[str]


def compare(robot: Robot) -> Comparison:
    """Decide a robot's base parameters in three ways; in two without gravity, where the rules do not hold."""
    columns = standard_columns(robot)
    W = regressor_at(robot, columns, *random_states(robot, STATES_PER_JOINT * robot.n, seed=1))
    # same norms and dependencies, fewer rows
    R = np.asarray(np.linalg.qr(W.transpose(0, 2, 1).reshape(-1, len(columns)), mode="r"))
    decided = [base_parameters_of(columns, R), local_transfer_base_parameters(robot)]
    if any(robot.gravity):
        decided.append(closed_form_base_parameters(robot))
    names = all(base.names == decided[0].names for base in decided)
    residuals = left_residuals(R)
    independent = residuals > RANK_TOLERANCE
    return Comparison(
        names,
        max(float(np.abs(base.grouping - decided[0].grouping).max()) for base in decided) if names else np.inf,
        max(_model_error(base, R) for base in decided),
        float(residuals[~independent].max(initial=0.0)),
        float(residuals[independent].min()),
        Counter(move.rule for move in moves(robot)) if any(robot.gravity) else Counter(),
    )


def _model_error(base: BaseParameters, R: Array) -> float:
    return float(np.linalg.norm(R - R[:, list(base.chosen)] @ base.grouping) / np.linalg.norm(R))
