"""The scalar operations a kernel knows: CasADi's code, the NumPy function, the C expression."""

from collections.abc import Callable
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from ...common.arrays import Array


class Operation(NamedTuple):
    """One operation on arrays: ``numpy(*args, out=...)`` and the same in C on vectors ``{0}``, ``{1}``."""

    numpy: Callable[..., Any]
    c: str


def _ufunc(compute: Callable[..., Any]) -> Callable[..., Any]:
    """Give a plain expression the ``out`` argument of a NumPy ufunc."""

    def into(*args: Any, out: Array) -> None:
        out[...] = compute(*args)

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
    "SIN": Operation(np.sin, "sin8({0})"),
    "COS": Operation(np.cos, "cos8({0})"),
    "SIGN": Operation(np.sign, "select8({0} > 0.0) - select8({0} < 0.0) + keep8({0} != {0}, {0})"),
    "FABS": Operation(np.abs, "each8(fabs, {0})"),
    "SQRT": Operation(np.sqrt, "each8(sqrt, {0})"),
    "TAN": Operation(np.tan, "each8(tan, {0})"),
    "ASIN": Operation(np.arcsin, "each8(asin, {0})"),
    "ACOS": Operation(np.arccos, "each8(acos, {0})"),
    "ATAN": Operation(np.arctan, "each8(atan, {0})"),
    "ATAN2": Operation(np.arctan2, "pair8(atan2, {0}, {1})"),
    "EXP": Operation(np.exp, "each8(exp, {0})"),
    "LOG": Operation(np.log, "each8(log, {0})"),
    "SINH": Operation(np.sinh, "each8(sinh, {0})"),
    "COSH": Operation(np.cosh, "each8(cosh, {0})"),
    "TANH": Operation(np.tanh, "each8(tanh, {0})"),
    "FLOOR": Operation(np.floor, "each8(floor, {0})"),
    "CEIL": Operation(np.ceil, "each8(ceil, {0})"),
    "FMIN": Operation(np.fmin, "pair8(fmin, {0}, {1})"),
    "FMAX": Operation(np.fmax, "pair8(fmax, {0}, {1})"),
    "POW": Operation(np.power, "pair8(pow, {0}, {1})"),
    "CONSTPOW": Operation(np.power, "pair8(pow, {0}, {1})"),
    "LT": Operation(_ufunc(np.less), "select8({0} < {1})"),
    "LE": Operation(_ufunc(np.less_equal), "select8({0} <= {1})"),
    "EQ": Operation(_ufunc(np.equal), "select8({0} == {1})"),
    "NE": Operation(_ufunc(np.not_equal), "select8({0} != {1})"),
    "NOT": Operation(_ufunc(np.logical_not), "select8({0} == 0.0)"),
    "AND": Operation(_ufunc(np.logical_and), "select8(({0} != 0.0) & ({1} != 0.0))"),
    "OR": Operation(_ufunc(np.logical_or), "select8(({0} != 0.0) | ({1} != 0.0))"),
    "IF_ELSE_ZERO": Operation(_ufunc(lambda c, x: np.where(c != 0, x, 0.0)), "keep8({0} != 0.0, {1})"),
}

BY_CODE: dict[int, str] = {getattr(ca, f"OP_{name}"): name for name in OPERATIONS}
