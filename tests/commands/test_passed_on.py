"""Numbers of options arrive where they decide: in goals and loads of motions."""

from pathlib import Path

import numpy as np
import pytest
from dynident import model
from dynident.apps.commands import near
from dynident.apps.commands.options import Setup
from dynident.apps.logs.map import LogMap
from dynident.apps.report.sections.motion import ladder_tables
from dynident.cli import main
from dynident.common.errors import InputError
from dynident.tests.commands.declared import parsed
from dynident.trajectories import NearMotion, PayloadSet
from dynident.trajectories.design.full_trajectory import Rung

ROBOT = model.load_robot("rx90")
SETUP = Setup(ROBOT, ROBOT.processing, (2.0,) * 6, None, LogMap())
PAYLOAD = "payload --robot rx90 --unloaded u.csv --loaded l.csv"
NEAR = "near --robot rx90 --pose 0,-90,90,0,0,0 --joints 2,3,5,6 --torque-limits 300"


@pytest.mark.parametrize(("option", "rate"), [("", 100.0), ("@40", 40.0)])
def test_samples_a_second_of_a_goal(option: str, rate: float) -> None:
    parts, _ = parsed(f"design --robot rx90 --torque-noise 1,2,3,4,5,6{option}".split())
    goal = parts["goal"].goal(ROBOT, parts["limits"].bounds(ROBOT), {}, None)
    assert goal.rate == rate
    assert goal.noise == pytest.approx([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])


def test_full_speed_of_a_ladder_bears_a_quarter_more_than_expected() -> None:
    parts, _ = parsed(f"{NEAR} --ladder --mass 4 --heaviest-payload 9@0,0,0.1 --within 0.1".split())
    limits = parts["limits"]
    known = limits.known(ROBOT)
    bounds = limits.bounds(known.robot)
    payloads = limits.payload(known.robot, bounds)
    _, loads = near._torques(known, bounds, limits, parts["options"], payloads)
    assert loads is not None
    assert isinstance(loads.heaviest, PayloadSet)
    assert loads.heaviest.mass == pytest.approx(1.25 * 4.0)


def test_a_ladder_shows_what_each_run_leaves_possible() -> None:
    still = np.zeros((1, 6, 2))
    motion = NearMotion(np.zeros((1, 6)), still, still, 5.0, 1, 0.0)
    (table,) = ladder_tables([Rung(0.25, 6.5, 4.5, motion)])
    assert [tuple(row) for row in table.rows] == [("run 1", "25", "6.50", "4.50")]


def test_a_sag_is_told_in_mrad(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    sags = []

    def sagging(*arguments: object) -> None:
        sags.append(arguments[-1])
        raise InputError("that is enough")

    monkeypatch.setattr("dynident.trajectories.simulation.closed_loop.Controller.sagging", sagging)
    body = tmp_path / "body.toml"
    body.write_text("mass = 3.0\ncom = [0.0, 0.0, 0.1]\ninertia_com = [0.01, 0.0, 0.0, 0.01, 0.0, 0.01]\n")
    words = f"simulate --robot rx90 --payload {body} --controller proportional --sag 4 --out {tmp_path / 'out'}"
    assert main(words.split()) == 2
    assert sags == [pytest.approx(4e-3)]
