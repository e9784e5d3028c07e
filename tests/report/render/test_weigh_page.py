"""The report of a weighing: the first screen, assumed inertia, repeats, a mass that only the scale knows."""

import re
from collections.abc import Sequence
from datetime import UTC, datetime

import numpy as np
import pytest
from dynident.apps.report import Provenance, payload_report
from dynident.apps.report.page import page_html
from dynident.estimation import KnownMass, PayloadAnswer, PossibleBody, StandIn, answer_payload
from dynident.estimation.payload.weighing import difference_weighing
from dynident.model import InertialParameters, Recording, Robot, load_robot
from dynident.trajectories import RX90_NOISE, NearMotion, Simulator

from .conftest import read

LOAD = InertialParameters.from_com(7.02, [0.01, -0.02, 0.15], np.diag([0.05, 0.05, 0.03]))
SCALE = (PossibleBody(), KnownMass(7.02, 0.02))
PROVENANCE = Provenance("dynident weigh", datetime(2001, 9, 9, tzinfo=UTC))


def recordings(robot: Robot, joints: Sequence[int], count: int = 1) -> list[Recording]:
    """One without payload, ``count`` with it."""
    draw, n = np.random.default_rng(0), robot.n
    a = np.zeros((1, n, 4))
    for joint in joints:
        own = 0.6 * draw.standard_normal(4)
        a[0, joint - 1] = own - own.mean()
    pose = np.radians([[0.0, -45.0, 90.0, 0.0, 45.0, 0.0]])
    motion, simulator = NearMotion(pose, a, 0.0 * a, 5.0, 3, 0.0).motion(250.0), Simulator(robot)
    noise = 0.3 * np.array(RX90_NOISE)
    loads = (None, *[LOAD] * count)
    return [simulator.record(motion, load, noise, [1, k], f"run {k}") for k, load in enumerate(loads)]


def answered(joints: Sequence[int], count: int = 1, stand_in: StandIn | None = None) -> PayloadAnswer:
    robot = load_robot("rx90")
    bare, *loaded = recordings(robot, joints, count)
    answer = answer_payload(difference_weighing(robot, loaded, [bare]), constraints=SCALE)
    return answer if stand_in is None else answer.assuming(stand_in)


def test_the_first_screen_leads_with_what_to_do() -> None:
    answer = answered((2, 3, 5, 6))
    page = payload_report(answer.result)
    text = page_html(page, PROVENANCE)
    first = text.split("<nav", 1)[0]
    assert [drawing.name for drawing in page.drawings()] == ["flange", "methods", "by_joints"]
    assert read(text).count["svg"] == 3
    order = ["Verdict", "type into the controller", "95 % interval", "Reasons", "agrees least", "Scale 7.02"]
    places = [first.index(words) for words in order]
    assert places == sorted(places)
    assert "condition number" not in first
    assert "condition number" in text
    uses = re.findall(r'<td class="words merged"[^>]*>([^<]+)</td>', first)
    assert uses == [answer.judged[name].use for name in ("mass", "centre of mass", "inertia")]
    low, high = answer.mass_interval
    cells = re.search(
        r"mass</th>\s*<td[^>]*>kg</td>\s*<td[^>]*>([\d.]+)</td>\s*<td[^>]*>([\d.]+) to ([\d.]+)<", first
    )
    assert cells is not None
    assert [float(x) for x in cells.groups()] == pytest.approx([answer.mass, low, high], abs=5e-3)


def test_a_mass_from_the_scale_alone() -> None:
    answer = answered((6,))
    page = payload_report(answer.result)
    text = page_html(page, PROVENANCE)
    read(text)
    assert answer.possible is None
    assert page.drawings() == []  # no joint sees the mass, no body is known
    assert "the torques of these joints do not contain it" in text
    assert "Verdict: do not use" in text
    assert "No controller takes this payload" in text
