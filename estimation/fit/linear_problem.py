"""Least squares whose columns have roles: wanted, free, fixed, or with a prior from what is known of them.

One solution for all: values, covariance (17)-(19) with the part of what is known, derivatives by the drive gains,
and the part of the covariance that no block of time shows.

Solutions without each block of time are the whole one downdated, weights fixed. With R the factor of
all weighted equations, A_b and Y_b those of block b, Q_b = A_b R^-1 and e_b = Y_b - A_b x, the solution without the
block is x - R^-1 S_b^-1 Q_b' e_b with S_b = 1 - Q_b'Q_b: what the others hold of each direction, 1 where the block
says nothing. Where a block holds next to all of one, S_b is rounding: the others' equations are then factored anew.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack, solve_triangular

from ...common import Array, Brief, InputError
from ..equations.equations import Equations, checked, compressed, triangular
from .estimate import Estimate, fit

_HELD = 1e-6  # fraction of a direction that the other blocks must hold: differences then keep ten digits


def left_out(
    equations: Equations,
    columns: Sequence[str],
    weights: Array,
    known: Sequence[str] = (),
    near: Array | None = None,
) -> list[tuple[Array, Array]]:
    """Solve for the parameters of some columns without each of the equations' blocks in turn, last by all of them.

    Gives values, c x m, and K, of which K K' is the parameters' covariance by the errors of Y, c x c.

    ``weights``: of the joints, (n,); ``known``: other columns, each a right-hand side of its own, the last of all m
    being Y; ``near``: further weighted equations that no block holds, in columns, known ones and Y.
    """
    names, c, solutions = tuple(columns), len(columns), list[tuple[Array, Array]]()
    indices = [*(equations.columns.index(name) for name in (*names, *known)), -1]
    near = np.zeros((0, len(indices))) if near is None else near

    def rows_of(*parts: Equations) -> Array:
        each = (w * own for part in parts for w, own in zip(weights, part.factors, strict=True))
        return np.vstack([near[:0], *(own[:, indices] for own in each)])

    def solved(rows: Array, count: Array) -> tuple[Array, Array, float]:
        """Solve by so many equations, and independent ones: values, inverse of R, and squared errors of Y."""
        R = checked(np.vstack([rows, near]), names, int(count[0]), float(count[1]))
        root = solve_triangular(R[:c, :c], np.eye(c))
        return root @ R[:c, c:], root, float(np.sum(R[c:, -1] ** 2))

    every = np.array([equations.equations, sum(equations.effective_rows)]) + len(near)
    x, root, squares = solved(rows_of(equations), every)
    # One after the other: the numbers of a single block stay in the processor's cache.
    for block in equations.blocks:
        rows, count = rows_of(block), every - np.array([block.equations, sum(block.effective_rows)])
        Q, errors = rows[:, :c] @ root, rows[:, c:] - rows[:, :c] @ x
        L, nothing_left = lapack.dpotrf(np.eye(c) - Q.T @ Q, lower=1)
        inverse = lapack.dtrtri(L, lower=1)[0] if not nothing_left else L
        if nothing_left or np.sum(inverse**2) > 1.0 / _HELD or count[0] < c or count[1] <= c:
            others = rows_of(*(other for other in equations.blocks if other is not block))
            values, own, left = solved(others, count)
        else:
            score, own = inverse @ (Q.T @ errors), root @ inverse.T
            values, left = x - own @ score, squares - np.sum(errors[:, -1] ** 2) - np.sum(score[:, -1] ** 2)
        solutions.append((values, own * np.sqrt(max(left, 0.0) / (count[1] - c))))
    return [*solutions, (x, root * np.sqrt(squares / (every[1] - c)))]


class Known(NamedTuple):
    """Parameters known from elsewhere, and how sure they are: fixed, or a prior that the recordings correct."""

    names: tuple[str, ...]
    values: Array
    covariance: Array  # part of the formula's, c x c; of a prior of full rank
    lasting: Array  # what no block of time shows of it, zero where blocks hold the recordings that it comes from
    degrees_of_freedom: float = float("inf")
    gain_sensitivity: Array | None = None  # by the relative error of each motor's torque, c x n, where known
    left_out: Callable[[], Array] | None = None  # values without each of the blocks they come from, B x c
    inflation: float = 1.0  # of a prior as of ``SoftPrior``

    def part(self, names: Sequence[str]) -> "Known":
        """Take some of the parameters."""
        own, S, each = [self.names.index(name) for name in names], self.gain_sensitivity, self.left_out
        C, lasting = (matrix[np.ix_(own, own)] for matrix in (self.covariance, self.lasting))
        more = None if S is None else S[own], None if each is None else lambda: each()[:, own]
        return Known(tuple(names), self.values[own], C, lasting, self.degrees_of_freedom, *more, self.inflation)

    @property
    def root(self) -> Array:
        """Rows of a prior, in units of weighted rows: root' root is the covariance's inverse, inflated."""
        scale = np.sqrt(np.diag(self.covariance))
        L = np.linalg.cholesky(self.covariance / np.outer(scale, scale))
        return np.asarray(np.sqrt(self.inflation) * solve_triangular(L, np.eye(len(L)), lower=True) / scale)


class SoftPrior(NamedTuple):
    """Prior on a parameter near zero: one more equation."""

    sigma: float
    inflation: float = 1.0  # of the variance of what the recordings say of it, by the memory of their errors

    @property
    def weight(self) -> float:
        """Weight of the equation, in units of weighted rows."""
        return float(np.sqrt(self.inflation)) / self.sigma


class Triangle(NamedTuple):
    """Triangle of weighted equations, and their solution."""

    R: Array  # of the unknown columns and the torque
    inverse: Array  # of its first c columns
    values: Array  # of the unknown parameters, (c,)
    influences: tuple[Array, ...]  # how they move with each known group, but for the sign: P = W_L^+ W
    by_torques: Array  # how they move with each motor's torque, c x n


@dataclass(frozen=True, eq=False)
class LinearProblem:
    """Equations and the roles of their columns; a column without a role is free, estimated with the wanted ones."""

    equations: Equations  # in all the columns
    wanted: tuple[str, ...]  # the parameters that are asked for
    fixed: tuple[Known, ...] = ()  # parameters known from elsewhere, group by group
    soft: Mapping[str, SoftPrior] = field(default_factory=dict)  # parameters near zero: one more equation for each
    prior: Known | None = None  # parameters near values that are known: as many equations more
    shown: Equations | None = None  # in the same columns: the fit is judged on their torques; all by default
    own_torque: bool = False  # judge the fit on the wanted parameters' own torque, that of all others taken off
    # equations without each block, where they are no sum of blocks; what is fixed then comes from no blocks
    parts: tuple[Equations, ...] = ()
    _triangles: dict[bytes, Triangle] = field(default_factory=dict, init=False, repr=False)

    def part(self, names: Sequence[str]) -> "LinearProblem":
        """Pose the problem in some of the parameters, the others zero."""
        own = [name for name in self.prior.names if name in names] if self.prior else []
        prior = self.prior.part(own) if self.prior and own else None
        return LinearProblem(self.equations.select(names), tuple(names), prior=prior)

    @cached_property
    def unknown(self) -> Equations:
        """Take the equations in the wanted and the free columns alone."""
        equations = self.equations.whole
        for group in self.fixed:
            equations = equations.minus(group.names, group.values)
        return equations

    def weights(self) -> Array:
        """Weights of the joints by their errors in the ordinary solution, (n,); a prior counts as it stands."""
        if self.prior is not None:
            return replace(self, fixed=self.given, prior=None).weights()
        return self.unknown.joint_weights(self.triangle(np.ones(len(self.equations.factors))).values)

    def without_blocks(self, weights: Array, pairs: Sequence[tuple[int, int]]) -> Array:
        """Solve without a block of these equations and one of those that known parameters come from, -1 for none.

        Without known parameters ``pairs`` are the equations' own blocks in their order.
        """
        if self.parts:
            return np.array([part.triangle(weights).values[part._indices] for part in self.without_each()])
        names = tuple(chain.from_iterable(group.names for group in self.fixed))
        rows, levels, *_ = self._prior_rows
        near = np.column_stack([rows, np.zeros((len(rows), len(names))), levels])
        solutions = left_out(self.equations, self.unknown.columns, weights, names, near)
        values = np.array([x[self._indices] for x, _ in solutions])
        if not self.fixed:
            return np.asarray(values[: len(pairs), :, 0])
        # Without each of their own blocks, last of all the whole ones.
        every = ((group.left_out() if group.left_out else values[:0, 0], group.values) for group in self.fixed)
        known = np.hstack([np.vstack([*parts, whole]) for parts, whole in every])
        return np.array([values[a, :, -1] - values[a, :, :-1] @ known[min(b, len(known) - 1)] for a, b in pairs])

    def without_each(self) -> "list[LinearProblem]":
        """Pose the problem without each of its equations' blocks, known parameters as they are."""
        parts = self.parts or self.equations.without_each()
        return [replace(self, equations=part, parts=()) for part in parts]

    def estimate(self, weights: Array | None = None) -> Estimate:
        """Estimate all unknown parameters, with what is known to be part of their error.

        Raises:
            InputError: if the equations leave a parameter undetermined.
        """
        weights = self.weights() if weights is None else weights
        triangle, c = self.triangle(weights), len(self.unknown.columns)
        dof = self._rows[1] - c
        covariance = np.sum(triangle.R[c:, c] ** 2) / dof * triangle.inverse @ triangle.inverse.T  # (17)-(19)
        value = dict(zip(self.unknown.columns, triangle.values.tolist(), strict=True))
        # Exact slopes: the solution is linear in Y. Without a known spring they add up to the solution, which an
        # error common to all joints scales. What is fixed was identified with the same drives, so the same errors.
        by_gains = triangle.by_torques
        for group, P in zip(self.fixed, triangle.influences, strict=True):
            covariance = covariance + P @ group.covariance @ P.T
            value |= zip(group.names, group.values.tolist(), strict=True)
            if group.gain_sensitivity is not None:
                by_gains = by_gains - P @ group.gain_sensitivity
        shown = (self.shown or self.equations).whole
        if self.own_torque:
            others = [name for name in shown.columns if name not in self.wanted]
            shown = shown.minus(others, np.array([value[name] for name in others]))
        told = fit(shown, np.array([value[name] for name in shown.columns]))
        least = min([dof, *(group.degrees_of_freedom for group in self.given)])
        S = None if any(group.gain_sensitivity is None for group in self.given) else by_gains
        return Estimate(self.unknown.columns, triangle.values, covariance, least, told, weights, gain_sensitivity=S)

    def solved(self, weights: Array | None = None) -> Estimate:
        """Estimate the wanted parameters alone."""
        return self.estimate(weights).part(self.wanted)

    def lasting(self, weights: Array) -> Array:
        """Between-session covariance of the wanted parameters, by fixed and prior ones: no block shows it."""
        total, triangle = np.zeros((len(self.wanted), len(self.wanted))), self.triangle(weights)
        for group, influence in zip(self.fixed, triangle.influences, strict=True):
            P = influence[self._indices]
            total += P @ group.lasting @ P.T
        rows, _, inflation, _ = self._prior_rows
        if len(rows):
            inverse = triangle.inverse
            moved = (inverse[self._indices] @ (inverse.T @ rows.T)) * np.sqrt(inflation)
            total += moved @ moved.T
        return total

    def sandwich(self, weights: Array, inflation: Sequence[float]) -> Array:
        """HAC (sandwich) covariance of the wanted parameters, ``lasting`` among it: errors remember.

        It is (W'W)^-1 S'S (W'W)^-1, S the weighted rows of W times the size of their errors (White 1980).
        """
        unknown, triangle = self.unknown, self.triangle(weights)
        freedom = max(1.0 - len(unknown.columns) / max(self._rows[0], 1), 1e-3)
        errors = unknown.error_norms(triangle.values) / np.sqrt(np.maximum(unknown.rows, 1) * freedom)
        sizes = weights**2 * errors * np.sqrt(np.asarray(inflation))
        sized = zip(sizes, unknown.factors, strict=True)
        noise = triangular(np.vstack([size * factor[:, :-1] for size, factor in sized]))
        moved = triangle.inverse[self._indices] @ triangle.inverse.T @ noise.T
        total = moved @ moved.T + self.lasting(weights)
        for group, influence in zip(self.fixed, triangle.influences, strict=True):
            if not group.lasting.any():  # of recordings that remember as well
                P = influence[self._indices]
                total += float(np.median(inflation)) * P @ group.covariance @ P.T
        return np.asarray(total)

    @property
    def given(self) -> tuple[Known, ...]:
        """Collect all that is known from elsewhere with its values."""
        return (*self.fixed, self.prior) if self.prior is not None else self.fixed

    @property
    def _indices(self) -> list[int]:
        return [self.unknown.columns.index(name) for name in self.wanted]

    @cached_property
    def _prior_rows(self) -> tuple[Array, Array, Array, Array]:
        """Rows of priors in the unknown columns, m x c, levels and inflation, (m,), the levels' derivatives."""
        columns, c = self.unknown.columns, len(self.unknown.columns)
        rows = [role.weight * np.eye(1, c, columns.index(name)) for name, role in self.soft.items()]
        levels, inflation = np.zeros(len(rows)), [role.inflation for role in self.soft.values()]
        by_gains = [np.zeros((len(rows), len(self.equations.factors)))]
        if (prior := self.prior) is not None:
            root, wide = prior.root, np.zeros((len(prior.names), c))
            wide[:, [columns.index(name) for name in prior.names]] = root
            rows.append(wide)
            levels, inflation = np.append(levels, root @ prior.values), inflation + [prior.inflation] * len(root)
            own = prior.gain_sensitivity
            by_gains.append(root @ own if own is not None else np.zeros((len(root), by_gains[0].shape[1])))
        return np.vstack([np.zeros((0, c)), *rows]), levels, np.array(inflation), np.vstack(by_gains)

    def triangle(self, weights: Array) -> Triangle:
        """Decompose the weighted equations of all joints, prior rows below; once for given weights."""
        if (key := weights.tobytes()) in self._triangles:
            return self._triangles[key]
        (near, levels, _, by_gains), sizes = self._prior_rows, [len(group.names) for group in self.fixed]
        indices = [self.equations.columns.index(name) for group in self.fixed for name in group.names]
        every = zip(weights, self.unknown.factors, self.equations.factors, self.equations.by_motor(), strict=True)
        rows = [w * np.column_stack([own, factor[:, indices], torques]) for w, own, factor, torques in every]
        below = np.column_stack([near, levels, np.zeros((len(near), len(indices))), by_gains])
        R, extra = compressed(np.vstack([*rows, below]), below.shape[1] - near.shape[1] - 1)
        R, c = checked(R, self.unknown.columns, *self._rows), len(self.unknown.columns)
        solved = solve_triangular(R[:c, :c], np.column_stack([np.eye(c), extra[:c]]))
        inverse, *influences, by_torques = np.split(solved, c + np.cumsum([0, *sizes]), axis=1)
        triangle = Triangle(R, inverse, inverse @ R[:c, c], tuple(influences), by_torques)
        self._triangles[key] = triangle
        return triangle

    @property
    def _rows(self) -> tuple[int, float]:
        """Count equations, and those with independent noise."""
        count = len(self._prior_rows[0])
        return self.unknown.equations + count, sum(self.unknown.effective_rows) + count


