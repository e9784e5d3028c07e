"""Writes a CasADi SX function as readable scalar C: one sample per call, only <math.h>."""

import re
from collections import Counter

import casadi as ca

from .c_path import c_number
from .operations import OPERATIONS
from .program import Program, read_program

_WIDTH = 90
"""Expressions up to this length are written where they are used, if only once."""

_SCALAR = (  # how the vector expressions read for a single number
    (r"v(?:each|pair)\((\w+), ", r"\1("),
    (r"v(sin|cos)\(", r"\1("),
    (r"vselect\(", "(double)("),
    (r"vkeep\((.*), (.*)\)", r"(\1 ? \2 : 0.0)"),
    (r" ([&|]) ", r" \1\1 "),
)


def c_body(function: ca.Function) -> list[str]:
    """Statements of a C function that computes the function's one output from its inputs.

    Inputs and output are arrays called as in the function, the output dense and row-major.

    Raises:
        TypeError: if the function is not made of scalar operations the kernel knows.
    """
    program = read_program(function)
    lines, values = _statements(program, _input_names(function))
    name, (rows, columns) = function.name_out(0), function.size_out(0)
    sparsity = function.sparsity_out(0).get_triplet()
    places = sorted((row * columns + column, k) for k, (row, column) in enumerate(zip(*sparsity, strict=True)))
    unused = [function.name_in(k) for k in range(function.n_in()) if not _used(program, function, k)]
    head = [f"(void){name};" for name in unused]
    if len(places) < rows * columns:
        head.append(f"for (int k = 0; k < {rows * columns}; ++k) {name}[k] = 0.0;")
    return [*head, *lines, *(f"{name}[{place}] = {values[program.outputs[k]]};" for place, k in places)]


def _input_names(function: ca.Function) -> list[str]:
    """C expression of each stacked input row."""
    return [f"{function.name_in(k)}[{i}]" for k in range(function.n_in()) for i in range(function.nnz_in(k))]


def _used(program: Program, function: ca.Function, which: int) -> bool:
    start = sum(function.nnz_in(k) for k in range(which))
    rows = range(start, start + function.nnz_in(which))
    read = {argument for step in program.steps for argument in step.arguments} | set(program.outputs)
    return any(value in read and row in rows for value, row in program.inputs.items())


def _statements(program: Program, inputs: list[str]) -> tuple[list[str], dict[int, str]]:
    """Declarations of what is used more than once, and the C expression of every value."""
    uses = Counter(program.outputs)
    for step in program.steps:
        for place, argument in enumerate(step.arguments):
            uses[argument] += OPERATIONS[step.name].c.count(f"{{{place}}}")
    values = {k: inputs[row] for k, row in program.inputs.items()}
    values |= {k: c_number(value) for k, value in program.constants.items()}
    lines: list[str] = []
    for step in program.steps:
        text = _scalar(step.name).format(*(_operand(values[k]) for k in step.arguments))
        if uses[step.result] > 1 or len(text) > _WIDTH:
            name = f"x{len(lines)}"
            lines.append(f"const double {name} = {text};")
            text = name
        values[step.result] = text
    return lines, values


def _scalar(name: str) -> str:
    template = OPERATIONS[name].c
    for pattern, replacement in _SCALAR:
        template = re.sub(pattern, replacement, template)
    return template


def _operand(text: str) -> str:
    """``text`` as an operand: in parentheses unless it is a name, an entry of an array or a plain number."""
    return text if re.fullmatch(r"[\w.]+(\[\d+\])?", text) else f"({text})"
