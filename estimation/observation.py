"""The observation system Y = W chi + rho of (14), joint by joint as in (15), made block by block."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ..model import Kernel, Measurement, Motion, Processing, Robot, regressor
from ..model.arrays import Array
from .decimation import Decimator, noise_bandwidth

_BRIDGE = 0.3  # s: a pause shorter than this does not end a moving stretch
_STRETCH = 1.0  # s: a moving stretch shorter than this is left out
_PART = 1024  # samples evaluated at once

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

    def between(self, start: float, stop: float) -> "Observation":
        """The equations with start <= t < stop [s]."""
        ends = [slice(*np.searchsorted(t, (start, stop))) for t in self.t]
        W, Y, t = (
            tuple(array[part] for array, part in zip(arrays, ends, strict=True))
            for arrays in (self.W, self.Y, self.t)
        )
        return Observation(self.columns, W, Y, t, self.bandwidth)

    def errors(self, values: Array) -> tuple[Array, ...]:
        """Y_j - W_j chi for each joint [N·m or N], shapes (r_j,)."""
        return tuple(Y - W @ values for W, Y in zip(self.W, self.Y, strict=True))


@dataclass(frozen=True)
class Block:
    """Decimated equations of a stretch of time.

    Attributes:
        equations: for each joint the non-zero entries of its row of the regressor, then its torque [N·m or N],
            known torques already moved there; (entries + n) x M.
        keep: which rows are used, n x M.
        t: time [s], shape (M,).
    """

    equations: Array
    keep: Mask
    t: Array


class Observer:
    """Turns measurements of one robot into equations in chosen columns.

    Attributes:
        robot: the robot.
        columns: what the columns are called.
        place: position of each column among the distinct ones that are evaluated.
        distinct: number of those.
        rows: per joint, where its entries and torque stand among a block's equations.
        touched: per joint, the distinct columns of its entries.
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
        function, self.touched = _equations(robot, unique)
        ends = np.cumsum([len(own) + 1 for own in self.touched])
        self.rows = tuple(
            slice(int(end) - len(own) - 1, int(end)) for end, own in zip(ends, self.touched, strict=True)
        )
        self._kernel = Kernel(function)

    def blocks(self, data: Measurement, processing: Processing, partner: Motion | None = None) -> Iterator[Block]:
        """Equations of one measurement, block by block.

        Y and every column of W are filtered and decimated alike; rows outside the moving stretches and rows of
        slow joints are marked as not used.

        Args:
            data: the measurement, even in time if it is to be decimated.
            processing: settings.
            partner: another motion on the same time whose slow rows are left out as well.
        """
        keep = kept_rows(data.motion, processing)
        if partner is not None:
            keep &= kept_rows(partner, processing)
        return self.stream([(data, keep)], processing.decimate)

    def stream(self, pieces: Iterable[tuple[Measurement, Mask]], factor: int) -> Iterator[Block]:
        """Equations of one recording that arrives in pieces, each with its rows to use (N x n).

        Raises:
            InputError: if a joint leaves the table of its spring.
        """
        decimator = Decimator(self.rows[-1].stop, factor)
        waiting = _Waiting(self.robot.n, factor)
        for data, keep in pieces:
            self._check_spring(data.motion.q)
            for part in _parts(len(data.motion.t), factor):
                motion = data.motion
                waiting.push(motion.t[part], keep[part])
                equations = self._kernel(motion.q[part], motion.qd[part], motion.qdd[part], data.torque[part])
                yield _block(decimator.push(equations), waiting)
        if factor > 1:
            yield _block(decimator.finish(), waiting)

    def observe(self, data: Measurement, processing: Processing, partner: Motion | None = None) -> Observation:
        """The equations of one measurement with W held whole; arguments as in ``blocks``."""
        return self._whole(self.blocks(data, processing, partner), processing.decimate)

    def observe_rows(self, data: Measurement, keep: Mask, decimate: int) -> Observation:
        """The same with the rows to use, N x n, given."""
        return self._whole(self.stream([(data, keep)], decimate), decimate)

    def _whole(self, parts: Iterable[Block], decimate: int) -> Observation:
        blocks = list(parts)
        W, Y, t = [], [], []
        for j, (own, touched) in enumerate(zip(self.rows, self.touched, strict=True)):
            kept = np.concatenate([block.equations[own][:, block.keep[j]] for block in blocks], axis=1)
            dense = np.zeros((kept.shape[1], self.distinct))
            dense[:, touched] = kept[:-1].T
            W.append(dense[:, self.place])
            Y.append(kept[-1])
            t.append(np.concatenate([block.t[block.keep[j]] for block in blocks]))
        return Observation(self.columns, tuple(W), tuple(Y), tuple(t), noise_bandwidth(decimate))

    def _check_spring(self, q: Array) -> None:
        """A spring's table does not go on beyond its ends."""
        if self.robot.spring is not None:
            self.robot.spring.torque(q[:, self.robot.spring.joint - 1])


