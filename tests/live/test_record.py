"""``dynident record ur`` against a player of the protocol, with every fault of controllers and lines."""

import csv
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
from dynident.apps import live
from dynident.cli import main
from dynident.common.errors import InputError
from dynident.tests.live.conftest import Play, Played

FAST = {"pace": 20.0}
"""Time of the played controller runs so much faster than ours."""


def record(player: Played, out: Path, *more: str) -> int:
    return main(["record", "ur", *player.address, "--out", str(out), *more])


def rows_of(path: Path) -> list[list[str]]:
    with path.open() as file:
        return list(csv.reader(file))


def columns(path: Path) -> dict[str, np.ndarray]:
    rows = rows_of(path)
    return dict(zip(rows[0], np.array(rows[1:], dtype=float).T, strict=True))


@pytest.mark.parametrize("rate", [125, 500])
def test_what_is_sent_is_what_is_written(rate: int, play: Play, tmp_path: Path) -> None:
    """Every sample once, in the controller's time, under the protocol's names; nothing was dropped."""
    player, before = play(rate=rate, **FAST), threading.active_count()
    assert record(player, tmp_path / "a.csv", "--seconds", "4") == 0
    assert threading.active_count() == before
    log = columns(tmp_path / "a.csv")
    t = log["timestamp"] - 1000.0
    np.testing.assert_allclose(t, np.arange(4 * rate + 1) / rate, atol=1e-9)
    for j in range(6):
        turn = 0.3 + 0.2 * j
        np.testing.assert_allclose(log[f"actual_q_{j}"], np.sin(turn * t), atol=1e-12)
        np.testing.assert_allclose(log[f"actual_qd_{j}"], turn * np.cos(turn * t), atol=1e-12)
    np.testing.assert_allclose(log["actual_current_as_torque_2"], 6.0 * np.sin(0.7 * t), atol=1e-12)
    assert (log["joint_temperatures_5"] == 35.0).all()
    request = player.events()[0]
    assert request["rate"] == 500.0
    assert set(request["fields"]) == set(live.FIELDS)


@pytest.mark.parametrize("name", ["a.csv", "a.csv.gz", "a.parquet"])
def test_every_format_is_read_again(name: str, play: Play, tmp_path: Path, capsys: Any) -> None:
    if name.endswith("parquet"):
        pytest.importorskip("pyarrow")
    assert record(play(**FAST), tmp_path / name, "--seconds", "3") == 0
    assert main(["check", "--robot", "ur10e", str(tmp_path / name)]) == 0
    out, err = capsys.readouterr()
    assert "Universal Robots, RTDE" in err
    assert "376 samples, 3 s at 125 Hz" in out


@pytest.mark.parametrize(("name", "why"), [("a.txt", "ends in .csv"), ("a", "ends in .csv")])
def test_a_file_that_cannot_be_written_is_refused_first(name: str, why: str, tmp_path: Path, capsys: Any) -> None:
    assert main(["record", "ur", "--host", "127.0.0.1", "--port", "1", "--out", str(tmp_path / name)]) == 2
    assert why in capsys.readouterr().err


BEFORE: dict[str, tuple[dict[str, Any], str]] = {
    "refused": ({"fault": "refused"}, "no connection"),
    "version 1": ({"fault": "version 1"}, "does not speak version 2"),
    "deaf": ({"fault": "deaf"}, "no answer within 2.5 s"),
    "slow": ({"fault": "slow"}, "no answer within 2.5 s"),
    "another protocol": ({"fault": "another protocol"}, "not RTDE"),
    "not started": ({"fault": "not started"}, "does not start"),
    "no positions": ({"absent": ["actual_q"]}, "has no actual_q"),
    "another type": ({"fault": "another type"}, "timestamp comes as INT32 in the place of DOUBLE"),
    "cut at once": ({"fault": "cut", "after": 1}, "closed the connection"),
}
"""Faults before the first sample, and what is said of them."""


@pytest.mark.parametrize("name", BEFORE)
def test_faults_before_the_first_sample(name: str, play: Play, tmp_path: Path, capsys: Any) -> None:
    options, why = BEFORE[name]
    player, threads, begin = play(**options), threading.active_count(), time.monotonic()
    assert record(player, tmp_path / "a.csv") == 2
    assert time.monotonic() - begin < 5.0
    err = capsys.readouterr().err
    assert len(err.splitlines()) == 1
    assert why in err
    assert not list(tmp_path.iterdir())
    assert threading.active_count() == threads


@pytest.fixture
def no_name_server(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A name server that stays silent holds the system's resolver for half a minute."""
    released = threading.Event()
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: released.wait(30.0))
    yield
    released.set()


@pytest.mark.usefixtures("no_name_server")
def test_a_name_that_never_resolves(tmp_path: Path, capsys: Any) -> None:
    begin, why = time.monotonic(), "robot.invalid was not resolved within 2.5 s: give the address"
    assert main(["record", "ur", "--host", "robot.invalid", "--out", str(tmp_path / "a.csv")]) == 2
    assert time.monotonic() - begin < 5.0
    (line,) = capsys.readouterr().err.splitlines()
    assert why in line
    assert not list(tmp_path.iterdir())
    begin = time.monotonic()
    with pytest.raises(InputError, match=why), live.send_program("sec", "robot.invalid"):
        pass
    assert time.monotonic() - begin < 5.0


