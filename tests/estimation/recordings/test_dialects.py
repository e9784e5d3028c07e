"""Every dialect of text with every recorder's columns gives what the plain file gives, and says what it was."""

import gzip
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from dynident.apps.logs.columns import KNOWN, PLAIN, Known
from dynident.apps.logs.read import read_recording
from dynident.common.errors import InputError
from dynident.model import Recording, Robot, load_robot

UNITS = {"time": "s", "position": "rad", "velocity": "rad/s", "torque": "Nm", "current": "A"}


class Sheet(NamedTuple):
    """Names, units and numbers of a table."""

    names: list[str]
    units: list[str]
    rows: np.ndarray


def sheet_of(known: Known, robot: Robot, signals: Mapping[str, np.ndarray]) -> Sheet:
    """The signals as a recorder calls them, with currents where it knows of no torque."""
    joints = robot.joint_names[0] if "{joint}" in known.columns["position"][0] else ()
    layout = replace(known, prefixes=("/robot/",))
    load = "torque" if "torque" in known.columns else "current"
    time = known.time[0] if known.time else "__time" if "*" in known.columns["position"][0] else "timestamp"
    names, units = [time], [known.time_unit or "s"]
    columns = [signals["t"] * (1000.0 if known.time_unit == "ms" else 1.0)]
    for kind in ("position", "velocity", load):
        names += layout.expanded(known.columns[kind][0], joints, robot.n)
        units += [UNITS[kind]] * robot.n
        columns += list(signals[kind if kind in signals else "torque"].T)
    return Sheet(names, units, np.column_stack(columns))


def _lines(sheet: Sheet, delimiter: str = ",", decimal: str = ".", quote: str = "") -> list[str]:
    header = delimiter.join(f"{quote}{name}{quote}" for name in sheet.names)
    rows = [[repr(float(value)).replace(".", decimal) for value in row] for row in sheet.rows]
    return [header, *(delimiter.join(f"{quote}{cell}{quote}" for cell in row) for row in rows)]


def _text(lines: list[str], encoding: str = "utf-8", end: str = "\n") -> bytes:
    return (end.join(lines) + end).encode(encoding)


def _with_units(sheet: Sheet) -> bytes:
    header, *rows = _lines(sheet)
    return _text([header, ",".join(sheet.units), *rows])


def _in_brackets(sheet: Sheet) -> bytes:
    return _text(
        _lines(sheet._replace(names=[f"{n} [{u}]" for n, u in zip(sheet.names, sheet.units, strict=True)]))
    )


def _with_remarks(sheet: Sheet) -> bytes:
    lines = _lines(sheet)
    return _text(["# recorded on a Monday", "#", *lines[:30], "# a pause", "", *lines[30:]])


def _cut(sheet: Sheet) -> bytes:
    lines = _lines(sheet)
    return _text(lines) + lines[-1][: len(lines[-1]) // 2].encode()


def _repeated(sheet: Sheet) -> bytes:
    lines = _lines(sheet)
    return _text([*lines[:20], lines[19], lines[19], *lines[20:]])


DIALECTS: dict[str, tuple[Callable[[Sheet], bytes], str]] = {
    "semicolons": (lambda s: _text(_lines(s, ";")), "semicolons"),
    "tabs": (lambda s: _text(_lines(s, "\t")), "tabs"),
    "blanks": (lambda s: _text(_lines(s, " ")), "blanks"),
    "bars": (lambda s: _text(_lines(s, "|")), "bars"),
    "commas and blanks": (lambda s: _text(_lines(s, ", ")), ""),
    "decimal commas": (lambda s: _text(_lines(s, ";", ",")), "decimal commas"),
    "decimal commas, tabs": (lambda s: _text(_lines(s, "\t", ",")), "decimal commas"),
    "decimal commas, quoted": (lambda s: _text(_lines(s, ";", ",", '"')), "decimal commas"),
    "quoted": (lambda s: _text(_lines(s, quote='"')), ""),
    "sep=": (lambda s: _text(["sep=,", *_lines(s)]), "commas"),
    "sep=;": (lambda s: _text(["sep=;", *_lines(s, ";")]), "semicolons"),
    "byte order mark": (lambda s: _text(_lines(s), "utf-8-sig"), "byte order mark"),
    "utf-16": (lambda s: _text(_lines(s), "utf-16"), "UTF-16"),
    "utf-16 without a mark": (lambda s: _text(_lines(s), "utf-16-le"), "UTF-16"),
    "latin-1": (lambda s: _text(["# Prüfstand", *_lines(s)], "latin-1"), "Latin-1"),
    "a row of units": (_with_units, "a row of units"),
    "units in brackets": (_in_brackets, ""),
    "remarks": (_with_remarks, "remarks"),
    "header as a remark": (lambda s: _text([f"# {' '.join(s.names)}", *_lines(s, " ")[1:]]), "remarks"),
    "windows": (lambda s: _text(_lines(s), end="\r\n"), ""),
    "old mac": (lambda s: _text(_lines(s), end="\r"), ""),
    "a last delimiter": (lambda s: _text([f"{line}," for line in _lines(s)]), ""),
    "no last line end": (lambda s: _text(_lines(s))[:-1], ""),
    "gzip": (lambda s: gzip.compress(_text(_lines(s))), ""),
    "the last row cut": (_cut, "cut off: left out"),
    "rows repeated": (_repeated, "2 rows repeat the time"),
}
"""Text of each dialect, and what the notes say of it."""
LAYOUTS = {known.title: known for known in KNOWN}


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
def test_arrays_and_parquet_go_by_the_same_table(tmp_path: Path, known: Known) -> None:
    """Columns are known by their names, whatever the format that holds them."""
    robot = arm_of(known.title)
    sheet = sheet_of(known, robot, signals_of(robot))
    columns = dict(zip(sheet.names, sheet.rows.T, strict=True))
    pq.write_table(pa.table(columns), tmp_path / "a.parquet")
    (tmp_path / "a.csv").write_bytes(_text(_lines(sheet)))
    np.savez(tmp_path / "a.npz", **{name: values for name, values in columns.items() if "/" not in name})
    expected = read(tmp_path / "a.csv", known.title)
    assert read(tmp_path / "a.parquet", known.title).fingerprint == expected.fingerprint
    if not any("/" in name for name in sheet.names):
        assert read(tmp_path / "a.npz", known.title).fingerprint == expected.fingerprint


def test_lists_of_a_lerobot_data_set(tmp_path: Path) -> None:
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
