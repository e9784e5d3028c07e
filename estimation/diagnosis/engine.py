"""One least-squares engine for every hypothesis: robot and payload together (method 4) on subsampled states.

Some 10 states a second are cheap enough to try many hypotheses on.

A hypothesis adds columns, or reads the recordings in another way. Gram matrices of columns scaled to norm 1 are
accurate enough for both, and fast; standard deviations leave out one block of time after another.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import lapack, solve_triangular
from scipy.special import stdtrit

from ...common import Array, Indices, InputError, Mask
from ...model import INERTIAL, Processing, Recording, Robot
from ...model.drives import DriveState, drive_terms, parameter_kind
from ...model.regressors import body_torques, own_columns, payload_columns, regressor_at
from ..fit.linear_problem import Known
from ..payload.long_motion import Source, frame_change
from ..signals.filtering import lowpass, measurement, taken, used_rows

BLOCKS = 20  # number of blocks of time that are left out in turn
FEW = 200  # number of states of a recording that are enough to compare readings of it
_RATE = 10.0  # Hz
_MOST = 600  # states of a recording
_LONGEST = 180.0  # s: of a longer recording the middle is used
_FEWEST = 60  # states altogether
_AWAY, _BACK = 0.4, 0.2
"""Distance of states, over that of any two, at which a motion has gone elsewhere, and at which it is back."""
_PLACES = 5  # of a block: half a second
_OVERLAP = 0.7  # of a recording: the longest passage of a motion that repeats itself
_CUTOFF = 0.4  # of the states' own rate
_RANK = 1e-10  # of the largest eigenvalue: squares of columns, scaled to norm 1
_REMAINS = 1e-6  # fraction of a direction that the other blocks must determine
_NOTHING = 1e-20  # of the largest column's square: rounding
_STEPS = 6  # of Gauss-Newton for gains
_ROUNDS = 5  # of such steps for signals of any scale
_GAIN = 0.3  # longest step of a gain's reciprocal, and how near to 1 it is thought to be
_ROWS = 2 * BLOCKS  # of a joint: a few rows fit exactly, and would count for infinitely much
_CHANCE = 1e-6  # probability at which few blocks count as ``BLOCKS`` do, by which thresholds were chosen
_SMALL, _ROUNDING = 16, 1e-13
"""Columns of which eigenvalues are soon found, and what a column of norm 1 is rounding below beside the others."""
_FLOOR = 1e-9  # of a joint's torque: data without noise still need finite weights


class States(NamedTuple):
    """Subsampled states of one or more recordings: N states of n joints."""

    t: Array  # time in its recording [s], shape (N,)
    q: Array  # filtered motion [rad or m], N x n
    qd: Array
    qdd: Array
    torque: Array  # low-passed [N·m or N], N x n
    keep: Mask  # rows that are used, n to a state, N x n
    loaded: Array  # 1 with payload, else 0, shape (N,)
    passed: Array  # fraction of the time that has passed, from 0 to 1 over each recording
    block: Indices  # number of the block of time, (N,)
    recording: Indices
    signals: tuple[tuple[Array, Array], ...]  # time [s] and torque of each recording's every sample
    recordings: tuple[Recording, ...]

    @staticmethod
    def of(recording: Recording, processing: Processing, count: int = FEW, loaded: float = 0.0) -> "States":
        """Subsample one recording evenly over its moving part, to about ``count`` states; 1 with payload."""
        data = measurement(recording, processing)
        motion, step = data.motion, 1.0 / data.motion.rate
        keep = used_rows(motion, processing) & (np.ptp(recording.torque, axis=0) > 0.0)  # no dead channel
        moving = np.flatnonzero(keep.any(axis=1))
        thin = max(1, len(moving) // count)
        torque = lowpass(data.torque, step, _CUTOFF / (thin * step) if thin > 1 else None, recording.source)
        at = moving[thin // 2 :: thin]
        t, zeros = motion.t[at], np.zeros(len(at), dtype=np.intp)
        return States(
            t, motion.q[at], motion.qd[at], motion.qdd[at], torque[at], keep[at], np.full(len(at), float(loaded)),
            (t - motion.t[0]) / (motion.t[-1] - motion.t[0]), zeros, zeros, ((motion.t, torque),), (recording,),
        )  # fmt: skip

    @staticmethod
    def joined(parts: Sequence["States"]) -> "States":
        """Join the states of several recordings, in blocks of time over all of them.

        What a model leaves, such as ripple, repeats with the motion: passages of one path count as one.
        """
        arrays: list[Any] = [np.concatenate(column) for column in zip(*(part[:-2] for part in parts), strict=True)]
        arrays += [tuple(one for part in parts for one in part[k]) for k in (-2, -1)]
        joined = States(*arrays)._replace(
            recording=np.repeat(np.arange(len(parts)), [len(part.t) for part in parts])
        )
        # Each state is numbered by the first one at its place of a motion that repeats, else by itself.
        q, place = joined.q, np.arange(len(joined.q))
        for k in range(len(parts)):
            own = np.flatnonzero(joined.recording == k)
            x, size = q[own], np.sqrt(2.0 * q[own].var(axis=0).sum()) or 1.0
            shifts = range(1, int(_OVERLAP * len(x)))
            apart = np.array([np.linalg.norm(x[m:] - x[:-m]) / np.sqrt(len(x) - m) for m in shifts]) / size
            gone = int(np.argmax(np.append(apart > _AWAY, True)))
            back = gone + np.flatnonzero(apart[gone:] < _BACK)
            if not len(back):
                continue
            passage = int(back[np.argmin(apart[back[back < back[0] + gone + 1]])]) + 1
            begins = range(own[0] - passage + 1)
            earlier = [float(np.linalg.norm(x[:passage] - q[j : j + passage])) for j in begins]
            if min(earlier, default=np.inf) < _BACK * size * np.sqrt(passage):  # passages of an earlier recording
                place[own[:passage]] = place[np.argmin(earlier) :][:passage]
            place[own] = np.resize(place[own[:passage]], len(own))
        _, place, sizes = np.unique(place, return_inverse=True, return_counts=True)
        blocks = BLOCKS if len(sizes) == len(place) else int(np.clip(len(sizes) // _PLACES, 2, BLOCKS))
        return joined._replace(block=(np.cumsum(sizes) - sizes)[place] * blocks // max(len(place), 1))

    def later(self, delay: "float | Array") -> "States":
        """Read the torque that was written ``delay`` [s] later, a number or one for each state."""
        times, torque = self.t + delay, np.array(self.torque)
        for number, (t, signal) in enumerate(self.signals):
            own = self.recording == number
            after = np.clip(np.searchsorted(t, times[own]), 1, len(t) - 1)
            fraction = np.clip((times[own] - t[after - 1]) / (t[after] - t[after - 1]), 0.0, 1.0)[:, None]
            torque[own] = (1.0 - fraction) * signal[after - 1] + fraction * signal[after]
        return self._replace(torque=torque)

    def taken(self, index: Any) -> "States":
        """Take some of the states: a slice, a mask or numbers."""
        return self._replace(**{name: getattr(self, name)[index] for name in States._fields[:-2]})

    def read(self, M: Array, turn: "float | Array" = 0.0, torque: Array | None = None) -> "States":
        """Read joints from columns of the log: positions M q + ``turn``, and torques by the same matrix or another.

        Rows of that of torques are columns of the log, or their opposites.
        """
        T = M if torque is None else torque
        return self._replace(
            q=self.q @ M.T + turn, qd=self.qd @ M.T, qdd=self.qdd @ M.T, torque=self.torque @ T.T,
            keep=self.keep[:, np.abs(T).argmax(axis=1)],
        )  # fmt: skip

    def mixed(self, other: "States", mask: Mask) -> "States":
        """Take some of the states in another reading."""
        names = ("q", "qd", "qdd", "torque", "keep")
        arrays = (np.where(mask[:, None], getattr(other, name), getattr(self, name)) for name in names)
        return self._replace(**dict(zip(names, arrays, strict=True)))


def states_of(source: Source | None, fewest: int = _FEWEST) -> States | None:
    """Some 10 states a second of all recordings, without payload first; None where there are too few."""
    parts = list[States]()
    if source is None:
        return None
    for loaded, recordings in enumerate((source.unloaded, source.loaded)):
        for recording in recordings:
            t = recording.t
            middle = 0.5 * (t[0] + t[-1]) + 0.5 * _LONGEST * np.array([-1.0, 1.0])
            own = slice(*map(int, np.searchsorted(t, middle)))
            used = taken(recording, own) if len(t[own]) < len(t) - 1 else recording
            count = min(_MOST, int(_RATE * float(used.t[-1] - used.t[0])) + 1)
            parts.append(States.of(used, source.processing, count, loaded))
    return States.joined(parts) if sum(len(part.t) for part in parts) >= fewest else None


@dataclass(frozen=True, eq=False)
class System:
    """Equations of robot and payload on subsampled states."""

    robot: Robot
    states: States
    names: tuple[str, ...]  # of the robot's columns
    columns: Array  # the robot's, the payload's ten in its frame, friction's changes under load, n x c x N
    torque: Array  # less what is known of the robot [N·m or N], n x N
    keep: Mask  # rows that are used, n x N; none of a joint that has a few only
    nominal: Array  # values of the robot from an earlier identification, else zero, by names
    prior: Array  # Gram matrix of the prior rows, c x c
    payload: slice  # indices of the payload's ten; empty where nothing hangs on the robot
    inflation: float = 1.0  # by which memory of the errors raises the variances that these equations leave

    @staticmethod
    def of(
        robot: Robot, states: States, changes: Mapping[str, float] | None = None, known: Known | None = None
    ) -> "System":
        """Set up the equations, with a payload where any state is loaded, without rows beyond a spring's table.

        ``changes``: frictions that may differ under load, with the weight of the prior row of each, 0 for none;
        ``known``: parameters of the robot from an earlier identification.
        """
        own = known.names if known is not None else own_columns(robot)
        payload = payload_columns(robot) if states.loaded.any() else ()
        changes = dict(changes or {}) if payload else {}
        names = tuple(dict.fromkeys((*own, *payload, *changes)))
        spring, keep = np.zeros(states.torque.T.shape), states.keep.T & (states.keep.sum(axis=0) >= _ROWS)[:, None]
        if robot.spring is not None:
            k = robot.spring.joint - 1
            try:
                spring[k] = robot.spring.torque(states.q[:, k])
            except InputError:  # the joint leaves the spring's table: it cannot be so
                keep = np.zeros_like(keep)
        b, c, nominal, inflation = len(own), len(own) + len(payload), np.zeros(len(own)), 1.0
        prior = np.diag(np.square([*np.zeros(c), *changes.values()]))
        if known is not None:
            nominal, inflation, prior[:b, :b] = known.values, known.inflation, known.root.T @ known.root
        W = regressor_at(robot, names, states.q, states.qd, states.qdd)
        load, friction = (W[:, list(map(names.index, some))] * states.loaded for some in (payload, changes))
        load = frame_change(robot.flange).T @ load if payload else load
        columns, measured = np.concatenate([W[:, :b], load, friction], axis=1), states.torque.T + spring
        torque = measured - nominal @ W[:, :b] if known is not None else measured
        system = System(robot, states, own, columns, torque, keep, nominal, prior, slice(b, c), inflation)
        if not robot.drives.loaded:
            return system
        # Friction under load goes by the torque of the bodies, as they come out without it.
        rigid = [k for k, name in enumerate((*own, *payload)) if parameter_kind(name) in INERTIAL]
        carried = system.values[rigid] @ columns[:, rigid] - spring
        terms = drive_terms(robot.drives, DriveState(states.q.T, states.qd.T, states.qdd.T, carried), np.sign)
        loaded = robot.drives.loaded
        for k, name in enumerate((*own, *payload, *changes)):
            for row, values in terms[name].items() if parameter_kind(name) in loaded else ():
                columns[row, k] = values if k < c else values * states.loaded
        # Columns of the Gram matrices that change, the torque's among them.
        changed = [*(k for k, name in enumerate(own) if parameter_kind(name) in loaded), -1]
        torque = measured - nominal @ columns[:, :b] if known is not None else measured
        rows, grams = np.concatenate([columns[:, :c], torque[:, None]], axis=1) * keep[:, None], system.joint_grams
        grams[:, changed] = rows[:, changed] @ rows.swapaxes(1, 2)
        grams[:, :, changed] = grams[:, changed].swapaxes(1, 2)
        system = replace(system, torque=torque)
        vars(system)["joint_grams"] = grams
        return system

    @cached_property
    def carried(self) -> Array:
        """Torque of the payload, n x N; zero where nothing shows one."""
        return np.asarray(self.values[self.payload] @ self.columns[:, self.payload])

    def bodies(self, robot: Robot | None = None, turns: Array | None = None, payload_alone: bool = False) -> Array:
        """Torques of links and payload together, or of the payload alone, n x k x N.

        On the way, with joints turned by ``turns`` [rad], k x n, or at rest under the gravity of another ``robot``.
        """
        values: dict[str, Any] = {} if payload_alone else dict(zip(self.names, self.values, strict=False))
        turns = np.zeros((1, self.robot.n)) if turns is None else turns
        loaded = np.tile(self.states.loaded, len(turns))
        if self.states.loaded.any():
            ten = frame_change(self.robot.flange) @ self.values[self.payload]
            for name, value in zip(payload_columns(self.robot), ten, strict=True):
                values[name] = values.get(name, 0.0) + value * loaded
        moves = float(robot is None)
        qd, qdd = (np.tile(moves * part, (len(turns), 1)).T for part in (self.states.qd, self.states.qdd))
        q = (self.states.q + turns[:, None]).reshape(-1, self.robot.n).T
        torques = body_torques(robot or self.robot, DriveState(q, qd, qdd, None), values, np)
        return np.array(torques).reshape(len(q), len(turns), -1)

    @cached_property
    def norms(self) -> Array:
        """Norm of each joint's torque over the rows that are used, 1 where it is zero, shape (n,)."""
        norms = np.linalg.norm(self.torque * self.keep, axis=1)
        return np.asarray(np.where(norms == 0.0, 1.0, norms))

    @cached_property
    def weights(self) -> Array:
        """Weights of the joints by their residuals [1/(N·m) or 1/N], shape (n,)."""
        weights = np.ones(self.robot.n)
        for _ in range(2):
            weights = 1.0 / self.fit(weights).left()[1]
        return weights

    @cached_property
    def values(self) -> Array:
        """Parameters of robot and payload, shape (c,); those that nothing shows are zero."""
        own = self.fit(self.weights).own
        values = np.append(own, np.zeros(len(self.prior) - len(own)))
        values[: len(self.names)] += self.nominal
        return values

    @cached_property
    def joint_grams(self) -> Array:
        """Gram matrices of each joint's rows: robot, payload, torque last; friction as without load."""
        rows = np.concatenate([self.columns[:, : self.payload.stop], self.torque[:, None]], axis=1)
        rows *= self.keep[:, None]
        return np.asarray(rows @ rows.swapaxes(1, 2))

    def fit(self, weights: Array, free_gains: bool = False) -> "SystemFit":
        """Solve the equations, friction as it is without load.

        With free gains each joint's columns have a scale, by Gauss-Newton from 1: the best step.
        """
        G, right, torque = self.joint_grams[:, :-1, :-1], self.joint_grams[:, :-1, -1], self.joint_grams[:, -1, -1]
        square, scales, tried = weights**2, np.ones(self.robot.n), list[tuple[float, SystemFit]]()
        prior = self.prior[: len(G[0]), : len(G[0])]
        for _ in range(_STEPS):
            root = _root(np.einsum("j,jab->ab", square * scales**2, G) + prior)
            fit = SystemFit(self, weights, scales, root, root @ (root.T @ (square * scales @ right)))
            if not free_gains:
                return fit
            # The parameters are eliminated from the normal equations of scales and parameters (Schur complement).
            along = G @ fit.own
            modelled, shown = along @ fit.own, right @ fit.own
            tried.append((float(square @ (torque - 2.0 * scales * shown + scales**2 * modelled)), fit))
            taken = (square * scales)[:, None] * (along @ root)
            gram = np.diag(square * modelled + 1.0 / _GAIN**2) - taken @ taken.T
            step = np.linalg.solve(gram, square * (shown - scales * modelled) + (1.0 - scales) / _GAIN**2)
            scales = np.clip(scales + np.clip(step, -_GAIN, _GAIN), _GAIN, 1.0 / _GAIN)
        return min(tried, key=lambda entry: entry[0])[1]

    def grams(self, groups: Indices, added: Sequence[Array] = ()) -> Array:
        """Gram matrices of all weighted columns, added ones (n x m x N), and the torque, by group of states."""
        every, grams = (self.columns, *added, self.torque[:, None]), list[Array]()
        for number in range(int(groups.max()) + 1):  # one after the other, near the processor
            own = groups == number
            rows = np.concatenate([part[:, :, own] for part in every], axis=1)
            rows *= (self.weights[:, None] * self.keep[:, own])[:, None]
            weighted = rows.transpose(1, 0, 2).reshape(rows.shape[1], -1)
            grams.append(weighted @ weighted.T)
        return np.array(grams)

    def with_columns(self, *columns: Array, prior: Array | None = None) -> "Added":
        """Add columns to the equations, n x m x N; ``prior``: Gram matrix of other prior rows, c x c."""
        prior = self.prior if prior is None else prior
        return Added.of(self.grams(self.states.block, columns), prior, self.payload, self.inflation)


