"""Looks for mistakes of unit in a recording before any number is computed from it."""

from collections.abc import Sequence

import numpy as np

from ..model import InputError, Recording, Robot

_MOST_TURNS = 4 * np.pi  # rad: no arm's joint goes further from zero
_BEYOND_LIMITS = 0.1  # of the range
_MOVES = 1e-3  # rad or m: a joint that covers less does not move


def check_units(robot: Robot, recording: Recording) -> None:
    """Refuse positions in degrees and speeds in another unit than positions.

    Raises:
        InputError: names the joint and the unit it looks like.
    """
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
    if recording.qd is not None:
        _check_speeds(recording)


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
