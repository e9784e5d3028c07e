"""Runs a program over blocks of samples with NumPy: no compiler needed."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ...common.arrays import Array
from .program import OPERATIONS, Program

BLOCK = 4096
"""Samples per block: the working set stays in the processor's cache."""
_KEPT = 2
"""Blocks of so many sizes stay ready: a search asks for two grids in turn."""


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
        self._blocks: dict[int, _Block] = {}

    def rows(self, inputs: Sequence[Array], out: Array) -> None:
        """Fill ``out`` (entries x N)."""
        samples = out.shape[1]
        # Silent like compiled code: overflow gives inf and a wrong argument nan.
        with np.errstate(all="ignore"):
            for start in range(0, samples, BLOCK):
                part = slice(start, min(start + BLOCK, samples))
                block = self._taken(part.stop - start)
                block.fill([x[part] if x.ndim == 2 else x for x in inputs])
                for compute, arrays in block.calls:
                    compute(*arrays)
                out[:, part] = block.outputs
                self._blocks[part.stop - start] = block
        for samples in list(self._blocks)[:-_KEPT]:
            self._blocks.pop(samples, None)

    def tiles(self, inputs: Sequence[Array], out: Array) -> None:
        """Fill ``out`` (tiles x entries x 8); spare places repeat the last sample."""
        samples = max((len(x) for x in inputs if x.ndim == 2), default=1)
        flat = np.empty((out.shape[1], samples))
        self.rows(inputs, flat)
        padded = np.pad(flat, ((0, 0), (0, 8 * len(out) - samples)), mode="edge")
        out[...] = padded.reshape(len(flat), -1, 8).swapaxes(0, 1)

    def _taken(self, samples: int) -> "_Block":
        """A block of that size, taken out while it works: two threads never share one."""
        block = self._blocks.pop(samples, None)
        return block or _Block(self._program, self._registers, self._count, samples)


class _Block:
    """A program's arrays for one number of samples, and its operations on them, to be called one after the other.

    To look up each operation and its arrays anew takes longer than to compute a few hundred samples.
    """

    def __init__(self, program: Program, registers: dict[int, int], count: int, samples: int) -> None:
        """Place every value."""
        self._inputs = np.empty((sum(program.input_sizes), samples))
        self.outputs = np.empty((len(program.outputs), samples))
        work, target = np.empty((count, samples)), {value: row for row, value in enumerate(program.outputs)}
        values = {k: self._inputs[row] for k, row in program.inputs.items()}
        values |= {k: np.array(number) for k, number in program.constants.items()}
        self.calls: list[tuple[Callable[..., Any], tuple[Array, ...]]] = []
        for step in program.steps:
            row = target.get(step.result)
            result = work[registers[step.result]] if row is None else self.outputs[row]
            self.calls.append((OPERATIONS[step.name].numpy, (*(values[k] for k in step.arguments), result)))
            values[step.result] = result
        for row, value in enumerate(program.outputs):
            if target[value] != row or value not in registers:
                self.calls.append((np.positive, (values[value], self.outputs[row])))

    def fill(self, inputs: Sequence[Array]) -> None:
        """Take the samples of each input, (N, size), or (size,) where all share it."""
        row = 0
        for x in inputs:
            rows = self._inputs[row : row + x.shape[-1]]
            rows[...] = x.T if x.ndim == 2 else x[:, None]
            row += len(rows)
