"""Log maps and flags: names, units, signs, sides; what controllers refer to; maps of public data sets."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps.logs import Gears, Layout, Quantity, Time, with_flags
from dynident.apps.logs.columns import Naming, RawLog
from dynident.apps.logs.log_check import following_change, read_following
from dynident.apps.logs.map import LogMap, read_log_map
from dynident.apps.logs.read import read_recording
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.common.schema import convert
from dynident.estimation.fit.covariance import student95
from dynident.model import Recording, Robot, load_robot, robot_names
from dynident.tests.estimation.recordings.conftest import NAMES, Signals, as_csv
from hypothesis import given
from hypothesis import strategies as st


def test_files_side_by_side_must_fit(tmp_path: Path, arm: Robot, signals: Signals) -> None:
    np.savetxt(tmp_path / "a.csv", signals["q"], delimiter=",")
    np.savetxt(tmp_path / "b.csv", signals["tau"][:-1], delimiter=",")
    names = {kind: tuple(f"{kind}{j}" for j in range(1, 7)) for kind in ("q", "tau")}
    parts = (Layout(name="a.csv", names=names["q"]), Layout(name="b.csv", names=names["tau"]))
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
        ('[position]\nunit = "grad"', "'grad' of position"),
        ('[position]\nside = "motor"', "motor side without gear ratios"),
        ("[torque]\nrated = [1, 1]", "rated goes with"),
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
    ],
)
def test_bad_log_maps(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "map.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=words) as caught:
        read_log_map(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_lists_must_be_as_long_as_the_robot(tmp_path: Path, arm: Robot, signals: Signals) -> None:
    path = as_csv(tmp_path / "a.csv", signals)
    how = LogMap("m.toml", position=Quantity(sign=(1.0, -1.0)))
    with pytest.raises(InputError, match=r"position\.sign has 2 entries, the robot 6"):
        read_recording(path, arm, None, how)
    with pytest.raises(InputError, match="joints has 5 entries, the robot 6 joints"):
        read_recording(path, arm, None, LogMap(joints=NAMES[:5]))


def test_flags(tmp_path: Path, arm: Robot, signals: Signals) -> None:
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


def joints_of(robot: str, names: tuple[str, ...]) -> tuple[str, ...]:
    """The arm's joints, in its own order, of a log that holds joints of these names."""
    raw = RawLog(Path("x"), ("t",), lambda names: np.empty((0, 0)), str, names)
    return Naming(raw, LogMap(), load_robot(robot)).joints


_NAMED = [(robot, names) for robot in robot_names() for names in load_robot(robot).joint_names]


@pytest.mark.parametrize(("robot", "names"), _NAMED, ids=[f"{robot}-{names[0]}" for robot, names in _NAMED])
@pytest.mark.parametrize("seed", range(2))
def test_every_arms_own_names_in_any_order(robot: str, names: tuple[str, ...], seed: int) -> None:
    order = tuple(np.random.default_rng(seed).permutation([*names, "left_finger"]).tolist())
    assert joints_of(robot, order) == names


@pytest.mark.parametrize("robot", robot_names())
@pytest.mark.parametrize("first", [0, 1])
def test_numbered_names_of_any_arm(robot: str, first: int) -> None:
    names = tuple(f"other_joint_{k}" for k in range(first, first + load_robot(robot).n))
    assert joints_of(robot, names[::-1]) == names


UR = ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint")


def test_two_arms_in_a_log_must_be_told_apart() -> None:
    both = tuple(f"{side}_{name}" for side in ("left", "right") for name in UR)
    with pytest.raises(InputError, match="--joints"):
        joints_of("ur10e", both)


