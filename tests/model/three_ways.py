"""Rules, local transfers and QR on one robot, and by how much they differ."""

from collections import Counter
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.common.linear import RANK_TOLERANCE
from dynident.model import BaseParameters, closed_form_base_parameters
from dynident.model.base import STATES_PER_JOINT, base_parameters_of, left_residuals, moves, random_states
from dynident.model.inertia import InertialParameters, cos_sin, skew
from dynident.model.regressors import regressor_at, standard_columns
from dynident.model.robot import Joint, Robot

_ZERO = 1e-8
"""A singular value below it is rounding (1e-15 in general) or, at lengths of 0.1 mm, their square."""


@dataclass(frozen=True)
class _Link:
    """Motions that a link can go through, in its frame: spans of columns.

    Its velocities, gravity at q = 0 as an acceleration and its changes with the positions; in rows, what torques
    show of its ten parameters.
    """

    velocities: Array
    gravity: Array
    swings: Array
    detectable: Array


def local_transfer_base_parameters(robot: Robot) -> BaseParameters:
    """Base parameters of a serial robot by local transfers; any gravity, zero included.

    Raises:
        InputError: for coupled drives.
    """
    if robot.coupling:
        raise InputError(
            f"robot {robot.name!r} has coupled drives, which local transfers do not cover: use base_parameters"
        )
    columns = standard_columns(robot)
    nullspace, dropped = np.zeros((0, len(columns))), list[int]()
    upwards = np.concatenate([np.zeros(3), -np.array(robot.gravity)])
    link = _Link(np.zeros((6, 0)), upwards, np.zeros((6, 0)), np.zeros((0, 10)))
    for j, joint in enumerate(robot.joints):
        own = [columns.index(f"XX{j + 1}") + k for k in range(10)]
        own += [columns.index(f"{kind}{j + 1}") for kind in ("IA", "OFF") if f"{kind}{j + 1}" in columns]
        unseen, link = _across(joint, link, robot)
        dropped += [own[k] for k in _last_entries(unseen)]
        vectors = np.zeros((len(unseen), len(columns)))
        vectors[:, own] = unseen
        if j > 0:
            before = columns.index(f"XX{j}")
            vectors[:, before : before + 10] = -unseen[:, :10] @ _transfer(joint).T
        nullspace = np.vstack([nullspace, vectors])
    return _from_nullspace(columns, nullspace, dropped)


def _across(joint: Joint, parent: _Link, robot: Robot) -> tuple[Array, _Link]:
    """Transfers across one joint (each row: ten parameters, IA, OFF where the robot has them), and its link."""
    axis = np.eye(6)[2 if joint.revolute else 5]
    # The 6 x 6 matrix of the cross product of velocities, d/dq of a vector fixed outside being minus it.
    v, w = skew(axis[:3]), skew(axis[3:])
    X, moving = _velocity_transform(joint), np.block([[v, np.zeros((3, 3))], [w, v]])
    gravity = X @ parent.gravity
    velocities = _span(*_orbit(X @ parent.velocities, moving, joint))
    swings = _span(*_orbit(X @ parent.swings, moving, joint), *_orbit(gravity[:, None], moving, joint)[1:])
    turned = _tens(-moving.T @ _UNITS - _UNITS @ moving)
    visible = _orbit((parent.detectable @ _transfer(joint)).T, turned, joint)
    invariant = _span(*visible[1:]).T

    coupled = _functionals(np.column_stack([velocities, swings]), axis)
    own = _functionals(np.column_stack([axis, gravity]), axis)
    link = _Link(np.column_stack([velocities, axis]), gravity, swings, _span(*visible, coupled.T, own.T).T)
    return _unseen(np.vstack([coupled, invariant]), own, robot), link


def _unseen(hidden: Array, own: Array, robot: Robot) -> Array:
    """Vectors under the conditions: rows of ``hidden`` give zero, the two of ``own`` are balanced by IA and OFF."""
    conditions = np.block([[hidden, np.zeros((len(hidden), 2))], [own, np.eye(2)]])
    columns = [*range(10)] + [10] * robot.drives.rotor_inertia + [11] * robot.drives.offsets
    return _nullspace(conditions[:, columns])


