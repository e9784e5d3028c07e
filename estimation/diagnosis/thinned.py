"""Method 4 on thinned states, and what one more column would say: how large it is, and what it moves.

Gram matrices of columns scaled to norm 1 are good enough for that, and fast. Standard deviations leave out one
block of time after another.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Robot
from ...model.many_states import own_columns, regressor_at
from ...model.regressors import payload_columns
from ...model.visibility import friction_columns
from ..equations.equations import PAYLOAD
from ..fit.roles import Prior
from ..payload.problem import PayloadProblem
from ..payload.result import frame_change
from ..signals.rows import Mask
from .states import BLOCKS, Places, States

_RANK = 1e-10  # of the largest eigenvalue: squares of columns, scaled to norm 1
_HELD = 1e-6  # share of a direction that the other blocks must hold
_NOTHING = 1e-20  # of the largest column's square: rounding
_FLOOR = 1e-9  # of a joint's torque: data without noise still need finite weights


class Answer(NamedTuple):
    """What columns are found to be: ``values`` (k,) with ``covariance``; ``effect``: of each on the ten, 10 x k.

    Variances are nan where nothing shows a column.
    """

    values: Array
    covariance: Array
    effect: Array

    @property
    def z(self) -> float:
        """Standard deviations by which they differ from zero, all together; 0 where nothing shows them."""
        if not np.isfinite(self.covariance).all():
            return 0.0
        squares = float(self.values @ np.linalg.pinv(self.covariance) @ self.values)
        return float(np.sqrt(max(squares, 0.0)))


@dataclass(frozen=True, eq=False)
class Thinned:
    """Robot and payload together on thinned states.

    Attributes:
        states: what is looked at.
        names: of the robot's columns.
        columns: the robot's, the payload's ten in its frame, and what friction changes by under load, n x c x N.
        torque: less what is known of the robot [N·m or N], n x N.
        keep: rows that are used, n x N.
        known: the robot's values where it was identified earlier, else zero; of the robot's columns.
        pulls: Gram matrix of equations beside the recordings, c x c.
        inflation: by how much memory raises the variances that these equations leave.
    """

    robot: Robot
    states: States
    names: tuple[str, ...]
    columns: Array
    torque: Array
    keep: Mask
    known: Array
    pulls: Array
    inflation: float = 1.0

    @property
    def payload(self) -> slice:
        """Where the payload's ten stand; nowhere where nothing hangs on the robot."""
        ten = len(PAYLOAD) if self.states.loaded.any() else 0
        return slice(len(self.names), len(self.names) + ten)

    @cached_property
    def weights(self) -> Array:
        """Weights of the joints, by what the friction of the robot alone leaves [1/(N·m) or 1/N], shape (n,)."""
        rms = np.ones(self.robot.n)
        for _ in range(2):
            values = self._plain(1.0 / rms)
            error = np.where(self.keep, self.torque - np.einsum("jcn,c->jn", self.columns, values), 0.0)
            rows = np.maximum(self.keep.sum(axis=1), 1)
            size = np.sqrt(np.sum(np.where(self.keep, self.torque, 0.0) ** 2, axis=1) / rows)
            rms = np.sqrt(np.sum(error**2, axis=1) / rows) + _FLOOR * size + 1e-300
            rms[~self.keep.any(axis=1)] = 1.0
        return np.asarray(1.0 / rms)

    @cached_property
    def values(self) -> Array:
        """Robot and payload, those that nothing shows zero; shape (c,)."""
        values = self._plain(self.weights)
        values[: len(self.names)] += self.known
        return values

    def _plain(self, weights: Array) -> Array:
        """The solution with friction as it was."""
        c = self.payload.stop
        gram = self._grams(weights, np.zeros((self.robot.n, 0, self.columns.shape[2])), self.states.block * 0, 1)[0]
        gram[:-1, :-1] += self.pulls
        root = _whitening(gram[:c, :c])
        return np.concatenate([root @ (root.T @ gram[:c, -1]), np.zeros(len(gram) - 1 - c)])

    def _grams(self, weights: Array, extras: Array, groups: Places, count: int) -> Array:
        """Gram matrices of all columns, extras and the torque, by groups of states that rise; count x C x C."""
        rows = np.concatenate([self.columns, extras, self.torque[:, None]], axis=1)
        rows = (rows * (weights[:, None] * self.keep)[:, None]).transpose(1, 0, 2)
        edges = np.searchsorted(groups, np.arange(count + 1))
        grams = np.zeros((count, len(rows), len(rows)))
        for k in range(count):
            own = rows[:, :, edges[k] : edges[k + 1]].reshape(len(rows), -1)
            grams[k] = own @ own.T
        return grams

    def with_columns(self, extras: Array) -> "Asked":
        """One more column for each of some torques, n x m x N."""
        blocks = self._grams(self.weights, extras, self.states.block, BLOCKS)
        whole, c = blocks.sum(axis=0), self.columns.shape[1]
        whole[:c, :c] += self.pulls
        root = _whitening(whole[:c, :c])
        left = np.array([_rest(whole - block, root) for block in blocks])
        return Asked(_rest(whole, root), left, (root @ (root.T @ whole[:c, c:]))[self.payload], self.inflation)

    def without_stretches(self, worse: float) -> tuple[int, int, Array]:
        """Leave out stretches of 3 s whose mean squared residual is ``worse`` times the median.

        Returns:
            How many, of how many, and by how much the payload's ten change, (10,).
        """
        count = int(self.states.stretch[-1]) + 1
        none = np.zeros((self.robot.n, 0, self.columns.shape[2]))
        grams = self._grams(self.weights, none, self.states.stretch, count)
        whole = grams.sum(axis=0)
        whole[:-1, :-1] += self.pulls
        values = _solution(whole)
        error = np.append(-values, 1.0)
        rows = np.bincount(self.states.stretch, self.keep.sum(axis=0), count)
        means = np.einsum("i,kij,j->k", error, grams, error)[rows > 0] / rows[rows > 0]
        high = means > worse * np.median(means)
        rest = whole - grams[rows > 0][high].sum(axis=0)
        change = (_solution(rest) - values)[self.payload]
        return int(high.sum()), len(means), change

    def of_difference(self) -> "Thinned":
        """Method 3: the payload alone, with payload, as if the robot's own torque were taken off."""
        own = slice(len(self.names), None)
        return replace(
            self,
            names=(),
            columns=self.columns[:, own],
            keep=self.keep & (self.states.loaded > 0.0),
            torque=self.torque - np.einsum("jcn,c->jn", self.columns[:, : own.start], self.values[: own.start]),
            known=self.known[:0],
            pulls=self.pulls[own, own],
        )