def solved(gram: Array, prior: Array) -> Array:
    """Parameters that stand for the last columns of a Gram matrix, beside prior rows, c x m."""
    root = _root(gram[: len(prior), : len(prior)] + prior)
    return np.asarray(root @ (root.T @ gram[: len(prior), len(prior) :]))


def relative_scales(robot: Robot, states: States) -> Array:
    """Scales of the joints' signals, (n,), by the links that several joints move; over them they are to one scale.

    From round to round each is near the one before.
    """
    scales = np.ones(robot.n)
    for _ in range(_ROUNDS):
        system = System.of(robot, states._replace(torque=states.torque / scales))
        scales *= system.fit(system.weights, True).scales
    return scales


@dataclass(frozen=True, eq=False)
class SystemFit:
    """Solution of a system for some weights of the joints and scales of their columns."""

    system: System
    weights: Array
    scales: Array
    root: Array  # root root' inverts the Gram matrix
    own: Array  # parameters of robot and payload

    def of_torque(self, torque: Array) -> "SystemFit":
        """Solve the same equations for another torque, n x N."""
        system, grams, c = replace(self.system, torque=torque), np.array(self.system.joint_grams), len(self.own)
        used = torque * system.keep
        grams[:, :c, c] = grams[:, c, :c] = (system.columns[:, :c] @ used[:, :, None])[:, :, 0]
        grams[:, c, c] = np.sum(used**2, axis=1)
        vars(system)["joint_grams"] = grams  # the columns' part stays as it is
        shown = (self.scales * self.weights**2) @ grams[:, :c, c]
        return replace(self, system=system, own=self.root @ (self.root.T @ shown))

    @cached_property
    def errors(self) -> Array:
        """Torque that is left [N·m or N], n x N, zero where rows are not used."""
        modelled = self.scales[:, None] * (self.own @ self.system.columns[:, : len(self.own)])
        return np.asarray((self.system.torque - modelled) * self.system.keep)

    def left(self) -> tuple[Array, Array]:
        """Errors of each joint over its torque, and their rms [N·m or N], 1 without rows; both of shape (n,)."""
        system, rows = self.system, self.system.keep.sum(axis=1)
        relative = np.linalg.norm(self.errors, axis=1) / system.norms + _FLOOR
        return relative, np.where(rows > 0, relative * system.norms / np.sqrt(np.maximum(rows, 1)), 1.0)

    @cached_property
    def likelihood(self) -> Array:
        """Log-likelihood of each row, n x N; each joint's variance by its own errors, over its torque's.

        Over the torque's, for a joint's torque may be in another unit.
        """
        relative, rms = self.left()
        terms = -np.log(relative)[:, None] - 0.5 * (self.errors / rms[:, None]) ** 2
        return np.where(self.system.keep, terms, 0.0)


