"""The observation system Y = W chi + rho of (14), joint by joint (15), made from measurements, reduced by QR."""

import copy
import functools
import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import casadi as ca
import numpy as np

from ...common import Array, Indices, InputError, Mask, without
from ...model import Motion, Processing, Robot, Spring
from ...model.kernel.kernel import Kernel
from ...model.motion import Measurement
from ...model.regressors import load_expression, regressor_expression
from ..signals.filtering import Decimator, noise_bandwidth
from ..signals.rows import used_rows
from .equations import NO_MOTOR, Equations, compressed, merged

PATH = "path"  # name of the column of a difference's torque that is taken off because the paths differ


@dataclass(frozen=True, eq=False)
class Layout:
    """Arrangement of equations: whose entries each joint's rows hold, and what stands behind its torque."""

    columns: tuple[str, ...]  # names of the columns of W, c
    index: Indices  # of each among the distinct ones, for columns may repeat, shape (c,)
    touched: tuple[Indices, ...]  # per joint, the distinct columns that are not zero
    motors: tuple[tuple[int, ...], ...]  # per joint, whose parts follow: motors (from 0), ``NO_MOTOR`` for a spring

    @functools.cached_property
    def rows(self) -> tuple[slice, ...]:
        """Places of each joint's entries, torque and parts of that among what is evaluated."""
        sizes = [len(own) + 1 + len(others) for own, others in zip(self.touched, self.motors, strict=True)]
        return tuple(itertools.starmap(slice, itertools.pairwise(itertools.accumulate(sizes, initial=0))))

    @property
    def distinct(self) -> int:
        """Number of distinct columns."""
        return int(self.index.max(initial=-1)) + 1

    def values(self, values: Array) -> Array:
        """Values by distinct columns, of the first columns' values; zero for the others."""
        chi = np.zeros(self.distinct)
        np.add.at(chi, self.index[: len(values)], values)
        return chi


