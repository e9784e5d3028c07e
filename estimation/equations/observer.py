"""The observation system Y = W chi + rho of (14), joint by joint as in (15), made from measurements."""

import copy
import functools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...common.linear import without
from ...model import Motion, Processing, Robot, Spring
from ...model.kernel.kernel import Kernel
from ...model.motion import Measurement
from ...model.regressors import load_expression, regressor_expression
from ..signals.decimation import Decimator, noise_bandwidth
from ..signals.rows import Mask, used_rows
from .equations import NO_MOTOR, SharedTorque

PATH = "path"
"""Name of the column of a difference's torque that is taken off because the paths differ."""


class Residuals(NamedTuple):
    """Residuals of a fit to one recording: per joint times [s] and errors [N·m or N], shapes (r_j,)."""

    t: tuple[Array, ...]
    errors: tuple[Array, ...]


@dataclass(frozen=True)
class Observation:
    """The equations of one recording, held whole.

    Attributes:
        columns: names of the columns of W.
        W: per joint, r_j x c.
        Y: per joint, torques [N·m or N], shape (r_j,); known torques (a spring) are already moved here.
        t: per joint, time of the rows [s], shape (r_j,).
        bandwidth: fraction of the frequency range that white noise fills; 1 without decimation.
        shared: what of a joint's torque is of another joint's motor (coupled drives), or of a known spring.
    """

    columns: tuple[str, ...]
    W: tuple[Array, ...]
    Y: tuple[Array, ...]
    t: tuple[Array, ...]
    bandwidth: float
    shared: tuple[SharedTorque, ...] = ()

    def between(self, start: float, stop: float) -> "Observation":
        """Take the equations with start <= t < stop [s]."""
        ends = [slice(*np.searchsorted(t, (start, stop))) for t in self.t]
        W, Y, t = (
            tuple(array[part] for array, part in zip(arrays, ends, strict=True))
            for arrays in (self.W, self.Y, self.t)
        )
        shared = tuple(torque._replace(torque=torque.torque[ends[torque.joint]]) for torque in self.shared)
        return replace(self, W=W, Y=Y, t=t, shared=shared)

    def eliminate(self, columns: Sequence[str]) -> "Observation":
        """Take off all that some columns can explain, joint by joint; rows keep their times."""
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
        """Errors Y_j - W_j chi for each joint [N·m or N], shapes (r_j,); chi may be of the first columns alone."""
        return tuple(Y - W[:, : len(values)] @ values for W, Y in zip(self.W, self.Y, strict=True))

    def residuals(self, values: Array) -> Residuals:
        """Residuals: the ``errors`` with their times."""
        return Residuals(self.t, self.errors(values))


def known_spring(robot: Robot) -> Spring | None:
    """Spring whose torque is moved to the left-hand side, if there is one."""
    return robot.spring if robot.spring is not None and not robot.spring.column else None


def _sharing(robot: Robot) -> tuple[tuple[int, ...], ...]:
    """Motors per joint (from 0) that also stand in its right-hand side: other joints' (from 0), ``NO_MOTOR``."""
    motors: list[tuple[int, ...]] = [()] * robot.n
    if robot.coupling is not None and robot.coupling.rows == "joint":
        j, k = robot.coupling.joints
        motors[j - 1] = (k - 1,)
    spring = known_spring(robot)
    if spring is not None:
        motors[spring.joint - 1] += (NO_MOTOR,)
    return tuple(motors)


@functools.lru_cache(maxsize=16)
def equation_code(robot: Robot, columns: tuple[str, ...]) -> tuple[Kernel, tuple[Array, ...]]:
    """Kernel of q, qd, qdd, torque to each joint's entries and torques, and the columns of the entries.

    With a known spring its torque in the recording that was subtracted is one more input; of the column ``PATH``,
    which is taken off the torques, its values are; where friction depends on load, the columns' parameters are.
    """
    own = [name for name in columns if name != PATH]
    state, phi = regressor_expression(robot, own)
    chi = ca.SX.sym("chi", len(columns))
    if robot.drives.loaded:
        rigid = [k for k, name in enumerate(columns) if name != PATH]
        phi = ca.substitute(phi, state.load, load_expression(robot, state, own, chi[rigid]))
    q, qd, qdd, _ = state
    torque, path, spring = ca.SX.sym("torque", robot.n), ca.SX.sym("path", robot.n), known_spring(robot)
    left = ca.SX(torque)
    if PATH in columns:
        left -= path
        at = columns.index(PATH)
        phi = ca.horzcat(phi[:, :at], path, phi[:, at:])
    inputs, apart = [q, qd, qdd, torque], {motor: left[motor] for motor in range(robot.n)}
    if spring is not None:
        joint, before = spring.joint - 1, ca.SX.sym("before")
        apart[NO_MOTOR] = spring.torque_symbol(q[joint]) - before
        left[joint] += apart[NO_MOTOR]
        inputs.append(before)
    if PATH in columns:
        inputs.append(path)
    if robot.drives.loaded:
        inputs.append(chi)
    if robot.coupling is not None and robot.coupling.rows != "joint":
        j, k = (joint - 1 for joint in robot.coupling.joints)
        # Joint j holds both motors' torque (9); less joint k's, motor j's is left.
        phi[j, :] -= phi[k, :]
        left[j] -= left[k]
        phi = ca.sparsify(phi)
    rows, touched = [], []
    for j, motors in enumerate(_sharing(robot)):
        there = phi[j, :].sparsity().get_triplet()[1]
        touched.append(np.array(there, dtype=int))
        rows += [phi[j, k] for k in there] + [left[j], *(apart[motor] for motor in motors)]
    return Kernel(ca.Function("equations", inputs, [ca.cse(ca.vertcat(*rows))])), tuple(touched)


