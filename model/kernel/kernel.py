"""Evaluation of one CasADi function on N samples, structure of arrays."""

import warnings
from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np

from ...common import Array
from .cache import CompilerUnavailable
from .program import OPERATIONS, Fill, Program, compiled_fill, read_program

NumpyRows = Callable[[Sequence[Array], Array], None]
"""Function of the inputs, and of the array of entries x N that it fills."""
_BLOCK = 4096  # samples per block: what is at work stays in the processor's cache


class Kernel:
    """Evaluates a scalar CasADi function on all samples at once.

    With a C compiler the function's own operation list is compiled for several samples per instruction and
    cached; without one, NumPy runs the same list over blocks of samples.

    Attributes:
        rows, columns: index of each non-zero entry in the function's first output.
    """

    def __init__(self, function: ca.Function) -> None:
        """Prepare the function."""
        program = read_program(function)
        self._function = function
        self._sizes = list(program.input_sizes)
        self._outputs = len(program.outputs)
        rows, columns = function.sparsity_out(0).get_triplet()
        self.rows, self.columns = np.array(rows, dtype=int), np.array(columns, dtype=int)
        self._compiled: Fill | None = None
        try:
            self._compiled = compiled_fill(program)
        except CompilerUnavailable as reason:
            if "failed" in str(reason):
                warnings.warn(f"{reason}; NumPy does the work instead", RuntimeWarning, stacklevel=1)
            self._rows = numpy_rows(program)

    def __reduce__(self) -> tuple[type["Kernel"], tuple[ca.Function]]:
        """Pickle the function; it is compiled, or read from the cache, where it is unpickled."""
        return Kernel, (self._function,)

    @property
    def compiled(self) -> bool:
        """True if compiled code does the work."""
        return self._compiled is not None

    def __call__(self, *inputs: Array) -> Array:
        """Evaluate on N samples.

        Args:
            inputs: one array per input of the function, each (N, size), or (size,) where all samples share it.

        Returns:
            The non-zero entries, shape (entries, N), in CasADi's (column-major) order.

        Raises:
            ValueError: if the inputs do not fit the function.
        """
        result = np.empty((self._outputs, self._samples(inputs)))
        if result.size:
            ready = [np.ascontiguousarray(x, dtype=np.float64) for x in inputs]
            if self._compiled is not None:
                self._compiled(ready, result[None], False)
            else:
                self._rows(ready, result)
        return result

    def chain(self, state: Array, *inputs: Array) -> Array:
        """Evaluate step after step: the first input is the state, which takes the first outputs of each step.

        Args:
            state: before the first step, (N, size).
            inputs: the others, each (steps, N, size), (N, size) where all steps share it, or (size,) where all
                samples do too; one at least differs from step to step.

        Returns:
            The entries of each step, shape (steps, entries, N).

        Raises:
            ValueError: if the inputs do not fit the function or each other.
        """
        if self._outputs < self._sizes[0]:  # compiled code would read beyond them
            raise ValueError(f"{self._outputs} outputs cannot be the next state of {self._sizes[0]} numbers")
        ready = [np.ascontiguousarray(x, dtype=np.float64) for x in inputs]
        steps = {len(x) for x in ready if x.ndim == 3}
        if len(steps) != 1 or state.ndim != 2:
            raise ValueError(f"inputs must have one number of steps and a state of two axes, got {steps or 'none'}")
        self._samples([state, *(x[0] if x.ndim == 3 else x for x in ready)])
        out = np.empty((steps.pop(), self._outputs, len(state)))
        if self._compiled is not None:
            self._compiled([np.array(state, dtype=np.float64, order="C"), *ready], out, True)
            return out
        # NumPy's way through a function, one call an operation, would take far longer for so few samples at once.
        symbols = [ca.SX.sym("x", size) for size in self._sizes]
        parts: list[ca.SX] = self._function.call(symbols)
        step = ca.Function("step", symbols, [ca.vertcat(*(part.nz[:] for part in parts))]).map(len(state))
        buffer: Any  # its stub asks for sizes, which a memoryview brings along
        buffer, evaluate = step.buffer()
        entries, given = np.empty((len(state), self._outputs)), [np.empty((len(state), x)) for x in self._sizes]
        for k, x in enumerate(given):
            buffer.set_arg(k, x.data)
        buffer.set_res(0, entries.data)
        given[0][:] = state
        for k in range(len(out)):
            for own, x in zip(given[1:], ready, strict=True):
                own[:] = x[k] if x.ndim == 3 else x
            evaluate()
            out[k] = entries.T
            given[0][:] = entries[:, : self._sizes[0]]
        return out

    def _samples(self, inputs: Sequence[Array]) -> int:
        sizes = [x.shape[-1] for x in inputs if x.ndim in (1, 2)]
        counts = {len(x) for x in inputs if x.ndim == 2}
        if sizes != self._sizes or len(counts) > 1:
            shapes = ", ".join(str(x.shape) for x in inputs)
            raise ValueError(f"inputs of shapes {shapes} do not fit: sizes must be {self._sizes}, N one number")
        return counts.pop() if counts else 1


def numpy_rows(program: Program) -> NumpyRows:
    """Make the function that evaluates a program."""
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