@dataclass(frozen=True, eq=False, repr=False)
class Excitation(Brief):
    """Signal of each parameter in weighted equations, in units of the noise.

    The relative standard deviation of a parameter is 1 / ``independent``, 1 / ``signal`` with all others known.
    """

    names: tuple[str, ...]  # of the parameters, c
    signal: Array  # norm of the parameter's torque, |chi_k| ||W_k|| over the noise, shape (c,)
    independent: Array  # the same of its part that no combination of the others can imitate, |chi_k| / sigma_k

    @property
    def share(self) -> Array:
        """Part of each torque that is its own, 0 to 1, (c,): 1 / sqrt(variance inflation factor); nan of 0."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.independent / self.signal)


def excitation(problem: Equations, estimate: Estimate) -> Excitation:
    """Measure the excitation of an estimate's parameters by the equations it comes from, in the same columns."""
    c, R = len(problem.columns), problem.stacked(estimate.weights)
    T = solve_triangular(R[:c, :c], np.eye(c))
    spare = max(sum(problem.effective_rows) - c, 1.0)
    error = R @ np.append(-estimate.values, 1.0)
    # Equations filtered and decimated count for fewer: sigma goes by the effective ones.
    noise = float(np.linalg.norm(error)) / np.sqrt(spare)
    size = np.abs(estimate.values) / max(noise, np.finfo(float).tiny)
    return Excitation(problem.columns, size * np.linalg.norm(R[:, :c], axis=0), size / np.linalg.norm(T, axis=1))


