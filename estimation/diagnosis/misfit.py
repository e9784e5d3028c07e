"""Thin samples of recordings, ways to read their joints, and how badly a robot's model fits them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from math import pi

import numpy as np

from ...common.arrays import Array
from ...common.linear import least_squares
from ...model import Processing, Recording, Robot, regressor, standard_columns
from ...model.kernel import Kernel
from ...model.many_states import own_columns, regressor_at
from ...model.motion import Measurement
from ..signals.filtering import lowpass
from ..signals.measurements import measurement
from ..signals.rows import Mask, kept_rows

_SAMPLES = 200
_STUCK = 0.5  # s
_CUTOFF = 0.4  # of the sample's own rate


@dataclass(frozen=True)
class Sample:
    """Some hundred instants of a recording.

    Attributes:
        source: name of the recording.
        t: time [s], shape (N,).
        q, qd, qdd: filtered motion [rad or m], shapes (N, n).
        torque: low-passed torque [N·m or N], shape (N, n).
        keep: which rows are used, N x n.
        stuck: where a joint's position is the very same number for over half a second, N x n.
        all_t: time of every sample of the recording [s].
        all_torque: low-passed torque at those, to read it at another time.
    """

    source: str
    t: Array
    q: Array
    qd: Array
    qdd: Array
    torque: Array
    keep: Mask
    stuck: Mask
    all_t: Array
    all_torque: Array

    @staticmethod
    def of(
        recording: Recording, processing: Processing, filtered: Measurement | None = None, count: int = _SAMPLES
    ) -> "Sample":
        """Take some 200 instants, evenly over the moving part; ``filtered`` is their measurement if it is there."""
        data = filtered or measurement(recording, processing)
        motion, step = data.motion, 1.0 / data.motion.rate
        keep = kept_rows(motion, processing)
        moving = np.flatnonzero(keep.any(axis=1))
        thin = max(1, len(moving) // count)
        cutoff = _CUTOFF / (thin * step) if thin > 1 else None
        torque = lowpass(data.torque, step, cutoff, recording.source)
        at = moving[thin // 2 :: thin]
        return Sample(
            recording.source, motion.t[at], motion.q[at], motion.qd[at], motion.qdd[at], torque[at], keep[at],
            _stuck(recording, motion.t[at]), motion.t, torque,
        )  # fmt: skip

    @staticmethod
    def joined(samples: Sequence["Sample"]) -> "Sample":
        """Samples of several recordings as one."""
        arrays = {
            field.name: np.concatenate([getattr(sample, field.name) for sample in samples])
            for field in fields(Sample)
            if field.name != "source"
        }
        return Sample(", ".join(sample.source for sample in samples), **arrays)

    def later(self, delay: "float | Array") -> "Sample":
        """This motion with the torque that was written ``delay`` [s] later."""
        times = self.t + delay
        torque = np.column_stack([np.interp(times, self.all_t, channel) for channel in self.all_torque.T])
        return replace(self, torque=torque)

    def part(self, start: int, stop: int, step: int = 1) -> "Sample":
        """Only some of the instants."""
        own = slice(start, stop, step)
        return replace(
            self, t=self.t[own], q=self.q[own], qd=self.qd[own], qdd=self.qdd[own], torque=self.torque[own],
            keep=self.keep[own], stuck=self.stuck[own],
        )  # fmt: skip


@dataclass(frozen=True)
class Reading:
    """How joint j of the robot is read: q_j = sign_j q_log[order_j] + quarters_j 90 degrees.

    Attributes:
        order: for each joint the column of the log, counted from 0.
        sign: +1 or -1: the log's sense of rotation, torque included.
        quarters: quarter turns to add, 0 to 3.
        torque: +1 or -1: sign of the torque alone.
    """

    order: tuple[int, ...]
    sign: tuple[int, ...]
    quarters: tuple[int, ...]
    torque: tuple[int, ...]

    @staticmethod
    def as_recorded(n: int) -> "Reading":
        """Every column as it stands."""
        return Reading(tuple(range(n)), (1,) * n, (0,) * n, (1,) * n)

    def swapped(self, i: int, j: int) -> "Reading":
        """The columns of two joints exchanged."""
        order = list(self.order)
        order[i], order[j] = order[j], order[i]
        return replace(self, order=tuple(order))

    def turned(self, *joints: int) -> "Reading":
        """Some joints counted the other way."""
        return replace(self, sign=_flipped(self.sign, joints))

    def pushed(self, j: int) -> "Reading":
        """The torque of one joint alone with the other sign."""
        return replace(self, torque=_flipped(self.torque, (j,)))

    def moved(self, j: int, quarters: int) -> "Reading":
        """The zero of one joint moved."""
        there = (self.quarters[j] + quarters) % 4
        return replace(self, quarters=(*self.quarters[:j], there, *self.quarters[j + 1 :]))

    def positions(self, q: Array) -> Array:
        """Joint positions [rad or m] from a log's, N x n."""
        return np.asarray(q[:, list(self.order)] * np.array(self.sign) + np.array(self.quarters) * (pi / 2))

    def of(self, sample: Sample) -> Sample:
        """A log's sample as it is read."""
        order, sign = list(self.order), np.array(self.sign)
        return replace(
            sample,
            q=self.positions(sample.q),
            qd=sample.qd[:, order] * sign,
            qdd=sample.qdd[:, order] * sign,
            torque=sample.torque[:, order] * (sign * np.array(self.torque)),
            keep=sample.keep[:, order],
        )

    @property
    def changes(self) -> int:
        """Number of joints and columns that are not taken as they stand."""
        moved = sum(column != j for j, column in enumerate(self.order))
        signs = sum(sign < 0 for sign in (*self.sign, *self.torque))
        return moved + signs + sum(quarter != 0 for quarter in self.quarters)

    def told(self) -> str:
        """In words, joints counted from 1; "as recorded" if nothing is changed."""
        parts = []
        for j in range(len(self.order)):
            words = []
            if self.order[j] != j:
                words.append(f"from column {self.order[j] + 1}")
            if self.sign[j] < 0:
                words.append("turned round (position and torque)")
            if self.quarters[j]:
                words.append(f"zero moved by {(90, 180, -90)[self.quarters[j] - 1]} degrees")
            if self.torque[j] < 0:
                words.append("torque turned round")
            if words:
                parts.append(f"joint {j + 1} {', '.join(words)}")
        return "; ".join(parts) or "as recorded"


def _flipped(signs: tuple[int, ...], joints: Sequence[int]) -> tuple[int, ...]:
    return tuple(-sign if j in joints else sign for j, sign in enumerate(signs))


def _stuck(recording: Recording, t: Array) -> Mask:
    """Instants of ``t`` within long stretches of one position, N x n."""
    result = np.zeros((len(t), recording.q.shape[1]), dtype=bool)
    for j, q in enumerate(recording.q.T):
        edges = np.flatnonzero(np.diff(q) != 0.0) + 1
        starts, stops = np.append(0, edges), np.append(edges - 1, len(q) - 1)
        long = recording.t[stops] - recording.t[starts] > _STUCK
        for start, stop in zip(recording.t[starts[long]], recording.t[stops[long]], strict=True):
            result[:, j] |= (t >= start) & (t <= stop)
    return result


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
        sample: the sample.
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
        kept = squares > _RANK**2 * squares.max(initial=0.0)
        return Model(robot, sample, known, scale, rows @ (V[:, kept] / np.sqrt(squares[kept])), apart)

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
