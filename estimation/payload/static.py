"""A payload weighed standing still, in poses that are each reached from both sides.

A joint's torque at rest is that of gravity and of friction, whose sign is the approach's. In the difference (29) at
one pose and side the robot's gravity cancels: left are the payload's, a constant torque of each joint, and a
Coulomb level of each joint and side. A drift linear in time goes out pose by pose where the order allows.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...common import Array, InputError, decomposed, without
from ...model import Motion, Processing, Recording, Robot, base_parameters
from ...model.drives import parameter_kind
from ...model.motion import Measurement
from ...model.regressors import payload_columns, regressor_at
from ..equations.equations import PAYLOAD
from ..equations.observer import Observation, Observer, reduced
from ..fit.covariance import in_blocks
from ..fit.settings import DEFAULTS, Settings
from ..signals.filtering import measurement
from ..signals.recordings import check_recordings, without_dead
from .long_motion import Recordings, Source, robot_of, torque_change
from .short_motion import Drift, Rests, Standing, StaticMotion, observer_of, offset_prior

_FEWEST = 4  # poses: fewer leave nothing to judge mass and first moments by
_SAME = 0.02  # rad or m: rests that lie closer are of one pose; approaches begin twice as far away
_SPEED = 1e-9  # rad/s or m/s: of the approach, whose sign alone counts
_ROUNDING = 1e-9  # of the largest entry of the payload's regressor
_COSTS = 2.0  # variance with drift over that without, above which the order does not tell it
_AT_REST = ("MX", "MY", "MZ", "M", "FS", "FSM", "OFF")  # kinds of parameters that act at rest
_SHORTEST = 0.6  # s: where a motion only turns round, the arm rests for less
_SETTLED = 0.5, 0.8  # of a rest: before, its torque settles; after, the next motion begins
_TREND = 0.2  # s of a rest after which its torque oscillates only where something swings
_CAME = 2e-3  # rad or m: a joint that came from less far away did not move
_BIN, _FASTEST = 0.1, 10.0  # Hz


class Order(NamedTuple):
    """Order of R recordings, those without payload first, and their times."""

    text: str
    unit: str
    t: Array  # by a clock in hours, (R,)
    # By the clock, how much later each loaded one is than its partner, over the mean step; none if all are later.
    gaps: Array

    @staticmethod
    def of(loaded: Recordings, unloaded: Recordings) -> "Order":
        """Order recordings by their clock, if they share one, else half of those unloaded first and half last."""
        recordings, bare, half = [*unloaded, *loaded], len(unloaded), (len(unloaded) + 1) // 2
        ends = np.array([one.origin + one.t[[0, -1]] for one in recordings])
        places, t = np.argsort(ends[:, 0], kind="stable"), ends.mean(axis=1) / 3600.0
        clocked = bool((ends[places[1:], 0] >= ends[places[:-1], 1]).all())
        if not clocked:
            places = np.array([*range(half), *range(bare, len(recordings)), *range(half, bare)])
            t = np.argsort(places).astype(float)
        text = ", ".join("loaded" if k >= bare else "unloaded" for k in places)
        gaps = (t[bare:] - t[:bare]) * (len(t) - 1) / np.ptp(t) if clocked and 2 * bare == len(t) else t[:0]
        gaps = gaps if gaps.size and gaps.min() < 0.0 < gaps.max() else t[:0]
        how, unit = (" by their clock", "hour") if clocked else (" as given", "recording")
        return Order(text + how, unit, t, gaps)


def rests_of(recording: Recording, processing: Processing) -> Rests:
    """Find the rests of a recording: slower than ``still_speed`` for 0.6 s, and after a motion."""
    data = measurement(recording, processing)
    q, torque, rate = data.motion.q, data.torque, data.motion.rate
    still = (np.abs(data.motion.qd) < processing.still_speed).all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], still, [False]]))).reshape(-1, 2)
    earlier, found, held = 0, list[tuple[Array, ...]](), list[Array]()
    for start, stop in edges[np.diff(edges)[:, 0] >= _SHORTEST * rate].tolist():
        if start > 0:
            settled = slice(*(start + int(part * (stop - start)) for part in _SETTLED))
            pose = q[settled].mean(axis=0)
            away = (q[earlier:start] - pose)[::-1]
            far = np.abs(away) > _CAME
            side = -np.sign(np.take_along_axis(away * far, far.argmax(axis=0)[None], axis=0)[0])
            found.append((pose, torque[settled].mean(axis=0), side))
            held.append(torque[start + int(_TREND * rate) : stop])
        earlier = stop
    if not found:
        raise InputError(
            f"{recording.source}: no pose is held for {_SHORTEST:g} s after a motion, all joints slower than "
            f"{processing.still_speed:g} rad/s or m/s: let it rest, or weigh without --static"
        )
    pose, mean, side = map(np.array, zip(*found, strict=True))
    return Rests(pose, mean, side, torque[~still].std(axis=0), tuple(held), rate)


def oscillation(rests: Sequence[Rests]) -> tuple[Array, Array]:
    """Frequencies [Hz], (F,), and rms of the torques' oscillations at rest [N·m or N], F x n, trends taken off."""
    frequencies, squares = np.arange(_BIN, _FASTEST, _BIN), list[Array]()
    for one in rests:
        for held in one.held:
            line = np.column_stack([np.ones(len(held)), np.linspace(0.0, 1.0, len(held))])
            waves = np.fft.rfft(without(held, line), max(round(one.rate / _BIN), len(held)), axis=0)
            squares.append(2.0 * np.abs(waves[1 : len(frequencies) + 1]) ** 2 / len(held) ** 2)
    return frequencies, np.asarray(np.sqrt(np.mean(squares, axis=0)))


