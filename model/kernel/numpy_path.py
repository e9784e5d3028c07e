"""Runs a program over blocks of samples with NumPy: no compiler needed."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ...common.arrays import Array
from .program import OPERATIONS, Program

BLOCK = 4096
"""Samples per block: the working set stays in the processor's cache."""
_KEPT = 2
"""Number of block sizes that stay ready: a search asks for two grids in turn."""
_Block = tuple[Array, Array, list[tuple[Callable[..., Any], tuple[Array, ...]]]]
"""Inputs and outputs of one number of samples, and the operations on them, to be called one after the other."""


class NumpyPath:
    """Evaluates one program; every intermediate result lives in a register that is used again."""

    def __init__(self, program: Program) -> None:
        """Assign a register to each step's result."""
        self._program = program
        self._registers: dict[int, int] = {}
        self._count, outputs = 0, set(program.outputs)
        free: list[int] = []
        dead: dict[int, list[int]] = {}
        last_use = {value: k for k, step in enumerate(program.steps) for value in step.arguments}
        for value, k in last_use.items():
            if value not in outputs:
                dead.setdefault(k, []).append(value)
        for k, step in enumerate(program.steps):
            # A result never overwrites an argument of its own step: not every operation allows that.
            self._registers[step.result] = free.pop() if free else self._count
            self._count = max(self._count, self._registers[step.result] + 1)
            free += [self._registers[value] for value in dead.get(k, []) if value in self._registers]
        self._blocks: dict[int, _Block] = {}

    def rows(self, inputs: Sequence[Array], out: Array) -> None:
        """Fill ``out`` (entries x N)."""
        samples = out.shape[1]
        # Silent like compiled code: overflow gives inf and a wrong argument nan.
        with np.errstate(all="ignore"):
            for start in range(0, samples, BLOCK):
                part = slice(start, min(start + BLOCK, samples))
                size = part.stop - start
                # Taken out while it works: two threads never share one.
                block = self._blocks.pop(size, None) or self._block(size)
                stacked, results, calls = block
                row = 0
                for x in inputs:
                    stacked[row : row + x.shape[-1]] = x[part].T if x.ndim == 2 else x[:, None]
                    row += x.shape[-1]
                for compute, arrays in calls:
                    compute(*arrays)
                out[:, part] = results
                self._blocks[size] = block
        for samples in list(self._blocks)[:-_KEPT]:
            self._blocks.pop(samples, None)

    def _block(self, samples: int) -> _Block:
        """Allocate every value for one number of samples.

        To look up each operation and its arrays anew takes longer than to compute a few hundred samples.
        """
        program = self._program
        inputs = np.empty((sum(program.input_sizes), samples))
        outputs = np.empty((len(program.outputs), samples))
        work, target = np.empty((self._count, samples)), {value: row for row, value in enumerate(program.outputs)}
        values = {k: inputs[row] for k, row in program.inputs.items()}
        values |= {k: np.array(number) for k, number in program.constants.items()}
        calls: list[tuple[Callable[..., Any], tuple[Array, ...]]] = []
        for step in program.steps:
            row = target.get(step.result)
            result = work[self._registers[step.result]] if row is None else outputs[row]
            calls.append((OPERATIONS[step.name].numpy, (*(values[k] for k in step.arguments), result)))
            values[step.result] = result
        for row, value in enumerate(program.outputs):
            if target[value] != row or value not in self._registers:
                calls.append((np.positive, (values[value], outputs[row])))
        return inputs, outputs, calls
