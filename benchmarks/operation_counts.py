"""Prints how many operations the generated functions of the RX90 need, next to SYMORO+'s counts."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import casadi as ca
from dynident.model import (
    Drives,
    base_parameters,
    base_regressor,
    coriolis,
    forward_dynamics,
    gravity,
    inverse_dynamics,
    inverse_dynamics_base,
    load_robot,
    mass_matrix,
    payload_regressor,
    standard_regressor,
)
from dynident.model.kernel.program import read_program

SYMORO = {"inverse dynamics, base parameters": (325, 272), "base identification model": (877, 501)}
"""Multiplications and additions that SYMORO+ needs for the RX90."""

_KINDS = {"MUL": "x", "SQ": "x", "DIV": "x", "INV": "x", "ADD": "+", "SUB": "+", "TWICE": "+", "NEG": "-"}


def operation_counts(function: ca.Function) -> tuple[int, int, int, int]:
    """Multiplications (and divisions), additions (and subtractions), changes of sign, other operations."""
    counts = Counter(_KINDS.get(step.name, "other") for step in read_program(function).steps)
    return counts["x"], counts["+"], counts["-"], counts["other"]


def rigid_bodies() -> Iterator[str]:
    """Rows of the comparison with SYMORO+: RX90, 36 base parameters of the links, no drives."""
    robot = replace(load_robot("rx90"), drives=Drives(rotor_inertia=False, friction=()))
    base = base_parameters(robot)
    functions = (inverse_dynamics_base(robot, base), base_regressor(robot, base))
    for (name, (multiplications, additions)), function in zip(SYMORO.items(), functions, strict=True):
        yield f"| {name} | {_cells(function)} | {multiplications} | {additions} |"


def whole_model() -> Iterator[str]:
    """Rows of all functions: RX90 with rotor inertia, friction and coupling."""
    robot = load_robot("rx90")
    base = base_parameters(robot)
    makers = (
        inverse_dynamics,
        mass_matrix,
        coriolis,
        gravity,
        forward_dynamics,
        standard_regressor,
        payload_regressor,
    )
    functions = [make(robot) for make in makers]
    functions += [inverse_dynamics_base(robot, base), base_regressor(robot, base)]
    for function in functions:
        yield f"| `{function.name()}` | {_cells(function)} |"


def _cells(function: ca.Function) -> str:
    return " | ".join(str(count) for count in operation_counts(function))


def tables() -> tuple[str, str]:
    """The two tables as they stand in docs/operation_counts.md."""
    head = "multiplications | additions | sign changes | sin, cos, sign |"
    first = [f"| links only | {head} SYMORO+ multiplications | additions |", "|---|" + "---:|" * 6, *rigid_bodies()]
    second = [f"| whole model | {head}", "|---|" + "---:|" * 4, *whole_model()]
    return "\n".join(first), "\n".join(second)


if __name__ == "__main__":
    print("\n\n".join(tables()))
