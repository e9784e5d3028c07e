"""Reads motion files back, each from its format's documentation alone."""

import csv
import math
import re
import xml.etree.ElementTree as ET
from typing import NamedTuple

import numpy as np
import yaml
from dynident.common.arrays import Array


class Read(NamedTuple):
    """t (N,) [s]; q, qd, qdd (N, n) [rad]; the last two None where the format has none."""

    t: Array
    q: Array
    qd: Array | None = None
    qdd: Array | None = None


def csv_samples(text: str) -> Read:
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(lines))

    def columns(kind: str) -> Array:
        names = [name for name in rows[0] if re.fullmatch(rf"{kind}\d+", name)]
        return np.array([[float(row[name]) for name in names] for row in rows])

    return Read(np.array([float(row["t"]) for row in rows]), columns("q"), columns("qd"), columns("qdd"))


def ros2(text: str) -> tuple[list[str], Read]:
    """trajectory_msgs/msg/JointTrajectory, every field present and of its type."""
    message = yaml.safe_load(text)
    assert set(message) == {"header", "joint_names", "points"}
    assert message["header"] == {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    n, times = len(message["joint_names"]), []
    for point in message["points"]:
        assert set(point) == {"positions", "velocities", "accelerations", "effort", "time_from_start"}
        for field in ("positions", "velocities", "accelerations"):
            assert len(point[field]) == n
            assert all(isinstance(value, float) for value in point[field])
        assert point["effort"] == []
        sec, nanosec = point["time_from_start"]["sec"], point["time_from_start"]["nanosec"]
        assert isinstance(sec, int)
        assert isinstance(nanosec, int)
        assert 0 <= nanosec < 10**9
        times.append(sec + 1e-9 * nanosec)
    fields = (
        np.array([point[name] for point in message["points"]])
        for name in ("positions", "velocities", "accelerations")
    )
    return message["joint_names"], Read(np.array(times), *fields)


class UrProgram(NamedTuple):
    """A URScript program as a controller would run it, line by line."""

    first: Array
    moves: list[tuple[str, dict[str, float]]]
    limits: list[float]
    motion: Read


def urscript(text: str) -> UrProgram:
    """The few statements that the program may have; everything else fails."""
    lines = [line.strip() for line in text.splitlines() if line.strip() and not line.strip().startswith("#")]
    assert lines[0] == "def dynident_motion():"
    assert lines[-2:] == ["end", "dynident_motion()"]
    opened = sum(line.endswith(":") for line in lines)
    assert opened == lines.count("end")
    first, moves, limits, q, steps = np.zeros(0), [], [], [], []
    for line in lines:
        if match := re.fullmatch(r"first = \[(.*)\]", line):
            first = _list(match[1])
        elif match := re.fullmatch(r"if norm\(here\[k\] - first\[k\]\) > (\S+):", line):
            limits.append(float(match[1]))
        elif match := re.fullmatch(r"movej\(first, a=(\S+), v=(\S+)\)", line):
            assert len(limits) == 1, "checked before it moves"
            moves.append(("movej", {"a": float(match[1]), "v": float(match[2])}))
        elif match := re.fullmatch(r"servoj\(\[(.*)\], 0, 0, (\S+), (\S+), (\S+)\)", line):
            assert len(limits) == 2, "checked after the approach"
            assert 0.03 <= float(match[3]) <= 0.2
            assert 100 <= float(match[4]) <= 2000
            q.append(_list(match[1]))
            steps.append(float(match[2]))
        elif match := re.fullmatch(r"stopj\((\S+)\)", line):
            moves.append(("stopj", {"a": float(match[1])}))
        else:
            known = r"def .*:|end|halt|here = get_actual_joint_positions\(\)|k = 0|k = k \+ 1|while k < 6:"
            known += r'|popup\("[^"]*", title="dynident", error=True, blocking=True\)|dynident_motion\(\)'
            assert re.fullmatch(known, line), line
    assert len(set(steps)) == 1
    return UrProgram(first, moves, limits, Read(np.array([k * steps[0] for k in range(len(q))]), np.array(q)))


class Val3(NamedTuple):
    """Joint variables [deg], times at rest and motion descriptors of an application; the code of its programs."""

    points: Array
    holds: Array
    motions: list[dict[str, str]]
    code: dict[str, str]
    remarks: str


def val3(files: dict[str, str]) -> Val3:
    """Project, database and programs, which must fit together."""
    space = "{http://www.staubli.com/robotics/VAL3/"
    roots = {name: ET.fromstring(text.encode()) for name, text in files.items()}
    (project,) = (name for name in files if name.endswith(".pjx"))
    programs = [entry.get("file") for entry in roots[project].iter(space + "Project/3}Program")]
    databases = [entry.get("file") for entry in roots[project].iter(space + "Project/3}Data")]
    assert {project, *programs, *databases} == set(files)
    data = {}
    for entry in roots[str(databases[0])].iter(space + "Data/2}Data"):
        values = sorted(entry, key=lambda value: int(value.get("key", "-1")))
        assert [value.get("key") for value in values] == [str(k) for k in range(int(entry.get("size", "-1")))]
        data[entry.get("name")] = (entry.get("type"), [dict(value.attrib) for value in values])
    assert data["jPoint"][0] == "jointRx"
    assert data["mMotion"][0] == "mdesc"
    points = np.array([[float(value[f"j{j}"]) for j in range(1, 7)] for value in data["jPoint"][1]])
    code = {}
    for name in programs:
        (program,) = roots[str(name)].iter(space + "Program/2}Program")
        (text,) = (part.text or "" for part in program.iter(space + "Program/2}Code"))
        lines = [line for line in text.strip().splitlines() if not line.strip().startswith("//")]
        assert (lines[0], lines[-1]) == ("begin", "end")
        code[str(program.get("name"))] = "\n".join(line.strip() for line in lines)
    variables = set(re.findall(r"\b[jmnt][A-Z]\w*", "\n".join(code.values())))
    assert variables <= set(data), "every variable of the program is declared"
    remarks = "\n".join(re.findall(r"<!--(.*?)-->", files[str(databases[0])], re.DOTALL))
    holds = np.array([float(value["value"]) for value in data.get("nHold", ("num", []))[1]])
    return Val3(points, holds, data["mMotion"][1], code, remarks)


def trapezoid_time(distance: Array, speed: Array, acceleration: Array) -> float:
    """Time of a synchronised move that rests at both ends, shape (n,) each [s]."""
    times = [0.0]
    for d, v, a in zip(distance, speed, acceleration, strict=True):
        times.append(d / v + v / a if d >= v * v / a else 2.0 * math.sqrt(d / a))
    return max(times)


def _list(text: str) -> Array:
    return np.array([float(word) for word in text.split(",")])
