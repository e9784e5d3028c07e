"""Logs of every format and length give the same recording, or are refused with the reason."""

import builtins
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident.apps.logs import Layout, Quantity, Time, open_log, with_flags
from dynident.apps.logs.map import LogMap
from dynident.apps.logs.read import read_recording
from dynident.common.errors import InputError
from dynident.model import Robot
from dynident.tests.estimation.recordings.log_files import FORMATS, NAMES, as_bag, as_csv, as_npz, same


@pytest.mark.parametrize("name", FORMATS)
def test_round_trip(tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray], name: str) -> None:
    recording = read_recording(FORMATS[name](tmp_path / name, signals), arm)
    same(recording, signals)
    assert recording.notes == ()


def test_a_fingerprint_is_the_recordings_not_the_files(
    tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray]
) -> None:
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


@pytest.mark.parametrize(
    ("delimiter", "layout"),
    [("\t", Layout("tab", ".")), (";", Layout("semicolon", ",")), (" ", Layout("space", "."))],
)
def test_text_layouts(
    tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray], delimiter: str, layout: Layout
) -> None:
    path = as_csv(tmp_path / "a.txt", signals, delimiter, layout.decimal)
    same(read_recording(path, arm, None, LogMap(layout=layout)), signals)


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
    how = LogMap(joints=NAMES, current=Quantity("{joint}.effort"))
    recording = read_recording(as_bag(tmp_path / "mcap", signals), arm, [10.0] * 6, how)
    assert np.allclose(recording.torque, 10.0 * signals["tau"])


def test_structures_of_a_mat_file(tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray]) -> None:
    from scipy.io import savemat

    savemat(tmp_path / "s.mat", {"log": {**signals, "run": {"id": 3}}})
    kinds = {"position": "log.q{}", "velocity": "log.qd{}", "torque": "log.tau{}"}
    entries: dict[str, Any] = {kind: Quantity(name) for kind, name in kinds.items()}
    how = LogMap(time=Time("log.t"), **entries)
    same(read_recording(tmp_path / "s.mat", arm, None, how), signals)


@pytest.mark.parametrize("name", ["mcap", "sqlite"])
def test_a_damaged_bag_is_one_line(tmp_path: Path, arm: Robot, signals: dict[str, np.ndarray], name: str) -> None:
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


def test_open_log_lists_its_columns(tmp_path: Path, signals: dict[str, np.ndarray]) -> None:
    assert open_log(as_npz(tmp_path / "a.npz", signals), LogMap()).names[:3] == ("t", "q1", "q2")


def test_a_long_text_is_read_as_arrays_are(tmp_path: Path, arm: Robot) -> None:
    """A bad cell near its end is found."""
    rows = 33_000
    table = np.random.default_rng(0).uniform(-1, 1, (rows, 13)).round(4)
    table[:, 0] = (0.001 * np.arange(rows)).round(4)
    header = ",".join(["t"] + [f"{kind}{j}" for kind in ("q", "tau") for j in range(1, 7)])
    path = tmp_path / "long.csv"
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.4f")
    recording = read_recording(path, arm)
    assert np.allclose(recording.q, table[:, 1:7])
    at_once = {"t": table[:, 0], "q": table[:, 1:7], "tau": table[:, 7:]}
    assert read_recording(as_npz(tmp_path / "a.npz", at_once), arm).fingerprint == recording.fingerprint
    assert np.array_equal(recording.t, table[:, 0])
    assert np.array_equal(recording.torque, table[:, 7:])
    lines = path.read_text().splitlines()
    lines[rows - 3] = lines[rows - 3].replace("-", "?").replace("0", "x")
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=f"line {rows - 2}, column 't'"):
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


@pytest.mark.parametrize("row", ["1,2", "1,2,[4]", "1,2,true", "1,2,null", '1,2,"x"', "1,2,", "1,2,nan"])
def test_rows_that_are_not_plain_numbers_are_refused(tmp_path: Path, row: str) -> None:
    path = tmp_path / "log.csv"
    path.write_text(f"t,q1,tau1\n0,1,2\n{row}\n")
    with pytest.raises(InputError, match=r"line 3|cannot be read"):
        open_log(path, LogMap()).read(("t", "q1", "tau1"))