def weighted(problem: Equations, weights: Array | None = None) -> Estimate:
    """Estimate all columns by weighted least squares.

    ``weights``: per joint [1/(N·m) or 1/N], shape (n,); by default from its error in the ordinary solution (16).
    """
    return LinearProblem(problem, problem.columns).estimate(weights)


STOP_RATIO = 1.02  # limit of the paper: the error's standard deviation over that with all parameters


@dataclass(frozen=True)
class SigmaRatio:
    """The paper's rule: end before the error's standard deviation reaches ``limit`` times the first one.

    Attributes:
        limit: the ratio, above 1.
    """

    limit: float = STOP_RATIO

    def __post_init__(self) -> None:
        if not 1.0 < self.limit < np.inf:
            raise InputError(f"essential parameters: ratio {self.limit:g} must be above 1, such as {STOP_RATIO}")

    @property
    def description(self) -> str:
        """Describe the rule in one line."""
        return f"error's standard deviation below {self.limit:g} times that with all parameters"

    def eliminated(self, sigma_ratio: Array, _: Array) -> int:
        """Count the steps before the first one that reaches the limit; later ones may fall below it again."""
        over = np.flatnonzero(sigma_ratio[1:] >= self.limit)
        return int(over[0]) if len(over) else len(sigma_ratio) - 1