class Effect(NamedTuple):
    """Estimate of the columns that a hypothesis adds."""

    where: str  # in which recordings, or where else
    values: Array  # of the columns, shape (k,)
    covariance: Array  # nan where nothing shows them
    effect: Array  # on the payload's ten once corrected, 10 x k
    fall: float = 0.0  # fraction of the squared residual that they take off
    size: float = 0.0  # in SI units: the value of a single column, the length of several
    sigma: float = 0.0  # its standard deviation, infinite where one is not shown
    by_difference: Array | None = None  # effect on method 3, if that is another one
    few: float = 1.0  # by which few blocks lower the significance, as Student's t does
    groups: Sequence[Sequence[int]] = ()  # values that are judged together, where not all of them are

    def z(self, *index: int) -> float:
        """Standard deviations from zero of some values together, by default of the clearest group, 0 unseen."""
        if self.groups and not index:
            return max(self.z(*group) for group in self.groups)
        k = list(index or range(len(self.values)))
        C = self.covariance[np.ix_(k, k)] + 1e-200 * np.eye(len(k))  # a variance of zero hides no value
        if not np.isfinite(C).all():
            return 0.0
        square = float(self.values[k] @ np.linalg.pinv(C, hermitian=True) @ self.values[k])
        return float(np.sqrt(max(square, 0.0))) / self.few

    @property
    def change(self) -> Array:
        """Change of the payload's ten by correcting it, shape (10,)."""
        return np.asarray(self.effect @ self.values)


