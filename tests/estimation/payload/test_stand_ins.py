"""An assumed inertia where none was measured."""

import numpy as np
import pytest
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation import StandIn
from dynident.model import InertialParameters
from dynident.tests.estimation.payload.recordings import Record, weighed
from dynident.trajectories import Simulator


def test_stand_ins_are_the_bodies_they_say() -> None:
    """A box and a cylinder of many points."""
    draw = np.random.default_rng(0)
    points = draw.uniform(-0.5, 0.5, (200_000, 3)) * [0.06, 0.08, 0.35]
    box = StandIn.parse("box:60x80x350")
    assert box.inertia(2.0) == pytest.approx(inertia(points, 2.0), abs=2e-4)
    inside = draw.uniform(-0.5, 0.5, (300_000, 3)) * [0.1, 0.1, 0.3]
    inside = inside[np.hypot(inside[:, 0], inside[:, 1]) <= 0.05]
    cylinder = StandIn.parse("Cylinder:100x300")
    assert cylinder.inertia(3.0) == pytest.approx(inertia(inside, 3.0), abs=2e-4)
    assert cylinder.body(3.0, np.array([0.0, 0.1, 0.2])).physically_consistent


def inertia(points: Array, mass: float) -> Array:
    centred = points - points.mean(axis=0)
    squares = centred.T @ centred / len(points)
    return np.asarray(mass * (np.trace(squares) * np.eye(3) - squares))


@pytest.mark.parametrize("text", ["", "box", "box:60x60", "box:0x1x1", "ball:60", "cylinder:1x2x3", "box:1x..x3"])
def test_stand_ins_that_are_none(text: str) -> None:
    with pytest.raises(InputError, match="cylinder"):
        StandIn.parse(text)


def test_a_stand_in_fills_what_is_missing_only(record: Record, simulator: Simulator) -> None:
    light = InertialParameters.from_com(1.0, [0.0, 0.0, 0.05], 1e-3 * np.eye(3))
    body = StandIn.parse("box:60x60x350")
    answer = weighed(simulator.robot, record((2, 3, 5, 6), load=light), stand_in=body)
    assert answer.judged["inertia"].use == "assumed"
    assert answer.assumed is not None
    assert answer.assumed.inertia_com == pytest.approx(body.inertia(answer.mass), abs=1e-12)
    assert answer.assumed.com == pytest.approx(answer.com)
    heavy = InertialParameters.from_com(20.0, [0.0, 0.0, 0.1], np.eye(3))
    measured = weighed(simulator.robot, record((2, 3, 5, 6), load=heavy), stand_in=body)
    assert measured.stand_in is None
    assert measured.judged["inertia"].use == "use"
