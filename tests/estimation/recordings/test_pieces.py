"""Time: gaps, units of time, pieces that are left, and planned motions from files."""

from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs import read_recordings, read_trajectory
from dynident.apps.logs.read import read_recording
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation.signals.rows import longest_step, pieces
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
    assert longest_step(T, cutoff) == pytest.approx(longest)
    t = T + (longest - 0.01 + (1e-3 if over else -1e-3)) * (T >= 9.995)
    assert len(pieces(t, cutoff, "log").rows) == 1 + over


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
    from dynident.apps.logs import with_flags
    from dynident.apps.logs.map import LogMap

    path = log(tmp_path / "a.csv", np.arange(2000.0), without())
    with pytest.raises(InputError, match=r"counts by ones: --units t=500Hz .* --units t=ms for milliseconds"):
        read_recording(path, arm)
    for flag, step in (("t=100Hz", 0.01), ("t=ms", 0.001)):
        recording = read_recording(path, arm, None, with_flags(LogMap(), units=[flag]))
        assert np.allclose(np.diff(recording.t), step)


def test_time_with_too_few_digits_is_refused(tmp_path: Path, arm: Robot) -> None:
    with pytest.raises(InputError, match=r"time stands still in 9\d % of the rows: write it with more digits"):
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
