"""Whether the payload was changed in the last seconds: one payload for the whole window, or another for its end."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.linear import least_squares
from ..equations.observation import Observation
from .constant_torques import FREE, HeldFriction, held_friction, less_robot
from .window import Block, MovingWindow

_LATEST = (1, 2, 3, 4)
"""Blocks at the end of the window that another payload is tried for."""
_BEFORE = 5
"""Blocks that must lie before them: fewer are no measure of what is usual."""
_KNOWN = 10
"""Blocks by which the size of the errors is known; fewer fit themselves too well."""
_RISE = 400.0
"""Fall of chi2 above which the payload was changed.

Measured on a real UR10e: at most 223 in three recordings of one payload, 828 and more in the first two seconds
after 2.805 kg were put on or off.
"""
_MASS, _MOMENT = 30.0, 0.5
"""kg and kg m: standard deviations of what is put on or off; its own inertia hardly shows in two seconds."""
_PAYLOAD = np.array([5.0] * 6 + [5.0] * 3 + [30.0])
"""Standard deviations of the ten of what hangs there, so wide that they count only where nothing is seen."""
_NORMAL95 = 1.96


class Change(NamedTuple):
    """A payload that was put on or off: when [s], by which mass [kg], and its 95 % interval."""

    time: float
    mass: float
    low: float
    high: float


def change_in(window: MovingWindow) -> Change | None:
    """The latest change that explains the last blocks' torques; None where one payload does for the whole window.

    The size of the errors is that of the last window that was long enough: it is the robot's, not the payload's.
    The equations are those of the window, the robot's torque taken off and friction held near its own; four more
    columns of the last blocks alone hold mass and first moments of what was put on or off.
    """
    blocks = list(window.blocks)
    tried = [count for count in _LATEST if count <= len(blocks) - _BEFORE]
    if not tried:
        return None
    less = [less_robot(block.equations, window.known.values) for block in blocks]
    usual = less[: -tried[-1]]
    if len(usual) >= _KNOWN:
        window.usual = held_friction([usual[0].followed_by(usual[1:])], window.sigmas)
    friction = window.usual
    if friction is None:
        return None
    return _latest_change(blocks, less, friction, tried)


def _latest_change(
    blocks: Sequence[Block], less: Sequence[Observation], friction: HeldFriction, tried: Sequence[int]
) -> Change | None:
    """Try another payload for ever more of the last blocks."""
    rows, columns = [_weighted(part, friction) for part in less], less[0].columns
    A, y = np.vstack([part[:, :-1] for part in rows]), np.concatenate([part[:, -1] for part in rows])
    near = _near(columns, friction)
    A, y = np.vstack([A, near]), np.append(y, np.zeros(len(near)))
    for count in tried:  # a later beginning holds nothing of the payload before
        first = sum(map(len, rows[:-count]))
        D = np.zeros((len(A), 4))
        D[first : len(A) - len(near)] = A[first : len(A) - len(near), -4:]
        mass, sigma, fall = _explained(A, y, D)
        if fall > _RISE:
            half = _NORMAL95 * sigma
            return Change(blocks[-count].start, mass, mass - half, mass + half)
    return None


def _weighted(part: Observation, friction: HeldFriction) -> Array:
    """Rows of all joints with noise, [W Y], in units of the errors that are usual."""
    sizes = friction.noise * np.sqrt(friction.memory)
    rows = [np.column_stack([W, Y]) / size for W, Y, size in zip(part.W, part.Y, sizes, strict=True) if size > 0.0]
    return np.vstack(rows)


def _near(columns: Sequence[str], friction: HeldFriction) -> Array:
    """Equations that keep friction near the robot's, and the payload within reason."""
    sigmas = [
        friction.held[name].sigma if (name := column.removeprefix(FREE)) in friction.held else 0.0
        for column in columns
    ]
    rows = [np.eye(1, len(columns), k) / sigma for k, sigma in enumerate(sigmas) if sigma > 0.0]
    payload = np.zeros((10, len(columns)))
    payload[:, -10:] = np.diag(1.0 / _PAYLOAD)
    return np.vstack([*rows, payload])


def _explained(A: Array, y: Array, D: Array) -> tuple[float, float, float]:
    """Mass of what the columns D stand for, its standard deviation, and by how much they lower the squares."""
    both = np.column_stack([D, y])
    left = both - A @ least_squares(A, both)
    E, e = left[:, :4], left[:, 4]
    prior = np.diag([_MOMENT**-2] * 3 + [_MASS**-2])
    covariance = np.linalg.inv(E.T @ E + prior)
    pull = E.T @ e
    delta = covariance @ pull
    return float(delta[3]), float(np.sqrt(covariance[3, 3])), float(pull @ delta)
