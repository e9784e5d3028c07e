"""Reading CSV: what is accepted, and one clear line for everything else."""

import gzip
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs.read import read_recording
from dynident.common.errors import InputError
from dynident.model import Robot

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
        name: str = "log.csv",
    ) -> Path:
        values = table() if values is None else values
        lines = [",".join(header)] + [",".join(f"{v:.9g}" for v in row) for row in values]
        edit(lines)
        path = tmp_path / name
        data = ("\n".join(lines) + "\n").encode()
        path.write_bytes(gzip.compress(data) if name.endswith(".gz") else data)
        return path

    return writer


@pytest.mark.parametrize("name", ["log.csv", "log.csv.gz"])
def test_plain_and_gzip(write: Write, rx90: Robot, name: str) -> None:
    recording = read_recording(write(name=name), rx90)
    assert np.allclose(recording.t, table()[:, 0])
    assert np.allclose(recording.q, table()[:, 1:7], atol=1e-8)
    assert np.allclose(recording.torque, table()[:, 7:], atol=1e-8)
    assert recording.qd is None
    assert recording.notes == ()


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
        (cell(7, 3, "nan"), ["line 7", "'q3'", "'nan'"]),
        (cell(8, 12, "inf"), ["line 8", "'tau6'"]),
        (cell(8, 3, "1e308"), ["line 8", "'q3'", "too large a number"]),
        (cell(8, 3, "-2e30"), ["too large"]),
        (cell(9, 0, "abc"), ["line 9", "'t'", "'abc'"]),
        (cell(10, 5, ""), ["line 10", "'q5'"]),
        (cell(51, 2, "1.5 Nm"), ["line 51", "'q2'"]),
        (lambda lines: lines.__setitem__(4, "1,2,3"), ["line 5", "'q3'"]),
        (lambda lines: lines.insert(20, lines[3]), ["line 21", "time runs back"]),
        (lambda lines: lines.__delitem__(slice(1, None)), ["0 rows"]),
        (lambda lines: lines.__delitem__(slice(0, None)), ["is empty"]),
        (lambda lines: lines.__delitem__(0), ["line 1 holds numbers", "header"]),
        (cell(1, 3, "Q3"), ["'Q3' looks like 'q3'", "rename"]),
        (cell(1, 3, "q_3"), ["'q_3' looks like 'q3'"]),
        (cell(1, 9, "torque3"), ["'torque3' looks like 'tau3'"]),
        (cell(1, 9, "tau03"), ["'tau03' looks like 'tau3'"]),
        (cell(1, 0, "clock"), ["column t missing"]),
        (lambda lines: lines.__setitem__(4, lines[4] + ",1"), ["line 5 has 14 cells, the header 13 names"]),
        (cell(1, 9, "load"), ["tau3 missing"]),
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
    with pytest.raises(InputError, match="qd2, qd3, qd4, qd5, qd6 missing"):
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
    with pytest.raises(InputError, match="not UTF-8 text: save it as UTF-8"):
        read_recording(binary, rx90)
    cut = tmp_path / "cut.csv.gz"
    cut.write_bytes(gzip.compress(b"t,q1\n" + b"1,2\n" * 1000)[:-20])
    with pytest.raises(InputError):
        read_recording(cut, rx90)
