"""Looks for mistakes of unit and dead channels in recordings before any number is computed from them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..model import InputError, Recording, Robot

_MOST_TURNS = 4 * np.pi  # rad: no arm's joint goes further from zero
_BEYOND_LIMITS = 0.1  # of the range
_MOST_TORQUE = 1e5  # N·m or N: no arm's joint has more
_OVER_LIMIT = 3.0  # times the torque limit: sensors and currents overshoot, units are off by more
_MOVES = 1e-3  # rad or m: a joint that covers less does not move
_WEAKEST = 1.0  # N·m per cubic metre of reach: the lightest arms carry themselves with a hundred times this
_STRONGEST = 2e4  # N·m per cubic metre of reach: the strongest arms have a tenth of this
_OVER_SPEED = 3.0  # times the speed limit: noise and overshoot reach less
_MOST_SPEED = 50.0  # rad/s or m/s, for a joint without a limit
_WINDOW = 0.01  # s: over which a speed is taken, to see past quantisation
_PLATEAU = 5  # samples in a row at the very extreme
_PLATEAU_SHARE = 0.01  # of the recording at the extreme
_PLATEAU_EXCESS = 20.0  # times as many samples as another level has: coarse numbers repeat everywhere


def check_recordings(robot: Robot, recordings: Sequence[Recording]) -> None:
    """Refuse recordings whose units or channels cannot be right, and one that is given twice.

    Raises:
        InputError: names the recording, the joint and what it looks like.
    """
    if not recordings:
        raise InputError("no recordings: give at least one")
    for k, recording in enumerate(recordings):
        for other in recordings[:k]:
            if np.array_equal(recording.torque, other.torque) and np.array_equal(recording.q, other.q):
                raise InputError(
                    f"{recording.source} holds the same numbers as {other.source}: given twice it would only seem "
                    "more certain; give it once"
                )
        _check_positions(robot, recording)
        _check_steps(robot, recording)
        _check_torques(robot, recording)
        _check_reach(robot, recording)
        _check_saturation(recording)
        if recording.qd is not None:
            _check_speeds(recording)


def _check_positions(robot: Robot, recording: Recording) -> None:
    for j, joint in enumerate(robot.joints):
        if not joint.revolute:
            continue
        low, high = joint.limits.position
        margin = _BEYOND_LIMITS * (high - low) if np.isfinite(high - low) else 0.0
        low, high = max(low - margin, -_MOST_TURNS), min(high + margin, _MOST_TURNS)
        q = recording.q[:, j]
        if q.min() < low or q.max() > high:
            worst = q[np.argmax(np.abs(q))]
            guess = "degrees" if abs(worst) > 2 * np.pi else "another zero or another joint"
            raise InputError(
                f"{recording.source}: q{j + 1} reaches {worst:.4g} rad, outside the range of joint {j + 1} of "
                f"{robot.name} ({low:.3g} to {high:.3g} rad with a margin): looks like {guess}; positions must "
                "be in rad, as the robot file counts them"
            )


def _check_torques(robot: Robot, recording: Recording) -> None:
    for j, joint in enumerate(robot.joints):
        torque = recording.torque[:, j]
        most = min(_OVER_LIMIT * joint.limits.torque, _MOST_TORQUE)
        worst = float(np.abs(torque).max())
        if worst > most:
            raise InputError(
                f"{recording.source}: the torque of joint {j + 1} reaches {worst:.4g}, more than a joint of "
                f"{robot.name} can give ({most:.4g}): torques must be in N·m, drive gains in N·m/A"
            )
        if np.ptp(torque) == 0.0:
            raise InputError(
                f"{recording.source}: the torque of joint {j + 1} is {torque[0]:g} throughout: the channel is dead"
            )


def _check_steps(robot: Robot, recording: Recording) -> None:
    """No joint jumps from one sample to the next."""
    window = max(1, int(_WINDOW * (len(recording.t) - 1) / (recording.t[-1] - recording.t[0])))
    if len(recording.t) <= window:
        return
    elapsed = recording.t[window:] - recording.t[:-window]
    speed = np.abs(recording.q[window:] - recording.q[:-window]) / elapsed[:, None]
    for j, joint in enumerate(robot.joints):
        most = _OVER_SPEED * joint.limits.speed if np.isfinite(joint.limits.speed) else _MOST_SPEED
        k = int(np.argmax(speed[:, j]))
        if speed[k, j] > most:
            step = recording.q[k + window, j] - recording.q[k, j]
            raise InputError(
                f"{recording.source}: q{j + 1} jumps by {step:.3g} (rad or m) within {elapsed[k]:.3g} s at "
                f"{recording.t[k]:.4g} s, which joint {j + 1} of {robot.name} cannot: lost samples, a stuck "
                "encoder, poses without the motion between them, or another unit; record the motion itself"
            )


def _check_reach(robot: Robot, recording: Recording) -> None:
    """Torques of an arm lie between its own weight and what any arm of its size can give."""
    if robot.n < 5 or not all(joint.revolute for joint in robot.joints) or not any(robot.gravity):
        return
    reach = sum(abs(joint.d) + abs(joint.r) for joint in robot.joints[1:])
    worst = np.abs(recording.torque).max(axis=0)
    if 0.0 < worst.max() < _WEAKEST * reach**3:
        raise InputError(
            f"{recording.source}: no torque exceeds {worst.max():.3g}, too little for an arm of {reach:.2g} m "
            "reach to move its own weight: looks like kN·m or motor-side torque; torques must be in N·m at the "
            "joint"
        )
    if worst.max() > _STRONGEST * reach**3:
        joint = int(np.argmax(worst)) + 1
        raise InputError(
            f"{recording.source}: the torque of joint {joint} reaches {worst.max():.4g}, too much for an arm of "
            f"{reach:.2g} m reach: looks like mN·m or mA; torques must be in N·m, drive gains in N·m/A"
        )


def _check_saturation(recording: Recording) -> None:
    """A torque that stays at its very extreme was cut off."""
    for j, torque in enumerate(recording.torque.T):
        levels = len(np.unique(torque))
        for extreme in (torque.min(), torque.max()):
            there = torque == extreme
            share = float(there.mean())
            if share < max(_PLATEAU_SHARE, _PLATEAU_EXCESS / levels) or _longest_run(there) < _PLATEAU:
                continue
            raise InputError(
                f"{recording.source}: the torque of joint {j + 1} stays at its extreme {extreme:.4g} for "
                f"{100 * share:.0f} % of the recording: it is saturated; record a gentler motion"
            )


def _longest_run(mask: NDArray[np.bool_]) -> int:
    """Most true values in a row."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    return int(np.max(edges[1::2] - edges[::2], initial=0))


