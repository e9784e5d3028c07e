"""Planned motions from files: with positions alone, speeds or accelerations too, or refused with the reason."""

from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs import read_trajectory
from dynident.common.errors import InputError
from dynident.model import load_robot

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
    table = read_trajectory(written(tmp_path / "m.csv", header(*KINDS[:columns])), RX90)
    assert np.array_equal(table.t, 0.01 * np.arange(5))
    for k, values in enumerate((table.q, table.qd, table.qdd)):
        assert (values is not None) == (k < columns)
        if values is not None:
            assert np.array_equal(values[0], np.arange(1 + 6 * k, 7 + 6 * k))


def test_other_columns_are_left(tmp_path: Path) -> None:
    table = read_trajectory(written(tmp_path / "m.csv", [*header("q"), "tau1", "note"]), RX90)
    assert table.q.shape == (5, 6)


def test_what_is_no_trajectory_is_refused(tmp_path: Path) -> None:
    for name, names, rows, words in (
        ("few", header("q", n=5), 5, "column q6 missing"),
        ("some", [*header("q"), "qd1"], 5, "column qd2, qd3"),
        ("many", header("q", n=7), 5, "column 'q7', but robot 'rx90' has 6 joints"),
        ("short", header("q"), 1, "1 rows of numbers"),
    ):
        with pytest.raises(InputError, match=words):
            read_trajectory(written(tmp_path / f"{name}.csv", names, rows), RX90)
    path = written(tmp_path / "late.csv", header("q"))
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:3], lines[1], *lines[3:]]))
    with pytest.raises(InputError, match=r"line 4, column 't': time runs back"):
        read_trajectory(path, RX90)
