"""Files of text: what is accepted, one line for all else; time, gaps, pieces, and planned motions."""

import gzip
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs import read_recordings, read_trajectory, with_flags
from dynident.apps.logs.map import LogMap
from dynident.apps.logs.read import read_recording
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation.signals.recordings import pieces
from dynident.model import Processing, Robot, load_robot
from dynident.tests.estimation.recordings.conftest import as_csv

T: Array = np.asarray(0.01 * np.arange(2000), dtype=np.float64)
"""20 s at 100 Hz."""


def log(path: Path, t: np.ndarray, rows: np.ndarray, **changed: np.ndarray) -> Path:
    """Some rows of a smooth motion."""
    draw = np.random.default_rng(0)
    speed, phase = draw.uniform(1.0, 2.0, 6), draw.uniform(0.0, 6.0, 6)
    angle = np.outer(T, speed) + phase
    signals = {"t": t, "q": np.sin(angle), "qd": speed * np.cos(angle), "tau": np.cos(angle)} | changed
    return as_csv(path, {kind: values[rows] for kind, values in signals.items()})


def without(*missing: slice) -> np.ndarray:
    keep = np.ones(len(T), dtype=bool)
    for part in missing:
        keep[part] = False
    return keep


@pytest.mark.parametrize("seed", range(5))
def test_one_percent_of_packets_lost_is_no_gap(tmp_path: Path, arm: Robot, seed: int) -> None:
    lost = np.random.default_rng(seed).uniform(size=len(T)) < 0.01
    (whole,) = read_recordings(log(tmp_path / "a.csv", T, ~lost), arm)
    assert len(whole.t) == len(T) - lost.sum()
    (note,) = whole.notes
    assert f"{lost[1:-1].sum()} rows are missing" in note
    assert "interpolated" in note


def test_0_22_s_missing_is_a_gap(tmp_path: Path, arm: Robot) -> None:
    """The cut-off of this arm is 5 Hz, of which half a period is 0.1 s."""
    path = log(tmp_path / "a.csv", T, without(slice(900, 921)))
    first, second = read_recordings(path, arm)
    assert second.t[0] - first.t[-1] == pytest.approx(0.22)
    assert len(first.t) + len(second.t) == len(T) - 21
    assert first.fingerprint != second.fingerprint
    assert "split at 1 gap (after 8.99 s; 0.22 s at most) into 2 pieces" in first.notes[0]
    assert "(0 to 8.99 s)" in first.source
    with pytest.raises(InputError, match="read_recordings gives them"):
        read_recording(path, arm)


@pytest.mark.parametrize(("cutoff", "longest"), [(5.0, 0.1), (20.0, 0.05), (2.0, 0.25), (None, 0.05)])
@pytest.mark.parametrize("over", [False, True])
def test_both_sides_of_the_threshold(cutoff: float | None, longest: float, over: bool) -> None:
    """Five median steps, or half a period of the cut-off, whichever is longer."""
    t = T + (longest - 0.01 + (1e-6 if over else -1e-6)) * (T >= 9.995)
    assert len(pieces(t, cutoff, "log")[0]) == 1 + over


def test_the_cut_off_that_is_asked_for_counts(tmp_path: Path, arm: Robot) -> None:
    path = log(tmp_path / "a.csv", T, without(slice(900, 921)))
    assert len(read_recordings(path, arm, processing=Processing(cutoff=2.0))) == 1


@pytest.mark.parametrize("rows", [1, 150])
def test_what_is_short_before_a_gap_is_left_out(tmp_path: Path, arm: Robot, rows: int) -> None:
    (rest,) = read_recordings(log(tmp_path / "a.csv", T, without(slice(rows, rows + 300))), arm)
    assert len(rest.t) == len(T) - 300 - rows
    assert "1 shorter than 2 s left out" in rest.notes[0]
    assert read_recording(tmp_path / "a.csv", arm).fingerprint == rest.fingerprint


def test_speeds_that_are_zero_are_taken_from_positions(tmp_path: Path, arm: Robot) -> None:
    path = log(tmp_path / "a.csv", T, without(), qd=np.zeros((len(T), 6)))
    recording = read_recording(path, arm)
    assert recording.qd is None
    assert "speeds of joint 1, 2, 3, 4, 5, 6 are zero throughout: taken from positions" in recording.notes[0]


