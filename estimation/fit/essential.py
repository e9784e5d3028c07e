"""Essential parameters: those that the torques show, by backward elimination (section III).

At each step the parameter with the largest relative standard deviation (21) is cancelled and the others are
estimated anew, weights unchanged. No step solves least squares again: with R of the QR decomposition of [W Y],
weighted, T = R^-1 holds the covariance as T T', and cancelling a parameter projects T's rows along its own.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...common import Array, Brief, InputError
from ..equations.equations import Equations
from .estimate import Estimate
from .linear_problem import Known, LinearProblem

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
    """Find the essential parameters of a problem by its weighted estimate, whose weights stay as they are.

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
