"""Makes the observation system of (14) from measurements, block by block."""

import copy
import functools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...model import Motion, Processing, Robot
from ...model.kernel.kernel import Kernel
from ...model.motion import Measurement
from ...model.regressors import regressor_expression
from ..signals.decimation import Decimator, noise_bandwidth
from ..signals.rows import Mask, used_rows
from .observation import Observation
from .shared_torque import NO_MOTOR, SharedTorque, known_spring, sharing

PATH = "path"
"""The column of a difference's torque that is taken off its right-hand side because the paths differ."""


@functools.lru_cache(maxsize=16)
def equation_code(robot: Robot, columns: tuple[str, ...]) -> tuple[Kernel, tuple[Array, ...]]:
    """Kernel of q, qd, qdd, torque to each joint's entries and torques, and the columns of the entries.

    With a known spring its torque in the recording that was subtracted is one more input; of the column ``PATH``,
    which is taken off the torques, its values are.
    """
    standard = [name for name in columns if name != PATH]
    motors, (q, qd, qdd), phi = sharing(robot), *regressor_expression(robot, standard)
    torque, path = ca.SX.sym("torque", robot.n), ca.SX.sym("path", robot.n)
    left = ca.SX(torque)
    with_path = PATH in columns
    if with_path:
        left -= path
        place = columns.index(PATH)
        phi = ca.horzcat(phi[:, :place], path, phi[:, place:])
    inputs, apart = [q, qd, qdd, torque], {motor: left[motor] for motor in range(robot.n)}
    spring = known_spring(robot)
    if spring is not None:
        joint, before = spring.joint - 1, ca.SX.sym("before")
        apart[NO_MOTOR] = spring.torque_symbol(q[joint]) - before
        left[joint] += apart[NO_MOTOR]
        inputs.append(before)
    if with_path:
        inputs.append(path)
    phi, left = _of_each_motor(robot, phi, left)
    rows, touched = [], []
    for j in range(robot.n):
        own = phi[j, :].sparsity().get_triplet()[1]
        touched.append(np.array(own, dtype=int))
        rows += [phi[j, k] for k in own] + [left[j], *(apart[motor] for motor in motors[j])]
    return Kernel(ca.Function("equations", inputs, [ca.cse(ca.vertcat(*rows))])), tuple(touched)