class Added(NamedTuple):
    """Rest of added columns and of the torque that a system's columns do not explain."""

    whole: Array  # their Gram matrix, torque last
    left: Array  # the same without each block of time
    payload: Array  # the payload's ten that stand for each column and the torque, 10 x (m + 1)
    inflation: float = 1.0

    @staticmethod
    def of(blocks: Array, prior: Array, payload: slice, inflation: float = 1.0) -> "Added":
        """Project Gram matrices by block (columns, added columns, torque) off the first columns."""
        c, whole = len(prior), blocks.sum(axis=0)
        whole[:c, :c] += prior
        root = _root(whole[:c, :c], small=c)  # by which ``remains`` was chosen
        root = root[:, root.any(axis=0)]
        grams, rests = [whole, *(whole - block for block in blocks)], list[Array]()
        whites = [root.T @ gram[:c, :c] @ root for gram in grams]  # nearly white
        try:
            factors = [np.linalg.cholesky(white) for white in whites]
            remains = min(float(np.diagonal(L).min(initial=1.0)) for L in factors) ** 2
        except np.linalg.LinAlgError:
            remains = 0.0
        for k, gram in enumerate(grams):
            right = root.T @ gram[:c, c:]
            if remains > _REMAINS:
                half = np.asarray(solve_triangular(factors[k], right, lower=True, check_finite=False))
                rests.append(gram[c:, c:] - half.T @ half)
            else:  # a direction that the other blocks do not determine explains nothing
                inverse = np.linalg.pinv(whites[k], _REMAINS, hermitian=True)
                rests.append(gram[c:, c:] - right.T @ inverse @ right)
        return Added(rests[0], np.array(rests[1:]), (root @ root.T @ whole[:c, c:])[payload], inflation)

    def effect(self, index: Sequence[int], free: Sequence[int] = (), where: str = "") -> Effect:
        """Estimate some of the added columns, others free as far as these are more than rounding."""
        squares, k = np.diag(self.whole), len(index)
        free = [i for i in free if squares[i] > _RANK * squares[list(index)].max()]
        every = [*index, *free]
        left, right = self.left[:, every], self.whole[every, -1]
        grams = self.whole[np.ix_(every, every)], self.whole[np.ix_(free, free)], left[:, :, every]
        # By eigenvalues: rounding makes such differences indefinite.
        roots = (_root(gram, 1e-12, gram.shape[-1]) for gram in grams)
        inverse, without, without_block = (root @ root.swapaxes(-1, -2) for root in roots)
        values = (inverse @ right)[:k]
        each = np.einsum("bij,bj->bi", without_block, left[:, :, -1])[:, :k] - values
        # The jackknife, and the formula where that says more.
        covariance = (1.0 - 1.0 / len(each)) * each.T @ each
        variance = self.inflation * np.diag(inverse)[:k]
        jackknife, formula = np.sqrt(np.diag(covariance)), np.sqrt(np.where(variance > 0.0, variance, np.nan))
        wider = np.maximum(1.0, formula / np.maximum(jackknife, 1e-300))
        effect = self.payload[:, free] @ without @ self.whole[np.ix_(free, index)] - self.payload[:, list(index)]
        explained = right @ inverse @ right - right[k:] @ without @ right[k:]
        fall = float(explained) / max(float(self.whole[-1, -1]), 1e-300)
        covariance *= np.outer(wider, wider)
        size = float(values[0] if k == 1 else np.linalg.norm(values))
        few, many = stdtrit([max(min(len(each), BLOCKS), 2) - 1.0, BLOCKS - 1.0], _CHANCE)
        sigma = float(np.nan_to_num(np.sqrt(np.trace(covariance)), nan=np.inf))
        return Effect(where, values, covariance, effect, fall, size, sigma, few=float(few / many))