@pytest.mark.parametrize(
    ("scale", "start", "unit"),
    [(1e3, 0.0, "ms"), (1e6, 0.0, "us"), (1e9, 0.0, "ns"), (1e9, 1.7e18, "ns"), (1.0, 1.7e9, "")],
)
def test_units_of_time_are_found_out(tmp_path: Path, arm: Robot, scale: float, start: float, unit: str) -> None:
    recording = read_recording(log(tmp_path / "a.csv", start + T * scale, without()), arm)
    assert np.allclose(recording.t, T, atol=1e-6)
    assert (f"time is in {unit}" in " ".join(recording.notes)) == bool(unit)


def test_an_index_is_named(tmp_path: Path, arm: Robot) -> None:
    path = log(tmp_path / "a.csv", np.arange(2000.0), without())
    with pytest.raises(InputError, match=r"counts by ones: --units t=500Hz .* --units t=ms for milliseconds"):
        read_recording(path, arm)
    for flag, step in (("t=100Hz", 0.01), ("t=ms", 0.001)):
        recording = read_recording(path, arm, None, with_flags(LogMap(), units=[flag]))
        assert np.allclose(np.diff(recording.t), step)


def test_time_with_too_few_digits_is_refused(tmp_path: Path, arm: Robot) -> None:
    with pytest.raises(InputError, match=r"time does not advance in 9\d % of the rows: write more digits"):
        read_recording(log(tmp_path / "a.csv", np.floor(T), without()), arm)


RX90 = load_robot("rx90")
KINDS = ("q", "qd", "qdd")


def header(*kinds: str, n: int = 6) -> list[str]:
    return ["t", *(f"{kind}{j}" for kind in kinds for j in range(1, n + 1))]


def written(path: Path, names: list[str], rows: int = 5) -> Path:
    table = np.arange(rows * len(names), dtype=float).reshape(rows, -1)
    table[:, 0] = 0.01 * np.arange(rows)
    np.savetxt(path, table, delimiter=",", header=",".join(names), comments="")
    return path


@pytest.mark.parametrize("columns", [1, 2, 3])
def test_what_stands_there_is_read(tmp_path: Path, columns: int) -> None:
    t, *signals = read_trajectory(written(tmp_path / "m.csv", header(*KINDS[:columns])), RX90)
    assert np.array_equal(t, 0.01 * np.arange(5))
    for k, values in enumerate(signals):
        assert (values is not None) == (k < columns)
        if values is not None:
            assert np.array_equal(values[0], np.arange(1 + 6 * k, 7 + 6 * k))


def test_what_is_no_trajectory_is_refused(tmp_path: Path) -> None:
    for name, names, rows, words in (
        ("few", header("q", n=5), 5, "column q6 is missing"),
        ("some", [*header("q"), "qd1"], 5, "column qd2, qd3"),
        ("many", header("q", n=7), 5, "column 'q7', robot 'rx90' has 6 joints"),
        ("short", header("q"), 1, "1 rows of numbers"),
    ):
        with pytest.raises(InputError, match=words):
            read_trajectory(written(tmp_path / f"{name}.csv", names, rows), RX90)
    path = written(tmp_path / "late.csv", header("q"))
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:3], lines[1], *lines[3:]]))
    with pytest.raises(InputError, match=r"line 4, column 't': time runs backwards"):
        read_trajectory(path, RX90)


HEADER = ["t"] + [f"{kind}{j}" for kind in ("q", "tau") for j in range(1, 7)]
Write = Callable[..., Path]