class Asked(NamedTuple):
    """What columns leave of more columns and of the torque.

    ``whole``: their Gram matrix, torque last; ``left``: without each block of time; ``shares``: of the payload's
    ten in each column and the torque, 10 x (m + 1); ``inflation`` as of ``Thinned``.
    """

    whole: Array
    left: Array
    shares: Array
    inflation: float = 1.0

    def fall(self, *places: int, beside: tuple[int, ...] = ()) -> float:
        """Share of the squared residual that some of the columns take off, others free beside them."""
        falls = [
            float(self.whole[k, -1] @ _inverse(self.whole[np.ix_(k, k)]) @ self.whole[k, -1])
            for k in ([*places, *beside], list(beside))
        ]
        return (falls[0] - falls[1]) / max(float(self.whole[-1, -1]), 1e-300)

    def of(self, *places: int, beside: tuple[int, ...] = ()) -> Answer:
        """Some of the columns, others free beside them as far as these are more than rounding."""
        squares = np.diag(self.whole)
        beside = tuple(k for k in beside if squares[k] > _RANK * squares[list(places)].max())
        every, k = [*places, *beside], len(places)
        inverse = _inverse(self.whole[np.ix_(every, every)])
        values = (inverse @ self.whole[every, -1])[:k]
        each = [(_inverse(gram[np.ix_(every, every)]) @ gram[every, -1])[:k] - values for gram in self.left]
        changes = np.array(each)
        covariance = (1.0 - 1.0 / len(changes)) * changes.T @ changes
        variances = self.inflation * np.diag(inverse)[:k]
        sigma, formula = np.sqrt(np.diag(covariance)), np.sqrt(np.where(variances > 0.0, variances, np.nan))
        wider = np.maximum(1.0, formula / np.maximum(sigma, 1e-300))
        free = _inverse(self.whole[np.ix_(beside, beside)]) @ self.whole[np.ix_(beside, places)]
        effect = -(self.shares[:, list(places)] - self.shares[:, list(beside)] @ free)
        return Answer(values, covariance * np.outer(wider, wider), effect)


