"""Every dialect of text with every recorder's columns gives what the plain file gives, and says what it was."""

from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs.columns import KNOWN, PLAIN
from dynident.apps.logs.read import read_recording
from dynident.common.errors import InputError
from dynident.model import Recording, Robot, load_robot
from dynident.tests.estimation.recordings.dialects import DIALECTS, LAYOUTS, _lines, _text, sheet_of

ARMS = {name: load_robot(name) for name in ("ur10e", "panda")}


def arm_of(title: str) -> Robot:
    return ARMS["panda" if "Franka" in title else "ur10e"]


def signals_of(robot: Robot) -> dict[str, np.ndarray]:
    draw = np.random.default_rng(0)
    kinds = {kind: draw.uniform(-1.0, 1.0, (60, robot.n)) for kind in ("position", "velocity", "torque")}
    return {"t": 0.008 * np.arange(60), **kinds}


def read(path: Path, title: str) -> Recording:
    robot = arm_of(title)
    return read_recording(path, robot, None if "torque" in LAYOUTS[title].columns else [1.0] * robot.n)


@pytest.mark.parametrize("title", LAYOUTS)
@pytest.mark.parametrize("dialect", DIALECTS)
def test_every_dialect_with_every_layout(tmp_path: Path, dialect: str, title: str) -> None:
    robot = arm_of(title)
    signals = signals_of(robot)
    plain, dialect_file = tmp_path / "plain.csv", tmp_path / "other.csv"
    plain.write_bytes(_text(_lines(sheet_of(PLAIN, robot, signals))))
    write, words = DIALECTS[dialect]
    dialect_file.write_bytes(write(sheet_of(LAYOUTS[title], robot, signals)))
    expected, recording = read_recording(plain, robot), read(dialect_file, title)
    assert np.allclose(recording.t, expected.t, atol=1e-12)
    assert recording.qd is not None
    assert expected.qd is not None
    for values, expected_values in (
        (recording.q, expected.q),
        (recording.qd, expected.qd),
        (recording.torque, expected.torque),
    ):
        assert np.array_equal(values, expected_values)
    notes = " ".join(recording.notes)
    assert words in notes
    if LAYOUTS[title] is not PLAIN and not LAYOUTS[title].columns["position"][0].startswith("{joint}"):
        assert f"columns of: {title}" in notes


@pytest.mark.parametrize("known", KNOWN, ids=[known.title for known in KNOWN])
def test_arrays_and_parquet_go_by_the_same_table(tmp_path: Path, known: object) -> None:
    """Columns are known by their names, whatever the format that holds them."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    (layout,) = [each for each in KNOWN if each is known]
    robot = arm_of(layout.title)
    sheet = sheet_of(layout, robot, signals_of(robot))
    columns = dict(zip(sheet.names, sheet.rows.T, strict=True))
    pq.write_table(pa.table(columns), tmp_path / "a.parquet")
    (tmp_path / "a.csv").write_bytes(_text(_lines(sheet)))
    np.savez(tmp_path / "a.npz", **{name: values for name, values in columns.items() if "/" not in name})
    expected = read(tmp_path / "a.csv", layout.title)
    assert read(tmp_path / "a.parquet", layout.title).fingerprint == expected.fingerprint
    if not any("/" in name for name in sheet.names):
        assert read(tmp_path / "a.npz", layout.title).fingerprint == expected.fingerprint


def test_lists_of_a_lerobot_data_set(tmp_path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    robot = ARMS["ur10e"]
    signals = signals_of(robot)
    gripper = np.column_stack([signals["position"], np.zeros(60)])
    table = {"observation.state": gripper, "observation.velocity": signals["velocity"],
             "observation.effort": signals["torque"], "action": gripper}  # fmt: skip
    columns = {name: pa.array(values.astype(np.float32).tolist(), pa.list_(pa.float32())) for name, values in
               table.items()}  # fmt: skip
    time = {"timestamp": signals["t"].astype(np.float32), "episode_index": np.zeros(60, dtype=int)}
    pq.write_table(pa.table(columns | time), tmp_path / "a.parquet")
    recording = read_recording(tmp_path / "a.parquet", robot)
    assert np.allclose(recording.q, signals["position"], atol=1e-6)
    assert np.allclose(recording.torque, signals["torque"], atol=1e-6)
    assert recording.qd is not None
    assert "LeRobot" in " ".join(recording.notes)
    assert "observation.state7" in " ".join(recording.notes)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.xlsx", b"PK\x03\x04", "save it as CSV"),
        ("a.xls", b"\xd0\xcf\x11\xe0", "save it as CSV"),
        ("a.csv", b"PK\x03\x04 and so on", "save it as CSV"),
        ("a.bag", b"#ROSBAG V2.0\n", "rosbags-convert"),
        ("a.csv.xz", b"\xfd7zXZ\x00", "compress it by gzip"),
    ],
)
def test_other_files_are_told_what_to_do(tmp_path: Path, name: str, content: bytes, words: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=words) as caught:
        read_recording(tmp_path / name, ARMS["ur10e"])
    assert "\n" not in str(caught.value)


def test_units_of_the_file_count(tmp_path: Path) -> None:
    """Degrees and milliseconds in a row of units; --units says otherwise."""
    robot = ARMS["ur10e"]
    signals = signals_of(robot)
    sheet = sheet_of(PLAIN, robot, signals)
    units = ["ms", *["deg"] * 6, *["deg/s"] * 6, *["Nm"] * 6]
    header, *rows = _lines(sheet._replace(rows=sheet.rows * [1000.0, *[1.0] * 18]))
    (tmp_path / "a.csv").write_bytes(_text([header, ",".join(units), *rows]))
    recording = read_recording(tmp_path / "a.csv", robot)
    assert np.allclose(recording.t, signals["t"])
    assert np.allclose(recording.q, np.radians(signals["position"]))
    assert "position deg; velocity deg/s" in " ".join(recording.notes)
    units[1:7] = ["%"] * 6
    (tmp_path / "a.csv").write_bytes(_text([header, ",".join(units), *rows]))
    with pytest.raises(InputError, match="column 'q1': unit 'percent' of position"):
        read_recording(tmp_path / "a.csv", robot)


def test_what_the_controller_computes_is_no_measurement(tmp_path: Path) -> None:
    robot = ARMS["ur10e"]
    sheet = sheet_of(LAYOUTS["Universal Robots, RTDE"], robot, signals_of(robot))
    names = [name.replace("actual_current_as_torque", "target_moment") for name in sheet.names]
    (tmp_path / "a.csv").write_bytes(_text(_lines(sheet._replace(names=names))))
    with pytest.raises(InputError, match="target_moment_0 and so on are what the controller computes"):
        read_recording(tmp_path / "a.csv", robot)