def _equations(robot: Robot, columns: Sequence[str]) -> tuple[ca.Function, tuple[Array, ...]]:
    """Function of q, qd, qdd, torque to each joint's entries and torque, and the columns of the entries."""
    q, qd, qdd, torque = (ca.SX.sym(name, robot.n) for name in ("q", "qd", "qdd", "torque"))
    phi = regressor(robot, columns)(q, qd, qdd)
    known = {robot.spring.joint - 1: robot.spring.torque_symbol(q[robot.spring.joint - 1])} if robot.spring else {}
    rows, touched = [], []
    for j in range(robot.n):
        own = phi[j, :].sparsity().get_triplet()[1]
        touched.append(np.array(own, dtype=int))
        rows += [phi[j, k] for k in own] + [torque[j] + known.get(j, 0.0)]
    function = ca.Function("equations", [q, qd, qdd, torque], [ca.cse(ca.vertcat(*rows))])
    return function, tuple(touched)


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


def kept_rows(motion: Motion, processing: Processing) -> Mask:
    """Which rows are used, N x n: the robot moves, and the sign of the joint's speed is known.

    Decimated rows go by the sample in their middle; the filter mixes in its neighbours.
    """
    moving = moving_parts(motion, processing.still_speed)
    fastest = np.abs(motion.qd)[moving].max(axis=0, initial=0.0)
    return fast_rows(motion.qd, fastest, moving, processing.slow_fraction)


def fast_rows(qd: Array, fastest: Array, moving: Mask, slow_fraction: float) -> Mask:
    """Rows, N x n, of moving samples at which a joint has at least a fraction of its largest speed.

    Args:
        qd: speeds, N x n.
        fastest: each joint's largest speed while the robot moves, shape (n,).
        moving: samples at which the robot is on its way, shape (N,).
        slow_fraction: of ``fastest``.
    """
    speed = np.abs(qd)
    fast: Mask = (speed >= slow_fraction * fastest) & (speed > 0.0)
    fast[~moving] = False
    return fast


def moving_parts(motion: Motion, still_speed: float) -> Mask:
    """Samples at which the robot is on its way, shape (N,).

    Pauses under 0.3 s belong to the motion; a stretch under 1 s (controllers often jog to the start) is left out,
    unless there is no longer one.

    Args:
        motion: the motion.
        still_speed: a joint below it stands still [rad/s or m/s].
    """
    on_its_way: Mask = np.any(np.abs(motion.qd) > still_speed, axis=1)
    return stretches(motion.t, on_its_way)


def stretches(t: Array, on_its_way: Mask) -> Mask:
    """The same from the times (N,) and whether some joint moves at each of them, (N,)."""
    mask = np.zeros(len(t), dtype=bool)
    moving = np.flatnonzero(on_its_way)
    if moving.size == 0:
        return mask
    breaks = np.flatnonzero(np.diff(t[moving]) > _BRIDGE)
    starts = moving[np.concatenate([[0], breaks + 1])]
    stops = moving[np.concatenate([breaks, [moving.size - 1]])] + 1
    lasts = t[stops - 1] - t[starts]
    for start, stop, last in zip(starts, stops, lasts, strict=True):
        mask[start:stop] = last >= min(_STRETCH, lasts.max())
    return mask
