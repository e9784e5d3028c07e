"""Long texts are read as arrays are, and every way to write a number is read."""

from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs import open_log
from dynident.apps.logs.map import LogMap
from dynident.apps.logs.read import read_recording
from dynident.common.errors import InputError
from dynident.model import Robot
from dynident.tests.estimation.recordings.log_files import as_npz


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
