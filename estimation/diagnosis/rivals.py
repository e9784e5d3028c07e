"""Other ways to take a set of recordings, always tried: another robot that is shipped, a joint turned round.

Method 4 on states thinned to 10 Hz, with the joints' weights of the robot as described, and Vuong's statistic: the
mean over blocks of time of the difference of log-likelihoods, over its standard error.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import INERTIAL, Robot, load_robot, robot_names
from ...model.many_states import own_columns, regressor_at
from ..signals.rows import Mask
from .reading import Reading
from .states import BLOCKS, Places, States

_FAR = -0.5  # fall of chi2 by those: such a robot is not looked at closer
_RANK = 1e-10  # of the largest eigenvalue: squares of columns, scaled to norm 1
_FLOOR = 1e-9  # of a joint's torque: data without noise still need finite weights
_STEPS = 6  # of Gauss-Newton for gains
_GAIN = 0.3  # longest step of a gain's reciprocal, and how near to 1 it is thought to be


class Rival(NamedTuple):
    """Another way to take the recordings.

    ``kind``: "robot", "turned" or "mixed up"; ``name``: of the robot, number of the joint, or what is mixed up;
    ``fall``: by which fraction chi2 falls, negative where it rises; ``z``: Vuong's statistic.
    """

    kind: str
    name: str
    fall: float
    z: float


_Other = tuple[str, str, Robot, States]
"""Kind and name of a rival, the robot and the states as it takes them."""
_Others = Callable[[Robot, States], Iterator[_Other]]


class _Equations(NamedTuple):
    """Per joint which of ``columns`` unknowns it sees, their columns and its torques; unused rows are zero."""

    joints: tuple[tuple[Places, Array, Array], ...]
    columns: int


class _Fit(NamedTuple):
    """Squared errors by block, (blocks,), and rms error of each joint, (n,)."""

    squares: Array
    rms: Array


def rivals(robot: Robot, states: States | None, free_gains: bool = False) -> tuple[Rival, ...]:
    """How other robots and senses of the joints explain the recordings; none where there is too little motion.

    Only robots with other geometry are tried, with as many joints and drives as described.

    Args:
        states: of the recordings.
        free_gains: whether each joint's torque has a scale of its own in every comparison, for gains that were
            identified with the robot as described favour it; not of coupled drives, nor beside a spring.
    """
    free = free_gains and robot.coupling is None and robot.spring is None
    return _tried(robot, states, _others, free) if states is not None else ()


def mixed_up(robot: Robot, states: States | None, gains: Sequence[float] = ()) -> tuple[Rival, ...]:
    """How neighbours that changed places, a reversed gain list, or a fault in one recording explain the recordings.

    Too many to be always tried: only where something else speaks against the recordings.

    Args:
        states: of the recordings.
        gains: with which currents were read, if they were.
    """
    if states is None:
        return ()
    return _tried(robot, states, lambda robot, states: _mixtures(robot, states, gains))


def _mixtures(robot: Robot, states: States, gains: Sequence[float]) -> Iterator[_Other]:
    plain, n = Reading.as_recorded(robot.n), robot.n
    exchanged = [(f"joints {i + 1} and {i + 2} are exchanged", plain.swapped(i, i + 1)) for i in range(n - 1)]
    turned = [(f"joint {j + 1} is counted the other way", plain.turned(j)) for j in range(n)]
    pushed = [(f"the sign of the torque of joint {j + 1} is wrong", plain.pushed(j)) for j in range(n)]
    loaded = states.loaded > 0.0
    for where, rows in _parts(loaded):
        alone = not rows.all() or loaded.all()
        for words, reading in (*exchanged, *(turned if alone else ()), *(pushed if alone else ())):
            yield "mixed up", f"{words}{where}", robot, _read(states, reading, rows)
        for i in range(n - 1):
            order = [*range(i), i + 1, i, *range(i + 2, n)]
            words = f"the torques of joints {i + 1} and {i + 2} are exchanged{where}"
            yield "mixed up", words, robot, _pushed(states, states.sample.torque[:, order], rows)
    if gains and tuple(gains) != tuple(gains[::-1]):
        factors = np.array(gains[::-1]) / np.array(gains)
        torque = states.sample.torque * factors
        yield "mixed up", "the list of drive gains is reversed", robot, _pushed(states, torque, loaded | True)


def _parts(loaded: Mask) -> Iterator[tuple[str, Mask]]:
    """All states, those without payload and those with it, in words."""
    yield "", np.ones(len(loaded), dtype=bool)
    if loaded.any() and not loaded.all():
        yield " in the recording without payload", ~loaded
        yield " in the recording with payload", loaded


def _read(states: States, reading: Reading, rows: Mask) -> States:
    """Some of the states with their joints read in another way."""
    sample, changed = states.sample, reading.of(states.sample)
    parts = {
        name: np.where(rows[:, None], getattr(changed, name), getattr(sample, name))
        for name in ("q", "qd", "qdd", "torque", "keep")
    }
    return states._replace(sample=replace(sample, **parts))


def _pushed(states: States, torque: Array, rows: Mask) -> States:
    """Some of the states with other torques."""
    sample = states.sample
    return states._replace(sample=replace(sample, torque=np.where(rows[:, None], torque, sample.torque)))


def _tried(robot: Robot, states: States, others: _Others, free_gains: bool = False) -> tuple[Rival, ...]:
    """Each beside the recordings as described; none where there is nothing to compare with."""
    try:
        rough, close = (_Described.of(robot, each, free_gains) for each in (states.thinned(), states))
    except InputError:  # a joint leaves the table of its spring: there is nothing to compare with
        return ()
    tried = []
    for kind, name, rival_robot, rival_states in others(robot, states):
        try:
            rival = rough.compared(kind, name, rival_robot, rival_states.thinned())
            tried.append(rival if rival.fall < _FAR else close.compared(kind, name, rival_robot, rival_states))
        except InputError:
            continue
    return tuple(tried)


class _Described(NamedTuple):
    """The robot as described: the joints' weights, its squared errors by block, and whether gains are free."""

    weights: Array
    squares: Array
    free_gains: bool

    @staticmethod
    def of(robot: Robot, states: States, free_gains: bool) -> "_Described":
        equations = _equations(robot, states)
        weights = 1.0 / _fit(equations, states, np.ones(robot.n)).rms
        if free_gains:
            equations = _with_gains(equations, weights)
        return _Described(weights, _fit(equations, states, weights).squares, free_gains)

    def compared(self, kind: str, name: str, robot: Robot, states: States) -> Rival:
        equations = _equations(robot, states)
        if self.free_gains:
            equations = _with_gains(equations, self.weights)
        squares = _fit(equations, states, self.weights).squares
        difference = 0.5 * (self.squares - squares)
        error = float(np.std(difference, ddof=1)) / np.sqrt(len(difference))
        fall = 1.0 - float(squares.sum() / self.squares.sum())
        return Rival(kind, name, fall, float(difference.mean()) / max(error, 1e-300))