@dataclass(frozen=True, eq=False)
class Observation:
    """The equations of one recording, row by row."""

    layout: Layout  # what the rows hold
    # Per joint, entries of W that are not zero, torque [N·m or N] (known torques, such as a spring's, are already
    # moved there), and parts of it that are not of its own motor; numbers of an equation x r_j.
    rows: tuple[Array, ...]
    t: tuple[Array, ...]  # per joint, time of the rows [s], shape (r_j,)
    bandwidth: float  # fraction of the frequency range that white noise fills; 1 without decimation

    @staticmethod
    def of(
        columns: Sequence[str],
        W: Sequence[Array],
        torques: Sequence[Array],
        t: Sequence[Array],
        bandwidth: float,
        motors: tuple[tuple[int, ...], ...] | None = None,
    ) -> "Observation":
        """Make equations of whole matrices, per joint r_j x c, and torques, (r_j,), or as by ``torques``."""
        touched = tuple(np.flatnonzero(own.any(axis=0)) for own in W)
        layout = Layout(tuple(columns), np.arange(len(columns)), touched, motors or ((),) * len(W))
        parts = zip(W, touched, torques, strict=True)
        rows = tuple(np.vstack([own[:, there].T, torque]) for own, there, torque in parts)
        return Observation(layout, rows, tuple(t), bandwidth)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns of W."""
        return self.layout.columns

    @property
    def W(self) -> tuple[Array, ...]:  # noqa: N802
        """Observation matrix per joint, r_j x c."""
        dense = [np.zeros((own.shape[1], self.layout.distinct)) for own in self.rows]
        for W, own, touched in zip(dense, self.rows, self.layout.touched, strict=True):
            W[:, touched] = own[: len(touched)].T
        return tuple(W[:, self.layout.index] for W in dense)

    @property
    def torques(self) -> tuple[Array, ...]:
        """Torque and the parts of it that are not of the joint's own motor, per joint (1 + k) x r_j."""
        return tuple(own[len(touched) :] for own, touched in zip(self.rows, self.layout.touched, strict=True))

    @property
    def Y(self) -> tuple[Array, ...]:  # noqa: N802
        """Torques per joint [N·m or N], shape (r_j,)."""
        return tuple(torques[0] for torques in self.torques)

    def between(self, start: float, stop: float) -> "Observation":
        """Take the equations with start <= t < stop [s]."""
        ends = [slice(*np.searchsorted(t, (start, stop))) for t in self.t]
        rows = tuple(own[:, part] for own, part in zip(self.rows, ends, strict=True))
        return replace(self, rows=rows, t=tuple(t[part] for t, part in zip(self.t, ends, strict=True)))

    def eliminate(self, columns: Sequence[str]) -> "Observation":
        """Take off all that some columns can explain, joint by joint; rows keep their times."""
        names = self.columns
        gone = [names.index(name) for name in columns]
        rest = [k for k in range(len(names)) if k not in gone]
        W, torques = [], []
        for A, own in zip(self.W, self.torques, strict=True):
            rows = np.column_stack([A[:, rest], own.T])
            left = without(rows, A[:, gone]) if len(rows) else rows
            W.append(left[:, : len(rest)])
            torques.append(left[:, len(rest) :].T)
        columns = [names[k] for k in rest]
        return Observation.of(columns, W, torques, self.t, self.bandwidth, self.layout.motors)

    def errors(self, values: Array) -> tuple[Array, ...]:
        """Errors Y_j - W_j chi for each joint [N·m or N], shapes (r_j,); chi may be of the first columns alone."""
        chi, each = self.layout.values(values), zip(self.rows, self.layout.touched, strict=True)
        return tuple(own[len(touched)] - chi[touched] @ own[: len(touched)] for own, touched in each)


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
def equation_code(robot: Robot, columns: tuple[str, ...]) -> tuple[Kernel, tuple[Indices, ...]]:
    """Kernel of q, qd, qdd, torque to each joint's entries and torques, and the columns of the entries.

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
    """Turns measurements of one robot into equations in chosen columns, as its ``layout`` says."""

    def __init__(self, robot: Robot, columns: Sequence[str], names: Sequence[str] | None = None) -> None:
        """Generate the code of the regressor of standard parameters, which may repeat, and ``PATH``; name them."""
        self.robot, self._evaluated_columns = robot, tuple(dict.fromkeys(columns))
        self._kernel, touched = equation_code(robot, self._evaluated_columns)
        self._chi = np.zeros(len(self._evaluated_columns))
        self._chosen: Indices | None = None
        self._standard = self._evaluated_columns
        index = np.array([self._standard.index(name) for name in columns])
        self.layout = Layout(tuple(names or columns), index, touched, _sharing(robot))

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns."""
        return self.layout.columns

    def at(self, values: Array) -> "Observer":
        """Make the observer whose friction is that under the load which these values of the first columns cause."""
        there, evaluated = copy.copy(self), self._evaluated_columns
        there._chi = np.zeros(len(evaluated))
        there._chi[[evaluated.index(name) for name in self._standard]] = self.layout.values(values)
        return there

    def only(self, columns: Sequence[str], names: Sequence[str] | None = None) -> "Observer":
        """Make the observer of some of the columns by the same generated code; arguments as when made."""
        part, unique = copy.copy(self), tuple(dict.fromkeys(columns))
        chosen, touched = list[int](), []
        for rows, own in zip(self.layout.rows, self.layout.touched, strict=True):
            entries = {self._standard[column]: rows.start + k for k, column in enumerate(own)}
            there = [name for name in unique if name in entries]
            touched.append(np.array([unique.index(name) for name in there], dtype=int))
            chosen += [entries[name] for name in there] + list(range(rows.start + len(own), rows.stop))
        part._standard = unique
        part._chosen = np.array(chosen) if self._chosen is None else self._chosen[chosen]
        index = np.array([unique.index(name) for name in columns])
        part.layout = Layout(tuple(names or columns), index, tuple(touched), self.layout.motors)
        return part

    def stream(self, pieces: Iterable[tuple[Measurement, Mask]], factor: int) -> Iterator[Observation]:
        """Observe one recording that arrives in pieces, each with its rows to use (N x n), stretch by stretch.

        Y and every column of W are filtered and decimated alike.
        """
        decimator, skip, bandwidth = Decimator(self.layout.rows[-1].stop, factor), 0, noise_bandwidth(factor)
        waiting = np.empty((self.robot.n + 1, 0))  # times and rows to use that the filter has not given yet

        def made(equations: Array) -> Observation:
            nonlocal waiting
            (t, *keep), waiting = waiting[:, : equations.shape[1]], waiting[:, equations.shape[1] :]
            used = [row > 0.0 for row in keep]
            rows = tuple(equations[own][:, there] for own, there in zip(self.layout.rows, used, strict=True))
            return Observation(self.layout, rows, tuple(t[there] for there in used), bandwidth)

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
                yield made(decimator.push(self._evaluated(data, part)))
        if factor > 1:
            yield made(decimator.finish())

    def observe(self, data: Measurement, processing: Processing) -> Observation:
        """Observe one measurement, its rows found by the settings."""
        return self.observe_rows(*used(data, processing))

    def observe_rows(self, data: Measurement, keep: Mask, decimate: int) -> Observation:
        """Observe a measurement with the rows to use, N x n, given."""
        parts = list(self.stream([(data, keep)], decimate))
        rows = tuple(np.concatenate(own, axis=1) for own in zip(*(part.rows for part in parts), strict=True))
        t = tuple(map(np.concatenate, zip(*(part.t for part in parts), strict=True)))
        return replace(parts[0], rows=rows, t=t)

    def torques(self, motion: Motion, values: Array) -> Array:
        """Torques of the joints that parameters of these values cause [N·m or N], N x n."""
        none = Measurement(motion, np.zeros(motion.q.shape))
        chi, torque = self.layout.values(values), np.empty(motion.q.shape)
        for part in _parts(len(motion.t), 1):
            equations = self._evaluated(none, part)
            for j, (own, touched) in enumerate(zip(self.layout.rows, self.layout.touched, strict=True)):
                torque[part, j] = chi[touched] @ equations[own][: len(touched)]
        if self.robot.coupling is not None and self.robot.coupling.rows == "motor":
            return self.robot.coupling.joint_torques(torque)
        return torque

    def _evaluated(self, data: Measurement, part: slice) -> Array:
        """Evaluate the rows of the equations that are asked for."""
        motion, before, path = data.motion, data.spring_before, data.path
        inputs = [motion.q[part], motion.qd[part], motion.qdd[part], data.torque[part]]
        if known_spring(self.robot) is not None:
            inputs.append(before[part, None] if before is not None else np.zeros(1))
        if PATH in self._evaluated_columns:
            inputs.append(path[part] if path is not None else np.zeros(self.robot.n))
        if self.robot.drives.loaded:
            inputs.append(self._chi)
        equations = self._kernel(*inputs)
        return equations if self._chosen is None else equations[self._chosen]


