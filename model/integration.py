"""Integration of robots that move by themselves: smooth dry friction, Runge-Kutta's step, and its length."""

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np

from ..common.arrays import Array
from .kernel.kernel import Kernel

SMOOTHING = 0.01
"""Width w of tanh(qd / w), which stands for the sign of a speed in dry friction [rad/s or m/s]."""
_STABLE = 2.0  # largest rate times step; Runge-Kutta's limit on the real axis is 2.78


def runge_kutta(
    slope: Callable[[ca.SX, ca.SX], ca.SX], x: ca.SX, h: ca.SX, inputs: tuple[ca.SX, ca.SX, ca.SX]
) -> ca.SX:
    """Step a state by the classical fourth-order method.

    Args:
        slope: time derivative of the state, by state and input.
        x: state at the start.
        h: step [s].
        inputs: at the start, middle and end of the step.
    """
    start, middle, end = inputs
    k1 = slope(x, start)
    k2 = slope(x + 0.5 * h * k1, middle)
    k3 = slope(x + 0.5 * h * k2, middle)
    k4 = slope(x + h * k3, end)
    return x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


def stable_steps(fastest: float, interval: float) -> int:
    """Number of steps in ``interval`` [s] that integrates a rate [1/s] stably."""
    return int(np.ceil(fastest * interval / _STABLE))


class Stepper:
    """Integrates a batch of runs over many steps: compiled, or by CasADi's own machine.

    NumPy's way through a function, one call an operation, would take far longer for so few runs at once.
    """

    def __init__(self, step: ca.Function) -> None:
        """Compile the step if there is a compiler."""
        self._step = step
        self._kernel = Kernel(step)
        self._mapped: dict[int, ca.Function] = {}

    def __call__(self, state: Array, *inputs: Array) -> Array:
        """Step again and again; the state takes the first outputs of each step.

        Args:
            state: before the first step, (runs, size).
            inputs: the others, (steps, runs, size), or (runs, size) for all steps; the last (size,) for all runs.

        Returns:
            The function's entries after each step, shape (steps, entries, runs).
        """
        if self._kernel.compiled:
            return self._kernel.chain(state, *inputs)
        steps = max(len(x) for x in inputs if x.ndim == 3)
        out = np.empty((steps, self._step.numel_out(0), len(state)))
        for k in range(steps):
            out[k] = self._once(state, *(x[k] if x.ndim == 3 else x for x in inputs))
            state = out[k, : state.shape[1]].T
        return out

    def _once(self, *inputs: Array) -> Array:
        """Take one step by CasADi's machine, entries x runs."""
        runs = len(inputs[0])
        if runs not in self._mapped:
            shared = [self._step.n_in() - 1]
            self._mapped[runs] = self._step.map(f"step{runs}", "serial", runs, shared, [])
        buffer: Any
        buffer, trigger = self._mapped[runs].buffer()
        arrays: list[Any] = [np.ascontiguousarray(x) for x in inputs]  # rows here are CasADi's columns
        out: Any = np.empty((runs, self._step.numel_out(0)))
        for k, x in enumerate(arrays):
            buffer.set_arg(k, memoryview(x))
        buffer.set_res(0, memoryview(out))
        trigger()
        return np.asarray(out.T)
