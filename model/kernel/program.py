"""The operation list of a CasADi SX function, and the scalar operations it may hold."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from ...common.arrays import Array


class Operation(NamedTuple):
    """Operation on arrays: ``numpy(*args, out)`` and the same in C on vectors ``{0}``, ``{1}``."""

    numpy: Callable[..., Any]
    c: str


def _ufunc(compute: Callable[..., Any]) -> Callable[..., Any]:
    """Let a plain expression write into its last argument, as a NumPy ufunc does."""

    def into(*args: Array) -> None:
        args[-1][...] = compute(*args[:-1])

    return into


OPERATIONS: dict[str, Operation] = {
    "ASSIGN": Operation(np.positive, "{0}"),
    "ADD": Operation(np.add, "{0} + {1}"),
    "SUB": Operation(np.subtract, "{0} - {1}"),
    "MUL": Operation(np.multiply, "{0} * {1}"),
    "DIV": Operation(np.divide, "{0} / {1}"),
    "NEG": Operation(np.negative, "-{0}"),
    "SQ": Operation(np.square, "{0} * {0}"),
    "TWICE": Operation(lambda x, out: np.add(x, x, out=out), "{0} + {0}"),
    "INV": Operation(np.reciprocal, "1.0 / {0}"),
    "SIN": Operation(np.sin, "vsin({0})"),
    "COS": Operation(np.cos, "vcos({0})"),
    "SIGN": Operation(np.sign, "vselect({0} > 0.0) - vselect({0} < 0.0) + vkeep({0} != {0}, {0})"),
    "FABS": Operation(np.abs, "veach(fabs, {0})"),
    "SQRT": Operation(np.sqrt, "veach(sqrt, {0})"),
    "TAN": Operation(np.tan, "veach(tan, {0})"),
    "ASIN": Operation(np.arcsin, "veach(asin, {0})"),
    "ACOS": Operation(np.arccos, "veach(acos, {0})"),
    "ATAN": Operation(np.arctan, "veach(atan, {0})"),
    "ATAN2": Operation(np.arctan2, "vpair(atan2, {0}, {1})"),
    "EXP": Operation(np.exp, "veach(exp, {0})"),
    "LOG": Operation(np.log, "veach(log, {0})"),
    "SINH": Operation(np.sinh, "veach(sinh, {0})"),
    "COSH": Operation(np.cosh, "veach(cosh, {0})"),
    "TANH": Operation(np.tanh, "veach(tanh, {0})"),
    "FLOOR": Operation(np.floor, "veach(floor, {0})"),
    "CEIL": Operation(np.ceil, "veach(ceil, {0})"),
    "FMIN": Operation(np.fmin, "vpair(fmin, {0}, {1})"),
    "FMAX": Operation(np.fmax, "vpair(fmax, {0}, {1})"),
    "POW": Operation(np.power, "vpair(pow, {0}, {1})"),
    "CONSTPOW": Operation(np.power, "vpair(pow, {0}, {1})"),
    "LT": Operation(_ufunc(np.less), "vselect({0} < {1})"),
    "LE": Operation(_ufunc(np.less_equal), "vselect({0} <= {1})"),
    "EQ": Operation(_ufunc(np.equal), "vselect({0} == {1})"),
    "NE": Operation(_ufunc(np.not_equal), "vselect({0} != {1})"),
    "NOT": Operation(_ufunc(np.logical_not), "vselect({0} == 0.0)"),
    "AND": Operation(_ufunc(np.logical_and), "vselect(({0} != 0.0) & ({1} != 0.0))"),
    "OR": Operation(_ufunc(np.logical_or), "vselect(({0} != 0.0) | ({1} != 0.0))"),
    "IF_ELSE_ZERO": Operation(_ufunc(lambda c, x: np.where(c != 0, x, 0.0)), "vkeep({0} != 0.0, {1})"),
}

BY_CODE: dict[int, str] = {getattr(ca, f"OP_{name}"): name for name in OPERATIONS}


@dataclass(frozen=True)
class Step:
    """Step of a program: ``values[result] = name(*values[arguments])``."""

    name: str
    result: int
    arguments: tuple[int, ...]


@dataclass(frozen=True)
class Program:
    """Operations that compute a function's outputs, one sample at a time.

    Attributes:
        inputs: value index -> row of the stacked inputs (all inputs one below the other).
        constants: value index -> number.
        steps: operations in order.
        outputs: value index of each non-zero output, in CasADi's order, outputs one below the other.
        input_sizes: size of each input.
    """

    inputs: dict[int, int]
    constants: dict[int, float]
    steps: tuple[Step, ...]
    outputs: tuple[int, ...]
    input_sizes: tuple[int, ...]


def read_program(function: ca.Function) -> Program:
    """Read the operation list of an SX function.

    Raises:
        TypeError: if the function is not made of scalar (SX) operations or uses one that is not supported.
    """
    if not function.is_a("SXFunction"):
        raise TypeError(f"{function.name()} is not an SX function: expand() it first")
    sizes = tuple(function.nnz_in(k) for k in range(function.n_in()))
    rows = [sum(sizes[:k]) for k in range(len(sizes))]
    offsets = [0]
    for k in range(function.n_out()):
        offsets.append(offsets[-1] + function.nnz_out(k))
    register: dict[int, int] = {}
    inputs: dict[int, int] = {}
    constants: dict[int, float] = {}
    steps: list[Step] = []
    outputs = [-1] * offsets[-1]
    size = 0
    for k in range(function.n_instructions()):
        code = function.instruction_id(k)
        source, target = function.instruction_input(k), function.instruction_output(k)
        if code == ca.OP_OUTPUT:
            outputs[offsets[target[0]] + target[1]] = register[source[0]]
            continue
        if code == ca.OP_INPUT:
            inputs[size] = rows[source[0]] + source[1]
        elif code == ca.OP_CONST:
            constants[size] = float(function.instruction_constant(k))
        elif code in BY_CODE:
            steps.append(Step(BY_CODE[code], size, tuple(register[s] for s in source)))
        else:
            raise TypeError(f"{function.name()} uses CasADi operation {code}, which the kernel does not know")
        register[target[0]] = size
        size += 1
    if -1 in outputs:
        raise TypeError(f"{function.name()} leaves an output unset")
    return Program(inputs, constants, tuple(steps), tuple(outputs), sizes)
