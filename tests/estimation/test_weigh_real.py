"""Windows of the real UR10e pair: how far the mass is off, and whether intervals hold it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs.read import read_recording
from dynident.estimation import Gains, PayloadAnswer, answer_payload
from dynident.estimation.payload.weighing import difference_weighing
from dynident.estimation.signals.alignment import aligned
from dynident.model import Recording, load_robot

MASS = 2.805  # kg, weighed
GAINS = (11.976, 11.976, 9.839, 10.763, 10.757, 10.680)


def part(recording: Recording, start: float, length: float) -> Recording:
    t = recording.t - recording.t[0]
    keep = (t >= start) & (t < start + length)
    assert recording.qd is not None
    return replace(
        recording,
        t=recording.t[keep],
        q=recording.q[keep],
        torque=recording.torque[keep],
        qd=recording.qd[keep],
    )


@pytest.fixture(scope="module")
def pair(recordings: Path) -> tuple[Recording, Recording, float]:
    """Without, with payload, and what the second's own time runs late [s]."""
    robot = load_robot("ur10e")
    names = ("unloaded", "loaded_2.805kg")
    bare, loaded = (read_recording(recordings / "ur10e" / f"{name}.csv.gz", robot, GAINS) for name in names)
    lag = aligned(bare, loaded, 100.0, 0.02).lag - (loaded.t[0] - bare.t[0])
    return bare, loaded, lag


def windows(pair: tuple[Recording, Recording, float], length: float, starts: list[float]) -> list[PayloadAnswer]:
    bare, loaded, lag = pair
    robot, gains = load_robot("ur10e"), Gains((0.02,))
    return [
        answer_payload(
            difference_weighing(robot, [part(loaded, start + lag, length)], [part(bare, start, length)]),
            gains=gains,
        )
        for start in starts
    ]


@pytest.mark.long
@pytest.mark.parametrize(
    ("length", "within", "starts"),
    [(10.0, 0.06, [3.0, 9.0, 15.0, 21.0, 27.0, 33.0, 37.0, 41.0]), (20.0, 0.03, [4.0, 14.0, 24.0, 31.0])],
)
def test_windows(
    pair: tuple[Recording, Recording, float], length: float, within: float, starts: list[float]
) -> None:
    answers = windows(pair, length, starts)
    off = np.array([answer.mass / MASS - 1.0 for answer in answers])
    assert np.abs(off).max() <= within
    hits = [answer.mass_interval[0] <= MASS <= answer.mass_interval[1] for answer in answers]
    assert sum(hits) >= len(hits) - 1


def test_joints_do_not_weigh_the_same(pair: tuple[Recording, Recording, float]) -> None:
    """The wrist shows several percent more than the arm: gains and friction."""
    (answer,) = windows(pair, 45.0, [4.0])
    masses = {group.name: group.mass for group in answer.by_joints.masses}
    arm, wrist = masses["joints 1-3"], masses["joints 4-6"]
    assert arm is not None
    assert wrist is not None
    assert 0.02 < wrist / arm - 1.0 < 0.08
