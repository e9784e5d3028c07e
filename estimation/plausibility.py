"""Looks for mistakes of unit and dead channels in recordings before any number is computed from them."""

from collections.abc import Sequence

import numpy as np

from ..model import InputError, Recording, Robot

_MOST_TURNS = 4 * np.pi  # rad: no arm's joint goes further from zero
_BEYOND_LIMITS = 0.1  # of the range
_MOST_TORQUE = 1e5  # N·m or N: no arm's joint has more
_OVER_LIMIT = 3.0  # times the torque limit: sensors and currents overshoot, units are off by more
_MOVES = 1e-3  # rad or m: a joint that covers less does not move


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
        _check_torques(robot, recording)
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


def still_joints(recordings: Sequence[Recording]) -> tuple[int, ...]:
    """Numbers of the joints that move in none of the recordings."""
    spans = np.max([np.ptp(recording.q, axis=0) for recording in recordings], axis=0)
    return tuple(int(j) + 1 for j in np.flatnonzero(spans < _MOVES))
