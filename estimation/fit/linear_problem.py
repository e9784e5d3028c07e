"""Least squares whose columns have roles: wanted, free, known from elsewhere, or held near what is known of them.

One solution for all: values, covariance (17)-(19) with the share of what is known, derivatives by the drive gains,
and the part of the covariance that no block of time shows.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
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
from .roles import Held, Known, Prior


class _Pulls(NamedTuple):
    """Equations beside the recordings: ``rows`` m x c in the unknown columns, ``levels`` and ``inflation`` (m,)."""

    rows: Array
    levels: Array
    inflation: Array


@dataclass(frozen=True, eq=False)
class LinearProblem:
    """Equations and the roles of their columns; a column without a role is free, estimated beside the wanted ones.

    Attributes:
        equations: in all the columns.
        wanted: the parameters that are asked for.
        known: parameters known from elsewhere, group by group.
        held: parameters that are near zero: one more equation for each.
        prior: parameters near values that are known: as many equations more.
        shown: equations in the same columns on whose torques the fit is judged; all by default.
        alone: judge the fit on the wanted parameters' own torque, that of all others taken off.
    """

    equations: Equations
    wanted: tuple[str, ...]
    known: tuple[Known, ...] = ()
    held: Mapping[str, Held] = field(default_factory=dict)
    prior: Prior | None = None
    shown: Equations | None = None
    alone: bool = False

    @cached_property
    def unknown(self) -> Equations:
        """The equations in the wanted and the free columns alone."""
        equations = self.equations
        for group in self.known:
            equations = equations.minus(group.names, group.values)
        return equations

    def weights(self) -> Array:
        """Weights of the joints by their errors in the ordinary solution, (n,); a prior counts as it stands."""
        if self.prior is not None:
            return replace(self, known=(*self.known, self.prior.known), prior=None).weights()
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
        pulls = self._pulls
        near = np.column_stack([pulls.rows, np.zeros((len(pulls.rows), len(names))), pulls.levels])
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
                [solution.degrees_of_freedom, *(group.degrees_of_freedom for group in self.given)]
            ),
            fit=self._fit(solution.values),
            weights=weights,
            gain_sensitivity=self._gain_sensitivity(weights),
        )

    def solved(self, weights: Array | None = None) -> Estimate:
        """The wanted parameters alone."""
        return self.estimate(weights).part(self.wanted)

    def lasting(self, weights: Array) -> Array:
        """Covariance of the wanted parameters that no block of time shows: of known, held and prior parameters."""
        total = np.zeros((len(self.wanted), len(self.wanted)))
        for group in self.known:
            P = self._influence(group, weights)[self._places]
            total += P @ group.lasting @ P.T
        pulls = self._pulls
        if len(pulls.rows):
            c = len(self.unknown.columns)
            inverse = solve_triangular(self._factor(weights)[:c, :c], np.eye(c))
            moved = (inverse[self._places] @ (inverse.T @ pulls.rows.T)) * np.sqrt(pulls.inflation)
            total += moved @ moved.T
        return total

    def remembered(self, weights: Array, inflation: Sequence[float]) -> Array:
        """Covariance of the wanted parameters where each joint's errors remember, ``lasting`` among it: a sandwich.

        Args:
            weights: of the joints.
            inflation: of each joint's errors, by their memory, n.
        """
        unknown, c = self.unknown, len(self.unknown.columns)
        inverse = solve_triangular(self._factor(weights)[:c, :c], np.eye(c))
        values = inverse @ self._factor(weights)[:c, c]
        share = max(1.0 - c / max(unknown.equations + len(self._pulls.rows), 1), 1e-3)
        errors = unknown.error_norms(values) / np.sqrt(np.maximum(unknown.rows, 1) * share)
        sizes = weights**2 * errors * np.sqrt(np.asarray(inflation))
        noise = triangular(
            np.vstack([size * factor[:, :-1] for size, factor in zip(sizes, unknown.factors, strict=True)])
        )
        moved = inverse[self._places] @ (inverse.T @ noise.T)
        total = moved @ moved.T + self.lasting(weights)
        for group in self.known:
            if not group.lasting.any():  # of recordings that remember as well
                P = self._influence(group, weights)[self._places]
                total += float(np.median(inflation)) * P @ group.covariance @ P.T
        return np.asarray(total)

    @property
    def given(self) -> tuple[Known, ...]:
        """All that is known from elsewhere with its values."""
        return (*self.known, self.prior.known) if self.prior is not None else self.known

    @property
    def _places(self) -> list[int]:
        return [self.unknown.columns.index(name) for name in self.wanted]

    @cached_property
    def _pulls(self) -> _Pulls:
        columns, c = self.unknown.columns, len(self.unknown.columns)
        rows = [role.weight * np.eye(1, c, columns.index(name)) for name, role in self.held.items()]
        levels, inflation = np.zeros(len(rows)), [role.inflation for role in self.held.values()]
        if self.prior is not None:
            root, wide = self.prior.root, np.zeros((len(self.prior.names), c))
            wide[:, [columns.index(name) for name in self.prior.names]] = root
            rows.append(wide)
            levels = np.concatenate([levels, root @ self.prior.values])
            inflation += [self.prior.inflation] * len(root)
        return _Pulls(np.vstack([np.zeros((0, c)), *rows]), levels, np.array(inflation))

    def _stacked(self, weights: Array) -> Array:
        """Weighted factor of all joints in the unknown columns, equations of what is held below."""
        pulls = self._pulls
        return np.vstack([self.unknown.stacked(weights), np.column_stack([pulls.rows, pulls.levels])])

    def _factor(self, weights: Array) -> Array:
        return checked(self._stacked(weights), self.unknown.columns, *self._rows)

    def _solution(self, weights: Array) -> Solution:
        return solve(self._stacked(weights), self.unknown.columns, *self._rows)

    @property
    def _rows(self) -> tuple[int, float]:
        """Number of equations, and of those with independent noise."""
        count = len(self._pulls.rows)
        return self.unknown.equations + count, sum(self.unknown.effective_rows) + count

    def _influence(self, group: Known, weights: Array) -> Array:
        """How the unknown parameters move with known ones, but for the sign: P = W_L^+ W."""
        order = (*group.names, *self.unknown.columns)
        factor, k = self.equations.select(order).stacked(weights), len(group.names)
        W, W_L = factor[:, :k], factor[:, k:-1]
        pulls = self._pulls.rows
        return least_squares(np.vstack([W_L, pulls]), np.vstack([W, np.zeros((len(pulls), k))]))

    def _fit(self, values: Array) -> Fit:
        value = dict(zip(self.unknown.columns, values.tolist(), strict=True))
        for group in self.known:
            value |= zip(group.names, group.values.tolist(), strict=True)
        equations = self.shown or self.equations
        if self.alone:
            others = [name for name in equations.columns if name not in self.wanted]
            equations = equations.minus(others, np.array([value[name] for name in others]))
        return fit(equations, np.array([value[name] for name in equations.columns]))

    def _gain_sensitivity(self, weights: Array) -> Array | None:
        taken = []
        for group in self.known:
            derivatives = group.gain_sensitivity()
            if derivatives is None:
                return None
            taken.append((group.names, derivatives))
        pulls, n = self._pulls, len(self.equations.factors)
        levels = np.zeros((len(pulls.rows), n))
        if self.prior is not None:
            own = self.prior.gain_sensitivity()
            if own is None:
                return None
            levels[len(self.held) :] = self.prior.root @ own
        return gain_sensitivity(self.equations, weights, taken, np.column_stack([pulls.rows, levels]))


def _in_turn(known: Known) -> Array:
    """Values without each of their own blocks, last of all the whole ones."""
    parts = known.left_out()
    return known.values[None] if parts is None else np.vstack([parts, known.values])


def gain_sensitivity(
    equations: Equations,
    weights: Array,
    known: Sequence[tuple[Sequence[str], Array]] = (),
    pulls: Array | None = None,
) -> Array:
    """Derivatives of a weighted least-squares solution by e_j, weights fixed, c x n; exact, it is linear in Y.

    Without a known spring they add up to the solution: an error common to all joints scales it.

    Args:
        equations: with the torques as measured.
        weights: of the joints.
        known: parameters whose torque is taken off, and their own derivatives, c_k x n: they were identified with
            the same drives, so with the same errors.
        pulls: rows of equations that no motor's torque is in, in the columns that are left, and derivatives of what
            they say, m x (c + n).
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
    rows += [pulls] if pulls is not None else []
    R = triangular(np.vstack(rows))
    return np.asarray(solve_triangular(R[:c, :c], R[:c, c:]))
