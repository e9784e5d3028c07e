"""Log maps and flags: names, files side by side, units, signs, sides; mistakes refused by name."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps.logs import FilePart, Gears, Quantity, Time, with_flags
from dynident.apps.logs.columns import Naming
from dynident.apps.logs.map import LogMap, factor, read_log_map
from dynident.apps.logs.read import read_recording
from dynident.apps.logs.table import RawLog
from dynident.common.errors import InputError
from dynident.common.schema import convert
from dynident.model import Robot, load_robot, robot_names
from dynident.tests.estimation.recordings.log_files import NAMES, as_csv
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace


def test_files_side_by_side_must_fit(tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray]) -> None:
    np.savetxt(tmp_path / "a.csv", signals["q"], delimiter=",")
    np.savetxt(tmp_path / "b.csv", signals["tau"][:-1], delimiter=",")
    names = {kind: tuple(f"{kind}{j}" for j in range(1, 7)) for kind in ("q", "tau")}
    parts = (FilePart(name="a.csv", names=names["q"]), FilePart(name="b.csv", names=names["tau"]))
    how = LogMap(files=parts, time=Time(rate=100.0))
    with pytest.raises(InputError, match=r"a\.csv, b\.csv have not the same number of rows"):
        read_recording(tmp_path, arm, None, how)
    np.savetxt(tmp_path / "b.csv", signals["tau"], delimiter=",")
    recording = read_recording(tmp_path, arm, None, how)
    assert np.allclose(recording.torque, signals["tau"])
    assert np.allclose(recording.t, signals["t"])
    with pytest.raises(InputError, match="needs the folder that holds"):
        read_recording(tmp_path / "a.csv", arm, None, how)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[positoin]\n", "'positoin': unknown"),
        ('[position]\nunit = "grad"', "'grad' of position"),
        ('[position]\nside = "motor"', "motor side without gear ratios"),
        ('[torque]\nunit = "percent"', "rated goes with"),
        ("[torque]\nsign = [2, 1, 1, 1, 1, 1]", "sign must be 1 or -1"),
        ("[torque]\nzero_deg = [0, 0]", "only positions"),
        ('[current]\nside = "motor"\n[motor]\ngear_ratios = [1, 1]', "a current has no side"),
        ("[motor]\ngear_ratios = [0, 1]", "ratio 0"),
        ("[motor]\ngear_ratios = [1, 1]\ncoupling = [{motor = 3, joint = 1}]", "no two of 2"),
        ("[time]\nrate_hz = -1", "rate_hz must be positive"),
        ('[time]\nrate_hz = 100\ncolumn = "t"', "give rate_hz, or column"),
        ('[time]\nunit = "h"', "'h' of time"),
        ('[file]\ndelimiter = "comma"\ndecimal = ","', "needs a delimiter"),
        ('[file]\nnames = ["q6..1"]', "a range must rise"),
        ('[file]\nnames = ["q1", "q1"]', "'q1' is given twice"),
        ('joints = ["a", "a"]', "named twice"),
        ("[time", "not valid TOML"),
    ],
)
def test_bad_log_maps(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "map.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=words) as caught:
        read_log_map(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_lists_must_be_as_long_as_the_robot(tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray]) -> None:
    path = as_csv(tmp_path / "a.csv", signals)
    how = LogMap("m.toml", position=Quantity(sign=(1.0, -1.0)))
    with pytest.raises(InputError, match=r"position\.sign has 2 entries, the robot 6"):
        read_recording(path, arm, None, how)
    with pytest.raises(InputError, match="5 joints, the robot has 6"):
        read_recording(path, arm, None, LogMap(joints=NAMES[:5]))


def test_flags(tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray]) -> None:
    path = as_csv(tmp_path / "a.csv", signals)
    turned = (1.0, -1.0, 1.0, 1.0, 1.0, 1.0)
    how = with_flags(LogMap(), units=["q=deg", "qd=deg/s", "tau=mN·m", "t=ms"], signs=turned)
    recording = read_recording(path, arm, None, how)
    assert recording.qd is not None
    assert np.allclose(recording.q, np.radians(signals["q"]) * turned)
    assert np.allclose(recording.qd, np.radians(signals["qd"]) * turned)
    assert np.allclose(recording.torque, 1e-3 * signals["tau"] * turned)
    assert np.allclose(recording.t, 1e-3 * signals["t"])
    for bad in ("x=deg", "q", "q="):
        with pytest.raises(InputError, match="--units"):
            with_flags(LogMap(), units=[bad])
    with pytest.raises(InputError, match="unit 'inch' of position"):
        with_flags(LogMap(), units=["q=inch"])


_NAMED = [(robot, names) for robot in robot_names() for names in load_robot(robot).joint_names]


@pytest.mark.parametrize(("robot", "names"), _NAMED, ids=[f"{robot}-{names[0]}" for robot, names in _NAMED])
@pytest.mark.parametrize("seed", range(2))
def test_every_arms_own_names_in_any_order(robot: str, names: tuple[str, ...], seed: int) -> None:
    order = tuple(np.random.default_rng(seed).permutation([*names, "left_finger"]).tolist())
    raw = RawLog(Path("x"), ("t",), lambda names: np.empty((0, 0)), str, order)
    assert Naming(raw, LogMap(), load_robot(robot)).joints == names


@pytest.mark.parametrize("robot", robot_names())
@pytest.mark.parametrize("first", [0, 1])
def test_numbered_names_of_any_arm(robot: str, first: int) -> None:
    arm = load_robot(robot)
    names = tuple(f"other_joint_{k}" for k in range(first, first + arm.n))
    raw = RawLog(Path("x"), ("t",), lambda names: np.empty((0, 0)), str, names[::-1])
    assert Naming(raw, LogMap(), arm).joints == names


UR = ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint")


@pytest.mark.parametrize("prefix", ["", "left_"])
def test_joints_by_the_makers_names(prefix: str) -> None:
    """A log names them in its own order, perhaps with another arm's beside them: no --joints is needed."""
    own_names = [f"{prefix}{name}" for name in sorted(UR)]
    raw = RawLog(Path("x"), ("t",), lambda names: np.empty((0, 0)), str, ("gripper", *own_names))
    naming = Naming(raw, LogMap(), load_robot("ur10e"))
    assert naming.joints == tuple(f"{prefix}{name}" for name in UR)


def test_two_arms_in_a_log_must_be_told_apart() -> None:
    both = tuple(f"{side}_{name}" for side in ("left", "right") for name in UR)
    raw = RawLog(Path("x"), ("t",), lambda names: np.empty((0, 0)), str, both)
    with pytest.raises(InputError, match="--joints"):
        _ = Naming(raw, LogMap(), load_robot("ur10e")).joints


def test_columns_that_are_not_used_are_named_in_few_words(tmp_path: Path, arm: Robot) -> None:
    joints = [f"{kind}{j}" for kind in ("q", "tau") for j in range(1, 7)]
    names = ["t", *joints, "a1", "a2", "a3", "temp1", "temp2", "fan"]
    rows = "\n".join(f"{k * 0.01},{','.join('1' * (len(names) - 1))}" for k in range(200))
    (tmp_path / "log.csv").write_text(f"{','.join(names)}\n{rows}\n")
    recording = read_recording(tmp_path / "log.csv", arm)
    assert "columns not used: a1 .. a3, temp1, temp2, fan" in " ".join(recording.notes)


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
