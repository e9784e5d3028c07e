"""How badly a robot's model fits thin samples of recordings."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...common.arrays import Array
from ...common.linear import least_squares
from ...model import Robot, regressor, standard_columns
from ...model.kernel import Kernel
from ...model.many_states import own_columns, regressor_at
from .sample import Sample

Regressor = Callable[[Sample], Array]
"""Phi_s at every instant of a sample, N x n x columns."""
_RANK = 1e-5
_NOTHING = 1e-10  # of the largest column: rounding


@dataclass(frozen=True)
class Model:
    """The space of torques that a robot can show on a sample's motion, whatever its parameters.

    With joints ``apart`` each has parameters of its own, so that a motor's current of unknown gain is seen as
    well as a torque: of coupled drives the first motor's row then holds what both joints show.

    Attributes:
        robot: as it is taken to be.
        known: torque of a spring, which joins the measured one, N x n.
        scale: norm of each joint's torque [N·m or N], shape (n,).
        Q: orthonormal basis of the weighted columns, rows x rank.
        apart: whether each joint has parameters of its own.
    """

    robot: Robot
    sample: Sample
    known: Array
    scale: Array
    Q: Array
    apart: bool = False

    @staticmethod
    def of(robot: Robot, sample: Sample, evaluate: Regressor | None = None, apart: bool = False) -> "Model":
        """Evaluate the robot's standard regressor, by ``evaluate`` if that is there already."""
        known = np.zeros(sample.torque.shape)
        if robot.spring is not None and not apart:
            k = robot.spring.joint - 1
            known[:, k] = robot.spring.torque(sample.q[:, k])
        scale = _norms(sample.torque, sample)
        W = evaluate(sample) if evaluate else _tried_once(robot, sample)
        if apart:
            W = _joint_by_joint(robot, W)
        rows = (W / scale[:, None])[sample.keep]
        norms = np.linalg.norm(rows, axis=0)
        there = norms > _NOTHING * norms.max(initial=0.0)
        rows = rows[:, there] / norms[there]
        # A Gram matrix is accurate enough to compare misfits, and fast.
        squares, V = np.linalg.eigh(rows.T @ rows)
        significant = squares > _RANK**2 * squares.max(initial=0.0)
        return Model(robot, sample, known, scale, rows @ (V[:, significant] / np.sqrt(squares[significant])), apart)

    def beside(self, robot: Robot, sample: Sample) -> "Model":
        """Another robot or reading of the recording, seen as this one is."""
        return Model.of(robot, sample, apart=self.apart)

    def misfit(self, torque: Array | None = None) -> float:
        """Root mean square over the joints of error norm over torque norm.

        Args:
            torque: other torques than the sample's, N x n.
        """
        return float(np.sqrt(np.mean(self.per_joint(torque) ** 2)))

    def per_joint(self, torque: Array | None = None) -> Array:
        """Error norm over torque norm of each joint, shape (n,)."""
        torque = self.sample.torque if torque is None else torque
        error = np.zeros(torque.shape)
        error[self.sample.keep] = self._error(torque + self.known)
        return np.asarray(np.linalg.norm(error, axis=0) * self.scale / _norms(torque, self.sample))

    def gain(self, joint: int) -> float:
        """Factor on one joint's torque with which it fits the others best."""
        own = self._channel(joint)
        a, b = self._error(own), self._error(self.sample.torque + self.known - own)
        return -float(a @ b) / max(float(a @ a), 1e-300)

    def gains(self) -> Array:
        """Factors on the joints' torques with which they fit one another best; 1 for the largest torque; (n,)."""
        n = self.robot.n
        A, fixed = np.array([self._error(self._channel(j)) for j in range(n)]).T, int(np.argmax(self.scale))
        free = [j for j in range(n) if j != fixed]
        factors = np.ones(n)
        factors[free] = -least_squares(A[:, free], A[:, fixed])
        return factors

    def with_column(self, column: Array) -> tuple[float, float]:
        """One more column in the joints' equations, N x n: its coefficient, and the misfit that is left."""
        more, error = self._error(column), self._error(self.sample.torque + self.known)
        size, whole = float(more @ more), float(np.sum((column / self.scale)[self.sample.keep] ** 2))
        x = float(more @ error) / size if size > 1e-12 * whole else 0.0
        return x, float(np.sqrt(np.sum((error - x * more) ** 2) / self.robot.n))

    def _channel(self, joint: int) -> Array:
        """The torque of one joint alone, N x n."""
        own = np.zeros(self.sample.torque.shape)
        own[:, joint] = self.sample.torque[:, joint]
        return own

    def _error(self, torque: Array) -> Array:
        """What the model leaves of torques, N x n, at the rows that are used and in units of each joint's own."""
        y = (torque / self.scale)[self.sample.keep]
        return np.asarray(y - self.Q @ (self.Q.T @ y))


def _joint_by_joint(robot: Robot, W: Array) -> Array:
    """Columns of each joint's own, N x n x (n or more times as many)."""
    n, count = W.shape[1:]
    wide = np.zeros((len(W), n, (n + 1) * count))
    for j in range(n):
        wide[:, j, j * count : (j + 1) * count] = W[:, j]
    if robot.coupling is not None:
        first, second = (joint - 1 for joint in robot.coupling.joints)
        wide[:, first, n * count :] = W[:, second]
    return wide[:, :, wide.any(axis=(0, 1))]


def _norms(torque: Array, sample: Sample) -> Array:
    """Norm of each joint's torque over the rows that are used, 1 where it is zero, shape (n,)."""
    norms = np.linalg.norm(np.where(sample.keep, torque, 0.0), axis=0)
    return np.where(norms == 0.0, 1.0, norms)


def compiled(robot: Robot) -> Regressor:
    """The standard regressor by compiled code: worth its time where one robot is tried on hundreds of samples."""
    function = regressor(robot, standard_columns(robot))
    kernel = Kernel(function)

    def on(sample: Sample) -> Array:
        motion = (np.ascontiguousarray(x) for x in (sample.q, sample.qd, sample.qdd))
        W = np.zeros((len(sample.t), *function.size_out(0)))
        W[:, kernel.rows, kernel.columns] = kernel(*motion).T
        return W

    return on


def _tried_once(robot: Robot, sample: Sample) -> Array:
    """Columns that span the standard regressor, for a robot for which code does not pay, N x n x columns."""
    return regressor_at(robot, own_columns(robot), sample.q, sample.qd, sample.qdd).transpose(2, 0, 1)