def static_weighing(
    robot: Robot, loaded: Sequence[Recording], unloaded: Sequence[Recording], settings: Settings = DEFAULTS
) -> StaticMotion:
    """Weigh by torque differences (29) at rest, in poses reached from both sides; else as ``weigh_at_rest``."""
    processing, recordings, bare = settings.processing_of(robot), [*unloaded, *loaded], len(unloaded)
    robot = without_dead(robot, recordings)
    check_recordings(robot, loaded, unloaded)
    every = [rests_of(recording, processing) for recording in recordings]
    # Number the poses of rests that all recordings hold, and find each one's rests there, those of a side alike.
    first, sides = every[0].q, every[0].side
    near = np.abs(first[:, None] - first).max(axis=2) < _SAME
    _, numbers = np.unique(near.argmax(axis=1), return_inverse=True)
    there = [(np.abs(first[:, None] - x.q).max(axis=2) < _SAME) & (sides @ x.side.T > 0.0) for x in every]
    held = np.all([own.any(axis=1) for own in there], axis=0) & (there[0].argmax(axis=1) == np.arange(len(first)))
    held[-1] &= near[-1].sum() > 1  # else that is where the arm goes in the end
    rows = sorted(np.flatnonzero(held).tolist(), key=lambda k: int(numbers[k]))
    poses, index = numbers[rows], [[np.flatnonzero(own[k]) for k in rows] for own in there]
    one_sided = {int(numbers[k]) + 1 for k in rows if not (near[k, rows] & (sides[rows] @ sides[k] < 0.0)).any()}
    if len(set(poses)) < _FEWEST:
        raise InputError(
            f"{len(set(poses))} poses are held in all recordings ({', '.join(str(len(one.q)) for one in every)} "
            f"rests): record one motion of {_FEWEST} poses or more, better 8, without and with payload"
        )
    # Positions, torques and approaches of recordings, rows and joints.
    means = [[np.array(one[:3])[:, at].mean(axis=1) for at in own] for one, own in zip(every, index, strict=True)]
    q, torque, side = np.array(means).transpose(2, 0, 1, 3)
    apart = np.abs(q[bare:].mean(axis=0) - q[:bare].mean(axis=0))
    if apart.max() > processing.max_mismatch:
        k, j = np.unravel_index(int(np.argmax(apart)), apart.shape)
        raise InputError(
            f"pose {poses[k] + 1}: joint {j + 1} stands {1e3 * apart[k, j]:.1f} mrad or mm apart with and without "
            f"payload, more than {1e3 * processing.max_mismatch:g}: the arm sags, or the poses are others"
        )
    W = regressor_at(robot, payload_columns(robot), q[-1], 0.0 * q[-1], 0.0 * q[-1])
    keep = (side == side[0]).all(axis=0) & (side[0] != 0.0)
    keep &= np.abs(W).max(axis=(1, 2)) > _ROUNDING * np.abs(W).max()  # a joint that no weight acts on says nothing
    keep &= np.isin(np.arange(1, robot.n + 1), settings.joints or range(1, robot.n + 1))
    order, of_loaded = Order.of(loaded, unloaded), np.arange(len(recordings)) >= bare
    # Weights of recordings for the difference less drift, and for the drift; without where that costs too much.
    A = np.column_stack([np.ones(len(recordings)), of_loaded, order.t - order.t.mean()])
    plain, parts = decomposed(A[:, :2]).inverse[1], decomposed(A)
    _, difference, drifting = parts.inverse
    if len(A) < 3 or len(parts.singular) < 3 or difference @ difference > _COSTS * plain @ plain:
        difference, drifting = plain, 0.0 * plain

    def joined(weights: Array) -> Measurement:
        motion = Motion(np.arange(float(len(poses))), np.tensordot(weights, q, 1), _SPEED * side[0], 0.0 * side[0])
        return Measurement(motion, np.tensordot(weights, torque, 1))

    without, under_load = joined(-difference * ~of_loaded), joined(difference * of_loaded)
    free, each = robot.with_offsets(True), keep / np.maximum(keep.sum(axis=0), 1)
    at_rest = [name for name in base_parameters(free).columns if parameter_kind(name) in _AT_REST]
    whole, observer = Observer(free, at_rest), observer_of(robot, None)
    own = robot_of(reduced(whole.observe(without, keep, 1)))
    path = whole.torques(under_load.motion, own) - whole.torques(without.motion, own)
    change = observer.observe(torque_change(robot, without, under_load, path), keep, 1)
    # What no joint shows at rest, such as inertia, leaves rounding, which rank would take for a column.
    size = dict(zip(PAYLOAD, np.abs(W).max(axis=(0, 2)).tolist(), strict=True))
    seen = np.array([size.get(name, np.inf) > _ROUNDING * max(size.values()) for name in change.columns])
    W_seen = [A * seen for A in change.W]
    change = Observation.of(change.columns, W_seen, change.torques, change.t, change.bandwidth, change.motors)
    ends = np.concatenate([[-np.inf], np.flatnonzero(np.diff(poses)) + 0.5, [np.inf]])
    coulomb = np.abs((each * side[0] * without.torque).sum(axis=0))
    source = Source(tuple(loaded), tuple(unloaded), processing, rate=every[-1].rate)
    joints, rms = np.flatnonzero(keep.any(axis=0)) + 1, np.sqrt(np.mean(under_load.torque**2, axis=0))
    runs, prior = in_blocks(reduced(change), [change], 0.0, [ends]), offset_prior([change], coulomb)
    posed = robot, base_parameters(robot), source, tuple(joints.tolist()), (runs,), prior, rms
    alone = tuple(sorted(one_sided))
    problem = StaticMotion(*posed, settings=settings, rests=tuple(every), one_sided=alone)
    weights = problem.posed().weights()
    scatter, drift = keep.any(axis=0) / weights / np.linalg.norm(difference), None
    if drifting.any():
        slope, step = np.tensordot(drifting, torque, 1), float(np.ptp(order.t)) / (len(order.t) - 1)
        as_torque = [step * slope[keep[:, j], j] for j in range(robot.n)]
        drifted = Observation.of(change.columns, change.W, as_torque, change.t, change.bandwidth)
        as_payload = replace(problem, runs=(reduced(drifted),))
        mass = as_payload.resolved(as_payload.posed().solved(weights))["M_L"]
        sigma = scatter * np.linalg.norm(drifting) / np.sqrt(np.maximum(keep.sum(axis=0), 1))
        ratio = max(0.0, 1.0 - (1.0 / bare + 1.0 / len(loaded)) / float(difference @ difference))
        offset, friction = (each * slope).sum(axis=0), (each * side[0] * slope).sum(axis=0)
        drift = Drift(order.unit, offset, friction, sigma, mass, ratio)
    return replace(problem, standing=Standing(len(set(poses)), order.text, scatter, drift))
