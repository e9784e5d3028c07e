"""The observation system Y = W chi + rho of (14), joint by joint (15), made from measurements, reduced by QR."""

import copy
import functools
import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import casadi as ca
import numpy as np
from scipy.linalg import lapack

from ...common import Array, Indices, InputError, Mask, without
from ...model import Motion, Processing, Robot, Spring
from ...model.drives import parameter_kind
from ...model.kernel.kernel import Kernel
from ...model.motion import Measurement
from ...model.regressors import load_expression, regressor_expression
from ..signals.filtering import decimated, noise_bandwidth, used_rows
from .equations import FREE, NO_MOTOR, Equations, merged

Arrays = Sequence[Array]
Motors = tuple[tuple[int, ...], ...]
"""Per joint, whose parts of its torque stand apart: motors (from 0), ``NO_MOTOR`` for a spring."""
PATH = "path"  # name of the column of a difference's torque that is taken off because the paths differ


@dataclass(frozen=True, eq=False)
class Observation:
    """The equations of one recording, row by row; without rows, how an observer arranges them."""

    columns: tuple[str, ...]  # names of the columns of W, c
    index: Indices  # of each among the distinct ones, for columns may repeat, shape (c,)
    distinct: int  # number of those
    touched: tuple[Indices, ...]  # per joint, the distinct columns that are not zero
    motors: Motors  # whose parts follow the torque
    # Per joint, entries of W that are not zero, torque [N·m or N] (known torques, such as a spring's, are already
    # moved there), and parts of it that are not of its own motor; numbers of an equation x r_j.
    rows: tuple[Array, ...] = ()
    t: tuple[Array, ...] = ()  # per joint, time of the rows [s], shape (r_j,)
    bandwidth: float = 1.0  # fraction of the frequency range that white noise fills; 1 without decimation

    @staticmethod
    def of(
        columns: Sequence[str], W: Arrays, torques: Arrays, t: Arrays, bandwidth: float, motors: Motors = ()
    ) -> "Observation":
        """Make equations of whole matrices, per joint r_j x c, and torques, (r_j,), or as by ``torques``."""
        touched = tuple(np.flatnonzero(own.any(axis=0)) for own in W)
        parts, none = zip(W, touched, torques, strict=True), ((),) * len(W)
        rows = tuple(np.vstack([own[:, there].T, torque]) for own, there, torque in parts)
        c = len(columns)
        return Observation(tuple(columns), np.arange(c), c, touched, motors or none, rows, tuple(t), bandwidth)

    def values(self, values: Array) -> Array:
        """Values by distinct columns, of the first columns' values; zero for the others."""
        chi = np.zeros(self.distinct)
        np.add.at(chi, self.index[: len(values)], values)
        return chi

    @property
    def W(self) -> tuple[Array, ...]:  # noqa: N802
        """Observation matrix per joint, r_j x c."""
        dense = [np.zeros((own.shape[1], self.distinct)) for own in self.rows]
        for W, own, touched in zip(dense, self.rows, self.touched, strict=True):
            W[:, touched] = own[: len(touched)].T
        return tuple(W[:, self.index] for W in dense)

    @property
    def torques(self) -> tuple[Array, ...]:
        """Torque and the parts of it that are not of the joint's own motor, per joint (1 + k) x r_j."""
        return tuple(own[len(touched) :] for own, touched in zip(self.rows, self.touched, strict=True))

    @property
    def Y(self) -> tuple[Array, ...]:  # noqa: N802
        """Torques per joint [N·m or N], shape (r_j,)."""
        return tuple(torques[0] for torques in self.torques)

    def between(self, start: float, stop: float) -> "Observation":
        """Take the equations with start <= t < stop [s]."""
        ends = [slice(*np.searchsorted(t, (start, stop))) for t in self.t]
        rows = tuple(own[:, part] for own, part in zip(self.rows, ends, strict=True))
        return replace(self, rows=rows, t=tuple(t[part] for t, part in zip(self.t, ends, strict=True)))

    def eliminate(self) -> "Observation":
        """Take off all that ``FREE`` columns can explain, joint by joint; rows keep their times."""
        gone = np.array([name.startswith(FREE) for name in self.columns], dtype=bool)
        rest, W, torques = [name for name in self.columns if not name.startswith(FREE)], [], []
        for A, own in zip(self.W, self.torques, strict=True):
            rows = np.column_stack([A[:, ~gone], own.T])
            left = without(rows, A[:, gone]) if len(rows) else rows
            W.append(left[:, : len(rest)])
            torques.append(left[:, len(rest) :].T)
        return Observation.of(rest, W, torques, self.t, self.bandwidth, self.motors)

    def errors(self, values: Array) -> tuple[Array, ...]:
        """Errors Y_j - W_j chi for each joint [N·m or N], shapes (r_j,); chi may be of the first columns alone."""
        chi, each = self.values(values), zip(self.rows, self.touched, strict=True)
        return tuple(own[len(touched)] - chi[touched] @ own[: len(touched)] for own, touched in each)


