"""Writes a program as Python that NumPy runs over blocks of samples: no compiler needed."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ...common.arrays import Array
from .program import OPERATIONS, Program

_BLOCK = 4096
"""Samples per block: what is at work stays in the processor's cache."""


def numpy_rows(program: Program) -> Callable[[Sequence[Array], Array], None]:
    """Make the function that evaluates a program: of its inputs, and of ``out`` (entries x N), which it fills."""
    names: dict[str, Any] = {"np": np}
    exec(python_source(program), names)

    def rows(inputs: Sequence[Array], out: Array) -> None:
        # Silent like compiled code: overflow gives inf and a wrong argument nan.
        with np.errstate(all="ignore"):
            for start in range(0, out.shape[1], _BLOCK):
                part = slice(start, start + _BLOCK)
                entries = [row for x in inputs for row in (np.ascontiguousarray(x[part].T) if x.ndim == 2 else x)]
                names["run"](entries, out[:, part])

    return rows


def python_source(program: Program) -> str:
    """Write ``run(rows, out)``, of a row for each input's entry; each value is forgotten after its last use."""
    lines = [f"x{k} = rows[{row}]" for k, row in program.inputs.items()]
    lines += [f"x{k} = np.float64('{value!r}')" for k, value in program.constants.items()]
    last = {value: k for k, step in enumerate(program.steps) for value in step.arguments}
    for k, step in enumerate(program.steps):
        values = [f"x{value}" for value in step.arguments]
        lines.append(f"x{step.result} = {OPERATIONS[step.name].numpy.format(*values)}")
        used = set(step.arguments) - set(program.outputs)
        lines += [f"del x{value}" for value in sorted(used) if last[value] == k]
    lines += [f"out[{row}] = x{k}" for row, k in enumerate(program.outputs)]
    return "\n    ".join(["def run(rows, out):", *lines, "return"])
