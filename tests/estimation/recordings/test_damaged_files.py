"""Logs whose bytes are wrong: an answer or one line, never a traceback, a crash or a wait."""

import io
import struct
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import scipy.io.matlab
from dynident.apps.logs.read import read_recording
from dynident.common.errors import InputError
from dynident.model import Robot
from dynident.tests.estimation.recordings.log_files import FORMATS, NAMES, same
from scipy.sparse import csc_matrix

BINARY = ["a.npz", "five.mat", "seven.mat", "a.parquet"]
FLIPS = 40
MATLAB = sorted((Path(scipy.io.matlab.__file__).parent / "tests" / "data").glob("*.mat"))
"""What MATLAB itself wrote, with objects, functions and cells; not in every installation of scipy."""


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
def test_a_wrong_byte_is_an_answer_or_one_line(
    tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray], name: str
) -> None:
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


def test_sparse_matrices_are_read(tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray]) -> None:
    data = {kind: csc_matrix(values) if kind == "q" else values for kind, values in signals.items()}
    scipy.io.matlab.savemat(tmp_path / "a.mat", data)
    same(read_recording(tmp_path / "a.mat", arm), signals)


@pytest.mark.skipif(not MATLAB, reason="scipy came without its tests' files")
def test_what_matlab_wrote_is_a_log_or_one_line(arm: Robot) -> None:
    """Objects, function handles and cells among them; nothing that scipy reads is called damaged."""
    for path in MATLAB:
        with pytest.raises(InputError) as caught:
            read_recording(path, arm)
        if "damaged" in str(caught.value):
            with pytest.raises(Exception):  # noqa: B017, PT011
                scipy.io.matlab.loadmat(path)


@pytest.mark.parametrize(
    ("cell", "words"),
    [("1e308", "too large a number"), ("-2e30", "too large"), ("inf", "not a finite"), ("nan", "nan")],
)
def test_a_number_that_cannot_be_is_named_by_its_place(
    tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray], cell: str, words: str
) -> None:
    lines = FORMATS["a.csv"](tmp_path / "a.csv", signals).read_text().splitlines()
    lines[7] = ",".join([*lines[7].split(",")[:3], cell, *lines[7].split(",")[4:]])
    (tmp_path / "a.csv").write_text("\n".join(lines))
    with pytest.raises(InputError, match=rf"line 8, column 'q3': .*{words}"):
        read_recording(tmp_path / "a.csv", arm)


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


def test_names_are_not_lost_on_the_way(tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray]) -> None:
    """An object beside the signals does no harm."""
    objects = {"note": np.array([{"a": 1}, "text"], dtype=object), "names": np.array(NAMES, dtype=object)}
    scipy.io.matlab.savemat(tmp_path / "a.mat", {**signals, **objects})
    same(read_recording(tmp_path / "a.mat", arm), signals)
