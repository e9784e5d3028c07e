"""A short motion of an RX90 and its recordings without and with a payload."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from dynident.estimation import LongMotion, PayloadAnswer, ShortMotion, StandIn, answer_payload
from dynident.estimation.payload.weighing import difference_weighing
from dynident.model import InertialParameters, Recording, Robot
from dynident.trajectories import RX90_NOISE, NearMotion

LOAD = InertialParameters.from_com(7.02, [0.01, -0.02, 0.15], np.diag([0.05, 0.05, 0.03]))
NOISE = 0.3 * np.array(RX90_NOISE)
POSE = np.radians([0.0, -45.0, 90.0, 0.0, 45.0, 0.0])


def near(joints: Sequence[int], duration: float = 20.0, seed: int = 0) -> NearMotion:
    """Periods of 5 s of random harmonics, within 30 degrees."""
    draw, n, harmonics = np.random.default_rng(seed), 6, 4
    a, b = np.zeros((2, 1, n, harmonics))
    for joint in joints:
        own = 0.6 * draw.standard_normal(harmonics)
        a[0, joint - 1] = own - own.mean()  # at rest where it begins
    return NearMotion(POSE[None], a, b, 5.0, int(duration / 5.0), 0.0)


class Pair(NamedTuple):
    """One motion without and with the payload."""

    bare: Recording
    loaded: Recording


Record = Callable[..., Pair]


def weighed(robot: Robot, pair: Pair, stand_in: StandIn | None = None, **options: Any) -> PayloadAnswer:
    answer = answer_payload(difference_weighing(robot, [pair.loaded], [pair.bare]), **options)
    return answer if stand_in is None else answer.assuming(stand_in)


def short(problem: LongMotion | ShortMotion) -> ShortMotion:
    """What a weighing's problem holds beside its equations."""
    assert isinstance(problem, ShortMotion)
    return problem


def cut(recording: Recording, begin: float, end: float) -> Recording:
    """From a time to a time [s]."""
    inside = (recording.t >= begin) & (recording.t <= end)
    return replace(recording, t=recording.t[inside], q=recording.q[inside], torque=recording.torque[inside])