@dataclass(frozen=True)
class SigmaBound:
    """End at the first set whose relative standard deviations are all within ``limit``.

    Attributes:
        limit: largest relative standard deviation, a fraction (the paper speaks of 0.05 to 0.10).
    """

    limit: float = 0.10

    def __post_init__(self) -> None:
        if not 0.0 < self.limit < np.inf:
            raise InputError(f"essential parameters: bound {self.limit:g} must be positive, such as 0.1 (10 %)")

    @property
    def description(self) -> str:
        """Describe the rule in one line."""
        return f"all relative standard deviations within {100.0 * self.limit:g} %"

    def eliminated(self, _: Array, largest_relative_sigma: Array) -> int:
        """Count the steps to the first set within the bound."""
        return int(np.flatnonzero(largest_relative_sigma <= self.limit)[0])


StopRule = SigmaRatio | SigmaBound
"""Rule that ends elimination: ``eliminated`` counts its steps by the columns of an ``Elimination.path``."""


@dataclass(frozen=True, eq=False, repr=False)
class Elimination(Brief):
    """Essential parameters, and backward elimination down to no parameter at all."""

    order: tuple[str, ...]  # the parameters, first eliminated first, c
    # With k parameters eliminated, k = 0 .. c, the error's standard deviation over that with none, and the largest
    # relative standard deviation of those that remain, 0 where none does; (c + 1) x 2.
    path: Array
    rule: StopRule  # when it ended
    estimate: Estimate  # of the essential parameters, the others zero; weights as with all parameters

    @property
    def essential(self) -> tuple[str, ...]:
        """Names of the essential parameters, in the problem's order."""
        return self.estimate.names

    @cached_property
    def eliminated(self) -> tuple[str, ...]:
        """Names of the others, first eliminated first."""
        return self.order[: len(self.order) - len(self.essential)]


