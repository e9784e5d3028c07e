"""What a log holds in numbers: its times, and each joint's signals."""

from dataclasses import dataclass

import numpy as np

from ...common.arrays import Array
from ...estimation.signals.plausibility import still_joints
from ...estimation.signals.rows import moving_parts
from ...model import Motion, Processing, Recording

_UNEVEN = 0.05  # of the mean step: larger deviations are jitter
_WHOLE = 0.05  # of a step: closer differences are whole multiples of it
_MOST_LEVELS = 200_000  # distinct values that are sorted to find a step


@dataclass(frozen=True)
class TimeFacts:
    """Time of a recording.

    Attributes:
        duration: from the first to the last [s].
        rate: mean [Hz].
        steps: shortest and longest [s].
        jitter: standard deviation of the steps over their mean.
        moving: first and last moment of the motion that is used [s]; None where nothing moves.
    """

    samples: int
    duration: float
    rate: float
    steps: tuple[float, float]
    jitter: float
    moving: tuple[float, float] | None

    @property
    def even(self) -> bool:
        """Whether the time steps are all alike."""
        mean = 1.0 / self.rate
        return max(self.steps[1] - mean, mean - self.steps[0]) < _UNEVEN * mean


@dataclass(frozen=True)
class JointFacts:
    """One joint's signals.

    Attributes:
        position: smallest and largest [rad or m].
        speed: largest [.../s], from filtered positions or speeds.
        torque: smallest and largest [N·m, N, or A].
        position_step, torque_step: smallest difference of two values; 0 where none shows.
        saturated: share of the samples at the torque's own extreme.
    """

    moves: bool
    position: tuple[float, float]
    speed: float
    torque: tuple[float, float]
    position_step: float
    torque_step: float
    saturated: float


def time_facts(recording: Recording, motion: Motion, processing: Processing) -> TimeFacts:
    """Facts about time; ``motion`` is the recording's, filtered."""
    steps = np.diff(recording.t)
    moving = motion.t[moving_parts(motion, processing.still_speed)]
    return TimeFacts(
        samples=len(recording.t),
        duration=float(recording.t[-1] - recording.t[0]),
        rate=float(1.0 / steps.mean()),
        steps=(float(steps.min()), float(steps.max())),
        jitter=float(steps.std() / steps.mean()),
        moving=(float(moving[0]), float(moving[-1])) if moving.size else None,
    )


def joint_facts(recording: Recording, motion: Motion) -> tuple[JointFacts, ...]:
    """Facts about each joint's signals; ``motion`` is the recording's, filtered."""
    still = still_joints([recording])
    speeds = np.abs(motion.qd).max(axis=0)
    return tuple(
        JointFacts(
            moves=j not in still,
            position=_range(q),
            speed=float(speed),
            torque=_range(torque),
            position_step=smallest_step(q),
            torque_step=smallest_step(torque),
            saturated=share_at_extreme(torque),
        )
        for j, (q, torque, speed) in enumerate(zip(recording.q.T, recording.torque.T, speeds, strict=True), 1)
    )


def smallest_step(values: Array) -> float:
    """Smallest difference of two different values: the quantum of coarse numbers; 0 for numbers without one.

    Numbers count as quantised if all their differences are whole multiples of the smallest one.
    """
    levels = np.unique(values[:_MOST_LEVELS])
    gaps = np.diff(levels)
    gaps = gaps[gaps > 1e-9 * max(float(np.abs(levels).max()), 1e-300)]
    if gaps.size < 2:
        return 0.0
    step = float(gaps.min())
    multiples = (levels - levels[0]) / step
    return step if np.abs(multiples - np.rint(multiples)).max() < _WHOLE else 0.0


def share_at_extreme(values: Array) -> float:
    """Share of the samples that stand at the largest or at the smallest value, whichever are more."""
    return float(max((values == values.max()).mean(), (values == values.min()).mean()))


def _range(values: Array) -> tuple[float, float]:
    return float(values.min()), float(values.max())
