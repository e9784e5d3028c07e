"""The observation system Y = W chi + rho of (14), joint by joint as in (15), made block by block."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ..model import Kernel, Measurement, Motion, Processing, Robot, regressor
from ..model.arrays import Array
from .decimation import Decimator, noise_bandwidth

_BRIDGE = 0.3  # s: a pause shorter than this does not end the moving part
_BLOCK = 8192  # samples evaluated at once

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Observation:
    """The equations of one recording, held whole.

    Attributes:
        columns: names of the columns of W.
        W: per joint, r_j x c.
        Y: per joint, torques [N·m or N], shape (r_j,); known torques (a spring) are already moved here.
        t: per joint, time of the rows [s], shape (r_j,).
        bandwidth: share of the frequency range that white noise fills; 1 without decimation.
    """

    columns: tuple[str, ...]
    W: tuple[Array, ...]
    Y: tuple[Array, ...]
    t: tuple[Array, ...]
    bandwidth: float


@dataclass(frozen=True)
class Block:
    """Decimated equations of a stretch of time.

    Attributes:
        entries: non-zero entries of the regressor, joint by joint, entries x M.
        torque: known torques moved to this side [N·m or N], n x M.
        keep: which rows are used, n x M.
        t: time [s], shape (M,).
    """

    entries: Array
    torque: Array
    keep: Mask
    t: Array


class Observer:
    """Turns measurements of one robot into equations in chosen columns.

    Attributes:
        robot: the robot.
        columns: what the columns are called.
        place: position of each column among the distinct ones that are evaluated.
        distinct: number of those.
        rows: per joint, where its entries stand among a block's.
        entry_columns: distinct column of each entry.
    """

    def __init__(self, robot: Robot, columns: Sequence[str], names: Sequence[str] | None = None) -> None:
        """Generate the code of the columns' regressor.

        Args:
            robot: the robot.
            columns: standard parameters whose columns make up W; may repeat.
            names: what the columns are called, by default the standard names.
        """
        self.robot = robot
        self.columns = tuple(names or columns)
        unique = tuple(dict.fromkeys(columns))
        self.place = np.array([unique.index(name) for name in columns])
        self.distinct = len(unique)
        phi = regressor(robot, unique)
        rows, self.entry_columns, self._kernel = _by_joint(phi)
        starts = np.searchsorted(rows, np.arange(robot.n + 1))
        self.rows = tuple(slice(int(a), int(b)) for a, b in pairwise(starts))

    def blocks(self, data: Measurement, processing: Processing, partner: Motion | None = None) -> Iterator[Block]:
        """Equations of one measurement, block by block.

        Y and every column of W are filtered and decimated alike; rows outside the longest moving part and rows of
        slow joints are marked as not used.

        Args:
            data: the measurement, even in time if it is to be decimated.
            processing: settings.
            partner: another motion on the same time whose slow rows are left out as well.
        """
        keep = kept_rows(data.motion, processing)
        if partner is not None:
            keep &= kept_rows(partner, processing)
        return self.stream(_pieces(data, keep), processing.decimate)

    def stream(self, pieces: Iterator[tuple[Measurement, Mask]], factor: int) -> Iterator[Block]:
        """Equations of one recording that arrives in pieces, each with its rows to use (N x n)."""
        decimator = Decimator(len(self.entry_columns) + self.robot.n, factor)
        waiting = _Waiting(self.robot.n, factor)
        for data, keep in pieces:
            motion = data.motion
            waiting.push(motion.t, keep)
            signals = np.concatenate(
                [self._kernel(motion.q, motion.qd, motion.qdd), self._known_torque_moved(data).T]
            )
            yield self._block(decimator.push(signals), waiting)
        if factor > 1:
            yield self._block(decimator.finish(), waiting)

    def observe(self, data: Measurement, processing: Processing, partner: Motion | None = None) -> Observation:
        """The equations of one measurement with W held whole; arguments as in ``blocks``."""
        blocks = list(self.blocks(data, processing, partner))
        W, Y, t = [], [], []
        for j, own in enumerate(self.rows):
            dense = [np.zeros((int(block.keep[j].sum()), self.distinct)) for block in blocks]
            for rows, block in zip(dense, blocks, strict=True):
                rows[:, self.entry_columns[own]] = block.entries[own][:, block.keep[j]].T
            W.append(np.concatenate(dense)[:, self.place])
            Y.append(np.concatenate([block.torque[j, block.keep[j]] for block in blocks]))
            t.append(np.concatenate([block.t[block.keep[j]] for block in blocks]))
        return Observation(self.columns, tuple(W), tuple(Y), tuple(t), noise_bandwidth(processing.decimate))

    def _block(self, signals: Array, waiting: "_Waiting") -> Block:
        t, keep = waiting.take(signals.shape[1])
        n = self.robot.n
        return Block(signals[:-n], signals[-n:], keep, t)

    def _known_torque_moved(self, data: Measurement) -> Array:
        spring = self.robot.spring
        if spring is None:
            return data.torque
        torque = np.array(data.torque)
        torque[:, spring.joint - 1] += spring.torque(data.motion.q[:, spring.joint - 1])
        return torque


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


def kept_rows(motion: Motion, processing: Processing) -> Mask:
    """Which rows are used, N x n: the robot moves, and the sign of the joint's speed is known."""
    speed = np.abs(motion.qd)
    start, stop = moving_part(motion, processing.still_speed)
    fast: Mask = speed >= processing.slow_fraction * speed[start:stop].max(axis=0, initial=0.0)
    fast &= speed > 0.0
    fast[:start] = False
    fast[stop:] = False
    return fast


def moving_part(motion: Motion, still_speed: float) -> tuple[int, int]:
    """First sample and one past the last of the longest stretch in which some joint moves.

    Args:
        motion: the motion.
        still_speed: a joint below it stands still [rad/s or m/s]. Pauses under 0.3 s do not end a stretch.
    """
    moving = np.flatnonzero((np.abs(motion.qd) > still_speed).any(axis=1))
    if moving.size == 0:
        return 0, 0
    breaks = np.flatnonzero(np.diff(motion.t[moving]) > _BRIDGE)
    starts = moving[np.concatenate([[0], breaks + 1])]
    stops = moving[np.concatenate([breaks, [moving.size - 1]])] + 1
    longest = int(np.argmax(stops - starts))
    return int(starts[longest]), int(stops[longest])


def _by_joint(phi: ca.Function) -> tuple[Array, Array, Kernel]:
    """Row and column of each non-zero entry, joint by joint, and a kernel that gives them in this order."""
    symbols = [ca.SX.sym(name, phi.size1_in(k)) for k, name in enumerate(phi.name_in())]
    matrix = phi(*symbols)
    rows, columns = (np.array(place, dtype=int) for place in matrix.sparsity().get_triplet())
    order = np.lexsort((columns, rows))
    entries = ca.vertcat(*(matrix.nz[int(k)] for k in order))
    return rows[order], columns[order], Kernel(ca.Function("entries", symbols, [ca.cse(entries)]))


def _pieces(data: Measurement, keep: Mask) -> Iterator[tuple[Measurement, Mask]]:
    motion = data.motion
    for start in range(0, len(motion.t), _BLOCK):
        part = slice(start, start + _BLOCK)
        piece = Motion(motion.t[part], motion.q[part], motion.qd[part], motion.qdd[part])
        yield Measurement(piece, data.torque[part]), keep[part]
