"""Whether the payload was changed in the last seconds: one payload for the whole window, or another for its end.

A generalised likelihood ratio: the fall of chi2 by four numbers more (mass and first moments of what was put on or
off) for ever longer ends of the window. How large a fall may be by chance follows from a stated number of false
alarms an hour: 4 F(4, nu) of errors whose size was measured with nu degrees of freedom in the stream itself, times
how much larger than that theory the stream's falls usually are. A block that even a payload of its own leaves badly
explained, such as one with a jerk beyond the filter, counts by its own errors: no change may rest on it.
"""

from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import chdtri, fdtri

from ...common.arrays import Array
from ..equations.equations import triangular
from ..equations.observation import Observation
from .constant_torques import FREE, HeldFriction, less_robot
from .window import MovingWindow

FALSE_ALARMS = 0.01
"""An hour of motion: changes that are told where there is none, if errors are normal and remember as measured."""
_ENDS = (1, 2, 3, 4, 7, 10)
"""Blocks at the end of the window that another payload is tried for."""
_BEFORE = 5
"""Blocks that must lie before them: fewer are no measure of what is usual."""
_KNOWN = 10
"""Blocks by which the size of the errors is known; fewer fit themselves too well."""
_LAG = 4
"""Blocks between those the errors are measured in and the newest: a change hides itself in its own errors."""
_SURE, _VAGUE, _ALONE = 2, 0.3, 2.0
"""Blocks that are waited for where the mass's interval is wider than the first share to either side.

Beyond the second, that is a mass within a standard deviation of zero, more are waited for: moments alone are no
payload that was put on or off.
"""
_MASS, _MOMENT = 30.0, 0.5
"""kg and kg m: standard deviations of what is put on or off; its own inertia hardly shows in two seconds."""
_PAYLOAD = np.array([5.0] * 6 + [5.0] * 3 + [30.0])
"""Standard deviations of the ten of what hangs there, so wide that they count only where nothing is seen."""
_NORMAL95 = 1.96
_SOON = 1e-6
"""s: what begins earlier by less begins at the same time."""
_CHANCE = FALSE_ALARMS / 3600.0 / len(_ENDS)
"""Of an end, in an hour's blocks of one second."""
_FALL = float(chdtri(4, _CHANCE))
"""Of chi2, which chance passes as rarely as is allowed where the size of the errors is known exactly."""
_MEDIAN = 3.357
"""Of chi2 with four degrees of freedom."""
_LEAST = 2.0
"""How much larger than by theory falls are taken to be at least: a real UR10e's errors differ by kind of motion."""
_REMEMBERED = 600
"""Falls by which the stream tells what is usual."""


class Change(NamedTuple):
    """A payload that was put on or off: when [s], by which mass [kg], and its 95 % interval."""

    time: float
    mass: float
    low: float
    high: float


class _Usual(NamedTuple):
    """Errors as they were: ``held`` by some blocks, ``freedom`` of each joint's, and after how many blocks."""

    held: HeldFriction
    freedom: Array
    blocks: int


class _Tried(NamedTuple):
    """Another payload for the last ``count`` blocks, and the ``fall`` of chi2.

    ``delta``: first moments [kg m] and mass [kg], with their ``covariance``.
    """

    blocks: int
    delta: Array
    covariance: Array
    fall: float


class ChangeWatch:
    """Watches a window's blocks as they come."""

    def __init__(self, window: MovingWindow) -> None:
        """Begin without any measure of the errors."""
        self.window = window
        self._usual: deque[_Usual] = deque(maxlen=_LAG + 1)
        self._falls: deque[float] = deque(maxlen=_REMEMBERED)
        self._loudness: dict[float, float] = {}
        self._blocks = 0

    @property
    def scale(self) -> float:
        """How much larger falls of chi2 usually are in this stream than by theory; at least 2."""
        return max(float(np.median(self._falls)) / _MEDIAN, _LEAST) if self._falls else _LEAST

    def change(self) -> Change | None:
        """The change that the newest block shows; None where one payload does for the whole window.

        Call it once for each block that was added.
        """
        self._blocks += 1
        window = self.window
        if len(window.blocks) >= _KNOWN:
            self._usual.append(_usual(window, self._blocks))
        if not self._usual:
            return None
        usual = self._usual[0]
        ends = self._ends(usual)
        if not ends:
            return None
        near = _near(window.less.columns, usual.held)
        starts = [block.start for block in window.blocks]
        rows = _quieter(_weighted(window.less, usual.held), starts, self._loud(usual, near))
        tried = _tried(rows, starts, ends, near)
        if not any(trial.fall > self._limit(trial, rows, usual) for trial in tried):
            self._falls.extend(trial.fall for trial in tried[:2])
            return None
        best = max(tried, key=lambda trial: trial.fall)
        mass, half = float(best.delta[3]), _NORMAL95 * float(np.sqrt(self.scale * best.covariance[3, 3]))
        if half > (_VAGUE if best.blocks < _SURE else _ALONE) * abs(mass):
            return None
        self._usual = deque([usual], maxlen=_LAG + 1)  # those after it hold both payloads
        return Change(list(window.blocks)[-best.blocks].start, mass, mass - half, mass + half)

    def _loud(self, usual: _Usual, near: Array) -> list[float]:
        """How much larger than usual the errors of each block are beside a payload of its own; at least 1."""
        known = self.window.known.values
        self._loudness = {
            block.start: self._loudness[block.start]
            if block.start in self._loudness
            else _loudness(_weighted(less_robot(block.equations, known), usual.held), near)
            for block in self.window.blocks
        }
        return list(self._loudness.values())

    def _ends(self, usual: _Usual) -> list[int]:
        """How many last blocks may hold another payload: enough stand before them, the errors are older."""
        since, most = self._blocks - usual.blocks, len(self.window.blocks) - _BEFORE
        return [end for end in _ENDS if end <= most and (end <= since or since >= _LAG)]

    def _limit(self, tried: _Tried, rows: "_Rows", usual: _Usual) -> float:
        """The fall of chi2 that chance passes as rarely as is allowed; infinite where this one is far below."""
        if tried.fall <= self.scale * _FALL:
            return np.inf
        start = list(self.window.blocks)[-tried.blocks].start
        own = np.array([np.sum((A[t >= start - _SOON][:, -5:-1] @ tried.delta) ** 2) for t, A in rows])
        shares = own / max(float(own.sum()), np.finfo(float).tiny)
        # Of errors that each joint's own size is measured for: Satterthwaite.
        freedom = 1.0 / float(np.sum(shares**2 / usual.freedom[usual.held.noise > 0.0]))
        return self.scale * 4.0 * float(fdtri(4.0, freedom, 1.0 - _CHANCE))


