"""Torques against the weight of the links as described: unit, sign, gains and mounting, of every shipped arm."""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs.read import read_recording
from dynident.estimation.diagnosis.engine import BLOCKS, states_of
from dynident.estimation.diagnosis.evidence import Evidence
from dynident.estimation.diagnosis.scales import nominal_gravity, weight
from dynident.estimation.payload.long_motion import Source
from dynident.model import Recording, Robot, load_robot, robot_names
from dynident.model.stand_in import rehearsed
from dynident.tests.estimation.conftest import LIFT, Change
from dynident.tests.selection import every
from dynident.trajectories import Simulator, ViaPoints

ARMS = {name: robot for name in robot_names() if (robot := load_robot(name)).spring is None} | {"lift": LIFT}


@cache
def recorded(name: str) -> tuple[Robot, Recording]:
    """An arm, and a recording of one whose links are 10 to 40 % heavier than described, at places of their own."""
    robot, draw = rehearsed(ARMS[name]), np.random.default_rng(1)
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
    nominal = nominal_gravity(robot, states_of(source, BLOCKS))
    return " ".join(finding.text for finding in weight(Evidence(robot, source, nominal=nominal)))


def scaled(*factors: float) -> Change:
    """Torques times factors, one for all or one for each of the first joints."""

    def change(recording: Recording) -> Recording:
        every_joint = np.ones(recording.q.shape[1])
        every_joint[: len(factors) if factors[1:] else None] = factors
        return replace(recording, torque=recording.torque * every_joint)

    return change


@pytest.mark.parametrize("name", ARMS)
def test_a_good_recording_goes_with_the_weight_of_the_links(name: str) -> None:
    assert told(*recorded(name)) == ""


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (scaled(0.09), "look like motor-side torques, currents"),
        (scaled(1000.0), "look like mN·m"),
        (scaled(-1.0), "torques have the wrong sign for gravity|torque of joint . has the wrong sign for"),
        (scaled(1.0, -1.0), "torque of joint 2 has the wrong sign for gravity"),
    ],
    ids=["currents", "mN·m", "all turned", "joint 2 turned"],
)
@pytest.mark.parametrize("name", every(3, ARMS))
def test_units_and_signs_are_named(name: str, change: Change, words: str) -> None:
    robot, recording = recorded(name)
    assert re.search(words, told(robot, change(recording)))


@pytest.mark.parametrize("name", every(4, ARMS))
def test_another_mounting_is_named_with_the_gravity_that_it_has(name: str) -> None:
    """Of an arm described as on a wall; a slide's own weight is constant, and so is not told from an offset."""
    robot, recording = recorded(name)
    described = replace(robot, gravity=(9.81, 0.0, 0.0))
    if name == "lift":
        assert told(described, recording) == ""
        return
    found = re.search(r"acts [89]. degrees away .* --mount gravity=(\S+?),(\S+?),(\S+)", told(described, recording))
    assert found is not None
    np.testing.assert_allclose(list(map(float, found.groups())), [0.0, 0.0, -9.81], atol=1.0)


def test_real_arms_with_bodies_of_their_urdf(recordings: Path) -> None:
    """A Gen3 goes with them, by a factor; a Med7 has all torques against gravity, as what acts on the arm."""
    gen3 = load_robot(recordings / "gen3/gen3.urdf")
    assert told(gen3, read_recording(recordings / "gen3/gen3_opti1.csv.gz", gen3)) == ""
    med7 = load_robot(recordings / "med7/med7dock.urdf")
    log = read_recording(recordings / "med7/med7_line.csv.gz", med7)
    assert "all torques have the wrong sign for gravity" in told(med7, log)
    assert told(med7, scaled(-1.0)(log)) == ""
