"""The memory of a merged passport's errors weighs its parts by their rows."""

import numpy as np
import pytest
from dynident.apps.fleet.merging import _memory
from dynident.estimation import PayloadProblem
from dynident.estimation.equations import Equations
from dynident.model import base_parameters, load_robot


def part(rows: int, inflation: float) -> PayloadProblem:
    """A problem of which only the number of rows and their memory count."""
    robot = load_robot("rx90")
    equations = Equations(("M_L",), (np.eye(2),) * robot.n, (rows,) * robot.n, (float(rows),) * robot.n)
    return PayloadProblem(robot, base_parameters(robot), equations, inflation=(inflation,) * robot.n)


def test_a_short_recording_hardly_counts() -> None:
    assert _memory([part(100, 2.0), part(300, 4.0)]) == pytest.approx((3.5,) * 6)
    assert _memory([part(0, 9.0), part(50, 4.0)]) == pytest.approx((4.0,) * 6)