DEGREE, TURN = np.pi / 180.0, 2.0 * np.pi
UNITS = {
    "position": {"rad": 1.0, "deg": DEGREE, "rev": TURN},
    "velocity": {"rad/s": 1.0, "deg/s": DEGREE, "rev/s": TURN, "rpm": TURN / 60.0},
    "torque": {"N·m": 1.0, "Nm": 1.0, "mN·m": 1e-3},
    "current": {"A": 1.0, "mA": 1e-3},
}
"""SI of one of each unit."""
SIGNS = st.lists(st.sampled_from([-1.0, 1.0]), min_size=6, max_size=6).map(tuple)
RATIOS = st.lists(st.floats(0.5, 200.0), min_size=6, max_size=6)


@pytest.mark.parametrize("kind", UNITS)
@given(data=st.data())
def test_units_and_signs_are_undone(kind: str, data: st.DataObject) -> None:
    """A log made from SI values by a unit and signs gives them back."""
    unit, sign = data.draw(st.sampled_from([*UNITS[kind]])), data.draw(SIGNS)
    values = np.random.default_rng(data.draw(st.integers(0, 99))).normal(size=(5, 6))
    raw = values / UNITS[kind][unit] * sign
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
    assert np.array_equal(motor.matrix(), G)
    qm, taum = np.random.default_rng(0).normal(size=(2, 4, 6))
    joint = np.sum(how.si("velocity", qm) * how.si("torque", taum), axis=1)
    assert np.allclose(joint, np.sum(qm * taum, axis=1), rtol=1e-6, atol=1e-8)


FOLDER = Path(__file__).parents[3] / "examples/logs"
DRAW = np.random.default_rng(0)


def test_every_recipe_is_read_and_described(root: Path) -> None:
    text = (root / "docs/data_sets.md").read_text(encoding="utf-8") + (root / "docs/logs.md").read_text("utf-8")
    paths = sorted(FOLDER.glob("*.toml"))
    assert len(paths) == 4
    for path in paths:
        assert read_log_map(path)
        assert f"examples/logs/{path.name}" in text


def test_tx40_of_figaroh(tmp_path: Path) -> None:
    """Two files without time, motor side; (8) and (9) by hand."""
    q, tau = DRAW.normal(size=(2, 30, 6))
    N = np.array([32.0, 32.0, 45.0, -48.0, 45.0, 32.0])
    counted = q - np.array([0.0, -np.pi / 2, np.pi / 2, 0.0, 0.0, 0.0])
    qm = N * counted
    qm[:, 5] += 32.0 * counted[:, 4]
    taum = tau / N
    taum[:, 4] = (tau[:, 4] - tau[:, 5]) / 45.0
    for name, values in (("pos_read_data.csv", qm), ("curr_data.csv", taum)):
        np.savetxt(tmp_path / name, values, delimiter=",", header="a,b,c,d,e,f", comments="")
    recording = read_recording(tmp_path, load_robot("tx40"), None, read_log_map(FOLDER / "tx40_figaroh.toml"))
    assert np.allclose(recording.t, np.arange(30) / 5000.0)
    assert np.allclose(recording.q, q)
    assert np.allclose(recording.torque, tau)


RATE, SECONDS = 100.0, 12.0


def signals(seed: int) -> tuple[Array, Array, Array]:
    """Times, positions of six joints (joint 1 held), and errors of the order of a milliradian."""
    t = np.arange(int(RATE * SECONDS)) / RATE
    q = 0.4 * np.sin(np.outer(t, [0.0, 1.1, 1.7, 2.3, 0.9, 1.4]))
    draw = np.random.default_rng(seed)
    slow = np.cumsum(draw.standard_normal((len(t), 6)), axis=0)
    error = 1e-3 * (np.sin(np.outer(t, [1.0, 2.1, 2.7, 3.3, 1.9, 2.4])) + 0.02 * (slow - slow.mean(axis=0)))
    return t, q, error


def write(path: Path, share: float, reference: str = "qref", seed: int = 0) -> Path:
    t, q, error = signals(0)
    torque = 30.0 * np.cos(q) + np.random.default_rng(seed).standard_normal(q.shape)
    names, columns = ["t"], [t[:, None]]
    for prefix, values in (("q", q), ("tau", torque)):
        names += [f"{prefix}{j}" for j in range(1, 7)]
        columns.append(values)
    extra = {"qref": q + share * error, "tauref": torque - 1e3 * share * error}.get(reference)
    if extra is not None:
        names += [f"{reference}{j}" for j in range(1, 7)]
        columns.append(extra)
    np.savetxt(path, np.hstack(columns), delimiter=",", header=",".join(names), comments="", fmt="%.12g")
    return path


