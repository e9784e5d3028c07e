"""The operation list of a CasADi SX function, and the scalar operations it may hold."""

from itertools import accumulate
from typing import NamedTuple

import casadi as ca


class Operation(NamedTuple):
    """Operation on ``{0}`` and ``{1}``: in NumPy on arrays, in C on vectors."""

    numpy: str
    c: str


OPERATIONS: dict[str, Operation] = {
    "ASSIGN": Operation("{0}", "{0}"),
    "ADD": Operation("{0} + {1}", "{0} + {1}"),
    "SUB": Operation("{0} - {1}", "{0} - {1}"),
    "MUL": Operation("{0} * {1}", "{0} * {1}"),
    "DIV": Operation("{0} / {1}", "{0} / {1}"),
    "NEG": Operation("-{0}", "-{0}"),
    "SQ": Operation("{0} * {0}", "{0} * {0}"),
    "TWICE": Operation("{0} + {0}", "{0} + {0}"),
    "INV": Operation("1.0 / {0}", "1.0 / {0}"),
    "SIN": Operation("np.sin({0})", "vsin({0})"),
    "COS": Operation("np.cos({0})", "vcos({0})"),
    "SIGN": Operation("np.sign({0})", "vselect({0} > 0.0) - vselect({0} < 0.0) + vkeep({0} != {0}, {0})"),
    "POW": Operation("np.power({0}, {1})", "vpair(pow, {0}, {1})"),
    "CONSTPOW": Operation("np.power({0}, {1})", "vpair(pow, {0}, {1})"),
    "ATAN2": Operation("np.arctan2({0}, {1})", "vpair(atan2, {0}, {1})"),
    "NOT": Operation("({0} == 0.0) * 1.0", "vselect({0} == 0.0)"),
    "IF_ELSE_ZERO": Operation("np.where({0} != 0.0, {1}, 0.0)", "vkeep({0} != 0.0, {1})"),
}
for _name in ("fabs", "sqrt", "tan", "exp", "log", "sinh", "cosh", "tanh", "floor", "ceil"):
    OPERATIONS[_name.upper()] = Operation(f"np.{_name}({{0}})", f"veach({_name}, {{0}})")
for _name in ("sin", "cos", "tan"):
    OPERATIONS[f"A{_name.upper()}"] = Operation(f"np.arc{_name}({{0}})", f"veach(a{_name}, {{0}})")
for _name in ("fmin", "fmax"):
    OPERATIONS[_name.upper()] = Operation(f"np.{_name}({{0}}, {{1}})", f"vpair({_name}, {{0}}, {{1}})")
for _name, _sign in (("LT", "<"), ("LE", "<="), ("EQ", "=="), ("NE", "!=")):
    OPERATIONS[_name] = Operation(f"({{0}} {_sign} {{1}}) * 1.0", f"vselect({{0}} {_sign} {{1}})")
for _name, _sign in (("AND", "&"), ("OR", "|")):
    _both = f"({{0}} != 0.0) {_sign} ({{1}} != 0.0)"
    OPERATIONS[_name] = Operation(f"({_both}) * 1.0", f"vselect({_both})")

_BY_CODE = {getattr(ca, f"OP_{name}"): name for name in OPERATIONS}


class Step(NamedTuple):
    """Step of a program: ``values[result] = name(*values[arguments])``."""

    name: str
    result: int
    arguments: tuple[int, ...]


class Program(NamedTuple):
    """Operations that compute a function's outputs, one sample at a time."""

    inputs: dict[int, int]  # value index -> row of the stacked inputs (all inputs one below the other)
    constants: dict[int, float]  # value index -> number
    steps: tuple[Step, ...]  # operations in order
    outputs: tuple[int, ...]  # value index of each non-zero output, in CasADi's order, outputs one below the other
    input_sizes: tuple[int, ...]  # size of each input


def read_program(function: ca.Function) -> Program:
    """Read the operation list of an SX function.

    Raises:
        TypeError: if the function is not made of scalar (SX) operations or uses one that is not supported.
    """
    if not function.is_a("SXFunction"):
        raise TypeError(f"{function.name()} is not an SX function: expand() it first")
    sizes = tuple(function.nnz_in(k) for k in range(function.n_in()))
    rows = list(accumulate(sizes, initial=0))
    offsets = list(accumulate(map(function.nnz_out, range(function.n_out())), initial=0))
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
        elif code in _BY_CODE:
            steps.append(Step(_BY_CODE[code], size, tuple(register[s] for s in source)))
        else:
            raise TypeError(f"{function.name()} uses CasADi operation {code}, which the kernel does not know")
        register[target[0]] = size
        size += 1
    if -1 in outputs:
        raise TypeError(f"{function.name()} leaves an output unset")
    return Program(inputs, constants, tuple(steps), tuple(outputs), sizes)