def _of_each_motor(robot: Robot, phi: ca.SX, left: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Rows of the regressor and their torques, of coupled drives those of the motors where these are asked for."""
    if robot.coupling is None or robot.coupling.rows == "joint":
        return phi, left
    j, k = (joint - 1 for joint in robot.coupling.joints)
    # Joint j holds both motors' torque (9); less joint k's, motor j's is left.
    phi[j, :] -= phi[k, :]
    left[j] -= left[k]
    return ca.sparsify(phi), left


_PART = 1024  # samples evaluated at once
_PIECE = 4096  # decimated samples of a piece


@dataclass(frozen=True)
class Block:
    """Decimated equations of a stretch of time.

    Attributes:
        equations: for each joint the non-zero entries of its row of the regressor, then its torque [N·m or N],
            known torques already moved there, and what of it its own motor does not make;
            (entries + n + shared) x M.
        keep: which rows are used, n x M.
        t: time [s], shape (M,).
    """

    equations: Array
    keep: Mask
    t: Array


class Used(NamedTuple):
    """A measurement, its rows to use (N x n), and the factor that thins its equations."""

    data: Measurement
    keep: Mask
    factor: int


class Observer:
    """Turns measurements of one robot into equations in chosen columns.

    Attributes:
        columns: what the columns are called.
        place: position of each column among the distinct ones that are evaluated.
        distinct: number of those.
        rows: per joint, where its entries and torque stand among a block's equations.
        touched: per joint, the distinct columns of its entries.
        motors: per joint, whose torque stands behind its own: other motors (from 0), ``NO_MOTOR`` for a spring.
    """

    def __init__(self, robot: Robot, columns: Sequence[str], names: Sequence[str] | None = None) -> None:
        """Generate the code of the columns' regressor.

        Args:
            columns: standard parameters whose columns make up W, may repeat; and ``PATH``.
            names: what the columns are called, by default the standard names.
        """
        self.robot = robot
        self.motors = sharing(robot)
        self._standard = tuple(dict.fromkeys(columns))
        self._with_path = PATH in self._standard
        self._kernel, touched = equation_code(robot, self._standard)
        self._chosen: NDArray[np.int64] | None = None
        self._lay_out(columns, names, touched)

    def _lay_out(self, columns: Sequence[str], names: Sequence[str] | None, touched: tuple[Array, ...]) -> None:
        """Say where what is asked for stands among the rows that are evaluated."""
        self.columns = tuple(names or columns)
        unique = tuple(dict.fromkeys(columns))
        self.place = np.array([unique.index(name) for name in columns])
        self.distinct, self.touched = len(unique), touched
        sizes = [len(own) + 1 + len(others) for own, others in zip(touched, self.motors, strict=True)]
        ends = np.cumsum(sizes)
        self.rows = tuple(slice(int(end) - size, int(end)) for end, size in zip(ends, sizes, strict=True))

    def only(self, columns: Sequence[str], names: Sequence[str] | None = None) -> "Observer":
        """Observer of some of the columns by the same generated code; arguments as when made."""
        part, unique = copy.copy(self), tuple(dict.fromkeys(columns))
        chosen, touched = [], []
        for rows, own in zip(self.rows, self.touched, strict=True):
            entries = {self._standard[column]: rows.start + k for k, column in enumerate(own)}
            there = [name for name in unique if name in entries]
            touched.append(np.array([unique.index(name) for name in there], dtype=int))
            chosen += [entries[name] for name in there] + list(range(rows.start + len(own), rows.stop))
        part._standard = unique
        part._chosen = np.array(chosen) if self._chosen is None else self._chosen[chosen]
        part._lay_out(columns, names, tuple(touched))
        return part

    def blocks(self, data: Measurement, processing: Processing, partner: Motion | None = None) -> Iterator[Block]:
        """Equations of one measurement, block by block.

        Y and every column of W are filtered and decimated alike; rows outside the moving stretches and rows of
        slow joints are marked as not used.

        Args:
            data: the measurement, even in time if it is to be decimated.
            partner: another motion on the same time whose slow rows are left out as well.
        """
        data, keep, factor = used(data, processing, partner)
        return self.stream([(data, keep)], factor)

    def stream(self, pieces: Iterable[tuple[Measurement, Mask]], factor: int) -> Iterator[Block]:
        """Equations of one recording that arrives in pieces, each with its rows to use (N x n).

        Raises:
            InputError: if a joint leaves the table of its spring.
        """
        decimator = Decimator(self.rows[-1].stop, factor)
        waiting = _Waiting(self.robot.n, factor)
        for data, keep in pieces:
            self._check_spring(data.motion.q)
            keep = _of_motors(self.robot, keep)
            for part in _parts(len(data.motion.t), factor):
                motion = data.motion
                waiting.push(motion.t[part], keep[part])
                states = (motion.q[part], motion.qd[part], motion.qdd[part], data.torque[part])
                yield _block(decimator.push(self._evaluated(*states, *self._beside(data, part))), waiting)
        if factor > 1:
            yield _block(decimator.finish(), waiting)

    def observe(self, data: Measurement, processing: Processing, partner: Motion | None = None) -> Observation:
        """The equations of one measurement with W held whole; arguments as in ``blocks``."""
        return self._held(list(self.blocks(data, processing, partner)), processing.thinning(data.motion.rate))

    def observe_rows(self, data: Measurement, keep: Mask, decimate: int) -> Observation:
        """Observe a measurement with the rows to use, N x n, given."""
        return self._held(list(self.stream([(data, keep)], decimate)), decimate)

    def pieces(
        self, data: Measurement, processing: Processing, partner: Motion | None = None
    ) -> Iterator[Observation]:
        """The equations of ``observe`` in consecutive pieces that need little memory."""
        waiting: list[Block] = []
        for block in self.blocks(data, processing, partner):
            waiting.append(block)
            if sum(len(part.t) for part in waiting) >= _PIECE:
                yield self._held(waiting, processing.thinning(data.motion.rate))
                waiting = []
        if waiting:
            yield self._held(waiting, processing.thinning(data.motion.rate))

    def _held(self, blocks: Sequence[Block], decimate: int) -> Observation:
        """Equations of blocks, those of each joint in all columns."""
        W, Y, t, shared = [], [], [], list[SharedTorque]()
        for j, (own, touched) in enumerate(zip(self.rows, self.touched, strict=True)):
            rows = np.concatenate([block.equations[own][:, block.keep[j]] for block in blocks], axis=1)
            dense = np.zeros((rows.shape[1], self.distinct))
            dense[:, touched] = rows[: len(touched)].T
            W.append(dense[:, self.place])
            Y.append(rows[len(touched)])
            others = rows[len(touched) + 1 :]
            shared += [SharedTorque(j, motor, part) for motor, part in zip(self.motors[j], others, strict=True)]
            t.append(np.concatenate([block.t[block.keep[j]] for block in blocks]))
        return Observation(self.columns, tuple(W), tuple(Y), tuple(t), noise_bandwidth(decimate), tuple(shared))

    def torques(self, motion: Motion, values: Array) -> Array:
        """Torques of the joints that parameters of these values cause [N·m or N], N x n."""
        none = Measurement(motion, np.zeros(motion.q.shape))
        states = (motion.q, motion.qd, motion.qdd, none.torque)
        chi, torque = np.zeros(self.distinct), np.empty(motion.q.shape)
        np.add.at(chi, self.place, values)
        for part in _parts(len(motion.t), 1):
            equations = self._evaluated(*(state[part] for state in states), *self._beside(none, part))
            for j, (own, touched) in enumerate(zip(self.rows, self.touched, strict=True)):
                torque[part, j] = chi[touched] @ equations[own][: len(touched)]
        if self.robot.coupling is not None and self.robot.coupling.rows == "motor":
            j, k = (joint - 1 for joint in self.robot.coupling.joints)
            torque[:, j] += torque[:, k]
        return torque

    def _evaluated(self, *inputs: Array) -> Array:
        """Rows of the equations that are asked for."""
        equations = self._kernel(*inputs)
        return equations if self._chosen is None else equations[self._chosen]

    def _beside(self, data: Measurement, part: slice) -> list[Array]:
        """What the kernel takes beside states and torques: the spring in what a difference lacks, and the path."""
        before, path, inputs = data.spring_before, data.path, []
        if known_spring(self.robot) is not None:
            inputs.append(before[part, None] if before is not None else np.zeros(1))
        if self._with_path:
            inputs.append(path[part] if path is not None else np.zeros(self.robot.n))
        return inputs

    def _check_spring(self, q: Array) -> None:
        """A spring's table does not go on beyond its ends."""
        if self.robot.spring is not None:
            self.robot.spring.torque(q[:, self.robot.spring.joint - 1])


def used(data: Measurement, processing: Processing, partner: Motion | None = None) -> Used:
    """A measurement with its rows to use; arguments as in ``Observer.blocks``."""
    keep = used_rows(data.motion, processing)
    if partner is not None:
        keep &= used_rows(partner, processing)
    return Used(data, keep, processing.thinning(data.motion.rate))


def _of_motors(robot: Robot, keep: Mask) -> Mask:
    """Rows to use, N x n: where equations are the motors', that of motor j holds joint k's torque too."""
    if robot.coupling is None or robot.coupling.rows == "joint":
        return keep
    j, k = (joint - 1 for joint in robot.coupling.joints)
    keep = keep.copy()
    keep[:, j] &= keep[:, k]
    return keep


def _parts(samples: int, factor: int) -> Iterator[slice]:
    """Stretches that stay in the processor's cache, long against the reach of the decimation filter."""
    size = max(_PART, 64 * factor if factor > 1 else 0)
    return (slice(start, start + size) for start in range(0, samples, size))


def _block(equations: Array, waiting: "_Waiting") -> Block:
    t, keep = waiting.take(equations.shape[1])
    return Block(equations, keep, t)


class _Waiting:
    """Times and rows to use of decimated samples that the filter has not given yet."""

    def __init__(self, n: int, factor: int) -> None:
        self._factor = factor
        self._skip = 0
        self._t = np.empty(0)
        self._keep = np.empty((n, 0), dtype=bool)

    def push(self, t: Array, keep: Mask) -> None:
        chosen = slice(self._skip, None, self._factor)
        self._skip = (self._skip - len(t)) % self._factor
        self._t = np.concatenate([self._t, t[chosen]])
        self._keep = np.concatenate([self._keep, keep[chosen].T], axis=1)

    def take(self, count: int) -> tuple[Array, Mask]:
        t, keep = self._t[:count], self._keep[:, :count]
        self._t, self._keep = self._t[count:], self._keep[:, count:]
        return t, keep
