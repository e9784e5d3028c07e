"""Logs of every format give the same recording; units, sides, signs and names are mapped, or refused by name."""

import builtins
import gzip
import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.estimation.logs import (
    FilePart,
    Layout,
    LogMap,
    Quantity,
    open_log,
    read_log_map,
    read_recording,
    stream_samples,
    with_flags,
)
from dynident.estimation.logs.table import BLOCK
from dynident.estimation.logs.units import factor
from dynident.model import InputError, Recording, Robot, load_robot
from hypothesis import given
from hypothesis import strategies as st

NAMES = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")


@pytest.fixture(scope="module")
def arm() -> Robot:
    return load_robot("ur10e")


@pytest.fixture(scope="module")
def signals() -> dict[str, np.ndarray]:
    draw = np.random.default_rng(0)
    rows = 400
    values = {kind: draw.uniform(-1.0, 1.0, (rows, 6)) for kind in ("q", "qd", "tau")}
    return {"t": 0.01 * np.arange(rows), **values}


def as_csv(path: Path, signals: dict[str, np.ndarray], delimiter: str = ",", decimal: str = ".") -> Path:
    header = ["t"] + [f"{kind}{j}" for kind in ("q", "qd", "tau") for j in range(1, 7)]
    table = np.column_stack(list(signals.values()))
    lines = [delimiter.join(header)]
    lines += [delimiter.join(repr(float(v)).replace(".", decimal) for v in row) for row in table]
    data = ("\n".join(lines) + "\n").encode()
    path.write_bytes(gzip.compress(data) if path.suffix == ".gz" else data)
    return path


def as_npz(path: Path, signals: dict[str, np.ndarray]) -> Path:
    arrays: dict[str, Any] = {kind: values.T if kind == "tau" else values for kind, values in signals.items()}
    np.savez(path, note=np.array("text"), gain=np.array(3.0), **arrays)
    return path


def as_mat5(path: Path, signals: dict[str, np.ndarray]) -> Path:
    from scipy.io import savemat

    savemat(
        path, {"t": signals["t"], "q": signals["q"].T, "qd": signals["qd"], "tau": signals["tau"], "name": "run 1"}
    )
    return path


def as_mat7(path: Path, signals: dict[str, np.ndarray]) -> Path:
    import h5py

    with h5py.File(path, "w", userblock_size=512) as data:
        for name, values in signals.items():
            data[name] = values.T.copy() if values.ndim == 2 else values[None]
    with path.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file")
    return path


def as_parquet(path: Path, signals: dict[str, np.ndarray]) -> Path:
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns: dict[str, Any] = {"t": signals["t"], "mode": ["run"] * len(signals["t"])}
    columns |= {f"{kind}{j + 1}": signals[kind][:, j] for kind in ("q", "qd", "tau") for j in range(6)}
    pq.write_table(pa.table(columns), path)
    return path


