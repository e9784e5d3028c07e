"""A payload weighed standing still, in poses that are each reached from both sides.

A joint's torque at rest is that of gravity and what friction holds, which has the sign of the approach. The loaded
less the unloaded torque at one pose and side (29) cancels the robot's own gravity: what is left is the payload's, a
constant torque of each joint, and a Coulomb level of each joint and side. Inertia takes no part.

A drift that is linear in time goes out of recordings in a suitable order, such as unloaded, loaded, loaded,
unloaded, pose by pose: whatever drifts, offsets, friction or the scale of the torques.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from msgspec import structs

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import decomposed
from ...common.schema import Document, Float, Vector
from ...model import Motion, Recording, Robot, base_parameters
from ...model.drives import parameter_kind
from ...model.motion import Measurement
from ...model.regressors import payload_columns, regressor_at
from ...model.visibility import friction_columns
from ..equations.equations import PAYLOAD
from ..equations.observer import PATH, Observer
from ..equations.reduction import reduced
from ..fit.blocks import in_blocks
from ..fit.own_equations import check_lengths
from ..fit.settings import DEFAULTS, Settings
from ..signals.plausibility import check_apart, check_recordings, without_dead
from ..signals.rests import Rests, rests_of
from .constant_torques import FREE, coulomb_friction, offset_prior
from .long_motion import Source
from .pairs import torque_change
from .short_motion import Run, ShortMotion
from .under_load import robot_of

FEWEST = 4
"""Number of poses below which nothing is left to judge mass and first moments by."""
_SAME = 0.02  # rad or m: rests that lie closer are of one pose; approaches begin twice as far away
_SPEED = 1e-9  # rad/s or m/s: of the approach, whose sign alone counts
_ROUNDING = 1e-9  # of the largest entry of the payload's regressor
_COSTS = 2.0  # variance with drift over that without, above which the order does not tell it


class Drift(Document, frozen=True):
    """Drift of the torques that is linear in time, per hour where files share a clock, else per recording.

    ``offset``, ``friction``: of each joint's constant torque and Coulomb level [N·m or N], with their sigmas;
    ``mass``: what it would add to the mass [kg] from one recording to the next, were it not known; ``ratio``:
    its part of the mass's variance.
    """

    per: str
    offset: Vector
    offset_sigma: Vector
    friction: Vector
    friction_sigma: Vector
    mass: Float
    ratio: float


class Standing(Document, frozen=True):
    """Rests that a payload was weighed by.

    ``poses``: their number; ``order``: of the recordings, and how it is known; ``scatter``: of each joint's torque
    from one approach to the next [N·m or N]; ``drift``: where the order shows it.
    """

    poses: int
    order: str
    scatter: Vector
    drift: Drift | None


@dataclass(frozen=True, eq=False, repr=False)
class StaticMotion(ShortMotion):
    """Recordings that rest in poses: a short motion whose rows are rests, and whose blocks are poses."""

    rests: tuple[Rests, ...] = ()  # of each recording, those without payload first
    one_sided: tuple[int, ...] = ()  # numbers of poses that are reached from one side only
    standing: Standing | None = None


class _Order(NamedTuple):
    """Order of recordings, and their weights for the difference and for the drift, (R,), 0 where that is not seen.

    ``step``: mean time from one to the next, hours where ``per`` is; ``ratio``: part of the variance by the drift.
    """

    text: str
    per: str
    step: float
    difference: Array
    drift: Array
    ratio: float


def static_weighing(
    robot: Robot, loaded: Sequence[Recording], unloaded: Sequence[Recording], settings: Settings = DEFAULTS
) -> StaticMotion:
    """Weigh by torque differences (29) at rest, in poses reached from both sides.

    Args:
        loaded: recordings of the poses with payload.
        unloaded: without it; with one before and one after ``loaded`` a drift is taken off.

    Raises:
        InputError: if poses are too few, or not the same with payload.
    """
    processing = settings.processing_of(robot)
    recordings = [*unloaded, *loaded]
    robot = without_dead(robot, recordings)
    check_recordings(robot, recordings)
    check_lengths(recordings, processing)
    check_apart(loaded, unloaded)
    settings.progress("looking for rests")
    every = [rests_of(recording, processing) for recording in recordings]
    rows, one_sided = _poses(every)
    poses = len({pose for pose, _ in rows})
    if poses < FEWEST:
        raise InputError(
            f"{poses} poses are held in all recordings ({', '.join(str(len(one.t)) for one in every)} rests): give "
            f"recordings of the same motion, with {FEWEST} poses or more, better 8"
        )
    order = _order(loaded, unloaded)
    # Positions, torques, and approaches: recordings x rows x joints.
    q, torque, side = (
        np.array([[getattr(one, kind)[at[r]].mean(axis=0) for _, at in rows] for r, one in enumerate(every)])
        for kind in ("q", "torque", "side")
    )
    bare = len(unloaded)
    apart = np.abs(q[bare:].mean(axis=0) - q[:bare].mean(axis=0))
    if apart.max() > processing.max_mismatch:
        k, j = np.unravel_index(int(np.argmax(apart)), apart.shape)
        raise InputError(
            f"pose {rows[k][0] + 1}: joint {j + 1} stands {1e3 * apart[k, j]:.1f} mrad or mm apart with and "
            f"without payload, more than {1e3 * processing.max_mismatch:g}: the arm sags, or the poses are others"
        )
    keep = (side == side[0]).all(axis=0) & (side[0] != 0.0)
    W = regressor_at(robot, payload_columns(robot), q[-1], 0.0 * q[-1], 0.0 * q[-1])
    keep &= np.abs(W).max(axis=(1, 2)) > _ROUNDING * np.abs(W).max()  # a joint that no weight acts on says nothing
    moving = tuple(int(j) + 1 for j in np.flatnonzero(keep.any(axis=0)))
    if settings.joints is not None:
        moving = tuple(sorted(settings.joints))
    keep[:, [j for j in range(robot.n) if j + 1 not in moving]] = False
    difference = order.difference[:, None, None]

    def joined(part: slice, sign: float) -> Measurement:
        motion = Motion(
            np.arange(len(rows), dtype=float),
            np.sum(sign * difference[part] * q[part], axis=0),
            _SPEED * side[0],
            np.zeros(side[0].shape),
        )
        return Measurement(motion, np.sum(sign * difference[part] * torque[part], axis=0))

    without, under_load = joined(slice(bare), -1.0), joined(slice(bare, None), 1.0)
    free = robot.with_offsets(True)
    own = tuple(name for name in base_parameters(free).columns if parameter_kind(name) not in ("FV", "FVM"))
    whole, friction = Observer(free, own), friction_columns(robot)
    observer = Observer(
        free, (*friction, *payload_columns(free), PATH), (*(f"{FREE}{name}" for name in friction), *PAYLOAD, PATH)
    )
    without_payload = reduced(whole.observe_rows(without, keep, 1))
    chi = robot_of(without_payload)
    path = whole.torques(under_load.motion, chi) - whole.torques(without.motion, chi)
    change = observer.observe_rows(torque_change(robot, without, under_load, path), keep, 1)
    ends = np.array([-np.inf, *(k - 0.5 for k in range(1, len(rows)) if rows[k][0] != rows[k - 1][0]), np.inf])
    seconds = float(np.median([own[-1] - own[0] for one in every for own, _ in one.held]))
    problem = StaticMotion(
        robot,
        base_parameters(robot),
        Source(tuple(loaded), tuple(unloaded), processing, rate=loaded[0].rate),
        moving,
        (Run(loaded[0].source, in_blocks(reduced(change), [change], [ends], seconds)),),
        offset_prior([change], coulomb_friction(without_payload)),
        np.sqrt(np.mean(under_load.torque**2, axis=0)),
        settings=settings,
    )
    weights = problem.posed().weights()
    standing = Standing(
        poses=poses,
        order=order.text,
        scatter=keep.any(axis=0) / weights / np.linalg.norm(order.difference),
        drift=None,
    )
    if order.drift.any():
        slope = np.einsum("r,rkj->kj", order.drift, torque)
        Y = tuple(slope[keep[:, j], j] for j in range(robot.n))
        drifting = replace(change, Y=tuple(order.step * y for y in Y), shared=())
        looks = replace(problem, runs=(replace(problem.runs[0], equations=reduced(drifting)),))
        mass = looks.resolved(looks.posed().solved(weights))["M_L"]
        standing = structs.replace(standing, drift=_drift(order, slope, side[0] * keep, mass))
    return replace(problem, rests=tuple(every), one_sided=one_sided, standing=standing)


def _poses(every: Sequence[Rests]) -> tuple[list[tuple[int, list[Array]]], tuple[int, ...]]:
    """Find poses and sides that all recordings hold, and the numbers of poses reached from one side only.

    Returns:
        Pose and, for each recording, the indices of its rests there from one side; row by row, pose after pose.
    """
    centres, last = list[Array](), len(every[0].t) - 1
    for q in every[0].q:
        if not any(np.abs(q - centre).max() < _SAME for centre in centres):
            centres.append(q)
    rows, one_sided = list[tuple[int, list[Array]]](), list[int]()
    for pose, centre in enumerate(centres):
        here = [np.flatnonzero(np.abs(one.q - centre).max(axis=1) < _SAME) for one in every]
        first = every[0].side[here[0][0]]
        ways = [
            [own[way * (one.side[own] @ first) > 0.0] for one, own in zip(every, here, strict=True)]
            for way in (1.0, -1.0)
        ]
        both = [way for way in ways if all(len(own) for own in way)]
        sides = [every[0].side[way[0][0]] for way in both]
        if len(both) == 1 and here[0].tolist() == [last]:  # on its way home
            continue
        if both and (len(both) == 1 or (sides[0] * sides[1] > 0.0).any()):
            one_sided.append(pose + 1)
        rows += [(pose, way) for way in both]
    return rows, tuple(one_sided)


def _order(loaded: Sequence[Recording], unloaded: Sequence[Recording]) -> _Order:
    """Order recordings by their clock, if they share one, else as they are given, and weigh them by it."""
    recordings, bare = [*unloaded, *loaded], len(unloaded)
    ends = np.array([one.origin + one.t[[0, -1]] for one in recordings])
    by_time = np.argsort(ends[:, 0], kind="stable")
    clocked = len(ends) > 1 and bool((ends[by_time[1:], 0] >= ends[by_time[:-1], 1]).all())
    half = (bare + 1) // 2
    given = [*range(half), *range(bare, len(recordings)), *range(half, bare)]
    places = by_time if clocked else np.array(given)
    t = ends.mean(axis=1) / 3600.0 if clocked else np.argsort(places).astype(float)
    under_load = (np.arange(len(recordings)) >= bare).astype(float)
    A = np.column_stack([np.ones(len(t)), under_load, t - t.mean()])
    plain, parts = decomposed(A[:, :2]).inverse[1], decomposed(A)
    text = " ".join("loaded" if k >= bare else "unloaded" for k in places)
    text += ", by their clock" if clocked else ", as given" if len(places) > 2 else ""
    step = float(np.ptp(t)) / (len(t) - 1)
    ratio = 1.0 - float(plain @ plain) / float(parts.inverse[1] @ parts.inverse[1])
    if len(t) < 3 or parts.rank < 3 or ratio > 1.0 - 1.0 / _COSTS:
        return _Order(text, "", step, plain, np.zeros(len(t)), 0.0)
    return _Order(text, "hour" if clocked else "recording", step, parts.inverse[1], parts.inverse[2], ratio)


def _drift(order: _Order, slope: Array, side: Array, mass: float) -> Drift:
    """Collect a drift of the torques, K x n, by offset and friction of each joint; ``side`` 0 leaves a row out."""
    found = np.zeros((4, side.shape[1]))
    for j, own in enumerate(side.T):
        used = own != 0.0
        if used.sum() > 2 and abs(own[used].sum()) < used.sum():
            parts = decomposed(np.column_stack([used, own])[used])
            values = parts.solution(slope[used, j])
            left = slope[used, j] - np.column_stack([used, own])[used] @ values
            sigmas = np.sqrt(np.diag(parts.covariance) * float(left @ left) / (used.sum() - 2))
            found[:, j] = values[0], sigmas[0], values[1], sigmas[1]
    offset, offset_sigma, friction, friction_sigma = found
    return Drift(order.per, offset, offset_sigma, friction, friction_sigma, mass, order.ratio)
