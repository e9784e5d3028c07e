"""Other ways to take a set of recordings, always tried: another robot that is shipped, a joint turned round.

Method 4 on states thinned to 10 Hz, with the joints' weights of the robot as described, and Vuong's statistic: the
mean over blocks of time of the difference of log-likelihoods, over its standard error.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import INERTIAL, Recording, Robot, load_robot, robot_names
from ...model.many_states import own_columns, regressor_at
from ..payload.problem import Source
from .misfit import Sample

_RATE = 10.0  # Hz
_MOST = 600  # states of a recording
_LONGEST = 180.0  # s: of a longer recording the middle is looked at
_FEWEST = 60  # states altogether
_BLOCKS = 20
_ROUGHLY = 5  # times fewer states decide first
_FAR = -0.5  # fall of chi2 by those: such a robot is not looked at closer
_RANK = 1e-10  # of the largest eigenvalue: squares of columns, scaled to norm 1
_FLOOR = 1e-9  # of a joint's torque: data without noise still need finite weights


Places = NDArray[np.intp]


class Rival(NamedTuple):
    """Another way to take the recordings.

    ``kind``: "robot" or "turned"; ``name``: of the robot, or number of the joint; ``fall``: by which fraction chi2
    falls, negative where it rises; ``z``: Vuong's statistic.
    """

    kind: str
    name: str
    fall: float
    z: float


class _States(NamedTuple):
    """Thinned states of all recordings: ``sample``, which are loaded (N,), and the block of time of each (N,)."""

    sample: Sample
    loaded: Array
    block: Places

    def thinned(self) -> "_States":
        """Every so many-th state; all of them where few would be left."""
        count = len(self.block)
        step = _ROUGHLY if count >= 3 * _ROUGHLY * _FEWEST else 1
        return _States(self.sample.part(0, count, step), self.loaded[::step], self.block[::step])


class _Equations(NamedTuple):
    """Per joint which of ``columns`` unknowns it sees, their columns and its torques; unused rows are zero."""

    joints: tuple[tuple[Places, Array, Array], ...]
    columns: int


class _Fit(NamedTuple):
    """Squared errors by block, (blocks,), and rms error of each joint, (n,)."""

    squares: Array
    rms: Array


def rivals(robot: Robot, source: Source) -> tuple[Rival, ...]:
    """How other robots and senses of the joints explain the recordings; none where there is too little motion.

    Only robots with other geometry are tried, with as many joints and drives as described.
    """
    states = _states(source)
    if states is None:
        return ()
    try:
        rough, close = _Described.of(robot, states.thinned()), _Described.of(robot, states)
    except InputError:  # a joint leaves the table of its spring: there is nothing to compare with
        return ()
    tried = []
    for kind, name, other, taken in _others(robot, states):
        try:
            rival = rough.compared(kind, name, other, taken.thinned())
            tried.append(rival if rival.fall < _FAR else close.compared(kind, name, other, taken))
        except InputError:
            continue
    return tuple(tried)


class _Described(NamedTuple):
    """The robot as described: the joints' weights, and its squared errors by block."""

    weights: Array
    squares: Array

    @staticmethod
    def of(robot: Robot, states: _States) -> "_Described":
        equations = _equations(robot, states)
        weights = 1.0 / _fit(equations, states, np.ones(robot.n)).rms
        return _Described(weights, _fit(equations, states, weights).squares)

    def compared(self, kind: str, name: str, other: Robot, states: _States) -> Rival:
        squares = _fit(_equations(other, states), states, self.weights).squares
        difference = 0.5 * (self.squares - squares)
        error = float(np.std(difference, ddof=1)) / np.sqrt(len(difference))
        fall = 1.0 - float(squares.sum() / self.squares.sum())
        return Rival(kind, name, fall, float(difference.mean()) / max(error, 1e-300))


def _others(robot: Robot, states: _States) -> Iterator[tuple[str, str, Robot, _States]]:
    sample = states.sample
    for j in range(robot.n):
        sign = np.ones(robot.n)
        sign[j] = -1.0
        turned = replace(
            sample, q=sample.q * sign, qd=sample.qd * sign, qdd=sample.qdd * sign, torque=sample.torque * sign
        )
        yield "turned", str(j + 1), robot, states._replace(sample=turned)
    for name in robot_names():
        other = load_robot(name)
        if other.n == robot.n and _geometry(other) != _geometry(robot):
            spring = other.drives.spring
            coupling = other.drives.coupling if robot.drives.rotor_inertia and robot.drives.friction else None
            drives = replace(robot.drives, coupling=coupling, spring=spring)
            yield "robot", name, replace(other, gravity=robot.gravity, drives=drives), states


