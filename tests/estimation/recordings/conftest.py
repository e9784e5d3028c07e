"""An arm, and the signals of a log of it."""

import numpy as np
import pytest
from dynident.model import Robot, load_robot


@pytest.fixture(scope="module")
def arm() -> Robot:
    return load_robot("ur10e")


@pytest.fixture(scope="module")
def signals() -> dict[str, np.ndarray]:
    draw = np.random.default_rng(0)
    rows = 400
    values = {kind: draw.uniform(-1.0, 1.0, (rows, 6)) for kind in ("q", "qd", "tau")}
    return {"t": 0.01 * np.arange(rows), **values}
