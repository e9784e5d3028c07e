"""The kernel: one CasADi function on N samples, structure of arrays."""

import warnings

import casadi as ca
import numpy as np

from ..arrays import Array
from .c_path import CPath
from .cache import CompilerUnavailable
from .numpy_path import NumpyPath
from .program import read_program


class Kernel:
    """Evaluates a scalar CasADi function on all samples at once.

    With a C compiler the function's own operation list is compiled for eight samples per instruction and
    cached; without one, NumPy runs the same list over blocks of samples.

    Attributes:
        rows, columns: place of each non-zero entry in the function's first output.
        compiled: whether compiled code does the work.
    """

    def __init__(self, function: ca.Function) -> None:
        """Prepare the function.

        Raises:
            TypeError: if the function is not an SX function or has an operation the kernel does not know.
        """
        program = read_program(function)
        self._sizes = [function.nnz_in(k) for k in range(function.n_in())]
        self._outputs = len(program.outputs)
        rows, columns = function.sparsity_out(0).get_triplet()
        self.rows, self.columns = np.array(rows, dtype=int), np.array(columns, dtype=int)
        self._path: CPath | NumpyPath
        try:
            self._path = CPath(program)
        except CompilerUnavailable as reason:
            if "failed" in str(reason):
                warnings.warn(f"{reason}; NumPy does the work instead", RuntimeWarning, stacklevel=2)
            self._path = NumpyPath(program)

    @property
    def compiled(self) -> bool:
        """Whether compiled code does the work."""
        return isinstance(self._path, CPath)

    def __call__(self, *inputs: Array) -> Array:
        """Evaluate on N samples.

        Args:
            inputs: one array per input of the function, each (N, size), or (size,) where all samples
                share it.

        Returns:
            The non-zero entries, shape (entries, N), in CasADi's (column-major) order.

        Raises:
            ValueError: if the inputs do not fit the function.
        """
        sizes = [x.shape[-1] for x in inputs if x.ndim in (1, 2)]
        counts = {len(x) for x in inputs if x.ndim == 2}
        if sizes != self._sizes or len(counts) > 1:
            shapes = ", ".join(str(x.shape) for x in inputs)
            raise ValueError(f"inputs of shapes {shapes} do not fit: sizes must be {self._sizes}, N one number")
        samples = counts.pop() if counts else 1
        stacked = np.empty((sum(sizes), samples))
        start = 0
        for x, size in zip(inputs, sizes, strict=True):
            stacked[start : start + size] = x.T if x.ndim == 2 else x[:, None]
            start += size
        result = np.empty((self._outputs, samples))
        self._path(stacked, result)
        return result