def table(rows: int = 50) -> np.ndarray:
    values = np.random.default_rng(0).uniform(-1.0, 1.0, (rows, 13))
    values[:, 0] = 0.01 * np.arange(rows)
    return values


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Write a CSV file; ``edit`` changes its lines."""

    def writer(
        header: list[str] = HEADER,
        values: np.ndarray | None = None,
        edit: Callable[[list[str]], None] = lambda lines: None,
    ) -> Path:
        values = table() if values is None else values
        lines = [",".join(header)] + [",".join(f"{v:.9g}" for v in row) for row in values]
        edit(lines)
        path = tmp_path / "log.csv"
        path.write_text("\n".join(lines) + "\n")
        return path

    return writer


def test_column_order_does_not_matter_and_others_are_listed_once(write: Write, rx90: Robot) -> None:
    values = np.hstack([table(), np.ones((50, 2))])
    order = np.random.default_rng(1).permutation(15)
    header = [*HEADER, "temperature", "mode"]
    recording = read_recording(write([header[k] for k in order], values[:, order]), rx90)
    assert np.allclose(recording.torque, table()[:, 7:], atol=1e-8)
    assert len(recording.notes) == 1
    assert "temperature" in recording.notes[0]
    assert "mode" in recording.notes[0]


def cell(line: int, column: int, text: str) -> Callable[[list[str]], None]:
    """Replace a cell; lines as an editor counts them."""

    def edit(lines: list[str]) -> None:
        cells = lines[line - 1].split(",")
        cells[column] = text
        lines[line - 1] = ",".join(cells)

    return edit


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (cell(8, 12, "inf"), ["line 8", "'tau6'"]),
        (cell(8, 3, "1e308"), ["line 8", "'q3'", "too large a number"]),
        (cell(8, 3, "-2e30"), ["too large"]),
        (cell(10, 5, ""), ["line 10", "'q5'"]),
        (cell(51, 2, "1.5 Nm"), ["line 51", "'q2'"]),
        (lambda lines: lines.__setitem__(4, "1,2,3"), ["line 5", "'q3'"]),
        (lambda lines: lines.__delitem__(0), ["line 1 has numbers", "header"]),
        (cell(1, 3, "Q3"), ["'Q3' looks like 'q3'", "rename"]),
        (cell(1, 3, "q_3"), ["'q_3' looks like 'q3'"]),
        (cell(1, 9, "torque3"), ["'torque3' looks like 'tau3'"]),
        (cell(1, 9, "tau03"), ["'tau03' looks like 'tau3'"]),
        (cell(1, 0, "clock"), ["column t is missing"]),
        (cell(1, 9, "load"), ["tau3 is missing"]),
        (cell(1, 9, "tau2"), ["'tau2'", "twice"]),
        (cell(1, 9, "tau7"), ["'tau7'", "6 joints", "right robot"]),
    ],
)
def test_bad_files_are_named(
    write: Write, rx90: Robot, edit: Callable[[list[str]], None], words: list[str]
) -> None:
    path = write(edit=edit)
    with pytest.raises(InputError) as caught:
        read_recording(path, rx90)
    message = str(caught.value)
    assert "\n" not in message
    for word in [str(path), *words]:
        assert word in message


def test_bad_cells_in_columns_that_are_not_used_do_not_matter(write: Write, rx90: Robot) -> None:
    values = np.hstack([table(), np.ones((50, 1))])
    path = write([*HEADER, "note"], values, edit=cell(5, 13, "warm-up"))
    assert len(read_recording(path, rx90).t) == 50


def test_some_speeds_missing(write: Write, rx90: Robot) -> None:
    path = write([*HEADER, "qd1"], np.hstack([table(), np.ones((50, 1))]))
    with pytest.raises(InputError, match="qd2, qd3, qd4, qd5, qd6 are missing"):
        read_recording(path, rx90)


CURRENTS = [name.replace("tau", "i") for name in HEADER]


@pytest.mark.parametrize(
    ("header", "gains", "words"),
    [
        (CURRENTS, None, "give --drive-gains, 6 numbers"),
        (CURRENTS, [1.0] * 5, "5 numbers, the robot has 6"),
        (CURRENTS, [1.0, 1.0, 0.0, 1.0, 1.0, 1.0], "gain 3 is 0"),
        (CURRENTS, [1.0, 1.0, float("nan"), 1.0, 1.0, 1.0], "gain 3 is nan"),
        (HEADER, [1.0] * 6, "no currents"),
    ],
)
def test_drive_gains(write: Write, rx90: Robot, header: list[str], gains: list[float] | None, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_recording(write(header), rx90, gains)


def test_files_that_cannot_be_read(tmp_path: Path, rx90: Robot) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_recording(tmp_path / "none.csv", rx90)
    bad = tmp_path / "bad.csv.gz"
    bad.write_bytes(b"t,q1\n1,2\n")
    with pytest.raises(InputError, match="cannot be read"):
        read_recording(bad, rx90)
    binary = tmp_path / "binary.csv"
    binary.write_bytes(bytes(range(256)) * 4)
    with pytest.raises(InputError, match="is not a text file"):
        read_recording(binary, rx90)
    cut = tmp_path / "cut.csv.gz"
    cut.write_bytes(gzip.compress(b"t,q1\n" + b"1,2\n" * 1000)[:-20])
    with pytest.raises(InputError):
        read_recording(cut, rx90)
