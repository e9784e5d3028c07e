"""Least squares whose columns have roles: wanted, free, known from elsewhere, or held near zero.

One solution for all: values, covariance (17)-(19) with the share of what is known, derivatives by the drive gains,
and the part of the covariance that no block of time shows.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

from ...common.arrays import Array
from ...common.linear import least_squares
from ..equations.equations import Equations, triangular
from .drive_gains import motor_torques
from .estimate import Estimate, Fit, fit
from .least_squares import Solution, checked, joint_weights, solve
from .left_out import left_out


class Known(NamedTuple):
    """Parameters whose torque is taken off, and how sure they are.

    ``covariance``: part of the formula's, c x c; ``lasting``: what no block of time shows of it, zero where the
    blocks hold the recordings that the parameters come from; ``degrees_of_freedom``; ``gain_sensitivity``:
    gives derivatives by the relative error of each motor's torque, c x n, None where they are not known;
    ``left_out``: gives the values without each of the blocks that they come from, B x c, none by default.
    """

    names: tuple[str, ...]
    values: Array
    covariance: Array
    lasting: Array
    degrees_of_freedom: float = float("inf")
    gain_sensitivity: Callable[[], Array | None] = lambda: None
    left_out: Callable[[], Array | None] = lambda: None


class Held(NamedTuple):
    """How a parameter is held near zero.

    ``sigma``: its standard deviation; ``inflation``: by how much the memory of the errors raises the variance that
    white noise would give what the recordings say of it. One more equation counts for as much as that allows.
    """

    sigma: float
    inflation: float = 1.0

    @property
    def weight(self) -> float:
        """Of the equation, in units of weighted rows."""
        return float(np.sqrt(self.inflation)) / self.sigma


@dataclass(frozen=True, eq=False)
class LinearProblem:
    """Equations and the roles of their columns; a column without a role is free, estimated beside the wanted ones.

    Attributes:
        equations: in all the columns.
        wanted: the parameters that are asked for.
        known: parameters known from elsewhere, group by group.
        held: parameters that are near zero: one more equation for each.
        shown: equations in the same columns whose torques the fit is told of; all by default.
    """

    equations: Equations
    wanted: tuple[str, ...]
    known: tuple[Known, ...] = ()
    held: Mapping[str, Held] = field(default_factory=dict)
    shown: Equations | None = None

    @cached_property
    def unknown(self) -> Equations:
        """The equations in the wanted and the free columns alone."""
        equations = self.equations
        for group in self.known:
            equations = equations.minus(group.names, group.values)
        return equations

    def weights(self) -> Array:
        """Weights of the joints by their errors in the ordinary solution, shape (n,)."""
        ordinary = self._solution(np.ones(len(self.unknown.factors)))
        return joint_weights(self.unknown, ordinary.values)

    def values(self, weights: Array) -> Array:
        """The wanted values for given weights; linear in the torques."""
        R, c = self._factor(weights), len(self.unknown.columns)
        return np.asarray(solve_triangular(R[:c, :c], R[:c, c])[self._places])

    def without_blocks(self, weights: Array, pairs: Sequence[tuple[int, int]]) -> Array:
        """The wanted values without a block of these equations and one of those that known parameters come from.

        Args:
            weights: of the joints, shape (n,).
            pairs: which blocks, -1 for none; without known parameters the equations' own blocks in their order.

        Raises:
            InputError: if what is left does not determine the parameters.
        """
        names = tuple(chain.from_iterable(group.names for group in self.known))
        near = {name: held.weight for name, held in self.held.items()}
        values = left_out(self.equations, self.unknown.columns, weights, names, near).values[:, self._places]
        if not self.known:
            return np.asarray(values[: len(pairs), :, 0])
        known = np.concatenate([_in_turn(group) for group in self.known], axis=1)
        return np.array([values[a, :, -1] - values[a, :, :-1] @ known[min(b, len(known) - 1)] for a, b in pairs])

    def estimate(self, weights: Array | None = None) -> Estimate:
        """All unknown parameters, with what is known to be part of their error.

        Args:
            weights: per joint [1/(N·m) or 1/N], shape (n,); by default from its error in the ordinary solution.

        Raises:
            InputError: if the equations leave a parameter undetermined.
        """
        weights = self.weights() if weights is None else weights
        solution = self._solution(weights)
        covariance = solution.covariance
        for group in self.known:
            P = self._influence(group, weights)
            covariance = covariance + P @ group.covariance @ P.T
        return Estimate(
            names=self.unknown.columns,
            values=solution.values,
            covariance=covariance,
            degrees_of_freedom=min(
                [solution.degrees_of_freedom, *(group.degrees_of_freedom for group in self.known)]
            ),
            fit=self._fit(solution.values),
            weights=weights,
            gain_sensitivity=self._gain_sensitivity(weights),
        )

    def solved(self, weights: Array | None = None) -> Estimate:
        """The wanted parameters alone."""
        return self.estimate(weights).part(self.wanted)

    def lasting(self, weights: Array) -> Array:
        """Covariance of the wanted parameters that no block of time shows: of known and of held parameters."""
        total = np.zeros((len(self.wanted), len(self.wanted)))
        for group in self.known:
            P = self._influence(group, weights)[self._places]
            total += P @ group.lasting @ P.T
        if self.held:
            c = len(self.unknown.columns)
            inverse = solve_triangular(self._factor(weights)[:c, :c], np.eye(c))
            places = [self.unknown.columns.index(name) for name in self.held]
            pull = np.array([held.weight**2 * held.sigma for held in self.held.values()])
            moved = (inverse @ inverse.T)[self._places][:, places] * pull
            total += moved @ moved.T
        return total

    @property
    def _places(self) -> list[int]:
        return [self.unknown.columns.index(name) for name in self.wanted]

    def _stacked(self, weights: Array) -> Array:
        """Weighted factor of all joints in the unknown columns, the held ones' equations below."""
        rows = self.unknown.stacked(weights)
        places = [self.unknown.columns.index(name) for name in self.held]
        own = np.zeros((len(places), rows.shape[1]))
        own[range(len(places)), places] = [held.weight for held in self.held.values()]
        return np.vstack([rows, own])

    def _factor(self, weights: Array) -> Array:
        return checked(self._stacked(weights), self.unknown.columns, *self._rows)

    def _solution(self, weights: Array) -> Solution:
        return solve(self._stacked(weights), self.unknown.columns, *self._rows)

    @property
    def _rows(self) -> tuple[int, float]:
        """Number of equations, and of those with independent noise."""
        return self.unknown.equations + len(self.held), sum(self.unknown.effective_rows) + len(self.held)

    def _influence(self, group: Known, weights: Array) -> Array:
        """How the unknown parameters move with known ones, but for the sign: P = W_L^+ W."""
        order = (*group.names, *self.unknown.columns)
        factor, k = self.equations.select(order).stacked(weights), len(group.names)
        W, W_L = factor[:, :k], factor[:, k:-1]
        if self.held:
            W_L = np.vstack([W_L, self._stacked(weights)[-len(self.held) :, :-1]])
            W = np.vstack([W, np.zeros((len(self.held), k))])
        return least_squares(W_L, W)

    def _fit(self, values: Array) -> Fit:
        value = dict(zip(self.unknown.columns, values.tolist(), strict=True))
        for group in self.known:
            value |= zip(group.names, group.values.tolist(), strict=True)
        shown = self.shown or self.equations
        return fit(shown, np.array([value[name] for name in shown.columns]))

    def _gain_sensitivity(self, weights: Array) -> Array | None:
        taken = []
        for group in self.known:
            derivatives = group.gain_sensitivity()
            if derivatives is None:
                return None
            taken.append((group.names, derivatives))
        return gain_sensitivity(self.equations, weights, taken, self.held)