@pytest.mark.parametrize(("reference", "kind"), [("qref", "following error"), ("tauref", "unpredicted torque")])
def test_the_fall_is_the_share(tmp_path: Path, rx90: Robot, reference: str, kind: str) -> None:
    before = read_following(write(tmp_path / "before.csv", 1.0, reference), rx90)
    following = following_change(before, read_following(write(tmp_path / "after.csv", 0.6, reference, 1), rx90))
    assert following.kind == kind
    assert [joint.name for joint in following.joints] == [f"joint {j}" for j in range(2, 7)]
    assert following.total.fall == pytest.approx(0.4, abs=0.01)
    assert following.total.interval[0] <= 0.41
    assert following.total.interval[1] >= 0.39
    assert following.total.clear == "fell"
    _, _, error = signals(0)
    scale = 1.0 if reference == "qref" else 1e3
    assert following.joints[0].before == pytest.approx(scale * np.sqrt(np.mean(error[:, 1] ** 2)), rel=0.02)


def test_different_references_are_not_compared(tmp_path: Path, rx90: Robot) -> None:
    a = read_following(write(tmp_path / "a.csv", 1.0, "qref"), rx90)
    b = read_following(write(tmp_path / "b.csv", 1.0, "tauref"), rx90)
    with pytest.raises(InputError, match="same columns in both"):
        following_change(a, b)


def test_the_interval_is_as_wide_as_chance() -> None:
    """With white noise in both, the logarithm of the ratio of two root mean squares scatters by 1/sqrt(samples)."""
    t, q, _ = signals(0)
    widths = []
    for seed in range(20):
        noise = np.random.default_rng(seed).standard_normal((2, *q.shape))
        before, after = (Recording(t, q, missed) for missed in noise)
        low, high = following_change(("torque", before), ("torque", after)).total.interval
        widths.append(np.log(1.0 - low) - np.log(1.0 - high))
    moving = 5 * len(t)
    assert np.mean(widths) == pytest.approx(2.0 * student95(11) / np.sqrt(moving), rel=0.15)


@pytest.mark.parametrize(("unit", "factor_of_one"), [("A", 1.0), ("mA", 1e-3), ("raw", 1.0), ("percent", 0.01)])
def test_torques_of_unknown_gain_are_read_as_currents_are(
    tmp_path: Path, arm: Robot, signals: Signals, unit: str, factor_of_one: float
) -> None:
    """Columns named torques need drive gains where a user says that they hold something else."""
    path = as_csv(tmp_path / "log.csv", signals)
    how = with_flags(LogMap(), units=[f"tau={unit}"])
    with pytest.raises(InputError, match=r"has currents .tau1\.\.tau6. but no torques: give --drive-gains"):
        read_recording(path, arm, None, how)
    gains = np.arange(1.0, 7.0)
    recording = read_recording(path, arm, gains.tolist(), how)
    np.testing.assert_allclose(recording.torque, signals["tau"] * gains * factor_of_one, rtol=1e-6, atol=1e-6)
    assert recording.torque_unit == "named"


def test_an_effort_is_no_torque_until_something_says_so(tmp_path: Path, arm: Robot, signals: Signals) -> None:
    """By the user, or the column's name."""
    path = as_csv(tmp_path / "log.csv", signals)
    assert read_recording(path, arm).torque_unit == "named"
    path.write_text(path.read_text().replace("tau", "effort"))
    how = LogMap(torque=Quantity("effort{}"))
    assert read_recording(path, arm, None, how).torque_unit == "unknown"
    assert read_recording(path, arm, None, with_flags(how, units=["tau=N·m"])).torque_unit == "given"