def _parts(samples: int, factor: int) -> Iterator[slice]:
    """Divide samples into stretches that stay in the processor's cache, long against the decimation filter."""
    size = max(_PART, 64 * factor if factor > 1 else 0)
    return (slice(start, start + size) for start in range(0, samples, size))


_ROWS = 1024  # per QR: the rows stay in the processor's cache


def recorded(observer: Observer, recordings: Iterable[Used]) -> tuple[Equations, list[Observation]]:
    """Reduce all recordings of one load, and keep the equations of each."""
    each = [observer.observe_rows(*recording) for recording in recordings]
    return merged(map(reduced, each)), each


def reduced(observation: Observation) -> Equations:
    """Reduce the equations of one recording: of each joint's rows the columns that they touch, then spread out."""
    layout, factors, shared = observation.layout, list[Array](), dict[tuple[int, int], Array]()
    parts = zip(observation.rows, layout.touched, layout.motors, strict=True)
    for j, (rows, touched, motors) in enumerate(parts):
        both = np.zeros((0, len(rows)))
        for k in range(0, rows.shape[1], _ROWS):
            both = np.hstack(compressed(np.vstack([both, rows[:, k : k + _ROWS].T]), len(motors)))
        R, others = np.split(both, [len(touched) + 1], axis=1)
        wide = np.zeros((len(R), layout.distinct + 1))
        wide[:, touched], wide[:, -1] = R[:, :-1], R[:, -1]
        factors.append(wide[:, [*layout.index, -1]])
        shared |= zip(((j, motor) for motor in motors), others.T, strict=True)
    counts = tuple(rows.shape[1] for rows in observation.rows)
    effective = tuple(observation.bandwidth * count for count in counts)
    return Equations(layout.columns, tuple(factors), counts, effective, shared)


def reduced_pieces(observer: Observer, pieces: Iterable[tuple[Measurement, Mask]], decimate: int = 1) -> Equations:
    """Reduce one recording that arrives in pieces, however long it is: its equations are never held whole.

    ``pieces``: consecutive pieces, even in time if they are to be decimated, each with its rows to use, N x n;
    ``decimate``: parallel decimation of Y and W.
    """
    parts = map(reduced, observer.stream(pieces, decimate))
    if (first := next(parts, None)) is None:
        raise InputError("no piece of a recording is given")
    return functools.reduce(lambda done, part: merged([done, part]), parts, first)
