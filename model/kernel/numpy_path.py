"""Runs a program over blocks of samples with NumPy: no compiler needed."""

import numpy as np

from ..arrays import Array
from .operations import OPERATIONS
from .program import Program

BLOCK = 4096
"""Samples per block: the working set stays in the processor's cache."""


class NumpyPath:
    """Evaluates one program; every intermediate result lives in a register that is used again."""

    def __init__(self, program: Program) -> None:
        """Assign a register to each step's result."""
        self._program = program
        self._registers: dict[int, int] = {}
        free: list[int] = []
        count = 0
        dead: dict[int, list[int]] = {}
        for value, k in program.last_use.items():
            dead.setdefault(k, []).append(value)
        for k, step in enumerate(program.steps):
            # A result never overwrites an argument of its own step: not every operation allows that.
            if free:
                self._registers[step.result] = free.pop()
            else:
                self._registers[step.result] = count
                count += 1
            free += [self._registers[value] for value in dead.get(k, []) if value in self._registers]
        self._count = count

    def __call__(self, inputs: Array, outputs: Array) -> None:
        """Fill ``outputs`` (rows x N) from ``inputs`` (rows x N)."""
        work = np.empty((self._count, BLOCK))
        # Silent like compiled code: overflow gives inf and a wrong argument nan.
        with np.errstate(all="ignore"):
            for start in range(0, inputs.shape[1], BLOCK):
                stop = min(start + BLOCK, inputs.shape[1])
                self._block(inputs[:, start:stop], outputs[:, start:stop], work[:, : stop - start])

    def _block(self, inputs: Array, outputs: Array, work: Array) -> None:
        program = self._program
        values: dict[int, Array | float] = {k: inputs[row] for k, row in program.inputs.items()}
        values.update(program.constants)
        for step in program.steps:
            result = work[self._registers[step.result]]
            OPERATIONS[step.name].numpy(*(values[k] for k in step.arguments), out=result)
            values[step.result] = result
        for row, value in enumerate(program.outputs):
            outputs[row] = values[value]