def _in_turn(known: Known) -> Array:
    """Values without each of their own blocks, last of all the whole ones."""
    parts = known.left_out()
    return known.values[None] if parts is None else np.vstack([parts, known.values])


def gain_sensitivity(
    equations: Equations,
    weights: Array,
    known: Sequence[tuple[Sequence[str], Array]] = (),
    held: Mapping[str, Held] | None = None,
) -> Array:
    """Derivatives of a weighted least-squares solution by e_j, weights fixed, c x n; exact, it is linear in Y.

    Without a known spring they add up to the solution: an error common to all joints scales it.

    Args:
        equations: with the torques as measured.
        weights: of the joints.
        known: parameters whose torque is taken off, and their own derivatives, c_k x n: they were identified with
            the same drives, so with the same errors.
        held: as of ``LinearProblem``.
    """
    gone = set(chain.from_iterable(names for names, _ in known))
    columns = [name for name in equations.columns if name not in gone]
    places, c, n = [equations.columns.index(name) for name in columns], len(columns), len(equations.factors)
    motors = (motor_torques(equations, j) for j in range(n))
    torques = map(np.column_stack, zip(*motors, strict=True))
    parts = [([equations.columns.index(name) for name in names], derivatives) for names, derivatives in known]
    rows = []
    for factor, torque, weight in zip(equations.factors, torques, weights, strict=True):
        taken = sum((factor[:, where] @ derivatives for where, derivatives in parts), np.zeros_like(torque))
        rows.append(weight * np.column_stack([factor[:, places], torque - taken]))
    rows += [one.weight * np.eye(1, c + n, columns.index(name)) for name, one in (held or {}).items()]
    R = triangular(np.vstack(rows))
    return np.asarray(solve_triangular(R[:c, :c], R[:c, c:]))