_PART = 1024  # samples evaluated at once
_PIECE = 4096  # decimated samples of a piece


class Block(NamedTuple):
    """Decimated equations of a stretch of time.

    ``equations``: for each joint the non-zero entries of its row of the regressor, then its torque [N·m or N],
    known torques already moved there, and what of it its own motor does not make; (entries + n + shared) x M.
    ``keep``: which rows are used, n x M; ``t``: time [s], shape (M,).
    """

    equations: Array
    keep: Mask
    t: Array


class Used(NamedTuple):
    """Measurement, its rows to use (N x n), and the factor that thins its equations."""

    data: Measurement
    keep: Mask
    factor: int


def used(data: Measurement, processing: Processing, partner: Motion | None = None) -> Used:
    """Find the rows of a measurement to use: moving stretches less rows of slow joints.

    Args:
        data: the measurement, even in time if it is to be decimated.
        partner: another motion on the same time whose slow rows are left out as well.
    """
    keep = used_rows(data.motion, processing)
    if partner is not None:
        keep &= used_rows(partner, processing)
    return Used(data, keep, processing.thinning(data.motion.rate))


class Observer:
    """Turns measurements of one robot into equations in chosen columns.

    Attributes:
        columns: what the columns are called.
        index: index of each column among the distinct ones that are evaluated.
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
        self.robot, self.motors = robot, _sharing(robot)
        self._standard = tuple(dict.fromkeys(columns))
        self._kernel, touched = equation_code(robot, self._standard)
        self._with_path = PATH in self._standard
        self._all, self._chi = self._standard, np.zeros(len(self._standard))
        self._chosen: NDArray[np.int64] | None = None
        self._lay_out(columns, names, touched)

    def _lay_out(self, columns: Sequence[str], names: Sequence[str] | None, touched: tuple[Array, ...]) -> None:
        """Lay out what is asked for among the rows that are evaluated."""
        self.columns = tuple(names or columns)
        unique = tuple(dict.fromkeys(columns))
        self.index = np.array([unique.index(name) for name in columns])
        self.distinct, self.touched = len(unique), touched
        sizes = [len(own) + 1 + len(others) for own, others in zip(touched, self.motors, strict=True)]
        ends = np.cumsum(sizes)
        self.rows = tuple(slice(int(end) - size, int(end)) for end, size in zip(ends, sizes, strict=True))

    def at(self, values: Array) -> "Observer":
        """Make the observer whose friction is that under the load which parameters of these values cause.

        Args:
            values: of the first columns; those of the others are zero.
        """
        there, standard = copy.copy(self), [self._standard[k] for k in self.index]
        there._chi = np.zeros(len(self._all))
        np.add.at(there._chi, [self._all.index(name) for name in standard[: len(values)]], values)
        return there

    def only(self, columns: Sequence[str], names: Sequence[str] | None = None) -> "Observer":
        """Make the observer of some of the columns by the same generated code; arguments as when made."""
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

    def stream(self, pieces: Iterable[tuple[Measurement, Mask]], factor: int) -> Iterator[Block]:
        """Make equations of one recording that arrives in pieces, each with its rows to use (N x n).

        Y and every column of W are filtered and decimated alike.
        """
        decimator, skip = Decimator(self.rows[-1].stop, factor), 0
        waiting = np.empty((self.robot.n + 1, 0))  # times and rows to use that the filter has not given yet

        def block(equations: Array) -> Block:
            nonlocal waiting
            (t, *keep), waiting = waiting[:, : equations.shape[1]], waiting[:, equations.shape[1] :]
            return Block(equations, np.array(keep, dtype=bool), t)

        for data, keep in pieces:
            if self.robot.spring is not None:  # its table does not go on beyond its ends
                self.robot.spring.torque(data.motion.q[:, self.robot.spring.joint - 1])
            if self.robot.coupling is not None and self.robot.coupling.rows != "joint":
                # Where equations are the motors', that of motor j holds joint k's torque too.
                j, k = (joint - 1 for joint in self.robot.coupling.joints)
                keep = keep.copy()
                keep[:, j] &= keep[:, k]
            if self.robot.drives.unmeasured:
                keep = keep & [j not in self.robot.drives.unmeasured for j in range(1, self.robot.n + 1)]
            for part in _parts(len(data.motion.t), factor):
                rows = np.vstack([data.motion.t[part], keep[part].T])
                waiting = np.hstack([waiting, rows[:, skip::factor]])
                skip = (skip - rows.shape[1]) % factor
                yield block(decimator.push(self._evaluated(data, part)))
        if factor > 1:
            yield block(decimator.finish())

    def observe(self, data: Measurement, processing: Processing) -> Observation:
        """Observe one measurement with W held whole."""
        return self.observe_rows(*used(data, processing))

    def observe_rows(self, data: Measurement, keep: Mask, decimate: int) -> Observation:
        """Observe a measurement with the rows to use, N x n, given."""
        return self._held(list(self.stream([(data, keep)], decimate)), decimate)

    def pieces(self, data: Measurement, processing: Processing) -> Iterator[Observation]:
        """Make the equations of ``observe`` in consecutive pieces that need little memory."""
        waiting: list[Block] = []
        data, keep, factor = used(data, processing)
        for block in self.stream([(data, keep)], factor):
            waiting.append(block)
            if sum(len(part.t) for part in waiting) >= _PIECE:
                yield self._held(waiting, factor)
                waiting = []
        if waiting:
            yield self._held(waiting, factor)

    def _held(self, blocks: Sequence[Block], decimate: int) -> Observation:
        """Join equations of blocks, those of each joint in all columns."""
        W, Y, t, shared = [], [], [], list[SharedTorque]()
        for j, (own, touched) in enumerate(zip(self.rows, self.touched, strict=True)):
            rows = np.concatenate([block.equations[own][:, block.keep[j]] for block in blocks], axis=1)
            dense = np.zeros((rows.shape[1], self.distinct))
            dense[:, touched] = rows[: len(touched)].T
            W.append(dense[:, self.index])
            Y.append(rows[len(touched)])
            others = rows[len(touched) + 1 :]
            shared += [SharedTorque(j, motor, part) for motor, part in zip(self.motors[j], others, strict=True)]
            t.append(np.concatenate([block.t[block.keep[j]] for block in blocks]))
        return Observation(self.columns, tuple(W), tuple(Y), tuple(t), noise_bandwidth(decimate), tuple(shared))

    def torques(self, motion: Motion, values: Array) -> Array:
        """Torques of the joints that parameters of these values cause [N·m or N], N x n."""
        none = Measurement(motion, np.zeros(motion.q.shape))
        chi, torque = np.zeros(self.distinct), np.empty(motion.q.shape)
        np.add.at(chi, self.index, values)
        for part in _parts(len(motion.t), 1):
            equations = self._evaluated(none, part)
            for j, (own, touched) in enumerate(zip(self.rows, self.touched, strict=True)):
                torque[part, j] = chi[touched] @ equations[own][: len(touched)]
        if self.robot.coupling is not None and self.robot.coupling.rows == "motor":
            j, k = (joint - 1 for joint in self.robot.coupling.joints)
            torque[:, j] += torque[:, k]
        return torque

    def _evaluated(self, data: Measurement, part: slice) -> Array:
        """Evaluate the rows of the equations that are asked for."""
        motion, before, path = data.motion, data.spring_before, data.path
        inputs = [motion.q[part], motion.qd[part], motion.qdd[part], data.torque[part]]
        if known_spring(self.robot) is not None:
            inputs.append(before[part, None] if before is not None else np.zeros(1))
        if self._with_path:
            inputs.append(path[part] if path is not None else np.zeros(self.robot.n))
        if self.robot.drives.loaded:
            inputs.append(self._chi)
        equations = self._kernel(*inputs)
        return equations if self._chosen is None else equations[self._chosen]


def _parts(samples: int, factor: int) -> Iterator[slice]:
    """Divide samples into stretches that stay in the processor's cache, long against the decimation filter."""
    size = max(_PART, 64 * factor if factor > 1 else 0)
    return (slice(start, start + size) for start in range(0, samples, size))