def _check_speeds(recording: Recording) -> None:
    assert recording.qd is not None
    span = recording.t[-1] - recording.t[0]
    window = max(1, int(0.05 / (span / (len(recording.t) - 1))))  # 50 ms, to see past quantisation
    if len(recording.t) <= 2 * window:
        return
    slope = (recording.q[window:] - recording.q[:-window]) / np.subtract(
        recording.t[window:], recording.t[:-window]
    )[:, None]
    speed = 0.5 * (recording.qd[window:] + recording.qd[:-window])
    for j in range(recording.q.shape[1]):
        moved = slope[:, j] @ slope[:, j]
        if np.ptp(recording.q[:, j]) < _MOVES or moved == 0.0:
            continue
        ratio = float(speed[:, j] @ slope[:, j] / moved)
        if not 0.8 < ratio < 1.25:
            unit = "; the speed looks like degrees per second" if 45 < ratio < 70 else ""
            raise InputError(
                f"{recording.source}: qd{j + 1} is {ratio:.3g} times the slope of q{j + 1}{unit}: both must be in "
                "the same unit (rad and rad/s) and on the same time"
            )


def check_apart(loaded: Sequence[Recording], unloaded: Sequence[Recording]) -> None:
    """Refuse one recording given both with and without payload.

    Raises:
        InputError: names both.
    """
    for a in loaded:
        for b in unloaded:
            if np.array_equal(a.torque, b.torque) and np.array_equal(a.q, b.q):
                raise InputError(
                    f"{a.source} with payload holds the same numbers as {b.source} without: give two recordings, "
                    "one with and one without the payload"
                )


def still_joints(recordings: Sequence[Recording]) -> tuple[int, ...]:
    """Numbers of the joints that move in none of the recordings."""
    spans = np.max([np.ptp(recording.q, axis=0) for recording in recordings], axis=0)
    return tuple(int(j) + 1 for j in np.flatnonzero(spans < _MOVES))
