"""Friction of the drives as the data ask for it, and the equations of friction that grows with load."""

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np
from msgspec import UNSET, UnsetType

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import without
from ...common.schema import Document
from ...model import Robot
from ...model.drives import joint_of, parameter_kind
from ...model.friction import Friction, terms_of
from ..equations.equations import Equations
from ..equations.observer import Observer
from .blocks import weighted_solution
from .linear_problem import LinearProblem, left_out

_PASSES = 10
"""Largest number of passes: the load is known after one, and each leaves its error times FL."""
_SETTLED = 1e-3
"""Fraction of a standard deviation: a smaller change of every parameter ends the passes."""
_SURE = 2.0
"""Standard errors by which the error on held-out blocks must fall: of 750 joints of simulated arms without such
friction 3 kept a term by 2; by 1 every fiftieth did."""
_OWN = 0.02
"""Part of a term's column that no other column can imitate, below which the data do not tell it apart."""


Held = TypeVar("Held")


class TermChoice(Document, frozen=True):
    """Term of friction at a joint that was tried, and what held-out blocks of time say of it.

    ``fall``: of the joint's squared error on them, as a fraction; ``error``: its standard error; both null, and the
    term of no joint, where none could be held out.
    """

    name: str
    kept: bool
    fall: float | None = None
    error: float | None = None
    why_not: str | UnsetType = UNSET


def under_own_load(
    observer: Observer, reduced: Callable[[Observer], tuple[Equations, Held]], known: Array | None = None
) -> tuple[tuple[Equations, Held], Array]:
    """Reduce recordings with friction under the load that their own parameters cause.

    The first pass finds the load without friction that grows with it; the next ones refresh it until no parameter
    moves by more than 1e-3 of its standard deviation.

    Args:
        observer: of the equations.
        reduced: equations of the recordings by an observer, and what else it keeps of them.
        known: values of the first columns, which are not found anew; none by default.

    Returns:
        What ``reduced`` gives, and the parameters by which the load is.
    """
    known = np.zeros(0) if known is None else known
    values = np.concatenate([known, np.zeros(len(observer.columns) - len(known))])
    if not observer.robot.drives.loaded:
        return reduced(observer), values
    for _ in range(_PASSES):
        result = reduced(observer.at(values))
        own = result[0].minus(observer.columns[: len(known)], known)
        found = np.concatenate([known, weighted_solution(own)])
        moved, values = (found - values)[len(known) :], found
        try:
            sigma = LinearProblem(own, own.columns).estimate().sigma
        except InputError:  # a parameter that is not determined may still move
            sigma = np.zeros(len(moved))
        if (np.abs(moved) <= _SETTLED * sigma).all():
            break
    return result, values


def chosen_terms(
    robot: Robot, candidates: Sequence[Friction], equations: Equations
) -> tuple[tuple[Friction, ...], tuple[TermChoice, ...]]:
    """Keep the terms by which a joint's error on held-out blocks falls by two standard errors.

    Args:
        robot: with all candidates at all joints.
        candidates: tried one after the other.
        equations: in its base parameters, in blocks of time.
    """
    kinds, kept, choices = [term.kind for term in candidates], dict[str, list[str]](), dict[str, TermChoice]()
    own = [name for name in equations.columns if parameter_kind(name) not in kinds]
    without = equations.whole.select(own)
    weights = without.joint_weights(weighted_solution(without))
    for term in (*candidates, *candidates):  # the second time beside the others that were kept
        others = [*own, *(name for kind, names in kept.items() if kind != term.kind for name in names)]
        if term.kind in kept and len(others) == len(own):
            continue
        names = [name for name in equations.columns if parameter_kind(name) == term.kind]
        tried = [name for name in names if _own_fraction(equations, name, others) > _OWN]
        before, after = (_held_out(equations, columns, weights) for columns in (others, [*others, *tried]))
        for name in names:
            joint = joint_of(name)
            falls = before[0][:, joint] - after[0][:, joint]
            total, error = float(falls.sum()), float(np.sqrt(len(falls)) * falls.std(ddof=1))
            size = max(float(before[0][:, joint].sum()), np.finfo(float).tiny)
            why_not = "" if total > _SURE * error else "explains no more on held-out blocks"
            if name not in tried:
                why_not = "cannot be separated from the others"
            elif not why_not and term.loaded and after[1][name] <= 0.0:
                why_not = "would be negative"
            choices[name] = TermChoice(name, not why_not, total / size, error / size, why_not or UNSET)
        kept[term.kind] = [name for name in names if choices[name].kept]
    found = terms_of([name for names in kept.values() for name in names], candidates, robot.n)
    return tuple(term for term in found if term.kind in kinds), tuple(choices.values())


def _own_fraction(equations: Equations, name: str, others: Sequence[str]) -> float:
    """Fraction of a column that its joint's other columns cannot imitate."""
    factor = equations.factors[joint_of(name)]
    column = factor[:, [equations.columns.index(name)]]
    own = without(column, factor[:, [equations.columns.index(other) for other in others]])
    return float(np.linalg.norm(own)) / max(float(np.linalg.norm(column)), np.finfo(float).tiny)


def _held_out(equations: Equations, names: Sequence[str], weights: Array) -> tuple[Array, dict[str, float]]:
    """Squared errors of each joint on each block by the others' fit, B x n, and the values by all."""
    solutions = left_out(equations, names, weights).values[:, :, 0]
    places = [*(equations.columns.index(name) for name in names), -1]
    rows = np.column_stack([-solutions[:-1], np.ones(len(solutions) - 1)])
    errors = [np.einsum("bkc,bc->bk", stack[:, :, places], rows) for stack in equations.blocks.factors]
    squares = np.column_stack([np.sum(error**2, axis=1) for error in errors])
    return squares, dict(zip(names, solutions[-1].tolist(), strict=True))