def as_bag(
    path: Path, signals: dict[str, np.ndarray], names: tuple[str, ...] = NAMES, gripper: bool = True
) -> Path:
    """A ROS 2 bag whose joints stand in alphabetical order, with messages of a gripper in between."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.LATEST)
    state, header = store.types["sensor_msgs/msg/JointState"], store.types["std_msgs/msg/Header"]
    clock = store.types["builtin_interfaces/msg/Time"]
    plugin = StoragePlugin.MCAP if path.name.startswith("mcap") else StoragePlugin.SQLITE3
    order = sorted(range(6), key=lambda j: names[j])
    with Writer(path, version=9, storage_plugin=plugin) as writer:
        connection = writer.add_connection("/joint_states", state.__msgtype__, typestore=store)
        for k, t in enumerate(signals["t"]):
            stamp = round(1e9 * t) + 1_700_000_000_123_456_789
            head = header(clock(stamp // 10**9, stamp % 10**9), "")
            rows = [np.ascontiguousarray(signals[kind][k, order]) for kind in ("q", "qd", "tau")]
            message = state(head, [names[j] for j in order], *rows)
            writer.write(connection, stamp, store.serialize_cdr(message, state.__msgtype__))
            if gripper:
                other = state(head, ["finger"], *(np.zeros(1) for _ in range(3)))
                writer.write(connection, stamp + 1, store.serialize_cdr(other, state.__msgtype__))
    return path


def same(recording: Recording, signals: dict[str, np.ndarray]) -> None:
    assert recording.qd is not None
    assert np.allclose(recording.t - recording.t[0], signals["t"], atol=1e-9)
    for mine, kind in ((recording.q, "q"), (recording.qd, "qd"), (recording.torque, "tau")):
        assert np.array_equal(mine, signals[kind])


FORMATS: dict[str, Callable[[Path, dict[str, np.ndarray]], Path]] = {
    "a.csv": as_csv,
    "a.csv.gz": as_csv,
    "a.npz": as_npz,
    "five.mat": as_mat5,
    "seven.mat": as_mat7,
    "a.parquet": as_parquet,
}


@pytest.mark.parametrize("name", FORMATS)
def test_round_trip(tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray], name: str) -> None:
    recording = read_recording(FORMATS[name](tmp_path / name, signals), arm)
    same(recording, signals)
    assert recording.notes == ()


def test_a_fingerprint_is_the_recordings_not_the_files(
    tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray]
) -> None:
    """The same in every format and whatever the gains; another with any other number."""
    prints = {read_recording(make(tmp_path / name, signals), arm).fingerprint for name, make in FORMATS.items()}
    assert len(prints) == 1
    header = ["t"] + [f"{kind}{j}" for kind in ("q", "i") for j in range(1, 7)]
    found = []
    for change in (0.0, 1e-9):
        i = signals["tau"].copy()
        i[200, 3] += change
        path = tmp_path / f"{change}.csv"
        table = np.column_stack([signals["t"], signals["q"], i])
        np.savetxt(path, table, delimiter=",", header=",".join(header), comments="", fmt="%.17g")
        found += [read_recording(path, arm, gains).fingerprint for gains in ((1.0,) * 6, (11.976, 9.839) * 3)]
    assert found[0] == found[1] != found[2] == found[3]
    assert {found[0]} == prints


@pytest.mark.parametrize(
    ("delimiter", "name", "decimal"), [("\t", "tab", "."), (";", "semicolon", ","), (" ", "space", ".")]
)
def test_text_layouts(
    tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray], delimiter: str, name: str, decimal: str
) -> None:
    path = as_csv(tmp_path / "a.txt", signals, delimiter, decimal)
    same(read_recording(path, arm, None, LogMap(layout=Layout(name, decimal))), signals)


def test_tsv_by_its_ending(tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray]) -> None:
    same(read_recording(as_csv(tmp_path / "a.tsv", signals, "\t"), arm), signals)


@pytest.mark.parametrize("name", ["mcap", "sqlite"])
def test_ros_bag(tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray], name: str) -> None:
    """Joints come in alphabetical order: only their names tell which is which."""
    path = as_bag(tmp_path / name, signals)
    with pytest.raises(InputError, match=r"elbow, shoulder_lift.*--joints"):
        read_recording(path, arm)
    recording = read_recording(path, arm, None, with_flags(LogMap(), joints=NAMES))
    same(recording, signals)
    file = next(p for p in path.iterdir() if p.suffix in (".mcap", ".db3"))
    same(read_recording(file, arm, None, LogMap(joints=NAMES)), signals)
    with pytest.raises(InputError, match="no topic '/arm'"):
        read_recording(path, arm, None, with_flags(LogMap(), joints=NAMES, topic="/arm"))
    with pytest.raises(InputError, match=r"elbo\.position.* missing \(is it 'elbow\.position'"):
        read_recording(path, arm, None, with_flags(LogMap(), joints=[n.replace("elbow", "elbo") for n in NAMES]))


def test_ros_bag_with_numbered_joints(tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray]) -> None:
    names = tuple(f"arm_joint{j}" for j in range(1, 7))
    same(read_recording(as_bag(tmp_path / "sqlite", signals, names, gripper=False), arm), signals)


def test_effort_may_be_a_current(tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray]) -> None:
    how = LogMap(joints=NAMES, quantities=(Quantity("current", ("{joint}.effort",)),))
    recording = read_recording(as_bag(tmp_path / "mcap", signals), arm, [10.0] * 6, how)
    assert np.allclose(recording.torque, 10.0 * signals["tau"])


def test_structures_of_a_mat_file(tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray]) -> None:
    from scipy.io import savemat

    savemat(tmp_path / "s.mat", {"log": {**signals, "run": {"id": 3}}})
    kinds = {"position": "log.q{}", "velocity": "log.qd{}", "torque": "log.tau{}"}
    how = LogMap(time="log.t", quantities=tuple(Quantity(kind, (name,)) for kind, name in kinds.items()))
    same(read_recording(tmp_path / "s.mat", arm, None, how), signals)


@pytest.mark.parametrize("name", ["a.npz", "a.mat", "a.parquet", "a.mcap", "a.db3"])
def test_files_of_another_kind(tmp_path: Path, arm: Robot, name: str) -> None:
    path = tmp_path / name
    path.write_bytes(b"t,q1\n1,2\n" * 100)
    with pytest.raises(InputError, match=r"a\.\w+: not a") as caught:
        read_recording(path, arm)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("name", "module"), [("seven.mat", "h5py"), ("a.parquet", "pyarrow"), ("mcap", "rosbags")])
def test_missing_library_names_the_extra(
    tmp_path: Path,
    arm: Robot,
    signals: dict[str, np.ndarray],
    name: str,
    module: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = as_bag(tmp_path / name, signals) if name == "mcap" else FORMATS[name](tmp_path / name, signals)
    real = __import__
    import sys

    for loaded in [key for key in sys.modules if key.split(".")[0] == module]:
        monkeypatch.delitem(sys.modules, loaded)

    class Finder:
        def find_spec(self, full: str, *_: Any) -> None:
            if full.split(".")[0] == module:
                raise ImportError(full)

    monkeypatch.setattr(sys, "meta_path", [Finder(), *sys.meta_path])
    assert builtins.__import__ is real
    with pytest.raises(InputError, match=rf"needs {module}: install dynident\[logs\]"):
        read_recording(path, arm)


def test_not_a_number_is_placed(tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray]) -> None:
    spoilt = {name: np.array(values) for name, values in signals.items()}
    spoilt["q"][7, 2] = np.nan
    with pytest.raises(InputError, match="row 8, column 'q3': nan"):
        read_recording(as_npz(tmp_path / "a.npz", spoilt), arm)


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
    how = LogMap(quantities=(Quantity(kind, unit=(unit,), sign=sign),))
    assert np.allclose(how.si(kind, raw), values, rtol=1e-12)


@given(data=st.data())
def test_power_is_the_same_on_both_sides(data: st.DataObject) -> None:
    """Motor torque times motor speed is joint torque times joint speed, whatever the gears and couplings."""
    ratios, coupled = data.draw(RATIOS), data.draw(st.floats(-50.0, 50.0))
    G = np.diag(ratios)
    G[5, 4] = coupled
    how = LogMap(
        gears=tuple(map(tuple, G)),
        quantities=(Quantity("velocity", side="motor"), Quantity("torque", side="motor")),
    )
    qm, taum = np.random.default_rng(0).normal(size=(2, 4, 6))
    joint = np.sum(how.si("velocity", qm) * how.si("torque", taum), axis=1)
    assert np.allclose(joint, np.sum(qm * taum, axis=1), rtol=1e-6, atol=1e-8)


@given(rated=st.lists(st.floats(1.0, 400.0), min_size=6, max_size=6).map(tuple))
def test_percent_of_rated(rated: tuple[float, ...]) -> None:
    how = LogMap(quantities=(Quantity("torque", unit=("percent",), rated=rated),))
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
    recipe = read_log_map(Path(__file__).parents[2] / "examples/logs/tx40_figaroh.toml")
    motor = read_recording(path, robot, None, replace(recipe, files=(), time="t", rate=None))
    assert np.abs(motor.q - joint.q).max() < 1e-8
    assert np.abs(motor.torque - joint.torque).max() < 1e-6


def test_blocks_make_no_difference(tmp_path: Path, arm: Robot) -> None:
    """A log longer than two blocks, streamed and at once; a bad cell in the last block is found."""
    rows = 2 * BLOCK + 11
    table = np.random.default_rng(0).uniform(-1, 1, (rows, 13)).round(4)
    table[:, 0] = (0.001 * np.arange(rows)).round(4)
    header = ",".join(["t"] + [f"{kind}{j}" for kind in ("q", "tau") for j in range(1, 7)])
    path = tmp_path / "long.csv"
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.4f")
    recording = read_recording(path, arm)
    assert np.allclose(recording.q, table[:, 1:7])
    at_once = {"t": table[:, 0], "q": table[:, 1:7], "tau": table[:, 7:]}
    assert read_recording(as_npz(tmp_path / "a.npz", at_once), arm).fingerprint == recording.fingerprint
    parts = list(stream_samples(path, arm))
    assert len(parts) == 3
    assert np.array_equal(np.concatenate([part.torque for part in parts]), recording.torque)
    assert np.array_equal(np.concatenate([part.t for part in parts]), recording.t)
    lines = path.read_text().splitlines()
    lines[rows - 3] = lines[rows - 3].replace("-", "?").replace("0", "x")
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=f"line {rows - 2}, column 't'"):
        read_recording(path, arm)


def test_a_long_log_takes_little_more_than_its_arrays(tmp_path: Path, arm: Robot) -> None:
    rows = 120_000
    path = tmp_path / "long.csv"
    header = ",".join(["t"] + [f"{kind}{j}" for kind in ("q", "tau") for j in range(1, 7)])
    cells = ",".join(f"{0.1 * k:.3f}" for k in range(12))
    with path.open("w") as stream:
        stream.write(header + "\n")
        stream.writelines(f"{k / 1000:.3f},{cells}\n" for k in range(rows))
    tracemalloc.start()
    recording = read_recording(path, arm)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    arrays = recording.t.nbytes + recording.q.nbytes + recording.torque.nbytes
    assert peak < 1.25 * arrays + 16e6  # a block of text and numbers on top


def test_files_side_by_side_must_fit(tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray]) -> None:
    np.savetxt(tmp_path / "a.csv", signals["q"], delimiter=",")
    np.savetxt(tmp_path / "b.csv", signals["tau"][:-1], delimiter=",")
    names = {kind: tuple(f"{kind}{j}" for j in range(1, 7)) for kind in ("q", "tau")}
    parts = (FilePart("a.csv", Layout(names=names["q"])), FilePart("b.csv", Layout(names=names["tau"])))
    how = LogMap(files=parts, time="", rate=100.0)
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
        ('[file]\ndecimal = ","', "needs a delimiter"),
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
    how = LogMap("m.toml", quantities=(Quantity("position", sign=(1.0, -1.0)),))
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


def test_open_log_lists_its_columns(tmp_path: Path, signals: dict[str, np.ndarray]) -> None:
    assert open_log(as_npz(tmp_path / "a.npz", signals), LogMap()).names[:3] == ("t", "q1", "q2")
