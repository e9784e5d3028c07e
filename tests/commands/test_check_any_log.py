"""``check`` without ``--robot``: what fits, what to mend first, and no log that it does not survive."""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from dynident.model import Robot, load_robot
from dynident.tests.commands.runs import Run
from dynident.tests.estimation.recordings.dialects import DIALECTS, LAYOUTS, _lines, _text, sheet_of

ARMS = {name: load_robot(name) for name in ("ur10e", "panda")}
JUNK = ["", "nan", "inf", "-", "1e400", "1,5", "x", '"', "0x10", "1_0", "\ufeff", "[3]", ";;", "\t", "#"]


def signals(robot: Robot, rows: int = 60, step: float = 0.008) -> dict[str, np.ndarray]:
    """A smooth motion whose speeds are its slopes, with torques that an arm may have."""
    t = step * np.arange(rows)
    draw = np.random.default_rng(0)
    speed, phase = draw.uniform(0.5, 1.0, robot.n), draw.uniform(0.0, 6.0, robot.n)
    angle = np.outer(t, speed) + phase
    low, high = np.array([joint.limits.position for joint in robot.joints]).T
    middle = 0.5 * (np.maximum(low, -6.0) + np.minimum(high, 6.0))
    return {"t": t, "position": middle + 0.3 * np.sin(angle), "velocity": 0.3 * speed * np.cos(angle),
            "torque": 20.0 * np.cos(angle)}  # fmt: skip


def mutants(count: int, seed: int) -> Iterator[tuple[str, bytes]]:
    """Logs of every dialect and layout with one thing wrong."""
    draw = np.random.default_rng(seed)
    titles, dialects = list(LAYOUTS), list(DIALECTS)
    for number in range(count):
        title, dialect = titles[number % len(titles)], dialects[int(draw.integers(len(dialects)))]
        robot = ARMS["panda" if "Franka" in title else "ur10e"]
        content = bytearray(DIALECTS[dialect][0](sheet_of(LAYOUTS[title], robot, signals(robot))))
        kind = int(draw.integers(6))
        if kind == 0:  # bytes
            for place in draw.integers(len(content), size=int(draw.integers(1, 20))):
                content[place] = int(draw.integers(256))
        elif kind == 1:  # cut
            del content[int(draw.integers(len(content))) :]
        elif kind == 2:  # a stretch twice
            start, stop = sorted(draw.integers(len(content), size=2))
            content[start:start] = content[start:stop]
        elif kind == 3:  # a stretch missing
            start = int(draw.integers(len(content)))
            del content[start : start + int(draw.integers(1, 2000))]
        elif kind == 4:  # junk in the place of cells
            for _ in range(int(draw.integers(1, 5))):
                place = int(draw.integers(len(content)))
                content[place : place + int(draw.integers(0, 9))] = JUNK[int(draw.integers(len(JUNK)))].encode()
        else:  # lines in another order
            lines = bytes(content).split(b"\n")
            first = int(draw.integers(len(lines)))
            lines[first:] = [lines[first:][k] for k in draw.permutation(len(lines) - first)]
            content = bytearray(b"\n".join(lines))
        yield f"{number}: {title}, {dialect}, {kind}", bytes(content)


def survives(run: Run, path: Path, name: str) -> None:
    status, out, err = run("check", str(path))
    lines = [line for line in err.splitlines() if not line.startswith("dynident: note:")]
    assert status in (0, 1, 2), f"{name}: {lines}"
    if status == 2:
        assert len(lines) == 1, f"{name}: {lines}"
    else:
        assert lines == [], name
        assert "Good:" in out or "Mend first:" in out, name


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(1, 9))])
def test_it_survives_every_log(run: Run, tmp_path: Path, seed: int) -> None:
    for name, content in mutants(16, seed):
        (tmp_path / "log.csv").write_bytes(content)
        survives(run, tmp_path / "log.csv", name)


@pytest.mark.parametrize(
    "content", [b"", b"\n", b",", b"t", b"\x00" * 100, b"\xff\xfe", b"t,q1\n", b"#\n#\n", b"{}", b"sep=;"]
)
def test_it_survives_next_to_nothing(run: Run, tmp_path: Path, content: bytes) -> None:
    (tmp_path / "log.csv").write_bytes(content)
    survives(run, tmp_path / "log.csv", repr(content))


@pytest.mark.long
def test_robots_that_fit_are_told(run: Run, tmp_path: Path) -> None:
    """Joints' number, their names and ranges say which; the one that recorded it is among them."""
    robot = ARMS["panda"]
    data = signals(robot, 600, 0.01)
    sheet = sheet_of(LAYOUTS["plain columns"], robot, data)
    path, target = tmp_path / "log.csv", tmp_path / "check.json"
    path.write_bytes(_text(_lines(sheet)))
    status, out, _ = run("check", str(path), "--json", str(target))
    assert status in (0, 1)
    assert "no --robot is given" in " ".join(out.split())
    document = json.loads(target.read_text())
    assert document["robot"] is None
    (fits,) = document["fits"]
    assert "panda" in [fit["robot"] for fit in fits["fitting"]]
    assert not {"ur10e", "rx90"} & {fit["robot"] for fit in fits["fitting"]}


def test_a_log_of_no_robot_says_what_is_in_it(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t,x,y\n" + "".join(f"{0.01 * k},1,2\n" for k in range(100)))
    status, out, _ = run("check", str(path))
    assert status == 1
    assert "columns t, x, y Mend first:" in " ".join(out.split())
    assert "missing" in out


def test_how_it_is_mounted_belongs_to_a_robot(run: Run, tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("t,q1\n0,1\n")
    status, _, err = run("check", str(tmp_path / "log.csv"), "--mount", "wall")
    assert status == 2
    assert "--mount belongs to --robot" in err


@pytest.mark.long
def test_gaps_are_told_and_the_longest_piece_is_looked_at(run: Run, tmp_path: Path) -> None:
    robot = ARMS["ur10e"]
    sheet = sheet_of(LAYOUTS["plain columns"], robot, signals(robot, 2000, 0.01))
    rows = np.delete(sheet.rows, slice(700, 722), axis=0)
    (tmp_path / "log.csv").write_bytes(_text(_lines(sheet._replace(rows=rows))))
    status, out, err = run("check", str(tmp_path / "log.csv"), "--robot", "ur10e")
    assert status in (0, 1)
    assert "split at 1 gap" in err
    assert "(7.22 to 19.99 s)" in " ".join(out.split())
