"""Units, signs, sides and ratings are undone."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps.logs import Gears, Quantity, Time
from dynident.apps.logs.map import LogMap, factor, read_log_map
from dynident.apps.logs.read import read_recording
from dynident.common.errors import InputError
from dynident.common.schema import convert
from dynident.model import load_robot
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

UNITS = {
    "position": ("rad", "deg", "rev"),
    "velocity": ("rad/s", "deg/s", "rev/s", "rpm"),
    "torque": ("N·m", "Nm", "mN·m"),
    "current": ("A", "mA"),
}
SIGNS = st.lists(st.sampled_from([-1.0, 1.0]), min_size=6, max_size=6).map(tuple)
RATIOS = st.lists(st.floats(0.5, 200.0), min_size=6, max_size=6)


@pytest.mark.parametrize("kind", UNITS)
@given(data=st.data())
def test_units_and_signs_are_undone(kind: str, data: st.DataObject) -> None:
    """A log made from SI values by a unit and signs gives them back."""
    unit, sign = data.draw(st.sampled_from(UNITS[kind])), data.draw(SIGNS)
    values = np.random.default_rng(data.draw(st.integers(0, 99))).normal(size=(5, 6))
    raw = values / factor(kind, unit) * sign
    entry: dict[str, Any] = {kind: Quantity(unit=unit, sign=sign)}
    how = LogMap(**entry)
    assert np.allclose(how.si(kind, raw), values, rtol=1e-12)


@given(data=st.data())
def test_power_is_the_same_on_both_sides(data: st.DataObject) -> None:
    """Motor torque times motor speed is joint torque times joint speed, whatever the gears and couplings."""
    ratios, coupled = data.draw(RATIOS), data.draw(st.floats(-50.0, 50.0))
    G = np.diag(ratios)
    G[5, 4] = coupled
    motor = convert({"gear_ratios": ratios, "coupling": [{"motor": 6, "joint": 5, "ratio": coupled}]}, Gears)
    how = LogMap(motor=motor, velocity=Quantity(side="motor"), torque=Quantity(side="motor"))
    assert np.array_equal(how.G, G)
    qm, taum = np.random.default_rng(0).normal(size=(2, 4, 6))
    joint = np.sum(how.si("velocity", qm) * how.si("torque", taum), axis=1)
    assert np.allclose(joint, np.sum(qm * taum, axis=1), rtol=1e-6, atol=1e-8)


@given(rated=st.lists(st.floats(1.0, 400.0), min_size=6, max_size=6).map(tuple))
def test_percent_of_rated(rated: tuple[float, ...]) -> None:
    how = LogMap(torque=Quantity(unit="percent", rated=rated))
    assert np.allclose(how.si("torque", np.full((1, 6), 50.0)), 0.5 * np.array(rated))


def test_known_units() -> None:
    assert factor("position", "deg") == pytest.approx(0.017453292519943295)
    assert factor("velocity", "rpm") == pytest.approx(0.10471975511965977)
    assert factor("time", "us") == 1e-6
    with pytest.raises(InputError, match="'grad' of position: give one of rad, deg"):
        factor("position", "grad")


def test_tx40_motor_side_gives_the_joint_side(recordings: Path) -> None:
    robot = load_robot("tx40")
    path = recordings / "tx40" / "tx40.csv.gz"
    joint = read_recording(path, robot)
    recipe = read_log_map(Path(__file__).parents[3] / "examples/logs/tx40_figaroh.toml")
    motor = read_recording(path, robot, None, replace(recipe, files=(), time=Time()))
    assert np.abs(motor.q - joint.q).max() < 1e-8
    assert np.abs(motor.torque - joint.torque).max() < 1e-6