def known_spring(robot: Robot) -> Spring | None:
    """Spring whose torque is moved to the left-hand side, if there is one."""
    return robot.spring if robot.spring is not None and not robot.spring.column else None


@functools.lru_cache(maxsize=16)
def equation_code(robot: Robot, columns: tuple[str, ...]) -> tuple[Kernel, tuple[Indices, ...], Motors]:
    """Kernel of q, qd, qdd, torque to each joint's entries and torques; the entries' columns and torques' motors.

    Further inputs: a known spring's torque in the recording that was subtracted; values of the column ``PATH``,
    which is taken off the torques; the columns' parameters, where friction depends on load.
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
    motors: list[tuple[int, ...]] = [()] * robot.n  # that also stand in a joint's right-hand side
    if spring is not None:
        joint, before = spring.joint - 1, ca.SX.sym("before")
        apart[NO_MOTOR] = spring.law(q[joint]) - before
        left[joint] += apart[NO_MOTOR]
        motors[joint] = (NO_MOTOR,)
        inputs.append(before)
    if PATH in columns:
        inputs.append(path)
    if robot.drives.loaded:
        inputs.append(chi)
    if robot.coupling is not None:
        j, k = (joint - 1 for joint in robot.coupling.joints)
        if robot.coupling.rows == "joint":
            motors[j] = (k, *motors[j])
        else:  # joint j holds both motors' torque (9); less joint k's, motor j's is left
            phi[j, :] -= phi[k, :]
            left[j] -= left[k]
            phi = ca.sparsify(phi)
    rows, touched = [], list[Indices]()
    for j, others in enumerate(motors):
        there = phi[j, :].sparsity().get_triplet()[1]
        touched.append(np.array(there, dtype=int))
        rows += [*(phi[j, k] for k in there), left[j], *(apart[motor] for motor in others)]
    return Kernel(ca.Function("equations", inputs, [ca.cse(ca.vertcat(*rows))])), tuple(touched), tuple(motors)


_PART = 1024  # samples evaluated at once: they stay in the processor's cache


class Used(NamedTuple):
    """Measurement, its rows to use (N x n), and the factor that thins its equations."""

    data: Measurement
    keep: Mask
    factor: int


def used(data: Measurement, processing: Processing, partner: Motion | None = None) -> Used:
    """Find the rows of a measurement to use: moving stretches less rows of slow joints, of a partner's as well."""
    keep = used_rows(data.motion, processing)
    if partner is not None:
        keep &= used_rows(partner, processing)
    return Used(data, keep, processing.thinning(data.motion.rate))


