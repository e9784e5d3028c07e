"""Torques against the weight of the links as described: unit, sign, gains and mounting, of every shipped arm."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from dynident.estimation.diagnosis.evidence import Diagnosis, Evidence
from dynident.estimation.diagnosis.nominal import nominal_gravity, weight
from dynident.estimation.diagnosis.states import BLOCKS, states_of
from dynident.estimation.payload.long_motion import Source
from dynident.model import Recording, Robot, load_robot, robot_names
from dynident.model.stand_in import rehearsed
from dynident.tests.selection import every
from dynident.trajectories import Simulator, ViaPoints

WEIGHED = [name for name in robot_names() if load_robot(name).spring is None and any(load_robot(name).gravity)]
Change = Callable[[Recording], Recording]


@cache
def recorded(name: str) -> tuple[Robot, Recording]:
    """An arm, and a recording of one whose links are 10 to 40 % heavier than described, at places of their own."""
    robot, draw = rehearsed(load_robot(name)), np.random.default_rng(1)
    values = dict(robot.parameters)
    for link in range(1, robot.n + 1):
        heavier = draw.uniform(1.1, 1.4)
        for kind in ("M", "MX", "MY", "MZ", "XX", "XY", "XZ", "YY", "YZ", "ZZ"):
            values[f"{kind}{link}"] *= heavier
        values[f"MX{link}"] += 0.01 * values[f"M{link}"]
    ranges = np.clip([joint.limits.position for joint in robot.joints], -1.2, 1.2)
    path = draw.uniform(ranges[:, 0], ranges[:, 1], (14, robot.n))
    motion = ViaPoints(path, draw.uniform(0.6, 1.2, 13)).motion(100.0)
    noise = 0.002 * np.array([joint.limits.torque for joint in robot.joints])
    return robot, Simulator(replace(robot, parameters=values)).record(motion, None, noise.tolist(), 2)


def told(robot: Robot, recording: Recording) -> str:
    source = Source((), (recording,), robot.processing)
    found = Diagnosis(nominal=nominal_gravity(robot, states_of(source, BLOCKS)))
    return " ".join(finding.text for finding in weight(Evidence(robot, source, found)))


def scaled(*factors: float) -> Change:
    """Torques times factors, one for all or one for each of the first joints."""

    def change(recording: Recording) -> Recording:
        every_joint = np.ones(recording.q.shape[1])
        every_joint[: len(factors) if factors[1:] else None] = factors
        return replace(recording, torque=recording.torque * every_joint)

    return change


@pytest.mark.parametrize("name", WEIGHED)
def test_a_good_recording_goes_with_the_weight_of_the_links(name: str) -> None:
    assert told(*recorded(name)) == ""


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (scaled(0.09), "look like motor-side torques, currents"),
        (scaled(1000.0), "look like mN·m"),
        (scaled(-1.0), "torques have the sign against gravity|torque of joint . has the sign against"),
        (scaled(1.0, -1.0), "torque of joint 2 has the sign against gravity"),
    ],
    ids=["currents", "mN·m", "all turned", "joint 2 turned"],
)
@pytest.mark.parametrize("name", every(3, WEIGHED))
def test_units_and_signs_are_named(name: str, change: Change, words: str) -> None:
    robot, recording = recorded(name)
    assert re.search(words, told(robot, change(recording)))