def _velocity_transform(joint: Joint) -> Array:
    """Velocity of link j from that of link j-1 at q = 0, 6 x 6."""
    R, p = _frame(joint)
    return np.block([[R.T, np.zeros((3, 3))], [-R.T @ skew(p), R.T]])


def _frame(joint: Joint) -> tuple[Array, Array]:
    """Axes and origin of frame j in frame j-1 at q = 0: turn and shift along x, then along z."""
    (ca, sa), (ct, st) = cos_sin(joint.alpha), cos_sin(joint.theta)
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, ca, -sa], [0.0, sa, ca]])
    about_z = np.array([[ct, -st, 0.0], [st, ct, 0.0], [0.0, 0.0, 1.0]])
    return about_x @ about_z, np.array([joint.d, 0.0, 0.0]) + joint.r * about_x[:, 2]


def _transfer(joint: Joint) -> Array:
    """Ten parameters of a body of link j as part of link j-1 at q = 0, 10 x 10."""
    X = _velocity_transform(joint)
    return _tens(X.T @ _UNITS @ X).T


def _spatial_inertia(ten: Array) -> Array:
    body = InertialParameters(ten)
    across = skew(body.first_moments)
    return np.block([[body.inertia, across], [-across, body.mass * np.eye(3)]])


def _tens(inertias: Array) -> Array:
    """Inverse of ``_spatial_inertia`` for many: count x 6 x 6 to count x 10."""
    rows, columns = np.array([(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2), (2, 4), (0, 5), (1, 3), (3, 3)]).T
    return np.asarray(inertias[:, rows, columns])


_UNITS = np.array([_spatial_inertia(unit) for unit in np.eye(10)])


def _functionals(vectors: Array, axis: Array) -> Array:
    """Rows that take ten parameters to v' I S, one for each column v."""
    return np.asarray(np.einsum("iv,kij,j->vk", vectors, _UNITS, axis))


def _orbit(vectors: Array, operator: Array, joint: Joint) -> list[Array]:
    """Span of exp(q operator) applied to the columns, for all q: first what stays, then what changes with q.

    About a revolute axis the images are constant plus first and second harmonics of q, along a prismatic axis
    polynomials in q of second degree. Taking these apart is exact where repeated images would pile up rounding.
    """
    once = operator @ vectors
    twice = operator @ once
    if not joint.revolute:
        return [vectors, once, twice]
    fourth = operator @ (operator @ twice)
    first, second = -(fourth + 4.0 * twice) / 3.0, (fourth + twice) / 12.0
    return [vectors - first - second, first, operator @ first, second, operator @ second]


def _span(*vectors: Array) -> Array:
    """Orthonormal basis of all columns."""
    left, values, _ = np.linalg.svd(np.column_stack(vectors), full_matrices=False)
    return np.asarray(left[:, values > _ZERO])


def _nullspace(rows: Array) -> Array:
    """Vectors that all the rows send to zero, in rows."""
    space = _span(rows.T)
    full = np.linalg.svd(space)[0]
    return np.asarray(full[:, space.shape[1] :].T)


def _from_nullspace(columns: tuple[str, ...], nullspace: Array, dropped: list[int]) -> BaseParameters:
    basis = np.setdiff1d(np.arange(len(columns)), dropped)
    grouping = np.zeros((len(basis), len(columns)))
    grouping[:, basis] = np.eye(len(basis))
    grouping[:, dropped] = -np.linalg.solve(nullspace[:, dropped], nullspace[:, basis]).T
    return BaseParameters(columns, tuple(basis.tolist()), grouping)


def _last_entries(unseen: Array) -> list[int]:
    """Columns in which some combination of the rows has its last entry: they depend on columns to their left."""
    ranks = [np.linalg.matrix_rank(unseen[:, k:], tol=_ZERO) for k in range(unseen.shape[1])]
    return [int(k) for k in np.flatnonzero(np.diff([*ranks, 0]))]


class Comparison(NamedTuple):
    """One robot by each way: equal names, largest difference of groupings, and of ||W - W_base G|| / ||W||.

    Largest residual of a column that QR rejects, smallest of one that it accepts; how often each rule was applied.
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
        Counter(rule for rule, *_ in moves(robot)) if any(robot.gravity) else Counter(),
    )


def _model_error(base: BaseParameters, R: Array) -> float:
    return float(np.linalg.norm(R - R[:, list(base.chosen)] @ base.grouping) / np.linalg.norm(R))