class Observer:
    """Turns measurements of one robot into equations in chosen columns, arranged as in ``empty``."""

    def __init__(self, robot: Robot, columns: Sequence[str], names: Sequence[str] | None = None) -> None:
        """Generate the code of the regressor of standard parameters, which may repeat, and ``PATH``; name them."""
        self.robot, self._code = robot, tuple(dict.fromkeys(columns))
        self._kernel, self._entries, self._motors = equation_code(robot, self._code)
        self._chi, self._by_load = np.zeros(len(self._code)), bool(robot.drives.loaded)
        self._choose(columns, names)

    def _choose(self, columns: Sequence[str], names: Sequence[str] | None) -> None:
        index = np.array([self._code.index(name) for name in columns], dtype=int)
        there = [np.isin(own, index) for own in self._entries]
        wanted = [np.append(own, [True] * (1 + len(parts))) for own, parts in zip(there, self._motors, strict=True)]
        ends = np.cumsum([0, *map(np.count_nonzero, wanted)]).tolist()
        self._wanted, self._rows = np.concatenate(wanted), [slice(*pair) for pair in itertools.pairwise(ends)]
        touched = tuple(own[chosen] for own, chosen in zip(self._entries, there, strict=True))
        self.columns = tuple(names or columns)
        self.empty = Observation(self.columns, index, len(self._code), touched, self._motors)

    def at(self, values: Array) -> "Observer":
        """Make the observer whose friction is that under the load which these values of the first columns cause."""
        there = copy.copy(self)
        there._chi = self.empty.values(values)
        return there

    def of(self, robot: Robot, columns: Sequence[str]) -> "Observer":
        """Make the observer of the same robot with fewer terms of friction by the same generated code."""
        fewer = self.only(columns)
        fewer.robot = robot
        return fewer

    def only(self, columns: Sequence[str], names: Sequence[str] | None = None) -> "Observer":
        """Make the observer of some of the columns by the same generated code; arguments as when made."""
        part = copy.copy(self)
        part._choose(columns, names)
        return part

    def stream(self, pieces: Iterable[tuple[Measurement, Mask]], factor: int) -> Iterator[Observation]:
        """Observe one recording that arrives in pieces, each with its rows to use (N x n), stretch by stretch.

        Y and every column of W are filtered and decimated alike.
        """
        skip, bandwidth = 0, noise_bandwidth(factor)
        waiting = np.empty((self.robot.n + 1, 0))  # times and rows to use that the filter has not given yet

        def evaluated() -> Iterator[Array]:
            nonlocal waiting, skip
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
                for part, equations in self._evaluated(data, factor):
                    rows = np.vstack([data.motion.t[part], keep[part].T])
                    waiting = np.hstack([waiting, rows[:, skip::factor]])
                    skip = (skip - rows.shape[1]) % factor
                    yield equations

        for equations in decimated(evaluated(), self._rows[-1].stop, factor):
            (t, *keep), waiting = waiting[:, : equations.shape[1]], waiting[:, equations.shape[1] :]
            used = [np.flatnonzero(row) for row in keep]
            rows = tuple(equations[own].take(there, axis=1) for own, there in zip(self._rows, used, strict=True))
            yield replace(self.empty, rows=rows, t=tuple(t[there] for there in used), bandwidth=bandwidth)

    def observe(self, data: Measurement, keep: Mask, decimate: int) -> Observation:
        """Observe one measurement: its rows to use, N x n, thinned by a factor, as ``used`` finds both."""
        parts = list(self.stream([(data, keep)], decimate))
        rows = tuple(np.concatenate(own, axis=1) for own in zip(*(part.rows for part in parts), strict=True))
        t = tuple(map(np.concatenate, zip(*(part.t for part in parts), strict=True)))
        return replace(parts[0], rows=rows, t=t)

    def refresh(self, observations: Sequence[Observation], recordings: Sequence[Used]) -> None:
        """Observe friction that grows with load anew, in equations of the same recordings and columns."""
        loaded, chosen = self.robot.drives.loaded, dict.fromkeys(self._code[k] for k in self.empty.index)
        part = self.only([name for name in chosen if parameter_kind(name) in loaded])
        for one, recording in zip(observations, recordings, strict=True):
            new = part.observe(*recording)
            for rows, own, touched, there in zip(one.rows, new.rows, one.touched, new.touched, strict=True):
                rows[: len(touched)][np.isin(touched, there)] = own[: len(there)]

    def torques(self, motion: Motion, values: Array) -> Array:
        """Torques of the joints that parameters of these values cause [N·m or N], N x n."""
        none = Measurement(motion, np.zeros(motion.q.shape))
        chi, torque = self.empty.values(values), np.empty(motion.q.shape)
        for part, equations in self._evaluated(none):
            for j, (own, touched) in enumerate(zip(self._rows, self.empty.touched, strict=True)):
                torque[part, j] = chi[touched] @ equations[own][: len(touched)]
        if self.robot.coupling is not None and self.robot.coupling.rows == "motor":
            return self.robot.coupling.joint_torques(torque)
        return torque

    def _evaluated(self, data: Measurement, factor: int = 1) -> Iterator[tuple[slice, Array]]:
        """Evaluate the rows of the equations that are asked for, stretch by stretch."""
        motion, before, path = data.motion, data.spring_before, data.path
        size = max(_PART, 64 * factor if factor > 1 else 0)  # long against the decimation filter
        for part in (slice(start, start + size) for start in range(0, len(motion.t), size)):
            inputs = [motion.q[part], motion.qd[part], motion.qdd[part], data.torque[part]]
            if known_spring(self.robot) is not None:
                inputs.append(before[part, None] if before is not None else np.zeros(1))
            if PATH in self._code:
                inputs.append(path[part] if path is not None else np.zeros(self.robot.n))
            if self._by_load:
                inputs.append(self._chi)
            equations = self._kernel(*inputs)
            yield part, equations if self._wanted.all() else equations[self._wanted]


