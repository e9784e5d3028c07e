"""The observation system Y = W chi + rho of (14), joint by joint as in (15), made block by block."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...common.arrays import Array
from ...common.linear import without
from .shared_torque import SharedTorque


@dataclass(frozen=True)
class Observation:
    """The equations of one recording, held whole.

    Attributes:
        columns: names of the columns of W.
        W: per joint, r_j x c.
        Y: per joint, torques [N·m or N], shape (r_j,); known torques (a spring) are already moved here.
        t: per joint, time of the rows [s], shape (r_j,).
        bandwidth: share of the frequency range that white noise fills; 1 without decimation.
        shared: what of a joint's torque is of another joint's motor (coupled drives), or of a known spring.
    """

    columns: tuple[str, ...]
    W: tuple[Array, ...]
    Y: tuple[Array, ...]
    t: tuple[Array, ...]
    bandwidth: float
    shared: tuple[SharedTorque, ...] = ()

    def between(self, start: float, stop: float) -> "Observation":
        """The equations with start <= t < stop [s]."""
        ends = [slice(*np.searchsorted(t, (start, stop))) for t in self.t]
        W, Y, t = (
            tuple(array[part] for array, part in zip(arrays, ends, strict=True))
            for arrays in (self.W, self.Y, self.t)
        )
        shared = tuple(torque._replace(torque=torque.torque[ends[torque.joint]]) for torque in self.shared)
        return replace(self, W=W, Y=Y, t=t, shared=shared)

    def eliminate(self, columns: Sequence[str]) -> "Observation":
        """The equations less all that some columns can explain, joint by joint; rows keep their times."""
        gone = [self.columns.index(name) for name in columns]
        rest = [k for k in range(len(self.columns)) if k not in gone]
        W, Y = [], []
        for A, y in zip(self.W, self.Y, strict=True):
            rows = np.column_stack([A[:, rest], y])
            left = without(rows, A[:, gone]) if len(y) else rows
            W.append(left[:, :-1])
            Y.append(left[:, -1])
        return Observation(tuple(self.columns[k] for k in rest), tuple(W), tuple(Y), self.t, self.bandwidth)

    def errors(self, values: Array) -> tuple[Array, ...]:
        """Y_j - W_j chi for each joint [N·m or N], shapes (r_j,); chi may be of the first columns alone."""
        return tuple(Y - W[:, : len(values)] @ values for W, Y in zip(self.W, self.Y, strict=True))