def test_a_name_that_is_unknown(tmp_path: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(socket, "getaddrinfo", Mock(side_effect=socket.gaierror(-2, "Name or service not known")))
    assert main(["record", "ur", "--host", "robot.invalid", "--out", str(tmp_path / "a.csv")]) == 2
    assert "no connection: Name or service not known" in capsys.readouterr().err


@pytest.mark.parametrize(("step", "why"), [(0.0, "time stopped"), (1e-9, "is no clock")])
def test_a_clock_that_stands_still_ends_by_ours(step: float, why: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """However few samples come."""
    ours = iter(range(1000))
    monkeypatch.setattr(time, "monotonic", lambda: 0.5 * next(ours))
    recorder = live.Recorder(500.0, 3.0)
    kind = np.dtype([(live.TIME, float), (live.POSITION, float, 6)])
    with pytest.raises(InputError, match=why):
        deque((recorder.add(np.array([(7.0 + step * k, 6 * (0.0,))], kind)) for k in range(30)), 0)
    assert recorder.count


AFTER = {
    "silent": "no sample for 2 s",
    "closed": "closed the connection",
    "garbage": "not RTDE",
    "wrong recipe": "not of the size or the recipe",
    "time stands still": "time stopped",
    "time runs back": "time runs back",
    "restarted": "time runs back",
}
"""Faults after two seconds, and what is said of them."""


@pytest.mark.parametrize("fault", AFTER)
def test_faults_on_the_way_leave_what_was_there(fault: str, play: Play, tmp_path: Path, capsys: Any) -> None:
    player, threads, begin = play(fault=fault, after=250, **FAST), threading.active_count(), time.monotonic()
    assert record(player, tmp_path / "a.csv") == 2
    assert time.monotonic() - begin < 5.0
    *notes, last = capsys.readouterr().err.splitlines()
    assert AFTER[fault] in last
    assert "holds the 2.0 s before" in last
    assert all(line.startswith("dynident: note: ") for line in notes)
    assert len(columns(tmp_path / "a.csv")["timestamp"]) == 250
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]
    assert threading.active_count() == threads


def test_a_field_that_is_absent_is_left_out(play: Play, tmp_path: Path, capsys: Any) -> None:
    player = play(absent=["payload_inertia", "actual_current_as_torque"], **FAST)
    assert record(player, tmp_path / "a.csv", "--seconds", "1") == 0
    assert "has no actual_current_as_torque, payload_inertia" in capsys.readouterr().err
    assert not {"payload_inertia_0", "actual_current_as_torque_0"} & set(columns(tmp_path / "a.csv"))
    first, second = player.events()[:2]
    assert set(first["fields"]) - set(second["fields"]) == {"payload_inertia", "actual_current_as_torque"}


def test_dropped_samples_are_counted(play: Play, tmp_path: Path, capsys: Any) -> None:
    """One of ten is missing from the second second on."""
    assert record(play(fault="drops", after=125, **FAST), tmp_path / "a.csv", "--seconds", "4") == 0
    err = capsys.readouterr().err
    t = columns(tmp_path / "a.csv")["timestamp"]
    missing = round(float(np.ptp(t)) * 125) + 1 - len(t)
    assert missing == 38
    assert f"{missing} dropped" in err


@pytest.mark.parametrize("version", [3, 5])
def test_old_controllers_are_asked_for_125(version: int, play: Play, tmp_path: Path) -> None:
    player = play(major=version, **FAST)
    assert record(player, tmp_path / "a.csv", "--seconds", "0.5") == 0
    assert player.events()[0]["rate"] == (125.0 if version == 3 else 500.0)


@pytest.mark.skipif(os.name == "nt", reason="signals are POSIX's")
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_an_interruption_leaves_a_whole_file(how: signal.Signals, play: Play, tmp_path: Path) -> None:
    player, out = play(), tmp_path / "a.csv"
    command = [sys.executable, "-m", "dynident", "record", "ur", *player.address, "--out", str(out)]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    assert player.next()["event"] == "fields"
    time.sleep(1.0)
    process.send_signal(how)
    _, err = process.communicate(timeout=5)
    assert process.returncode == 0, err
    assert "stopped after" in err
    assert len(set(map(len, rows_of(out)))) == 1
    assert len(columns(out)["timestamp"]) > 50


@pytest.mark.long
def test_cut_at_any_byte(play: Play, tmp_path: Path) -> None:
    """One line and status 2, and a file if there was a whole sample; nothing half-written."""
    sample = 3 + 1 + 8 * 52 + 4 * 2
    cuts = [*range(1, 60, 3), *range(500, 500 + 2 * sample, 37)]
    player = play(fault="cut", cuts=cuts, **FAST)
    for cut in cuts:
        out = tmp_path / f"{cut}.csv"
        assert record(player, out, "--quiet") == 2
        if out.exists():
            rows = rows_of(out)
            assert len(rows) > 1
            assert {len(row) for row in rows} == {len(rows[0])}
    assert 5 < len(list(tmp_path.iterdir())) < len(cuts)