_ROWS, _PANEL = 1024, 8
"""Rows and columns that a QR takes at once: they and the factor stay in the processor's cache."""


def recorded(observer: Observer, recordings: Iterable[Used]) -> tuple[Equations, list[Observation]]:
    """Reduce all recordings of one load, and keep the equations of each."""
    each = [observer.observe(*recording) for recording in recordings]
    return merged(map(reduced, each)), each


def reduced_pieces(observer: Observer, pieces: Iterable[tuple[Measurement, Mask]], decimate: int = 1) -> Equations:
    """Reduce one recording that arrives in pieces, however long it is: its equations are never held whole.

    ``pieces``: consecutive pieces, even in time if they are to be decimated, each with its rows to use, N x n;
    ``decimate``: parallel decimation of Y and W.
    """
    return reduced(observer.stream(pieces, decimate))


def reduced(observation: Observation | Iterable[Observation]) -> Equations:
    """Reduce the equations of one recording, or its stretches: per joint the columns touched, then spread out."""
    triangles, counts = list[Array](), np.zeros(1, dtype=int)
    for one in [observation] if isinstance(observation, Observation) else observation:
        triangles = triangles or [np.zeros((len(rows), len(rows)), order="F") for rows in one.rows]
        counts = counts + [rows.shape[1] for rows in one.rows]
        for j, rows in enumerate(one.rows):
            for k in range(0, rows.shape[1], _ROWS):
                # LAPACK's QR of a triangle above a rectangle: faster than of both as one matrix.
                below, panel = rows[:, k : k + _ROWS].T, min(_PANEL, len(rows))
                triangles[j] = lapack.dtpqrt(0, panel, triangles[j], below, overwrite_a=1)[0]
    if not triangles:
        raise InputError("no piece of a recording is given")
    factors, shared = list[Array](), dict[tuple[int, int], Array]()
    for j, (triangle, touched, motors) in enumerate(zip(triangles, one.touched, one.motors, strict=True)):
        own = np.triu(triangle)[: len(touched) + 1]  # what stands below is of the others' torques alone
        wide = np.zeros((len(own), one.distinct + 1))
        wide[:, touched], wide[:, -1] = own[:, : len(touched)], own[:, len(touched)]
        factors.append(wide[:, [*one.index, -1]])
        shared |= zip(((j, motor) for motor in motors), own[:, len(touched) + 1 :].T, strict=True)
    effective = tuple((one.bandwidth * counts).tolist())
    return Equations(one.columns, tuple(factors), tuple(counts.tolist()), effective, shared)
