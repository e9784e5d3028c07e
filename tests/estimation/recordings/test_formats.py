"""Logs of every format and length give the same recording, or are refused in one line whatever byte is wrong."""

import io
import struct
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs import with_flags
from dynident.apps.logs.map import LogMap
from dynident.apps.logs.read import read_recording
from dynident.common.errors import InputError
from dynident.model import Robot
from dynident.tests.estimation.recordings.conftest import FORMATS, MESSAGES, NAMES, Signals, as_bag, same


@pytest.mark.parametrize("name", FORMATS)
def test_round_trip(tmp_path: Path, arm: Robot, signals: Signals, name: str) -> None:
    recording = read_recording(FORMATS[name](tmp_path / name, signals), arm)
    same(recording, signals)
    assert recording.notes == ()


def test_a_fingerprint_is_the_recordings_not_the_files(tmp_path: Path, arm: Robot, signals: Signals) -> None:
    """A fingerprint stays in every format and whatever the gains; any other number changes it."""
    prints = {read_recording(make(tmp_path / name, signals), arm).fingerprint for name, make in FORMATS.items()}
    assert len(prints) == 1
    header = ["t"] + [f"{kind}{j}" for kind in ("q", "i") for j in range(1, 7)]
    digests = []
    for change in (0.0, 1e-9):
        i = signals["tau"].copy()
        i[200, 3] += change
        path = tmp_path / f"{change}.csv"
        table = np.column_stack([signals["t"], signals["q"], i])
        np.savetxt(path, table, delimiter=",", header=",".join(header), comments="", fmt="%.17g")
        digests += [read_recording(path, arm, gains).fingerprint for gains in ((1.0,) * 6, (11.976, 9.839) * 3)]
    assert digests[0] == digests[1] != digests[2] == digests[3]
    assert {digests[0]} == prints


@pytest.mark.parametrize("also", [["FrankaRobotState"], ["DynamicJointState"], [*MESSAGES]])
def test_other_messages_of_joint_states(tmp_path: Path, arm: Robot, signals: Signals, also: list[str]) -> None:
    """Of an effort only Franka's message says that it is in N·m; a bag with both is read by that."""
    recording = read_recording(as_bag(tmp_path / "mcap", signals, also=also), arm, None, LogMap(joints=NAMES))
    same(recording, signals)
    assert recording.torque_unit == ("given" if "FrankaRobotState" in also else "unknown")
    assert ("nothing tells the unit of effort" in " ".join(recording.notes)) == (recording.torque_unit == "unknown")


@pytest.mark.parametrize("name", ["mcap", "sqlite"])
def test_ros_bag(tmp_path: Path, arm: Robot, signals: Signals, name: str) -> None:
    """Joints come in alphabetical order: only their names tell which is which."""
    path = as_bag(tmp_path / name, signals)
    with pytest.raises(InputError, match=r"elbow, shoulder_lift.*--joints"):
        read_recording(path, arm)
    recording = read_recording(path, arm, None, with_flags(LogMap(), joints=NAMES))
    same(recording, signals)
    file = next(p for p in path.iterdir() if p.suffix in (".mcap", ".db3"))
    same(read_recording(file, arm, None, LogMap(joints=NAMES)), signals)
    with pytest.raises(InputError, match="no joint states in '/arm'"):
        read_recording(path, arm, None, with_flags(LogMap(), joints=NAMES, topic="/arm"))
    with pytest.raises(InputError, match=r"elbo\.position.* missing \(is it 'elbow\.position'"):
        read_recording(path, arm, None, with_flags(LogMap(), joints=[n.replace("elbow", "elbo") for n in NAMES]))


@pytest.mark.parametrize("name", ["mcap", "sqlite"])
def test_a_damaged_bag_is_one_line(tmp_path: Path, arm: Robot, signals: Signals, name: str) -> None:
    """Whatever of the bag's files has wrong bytes; what no byte tells is read."""
    path, refused = as_bag(tmp_path / name, signals), list[str]()
    for file in sorted(path.iterdir()):
        good = file.read_bytes()
        for k in range(12):
            draw = np.random.default_rng(k)
            damaged = bytearray(good)
            begin = int(draw.integers(max(1, len(good) - 64)))
            damaged[begin : begin + 64] = draw.integers(0, 256, 64, dtype=np.uint8).tobytes()
            file.write_bytes(damaged if k % 2 else good[:begin] + damaged[begin : begin + 9] + good[begin:])
            try:
                read_recording(path, arm)
            except InputError as error:
                refused.append(str(error))
        file.write_bytes(good)
    assert len(refused) > 10
    assert not any("\n" in line for line in refused)