def _root(gram: Array, least: float = _RANK, small: int = _SMALL) -> Array:
    """Roots K with K K' the inverse of Gram matrices, as far as they determine their columns, else zero.

    Up to ``small`` columns they stand along the eigenvectors.
    """
    squares = np.diagonal(gram, axis1=-2, axis2=-1)
    # Columns of which nothing but rounding is left are taken out.
    size = np.sqrt(np.where(squares > _NOTHING * squares.max(axis=-1, initial=0.0, keepdims=True), squares, np.inf))
    scaled = gram / (size[..., :, None] * size[..., None, :])
    if gram.ndim == 2 and len(gram) > small and np.isfinite(scaled).all():
        # Much faster than eigenvalues, where these would leave out the same: rounding, and nothing but that.
        R, order, rank, _ = lapack.dpstrf(scaled, tol=_ROUNDING)
        root, known = np.zeros((len(gram), rank)), order[:rank] - 1
        root[known] = np.triu(lapack.dtrtri(R[:rank, :rank])[0]) if rank else 0.0
        if np.sum(root**2) * len(gram) * least < 1.0:
            null = np.eye(len(gram))[:, order[rank:] - 1]
            null[known] = -root[known] @ R[:rank, rank:]
            root -= null @ np.linalg.solve(null.T @ null, null.T @ root)
            return np.asarray(root / size[:, None])
    eigenvalues, V = np.linalg.eigh(scaled)
    size = size[..., :, None] * np.sqrt(np.maximum(eigenvalues, 1e-300))[..., None, :]
    return np.where((eigenvalues > least * eigenvalues[..., -1:])[..., None, :], V / size, 0.0)