def _others(robot: Robot, states: States) -> Iterator[_Other]:
    sample = states.sample
    for j in range(robot.n):
        sign = np.ones(robot.n)
        sign[j] = -1.0
        turned = replace(
            sample, q=sample.q * sign, qd=sample.qd * sign, qdd=sample.qdd * sign, torque=sample.torque * sign
        )
        yield "turned", str(j + 1), robot, states._replace(sample=turned)
    for name in robot_names():
        candidate = load_robot(name)
        if candidate.n == robot.n and _geometry(candidate) != _geometry(robot):
            spring = candidate.drives.spring
            coupling = candidate.drives.coupling if robot.drives.rotor_inertia and robot.drives.friction else None
            drives = replace(robot.drives, coupling=coupling, spring=spring)
            yield "robot", name, replace(candidate, gravity=robot.gravity, drives=drives), states


def _geometry(robot: Robot) -> list[tuple[str, float, float, float, float]]:
    return [(joint.kind, joint.alpha, joint.d, joint.theta, joint.r) for joint in robot.joints]


def _equations(robot: Robot, states: States) -> _Equations:
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
    for rows, y, used_samples in zip(W, torque, keep, strict=True):
        used = np.flatnonzero(rows.any(axis=1)[places])
        columns = rows[places[used]] * used_samples
        columns[used >= len(own)] *= states.loaded
        parts.append((used, columns, y * used_samples))
    return _Equations(tuple(parts), len(places))


def _fit(equations: _Equations, states: States, weights: Array) -> _Fit:
    """By weighted least squares."""
    x, n = _solved(equations, weights), len(equations.joints)
    squares, rms = np.zeros(BLOCKS), np.ones(n)
    counts = states.sample.keep.sum(axis=0)
    for j, ((used, columns, y), weight, count) in enumerate(zip(equations.joints, weights, counts, strict=True)):
        error = weight * (y - x[used] @ columns)
        squares += np.bincount(states.block, error**2, BLOCKS)
        if count:
            rms[j] = np.sqrt(error @ error / count) + _FLOOR * weight * np.sqrt(y @ y / count) + 1e-300
    return _Fit(squares, rms)


def _with_gains(equations: _Equations, weights: Array) -> _Equations:
    """Each joint's columns times its gain's reciprocal, by Gauss-Newton from 1; the best of its steps."""
    scales, c, n = np.ones(len(weights)), equations.columns, len(weights)
    best, least = equations, np.inf
    for _ in range(_STEPS):
        scaled = _Equations(
            tuple((used, k * columns, y) for (used, columns, y), k in zip(equations.joints, scales, strict=True)), c
        )
        x = _solved(scaled, weights)
        errors = [w * (y - x[used] @ columns) for (used, columns, y), w in zip(scaled.joints, weights, strict=True)]
        square = sum(float(error @ error) for error in errors)
        if square < least:
            best, least = scaled, square
        own = [
            (np.append(used, c + j), np.concatenate([columns, (x[used] @ columns)[None] / scales[j]]), y)
            for j, (used, columns, y) in enumerate(scaled.joints)
        ]
        near = [(np.array([c + j]), np.ones((1, 1)), np.array([1.0 - scales[j]])) for j in range(n)]
        more = _solved(_Equations((*own, *near), c + n), np.append(weights, np.full(n, 1.0 / _GAIN)))[c:]
        scales = np.clip(scales + np.clip(more, -_GAIN, _GAIN), _GAIN, 1.0 / _GAIN)
    return best


def _solved(equations: _Equations, weights: Array) -> Array:
    """Least squares by the Gram matrix of columns scaled to norm 1: good enough to compare residuals, and fast."""
    gram, right = np.zeros((equations.columns, equations.columns)), np.zeros(equations.columns)
    for (used, columns, y), weight in zip(equations.joints, weights, strict=True):
        gram[np.ix_(used, used)] += weight**2 * (columns @ columns.T)
        right[used] += weight**2 * (columns @ y)
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    squares, V = np.linalg.eigh(gram / np.outer(size, size))
    significant = squares > _RANK * squares[-1]
    return np.asarray(V[:, significant] @ ((V[:, significant].T @ (right / size)) / squares[significant]) / size)