def thinned_problem(problem: PayloadProblem, states: States | None) -> Thinned | None:
    """A payload problem on thinned states; None where there are none, or the robot is neither shown nor known."""
    if states is None or (problem.known is not None and not problem.inflation):
        return None
    bare = problem.source is not None and bool(problem.source.unloaded)
    changes = {name: role.weight for name, role in problem.friction.items()}
    if problem.short is not None:
        names = friction_columns(problem.robot.with_offsets(True))
        changes = dict.fromkeys(names, 0.0) | {name: role.weight for name, role in problem.short.held.held.items()}
    try:
        return thinned(problem.robot, states, changes, None if bare else problem.robot_prior)
    except InputError:  # a joint leaves the table of its spring
        return None


def thinned_robot(robot: Robot, states: States | None) -> Thinned | None:
    """A robot without payload on thinned states; None where there are none."""
    if states is None:
        return None
    try:
        return thinned(robot, states, {})
    except InputError:  # a joint leaves the table of its spring
        return None


def thinned(robot: Robot, states: States, changes: Mapping[str, float], known: Prior | None = None) -> Thinned:
    """Robot and payload on thinned states.

    Args:
        changes: frictions that may be others under load, and the weight of the equation that holds each at zero, 0
            for none.
        known: the robot's parameters from an earlier identification.
    """
    sample, wide = states.sample, robot.with_offsets(True)
    own = known.names if known is not None else own_columns(robot)
    payload = payload_columns(robot) if states.loaded.any() else ()
    rubs = tuple(changes) if payload else ()
    names = tuple(dict.fromkeys((*own, *payload, *rubs)))
    W = regressor_at(wide, names, sample.q, sample.qd, sample.qdd)
    heavy, rubbing = (W[:, [names.index(name) for name in some]] * states.loaded for some in (payload, rubs))
    if payload:
        heavy = np.einsum("jcn,cd->jdn", heavy, frame_change(robot.flange))
    columns = np.concatenate([W[:, : len(own)], heavy, rubbing], axis=1)
    torque = np.array(sample.torque.T)
    if robot.spring is not None:
        k = robot.spring.joint - 1
        torque[k] = torque[k] + robot.spring.torque(sample.q[:, k])
    values = np.zeros(len(own)) if known is None else known.values
    pulls = np.zeros((columns.shape[1],) * 2)
    if known is not None:
        pulls[: len(own), : len(own)] = known.root.T @ known.root
    places = np.arange(len(own) + len(payload), len(pulls))
    pulls[places, places] = [changes[name] ** 2 for name in rubs]
    torque -= np.einsum("jcn,c->jn", W[:, : len(own)], values)
    inflation = known.inflation if known is not None else 1.0
    return Thinned(robot, states, tuple(own), columns, torque, sample.keep.T, values, pulls, inflation)


def _whitening(gram: Array) -> Array:
    """K with K K' the inverse of a Gram matrix, as far as it determines its columns; c x r."""
    squares = np.diag(gram)
    size = np.sqrt(np.where(squares > _NOTHING * squares.max(initial=0.0), squares, np.inf))
    eigenvalues, V = np.linalg.eigh(gram / np.outer(size, size))
    significant = eigenvalues > _RANK * eigenvalues[-1]
    return np.asarray(V[:, significant] / np.sqrt(eigenvalues[significant]) / size[:, None])


def _solution(gram: Array) -> Array:
    root = _whitening(gram[:-1, :-1])
    return np.asarray(root @ (root.T @ gram[:-1, -1]))


def _rest(gram: Array, root: Array) -> Array:
    """Gram matrix of the last columns less all that the first ones explain; ``root`` makes these nearly white."""
    c = len(root)
    white, right = root.T @ gram[:c, :c] @ root, root.T @ gram[:c, c:]
    try:
        L = np.linalg.cholesky(white)
        clear = bool(np.diag(L).min(initial=1.0) ** 2 > _HELD)
    except np.linalg.LinAlgError:
        clear = False
    if clear:
        explained = solve_triangular(L, right, lower=True)
    else:
        eigenvalues, V = np.linalg.eigh(white)
        significant = eigenvalues > _HELD
        explained = (V[:, significant] / np.sqrt(eigenvalues[significant])).T @ right
    return np.asarray(gram[c:, c:] - explained.T @ explained)


def _inverse(gram: Array) -> Array:
    """Inverse of a small Gram matrix, columns of which nothing is left taken out."""
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    return np.asarray(np.linalg.pinv(gram / np.outer(size, size), 1e-12, hermitian=True) / np.outer(size, size))