@pytest.mark.parametrize(("name", "module"), [("seven.mat", "h5py"), ("a.parquet", "pyarrow"), ("mcap", "rosbags")])
def test_missing_library_names_the_extra(
    tmp_path: Path, arm: Robot, signals: Signals, name: str, module: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = as_bag(tmp_path / name, signals) if name == "mcap" else FORMATS[name](tmp_path / name, signals)
    for loaded in [key for key in sys.modules if key.split(".")[0] == module]:
        monkeypatch.setitem(sys.modules, loaded, None)
    with pytest.raises(InputError, match=rf"needs {module}: install dynident\[logs\]"):
        read_recording(path, arm)


@pytest.mark.parametrize(
    "cell", ["1.5", "+1.5", "1.", ".5", "1e-3", "-0", "01", " 2.5 ", "1e22", "123456789012345678901"]
)
def test_every_way_to_write_a_number_is_read_alike(tmp_path: Path, arm: Robot, cell: str) -> None:
    """The reader must give what Python reads."""
    numbers = np.random.default_rng(1).standard_normal((40, 12))
    rows = [[repr(0.01 * k), *map(repr, values)] for k, values in enumerate(numbers.tolist())]
    rows[7][9] = cell
    header = ",".join(["t"] + [f"{kind}{j}" for kind in ("q", "tau") for j in range(1, 7)])
    path = tmp_path / "log.csv"
    path.write_text("\n".join([header, *map(",".join, rows)]))
    numbers[7, 8] = float(cell)
    recording = read_recording(path, arm)
    assert np.array_equal(np.column_stack([recording.q, recording.torque]), numbers)


BINARY = ["a.npz", "five.mat", "seven.mat", "a.parquet"]
FLIPS = 40


def damaged(good: bytes, seed: int) -> Iterator[bytes]:
    """One bit flipped each: anywhere, in the first bytes and in the last ones; then cut."""
    draw = np.random.default_rng(seed)
    ends = [*draw.integers(0, 400, FLIPS), *(len(good) - draw.integers(1, 400, FLIPS))]
    for place in (*draw.integers(0, len(good), FLIPS), *ends):
        content = bytearray(good)
        content[place] ^= 1 << int(draw.integers(8))
        yield bytes(content)
    for share in (0.0, 0.01, 0.5, 0.99):
        yield good[: int(share * len(good))]


@pytest.mark.parametrize("name", BINARY)
def test_a_wrong_byte_is_an_answer_or_one_line(tmp_path: Path, arm: Robot, signals: Signals, name: str) -> None:
    short = {kind: values[:50] for kind, values in signals.items()}
    good, lines = FORMATS[name](tmp_path / name, short).read_bytes(), []
    for content in damaged(good, 3):
        (tmp_path / name).write_bytes(content)
        try:
            read_recording(tmp_path / name, arm)
        except InputError as error:
            lines.append(str(error))
    assert not any("\n" in line for line in lines)
    # MAT files have no checksums: a wrong bit in a number is a wrong number.
    assert len(lines) > (2 * FLIPS if name == "a.npz" else 2)


def npy(shape: str) -> bytes:
    """An array file whose header tells of so many numbers, with a hundred of them."""
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}"
    header += " " * (63 - (10 + len(header)) % 64) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + bytes(800)


def objects() -> bytes:
    stream = io.BytesIO()
    np.save(stream, np.array([{}, 1], dtype=object), allow_pickle=True)
    return stream.getvalue()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (npy("(1000000000000,)"), "damaged one"),
        (npy("(1000000000000, 1000000)"), "damaged one"),
        (npy("(101,)"), "damaged one"),
        (npy("(-5,)"), "damaged one"),
        (npy("(10**3,)"), "not an NPZ file, or a damaged one"),
        (b"\x93NUMPY\x03\x00" + struct.pack("<I", 4_000_000_000) + bytes(100), "damaged one"),
        (objects(), "no arrays of samples"),
        (b"hello", "not an NPZ file"),
    ],
)
def test_headers_that_promise_too_much(tmp_path: Path, arm: Robot, content: bytes, words: str) -> None:
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("t.npy", content)
    with pytest.raises(InputError, match=words):
        read_recording(tmp_path / "a.npz", arm)


def opaque(name: str, kind: str) -> bytes:
    """A MAT file of version 5 whose only variable is an object, as MATLAB lays it out."""

    def element(tag: int, content: bytes) -> bytes:
        return struct.pack("<II", tag, len(content)) + content + bytes(-len(content) % 8)

    reference = element(6, struct.pack("<II", 6, 0)) + element(5, struct.pack("<ii", 6, 1)) + element(1, b"")
    reference = element(14, reference + element(6, struct.pack("<6I", 0xDD000000, 2, 1, 1, 1, 1)))
    texts = b"".join(element(1, text.encode()) for text in (name, "MCOS", kind))
    body = element(14, element(6, struct.pack("<II", 17, 0)) + texts + reference)
    return b"MATLAB 5.0 MAT-file".ljust(116) + bytes(8) + struct.pack("<H", 0x0100) + b"IM" + body


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("table", r"variable log is a MATLAB table, .*writetable\(log, 'log.csv'\)"),
        ("timetable", r"variable log is a MATLAB timetable, .*T = timetable2table\(log\)"),
        ("timeseries", "variable log is a MATLAB timeseries, .*arrays t, q and tau"),
    ],
)
def test_an_object_of_matlab_is_one_line_that_says_what_to_do(
    kind: str, words: str, tmp_path: Path, arm: Robot
) -> None:
    (tmp_path / "a.mat").write_bytes(opaque("log", kind))
    with pytest.raises(InputError, match=words) as refused:
        read_recording(tmp_path / "a.mat", arm)
    assert "\n" not in str(refused.value)


def test_an_object_of_matlab_7_3_is_named_too(tmp_path: Path, arm: Robot) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.mat", "w") as data:
        data["log"] = np.arange(6, dtype=np.uint32).reshape(1, 6)
        data["log"].attrs["MATLAB_class"] = np.bytes_(b"timetable")
    with pytest.raises(InputError, match=r"variable log is a MATLAB timetable, .*timetable2table"):
        read_recording(tmp_path / "a.mat", arm)