def eliminate(
    problem: Equations, estimate: Estimate, rule: StopRule | None = None, prior: Known | None = None
) -> Elimination:
    """Find the essential parameters of a problem, those that the torques show, by backward elimination.

    At each step (section III) the parameter with the largest relative standard deviation (21) is cancelled and the
    others are estimated anew, the estimate's weights unchanged. No step solves least squares again: T = R^-1 holds
    the covariance as T T', and cancelling a parameter projects T's rows along its own.

    ``rule``: the paper's by default; ``prior``: of some of the parameters.
    """
    rule, posed = rule or SigmaRatio(), LinearProblem(problem, problem.columns, prior=prior)
    (R, T, x, *_), c = posed.triangle(estimate.weights), len(problem.columns)
    squares, rows = float(np.sum(R[c:, c] ** 2)), sum(problem.effective_rows)
    order, largest, variances = list[int](), list[float](), [squares / (rows - c)]
    while len(order) < c:  # one by one, until none is left
        sigma = np.sqrt(variances[-1]) * np.sqrt(np.einsum("kl,kl->k", T, T))
        with np.errstate(divide="ignore", invalid="ignore"):
            relative = np.where(x == 0.0, np.inf, sigma / np.abs(x))
        relative[order] = -1.0
        k = int(np.argmax(relative))
        largest.append(float(relative[k]))
        order.append(k)
        # Least squares under x_k = 0: with t the k-th row of T, x loses T t' x_k / (t t'), the sum of squares grows
        # by x_k^2 / (t t'), and T loses its part along t.
        length = float(np.linalg.norm(T[k]))
        u, pull = T[k] / length, float(x[k]) / length
        along = T @ u
        T, x, squares = T - np.outer(along, u), x - along * pull, squares + pull * pull
        T[k], x[k] = 0.0, 0.0
        variances.append(squares / (rows - c + len(order)))
    with np.errstate(over="ignore"):  # data without noise: any elimination is infinitely worse
        ratio = np.sqrt(np.array(variances) / max(variances[0], np.finfo(float).tiny))
    names = tuple(problem.columns[k] for k in order)
    path = np.column_stack([np.append(1.0, ratio[1:]), [*largest, 0.0]])
    path.setflags(write=False)
    essential = [name for name in problem.columns if name not in names[: rule.eliminated(*path.T)]]
    return Elimination(names, path, rule, posed.part(essential).estimate(estimate.weights))