_Rows = list[tuple[Array, Array]]
"""Times and rows [W Y] of each joint with noise, in units of the errors that are usual."""


def _usual(window: MovingWindow, blocks: int) -> _Usual:
    """The errors by all blocks of the window; each joint's friction and part of the payload took some freedom."""
    friction = window.held
    rows = np.array([len(Y) for Y in window.less.Y], dtype=float)
    return _Usual(friction, np.maximum(rows / friction.memory - 5.0, 4.0), blocks)


def _weighted(less: Observation, friction: HeldFriction) -> _Rows:
    sizes = friction.noise * np.sqrt(friction.memory)
    parts = zip(less.t, less.W, less.Y, sizes, strict=True)
    return [(t, np.column_stack([W, Y]) / size) for t, W, Y, size in parts if size > 0.0]


def _loudness(rows: _Rows, near: Array) -> float:
    """How much larger than usual errors are that a payload of their own leaves; at least 1."""
    count = sum(len(A) for _, A in rows)
    left = triangular(np.vstack([*(A for _, A in rows), near]))[near.shape[1] - 1 :, -1]
    return float(np.sqrt(max(float(left @ left) / max(count - len(_PAYLOAD), 1), 1.0)))


def _quieter(rows: _Rows, starts: Sequence[float], loud: Sequence[float]) -> _Rows:
    """Rows of blocks with larger errors than usual in units of their own."""
    sizes, edges = np.array(loud), np.array(starts) - _SOON
    return [(t, A / sizes[np.searchsorted(edges, t, side="right") - 1, None]) for t, A in rows]


def _near(columns: Sequence[str], friction: HeldFriction) -> Array:
    """Equations that keep friction near the robot's, and the payload within reason, [W Y]."""
    sigmas = [
        friction.held[name].sigma if (name := column.removeprefix(FREE)) in friction.held else 0.0
        for column in columns
    ]
    rows = [np.eye(1, len(columns), k) / sigma for k, sigma in enumerate(sigmas) if sigma > 0.0]
    payload = np.zeros((10, len(columns)))
    payload[:, -10:] = np.diag(1.0 / _PAYLOAD)
    near = np.vstack([*rows, payload])
    return np.column_stack([near, np.zeros(len(near))])


def _tried(rows: _Rows, starts: Sequence[float], ends: Sequence[int], near: Array) -> list[_Tried]:
    """Another payload for each end of the window, from the shortest on.

    The rows of a stretch are reduced once; what lies before and behind each beginning is put together from them.
    """
    edges = [-np.inf, *(starts[-end] - _SOON for end in reversed(ends)), np.inf]
    places = [np.searchsorted(t, edges) for t, _ in rows]
    stretches = [
        triangular(np.vstack([A[cut[k] : cut[k + 1]] for cut, (_, A) in zip(places, rows, strict=True)]))
        for k in range(len(edges) - 1)
    ]
    before = [triangular(np.vstack([stretches[0], near]))]
    for stretch in stretches[1:-1]:
        before.append(triangular(np.vstack([before[-1], stretch])))
    tried, end = [], stretches[-1][:0]
    for count, earlier, stretch in zip(ends, reversed(before), reversed(stretches), strict=False):
        end = triangular(np.vstack([end, stretch]))
        tried.append(_explained(count, earlier, end))
    return tried


def _explained(count: int, earlier: Array, end: Array) -> _Tried:
    """Moments and mass that the last rows hold more than the earlier ones, beside all that both share."""
    width = earlier.shape[1] - 1
    own = np.zeros((len(earlier) + len(end), 4))
    own[len(earlier) :] = end[:, -5:-1]
    both = np.vstack([earlier, end])
    R = triangular(np.column_stack([both[:, :-1], own, both[:, -1]]))[width : width + 4]
    E, e = R[:, width : width + 4], R[:, -1]
    prior = np.diag([_MOMENT**-2] * 3 + [_MASS**-2])
    covariance = np.asarray(np.linalg.inv(E.T @ E + prior), dtype=float)
    pull = E.T @ e
    delta = covariance @ pull
    return _Tried(count, delta, covariance, float(pull @ delta))
