"""A value's ``repr`` is short whatever it holds."""

from typing import Any

import numpy as np
import pytest
from dynident.estimation import Estimate
from dynident.estimation.fit.estimate import Fit
from dynident.model import Recording, base_parameters, load_robot, robot_names
from dynident.trajectories import random_via_points

_LARGE = np.linspace(0.0, 1.0, 6000).reshape(1000, 6)


def values() -> list[Any]:
    robot = load_robot("rx90")
    via = random_via_points(robot, count=12, seed=0)
    base, fit = base_parameters(robot), Fit(np.ones(6), np.ones(6), (9,) * 6)
    names = base.columns
    estimate = Estimate(names, np.ones(len(names)), np.eye(len(names)), 10.0, fit, np.ones(6))
    recording = Recording(np.arange(1000.0), _LARGE, _LARGE, source="a.csv")
    return [*map(load_robot, robot_names()), via, via.motion(rate=100.0), base, estimate, recording]


@pytest.mark.parametrize("value", values(), ids=lambda value: type(value).__name__)
def test_ten_lines_hold_it(value: Any) -> None:
    text = repr(value)
    assert text.startswith(f"{type(value).__name__}(")
    assert len(text) <= 10 * 80
    assert "\n" not in text
