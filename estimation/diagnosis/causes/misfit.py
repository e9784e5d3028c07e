"""How badly a robot's model fits a sample, every joint in units of its own torque."""

import functools
from dataclasses import dataclass

import casadi as ca
import numpy as np

from ....common.arrays import Array
from ....common.linear import least_squares
from ....model import Robot, regressor, standard_columns
from .sample import Sample

_RANK = 1e-5
_NOTHING = 1e-10  # of the largest column: rounding


@dataclass(frozen=True)
class Model:
    """The space of torques that a robot can show on a sample's motion, whatever its parameters.

    Attributes:
        sample: the sample.
        known: torque of a spring, which joins the measured one, N x n.
        scale: norm of each joint's torque [N·m or N], shape (n,).
        Q: orthonormal basis of the weighted columns, rows x rank.
    """

    sample: Sample
    known: Array
    scale: Array
    Q: Array

    @staticmethod
    def of(robot: Robot, sample: Sample) -> "Model":
        """Evaluate the robot's standard regressor."""
        known = np.zeros(sample.torque.shape)
        if robot.spring is not None:
            k = robot.spring.joint - 1
            known[:, k] = robot.spring.torque(sample.q[:, k])
        keep = sample.keep
        W = _regressor_on(robot, sample)
        scale = np.linalg.norm(np.where(keep, sample.torque, 0.0), axis=0)
        scale[scale == 0.0] = 1.0
        rows = (W / scale[:, None])[keep]
        norms = np.linalg.norm(rows, axis=0)
        there = norms > _NOTHING * norms.max(initial=0.0)
        rows = rows[:, there] / norms[there]
        # A Gram matrix is accurate enough to compare misfits, and fast.
        squares, V = np.linalg.eigh(rows.T @ rows)
        kept = squares > _RANK**2 * squares.max(initial=0.0)
        return Model(sample, known, scale, rows @ (V[:, kept] / np.sqrt(squares[kept])))

    def misfit(self, torque: Array | None = None) -> float:
        """Root mean square over the joints of error norm over torque norm.

        Args:
            torque: other torques than the sample's, N x n.
        """
        return float(np.sqrt(np.mean(self.per_joint(torque) ** 2)))

    def per_joint(self, torque: Array | None = None) -> Array:
        """Error norm over torque norm of each joint, shape (n,)."""
        torque = self.sample.torque if torque is None else torque
        keep = self.sample.keep
        scale = np.linalg.norm(np.where(keep, torque, 0.0), axis=0)
        scale[scale == 0.0] = 1.0
        error = self._error(((torque + self.known) / self.scale)[keep])
        spread = np.zeros(keep.shape)
        spread[keep] = error
        return np.asarray(np.linalg.norm(spread, axis=0) * self.scale / scale)

    def gain(self, joint: int) -> float:
        """Factor on one joint's torque with which it fits the others best."""
        own = np.zeros(self.sample.torque.shape)
        own[:, joint] = self.sample.torque[:, joint]
        rest = self.sample.torque + self.known - own
        keep = self.sample.keep
        a, b = (self._error((part / self.scale)[keep]) for part in (own, rest))
        return -float(a @ b) / max(float(a @ a), 1e-300)

    def gains(self) -> Array:
        """Factors on the joints' torques with which they fit one another best; 1 for the largest torque; (n,)."""
        n, keep, scale = len(self.scale), self.sample.keep, self.scale
        columns = []
        for j in range(n):
            own = np.zeros(self.sample.torque.shape)
            own[:, j] = self.sample.torque[:, j]
            columns.append(self._error((own / scale)[keep]))
        A, fixed = np.array(columns).T, int(np.argmax(scale))
        free = [j for j in range(n) if j != fixed]
        factors = np.ones(n)
        factors[free] = -least_squares(A[:, free], A[:, fixed])
        return factors

    def with_column(self, column: Array) -> tuple[float, float]:
        """One more column in the joints' equations, N x n: its coefficient, and the misfit that is left."""
        keep = self.sample.keep
        more = self._error((column / self.scale)[keep])
        error = self._error(((self.sample.torque + self.known) / self.scale)[keep])
        size = float(more @ more)
        x = float(more @ error) / size if size > 1e-12 * float(np.sum((column / self.scale)[keep] ** 2)) else 0.0
        return x, float(np.sqrt(np.sum((error - x * more) ** 2) / len(self.scale)))

    def _error(self, y: Array) -> Array:
        return np.asarray(y - self.Q @ (self.Q.T @ y))


def _regressor_on(robot: Robot, sample: Sample) -> Array:
    """Phi_s at every instant, N x n x columns."""
    samples = len(sample.t)
    function, rows, columns, width = _mapped(robot, samples)
    values = function(sample.q.T, sample.qd.T, sample.qdd.T)
    W = np.zeros((samples, robot.n, width))
    W[:, rows, columns] = np.array(values.nonzeros()).reshape(samples, len(rows))
    return W


@functools.lru_cache(maxsize=128)
def _mapped(robot: Robot, samples: int) -> tuple[ca.Function, Array, Array, int]:
    """The standard regressor on all samples at once, the places of its entries, and the number of columns."""
    function = regressor(robot, standard_columns(robot))
    rows, columns = (np.array(places, dtype=int) for places in function.sparsity_out(0).get_triplet())
    return function.map(samples), rows, columns, function.size2_out(0)
