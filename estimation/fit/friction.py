"""Friction of the drives as the data ask for it, and the equations of friction that grows with load."""

from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeVar

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import without
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


class TermChoice(NamedTuple):
    """Term of friction at a joint that was tried on held-out blocks of time.

    ``fall``: of the joint's squared error on them, as a fraction of it; ``error``: its standard error;
    ``why_not``: why the term is left out, empty where it is kept.
    """

    name: str
    fall: float
    error: float
    why_not: str = ""


def loaded_friction(robot: Robot) -> tuple[str, ...]:
    """Parameters of friction that depends on the torque that a gear carries."""
    loaded = [term for term in robot.drives.friction if term.loaded]
    return tuple(f"{term.kind}{j}" for term in loaded for j in range(1, robot.n + 1) if term.at(j))


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
        if (np.abs(moved) <= _SETTLED * _sigma(own)).all():
            break
    return result, values


def _sigma(equations: Equations) -> Array:
    """Standard deviations by the formula; zero where the parameters are not determined."""
    try:
        return LinearProblem(equations, equations.columns).estimate().sigma
    except InputError:
        return np.zeros(len(equations.columns))


def chosen_terms(
    robot: Robot, candidates: Sequence[Friction], equations: Equations
) -> tuple[tuple[Friction, ...], tuple[TermChoice, ...]]:
    """Keep the terms by which a joint's error on held-out blocks falls by two standard errors.

    Args:
        robot: with all candidates at all joints.
        candidates: tried one after the other.
        equations: in its base parameters, in blocks of time.
    """
    every, kept = equations.columns, dict[str, list[str]]()
    kinds = [term.kind for term in candidates]
    own = [name for name in every if parameter_kind(name) not in kinds]
    weights, choices = equations.joint_weights(_padded(equations, own)), dict[str, TermChoice]()
    for term in (*candidates, *candidates):  # the second time beside the others that were kept
        others = [*own, *(name for kind, names in kept.items() if kind != term.kind for name in names)]
        if term.kind in kept and len(others) == len(own):
            continue
        names = [name for name in every if parameter_kind(name) == term.kind]
        tried = [name for name in names if _apart(equations, name, others) > _OWN]
        before, after = (_held_out(equations, columns, weights) for columns in (others, [*others, *tried]))
        for name in names:
            joint = joint_of(name)
            falls = before[0][:, joint] - after[0][:, joint]
            total, error = float(falls.sum()), float(np.sqrt(len(falls)) * falls.std(ddof=1))
            size = max(float(before[0][:, joint].sum()), np.finfo(float).tiny)
            why_not = "" if total > _SURE * error else "explains no more on held-out blocks"
            if name not in tried:
                why_not = "not told apart from the others"
            elif not why_not and term.loaded and after[1][name] <= 0.0:
                why_not = "would be negative"
            choices[name] = TermChoice(name, total / size, error / size, why_not)
        kept[term.kind] = [name for name in names if not choices[name].why_not]
    found = terms_of([name for names in kept.values() for name in names], candidates, robot.n)
    return tuple(term for term in found if term.kind in kinds), tuple(choices.values())


def _padded(equations: Equations, names: Sequence[str]) -> Array:
    """Fit some of the columns; zero for the others."""
    values = np.zeros(len(equations.columns))
    values[[equations.columns.index(name) for name in names]] = weighted_solution(equations.whole.select(names))
    return values


def _apart(equations: Equations, name: str, others: Sequence[str]) -> float:
    """Fraction of a column that its joint's other columns cannot imitate."""
    place, rest = equations.columns.index(name), [equations.columns.index(other) for other in others]
    j = joint_of(name)
    column = equations.factors[j][:, [place]]
    size = float(np.linalg.norm(column))
    return float(np.linalg.norm(without(column, equations.factors[j][:, rest]))) / size if size else 0.0


def _held_out(equations: Equations, names: Sequence[str], weights: Array) -> tuple[Array, dict[str, float]]:
    """Squared errors of each joint on each block by the others' fit, B x n, and the values by all."""
    solutions = left_out(equations, names, weights).values[:, :, 0]
    places = [*(equations.columns.index(name) for name in names), -1]
    rows = np.column_stack([-solutions[:-1], np.ones(len(solutions) - 1)])
    errors = [np.einsum("bkc,bc->bk", stack[:, :, places], rows) for stack in equations.blocks.factors]
    squares = np.column_stack([np.sum(error**2, axis=1) for error in errors])
    return squares, dict(zip(names, solutions[-1].tolist(), strict=True))
