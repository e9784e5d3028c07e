"""Least squares whose columns have roles: wanted, free, known from elsewhere, or held near what is known of them.

One solution for all: values, covariance (17)-(19) with the share of what is known, derivatives by the drive gains,
and the part of the covariance that no block of time shows.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

from ...common.arrays import Array
from ..equations.equations import Equations, triangular
from ..equations.shared_torque import compressed
from .drive_gains import motor_torques
from .estimate import Estimate, Fit, fit
from .least_squares import Solution, checked, joint_weights, solve, solve_triangle
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
        """Weight of the equation, in units of weighted rows."""
        return float(np.sqrt(self.inflation)) / self.sigma


class Prior(NamedTuple):
    """Parameters known from elsewhere that the recordings correct, as far as their covariance leaves it to them.

    ``covariance``: c x c, of full rank; ``inflation`` as of ``Held``; the rest as of ``Known``.
    """

    names: tuple[str, ...]
    values: Array
    covariance: Array
    inflation: float = 1.0
    degrees_of_freedom: float = float("inf")
    gain_sensitivity: Callable[[], Array | None] = lambda: None

    @property
    def known(self) -> Known:
        """The parameters as they stand."""
        return Known(*self[:3], self.covariance, self.degrees_of_freedom, self.gain_sensitivity)

    @property
    def root(self) -> Array:
        """Rows of the equations, in units of weighted rows: root' root: the covariance's inverse, inflated."""
        scale = np.sqrt(np.diag(self.covariance))
        L = np.linalg.cholesky(self.covariance / np.outer(scale, scale))
        inverse = solve_triangular(L, np.eye(len(L)), lower=True)
        return np.asarray(np.sqrt(self.inflation) * inverse / scale)


class _Pulls(NamedTuple):
    """Equations beside the recordings: ``rows`` m x c in the unknown columns, ``levels`` and ``inflation`` (m,).

    ``by_gains``: derivatives of the levels by e_j, m x n; zeros where they are not known.
    """

    rows: Array
    levels: Array
    inflation: Array
    by_gains: Array


class _Triangle(NamedTuple):
    """Weighted equations after a QR: ``R`` of the unknown columns and the torque, the ``inverse`` of its first c.

    ``influences``: how the unknown parameters move with each known group, but for the sign: P = W_L^+ W;
    ``by_torques``: how they move with each motor's torque, c x n.
    """

    R: Array
    inverse: Array
    influences: tuple[Array, ...]
    by_torques: Array


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
        pulls = np.column_stack([self._pulls.rows, self._pulls.levels])
        ordinary = solve(np.vstack([*self.unknown.factors, pulls]), self.unknown.columns, *self._rows)
        return joint_weights(self.unknown, ordinary.values)

    def values(self, weights: Array) -> Array:
        """The wanted values for given weights; linear in the torques."""
        R, c = self._triangle(weights).R, len(self.unknown.columns)
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
        for group, P in zip(self.known, self._triangle(weights).influences, strict=True):
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
            gain_sensitivity=self.gain_sensitivity(weights),
        )

    def solved(self, weights: Array | None = None) -> Estimate:
        """The wanted parameters alone."""
        return self.estimate(weights).part(self.wanted)

    def lasting(self, weights: Array) -> Array:
        """Covariance of the wanted parameters that no block of time shows: of known, held and prior parameters."""
        total, triangle = np.zeros((len(self.wanted), len(self.wanted))), self._triangle(weights)
        for group, influence in zip(self.known, triangle.influences, strict=True):
            P = influence[self._places]
            total += P @ group.lasting @ P.T
        pulls = self._pulls
        if len(pulls.rows):
            inverse = triangle.inverse
            moved = (inverse[self._places] @ (inverse.T @ pulls.rows.T)) * np.sqrt(pulls.inflation)
            total += moved @ moved.T
        return total

    def remembered(self, weights: Array, inflation: Sequence[float]) -> Array:
        """Covariance of the wanted parameters where each joint's errors remember, ``lasting`` among it: a sandwich.

        Args:
            weights: of the joints.
            inflation: of each joint's errors, by their memory, n.
        """
        unknown, c, triangle = self.unknown, len(self.unknown.columns), self._triangle(weights)
        inverse = triangle.inverse
        values = inverse @ triangle.R[:c, c]
        share = max(1.0 - c / max(unknown.equations + len(self._pulls.rows), 1), 1e-3)
        errors = unknown.error_norms(values) / np.sqrt(np.maximum(unknown.rows, 1) * share)
        sizes = weights**2 * errors * np.sqrt(np.asarray(inflation))
        noise = triangular(
            np.vstack([size * factor[:, :-1] for size, factor in zip(sizes, unknown.factors, strict=True)])
        )
        moved = inverse[self._places] @ (inverse.T @ noise.T)
        total = moved @ moved.T + self.lasting(weights)
        for group, influence in zip(self.known, triangle.influences, strict=True):
            if not group.lasting.any():  # of recordings that remember as well
                P = influence[self._places]
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
        by_gains = [np.zeros((len(rows), len(self.equations.factors)))]
        if self.prior is not None:
            root, wide = self.prior.root, np.zeros((len(self.prior.names), c))
            wide[:, [columns.index(name) for name in self.prior.names]] = root
            rows.append(wide)
            levels = np.concatenate([levels, root @ self.prior.values])
            inflation += [self.prior.inflation] * len(root)
            own = self.prior.gain_sensitivity()
            by_gains.append(root @ own if own is not None else np.zeros((len(root), by_gains[0].shape[1])))
        return _Pulls(np.vstack([np.zeros((0, c)), *rows]), levels, np.array(inflation), np.vstack(by_gains))

    def _triangle(self, weights: Array) -> "_Triangle":
        """The weighted equations of all joints, those of what is held below; decomposed once for given weights.

        Raises:
            InputError: if they leave a parameter undetermined.
        """
        key = weights.tobytes()
        if key not in self._triangles:
            self._triangles[key] = self._decomposed(weights)
        return self._triangles[key]

    @cached_property
    def _triangles(self) -> "dict[bytes, _Triangle]":
        return {}

    def _decomposed(self, weights: Array) -> "_Triangle":
        groups, pulls, n = self.known, self._pulls, len(self.equations.factors)
        names = list(chain.from_iterable(group.names for group in groups))
        places = [self.equations.columns.index(name) for name in names]
        torques = map(np.column_stack, zip(*(motor_torques(self.equations, j) for j in range(n)), strict=True))
        every = zip(weights, self.unknown.factors, self.equations.factors, torques, strict=True)
        rows = [w * np.column_stack([own, factor[:, places], torque]) for w, own, factor, torque in every]
        pulled = np.column_stack(
            [pulls.rows, pulls.levels, np.zeros((len(pulls.rows), len(names))), pulls.by_gains]
        )
        R, beside = compressed(np.vstack([*rows, pulled]), len(names) + n)
        R, c = checked(R, self.unknown.columns, *self._rows), len(self.unknown.columns)
        solved = solve_triangular(R[:c, :c], np.column_stack([np.eye(c), beside[:c]]))
        ends = c + np.cumsum([0, *(len(group.names) for group in groups)])
        inverse, *influences, by_torques = np.split(solved, ends, axis=1)
        return _Triangle(R, inverse, tuple(influences), by_torques)

    def _solution(self, weights: Array) -> Solution:
        return solve_triangle(self._triangle(weights).R, self._rows[1])

    @property
    def _rows(self) -> tuple[int, float]:
        """Number of equations, and of those with independent noise."""
        count = len(self._pulls.rows)
        return self.unknown.equations + count, sum(self.unknown.effective_rows) + count

    def _fit(self, values: Array) -> Fit:
        value = dict(zip(self.unknown.columns, values.tolist(), strict=True))
        for group in self.known:
            value |= zip(group.names, group.values.tolist(), strict=True)
        equations = self.shown or self.equations
        if self.alone:
            others = [name for name in equations.columns if name not in self.wanted]
            equations = equations.minus(others, np.array([value[name] for name in others]))
        return fit(equations, np.array([value[name] for name in equations.columns]))

    def gain_sensitivity(self, weights: Array) -> Array | None:
        """Derivatives of the solution by e_j, weights fixed, c x n; exact, it is linear in Y.

        Without a known spring they add up to the solution: an error common to all joints scales it. Known
        parameters were identified with the same drives, so with the same errors; None where theirs are not known.
        """
        own = [group.gain_sensitivity() for group in self.given]
        triangle = self._triangle(weights)
        total = triangle.by_torques
        for influence, derivatives in zip(triangle.influences, own, strict=False):
            if derivatives is not None:
                total = total - influence @ derivatives
        return None if any(derivatives is None for derivatives in own) else total


def _in_turn(known: Known) -> Array:
    """Values without each of their own blocks, last of all the whole ones."""
    parts = known.left_out()
    return known.values[None] if parts is None else np.vstack([parts, known.values])


def gain_sensitivity(equations: Equations, weights: Array) -> Array:
    """Derivatives of a weighted least-squares solution by e_j, weights fixed, c x n.

    Raises:
        InputError: if the equations leave a parameter undetermined.
    """
    derivatives = LinearProblem(equations, equations.columns).gain_sensitivity(weights)
    assert derivatives is not None  # nothing is known from elsewhere
    return derivatives