def _geometry(robot: Robot) -> list[tuple[str, float, float, float, float]]:
    return [(joint.kind, joint.alpha, joint.d, joint.theta, joint.r) for joint in robot.joints]


def _states(source: Source) -> _States | None:
    """Some 10 states a second of all recordings, in 20 blocks of time."""
    samples: list[Sample] = []
    loaded: list[Array] = []
    for recordings, with_payload in ((source.unloaded, 0.0), (source.loaded, 1.0)):
        for recording in recordings:
            part = _stretch(recording)
            samples.append(Sample.of(part, source.processing, count=_count(part)))
            loaded.append(np.full(len(samples[-1].t), with_payload))
    total = sum(len(sample.t) for sample in samples)
    if total < _FEWEST:
        return None
    block = np.arange(total) * _BLOCKS // total
    return _States(Sample.joined(samples), np.concatenate(loaded), block)


def _stretch(recording: Recording) -> Recording:
    """The middle of a recording that has far more than the states that are looked at."""
    t = recording.t
    first, last = np.searchsorted(t, 0.5 * (t[0] + t[-1]) + 0.5 * _LONGEST * np.array([-1.0, 1.0]))
    if last - first >= len(t) - 1:
        return recording
    part = slice(int(first), int(last))
    qd = recording.qd[part] if recording.qd is not None else None
    return replace(recording, t=t[part], q=recording.q[part], torque=recording.torque[part], qd=qd)


def _count(recording: Recording) -> int:
    return min(_MOST, int(_RATE * float(recording.t[-1] - recording.t[0])) + 1)


def _equations(robot: Robot, states: _States) -> _Equations:
    """Robot and payload together.

    Raises:
        InputError: if a joint leaves the table of the robot's spring.
    """
    sample, keep = states.sample, states.sample.keep.T
    torque = np.array(sample.torque.T)
    if robot.spring is not None:
        k = robot.spring.joint - 1
        torque[k] = torque[k] + robot.spring.torque(sample.q[:, k])
    own = own_columns(robot)
    payload = [f"{kind}{robot.n}" for kind in INERTIAL] if states.loaded.any() else []
    names = (*own, *(name for name in payload if name not in own))
    W = regressor_at(robot, names, sample.q, sample.qd, sample.qdd)
    places = np.array([*range(len(own)), *(names.index(name) for name in payload)])
    parts = []
    for rows, y, kept in zip(W, torque, keep, strict=True):
        used = np.flatnonzero(rows.any(axis=1)[places])
        columns = rows[places[used]] * kept
        columns[used >= len(own)] *= states.loaded
        parts.append((used, columns, y * kept))
    return _Equations(tuple(parts), len(places))


def _fit(equations: _Equations, states: _States, weights: Array) -> _Fit:
    """By weighted least squares."""
    x, n = _solved(equations, weights), len(equations.joints)
    squares, rms = np.zeros(_BLOCKS), np.ones(n)
    counts = states.sample.keep.sum(axis=0)
    for j, ((used, columns, y), weight, count) in enumerate(zip(equations.joints, weights, counts, strict=True)):
        error = weight * (y - x[used] @ columns)
        squares += np.bincount(states.block, error**2, _BLOCKS)
        if count:
            rms[j] = np.sqrt(error @ error / count) + _FLOOR * weight * np.sqrt(y @ y / count) + 1e-300
    return _Fit(squares, rms)


def _solved(equations: _Equations, weights: Array) -> Array:
    """Least squares by the Gram matrix of columns scaled to norm 1: good enough to compare residuals, and fast."""
    gram, right = np.zeros((equations.columns, equations.columns)), np.zeros(equations.columns)
    for (used, columns, y), weight in zip(equations.joints, weights, strict=True):
        gram[np.ix_(used, used)] += weight**2 * (columns @ columns.T)
        right[used] += weight**2 * (columns @ y)
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    squares, V = np.linalg.eigh(gram / np.outer(size, size))
    kept = squares > _RANK * squares[-1]
    return np.asarray(V[:, kept] @ ((V[:, kept].T @ (right / size)) / squares[kept]) / size)
