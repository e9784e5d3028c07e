"""``check`` without ``--robot``: what fits, what to mend first, and no log that it does not survive."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from dynident.model import Robot, load_robot
from dynident.tests.commands.typed import answered, typed
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


def survives(content: bytes, name: str) -> None:
    Path("log.csv").write_bytes(content)
    ended = typed("check log.csv --details")
    assert ended.status in (0, 1, 2), f"{name}: {ended.errors}"
    assert len(ended.errors) == (ended.status == 2), f"{name}: {ended.errors}"
    assert ended.status == 2 or "Good:" in ended.out or "Mend first:" in ended.out, name


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(1, 9))])
def test_it_survives_every_log(here: Path, seed: int) -> None:
    for name, content in mutants(16, seed):
        survives(content, name)


@pytest.mark.parametrize(
    "content", [b"", b"\n", b",", b"t", b"\x00" * 100, b"\xff\xfe", b"t,q1\n", b"#\n#\n", b"{}", b"sep=;"]
)
def test_it_survives_next_to_nothing(here: Path, content: bytes) -> None:
    survives(content, repr(content))


@pytest.mark.long
def test_robots_that_fit_are_told(here: Path) -> None:
    """Joints' number, their names and ranges say which; the one that recorded it is among them."""
    sheet = sheet_of(LAYOUTS["plain columns"], ARMS["panda"], signals(ARMS["panda"], 600, 0.01))
    (here / "log.csv").write_bytes(_text(_lines(sheet)))
    document, text = answered("check log.csv", status=(0, 1))
    assert "no --robot is given" in text
    assert document["robot"] is None
    names = {fit["robot"] for fit in document["fits"][0]["fitting"]}
    assert "panda" in names
    assert not {"ur10e", "rx90"} & names


def test_a_log_of_no_robot_says_what_is_in_it(here: Path) -> None:
    (here / "log.csv").write_text("t,x,y\n" + "".join(f"{0.01 * k},1,2\n" for k in range(100)))
    ended = typed("check log.csv --details")
    assert ended.status == 1
    assert "columns t, x, y Mend first:" in ended.text
    assert "missing" in ended.out


@pytest.mark.long
def test_gaps_are_told_and_the_longest_piece_is_looked_at(here: Path) -> None:
    sheet = sheet_of(LAYOUTS["plain columns"], ARMS["ur10e"], signals(ARMS["ur10e"], 2000, 0.01))
    rows = np.delete(sheet.rows, slice(700, 722), axis=0)
    (here / "log.csv").write_bytes(_text(_lines(sheet._replace(rows=rows))))
    _, text = answered("check log.csv --robot ur10e", status=(0, 1))
    assert "split at 1 gap" in text
    assert "(7.22 to 19.99 s)" in text
