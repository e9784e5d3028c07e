"""Runs a program over blocks of samples with NumPy: no compiler needed."""

from collections.abc import Sequence

import numpy as np

from ...common.arrays import Array
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
        self._target = {value: row for row, value in enumerate(program.outputs)}

    def rows(self, inputs: Sequence[Array], out: Array) -> None:
        """Fill ``out`` (entries x N)."""
        samples = out.shape[1]
        work = np.empty((self._count, BLOCK))
        # Silent like compiled code: overflow gives inf and a wrong argument nan.
        with np.errstate(all="ignore"):
            for start in range(0, samples, BLOCK):
                part = slice(start, min(start + BLOCK, samples))
                columns = [
                    column for x in inputs for column in (np.ascontiguousarray(x[part].T) if x.ndim == 2 else x)
                ]
                self._block(columns, out[:, part], work[:, : part.stop - start])

    def tiles(self, inputs: Sequence[Array], out: Array) -> None:
        """Fill ``out`` (tiles x entries x 8); spare places repeat the last sample."""
        samples = max((len(x) for x in inputs if x.ndim == 2), default=1)
        flat = np.empty((out.shape[1], samples))
        self.rows(inputs, flat)
        padded = np.pad(flat, ((0, 0), (0, 8 * len(out) - samples)), mode="edge")
        out[...] = padded.reshape(len(flat), -1, 8).swapaxes(0, 1)

    def _block(self, columns: list[Array], out: Array, work: Array) -> None:
        program = self._program
        values: dict[int, Array | float] = {k: columns[row] for k, row in program.inputs.items()}
        values.update(program.constants)
        for step in program.steps:
            target = self._target.get(step.result)
            result = work[self._registers[step.result]] if target is None else out[target]
            OPERATIONS[step.name].numpy(*(values[k] for k in step.arguments), out=result)
            values[step.result] = result
        for row, value in enumerate(program.outputs):
            if self._target[value] != row or value not in self._registers:
                out[row] = values[value]
