"""Which of the shipped robots a log can be of, where nobody says it."""

from pathlib import Path
from typing import NamedTuple

from ...common.errors import InputError
from ...estimation.fit.least_squares import weighted
from ...model import Recording, Robot, load_robot, robot_names
from ...model.drives import Coupling
from .columns import Columns, Naming, choose
from .log_check import mistakes, reduced
from .map import LogMap
from .read import open_log, read_recordings
from .table import RawLog


class RobotFit(NamedTuple):
    """A robot that a log can be of; ``residual``: what its model leaves of the torque, None if not known."""

    robot: str
    residual: float | None


class RobotFits(NamedTuple):
    """The shipped robots beside one log.

    ``fitting``: robots that it can be of, the likeliest first; ``others``: those with as many joints that do not
    fit, and why; ``columns`` of the log; ``fault``: why it is no robot's, empty where some fit.
    """

    columns: tuple[str, ...]
    fitting: tuple[RobotFit, ...]
    others: tuple[tuple[str, str], ...]
    fault: str


class _Taken(NamedTuple):
    """A log as one robot's columns give it, and whether its torques are currents."""

    recording: Recording
    currents: bool


_Key = tuple[Columns, Coupling | None]


def robot_fits(path: str | Path, log_map: LogMap | None = None) -> RobotFits:
    """Try all shipped robots on a log.

    Args:
        path: the file or folder.
        log_map: which columns, units, side and signs.

    Raises:
        InputError: if the log cannot be opened at all.
    """
    log_map = log_map or LogMap()
    raw = open_log(path, log_map)
    read: dict[_Key, _Taken | str] = {}
    fitting: list[RobotFit] = []
    others: list[tuple[str, str]] = []
    faults: list[str] = []
    for name in robot_names():
        robot = load_robot(name)
        try:
            reading = _taken(raw, robot, log_map, read)
        except InputError as refusal:
            faults.append(str(refusal))
            continue
        wrong = mistakes(robot, reading.recording, reading.currents)
        if wrong:
            others.append((name, wrong[0]))
        else:
            fitting.append(RobotFit(name, _residual(robot, reading)))
    fitting.sort(key=lambda fit: (fit.residual is None, fit.residual or 0.0))
    fault = "" if fitting else f"{path}: {others[0][1]}" if others else _first_fault(faults)
    return RobotFits(raw.names, tuple(fitting), tuple(others), fault)


def _taken(raw: RawLog, robot: Robot, log_map: LogMap, read: dict[_Key, _Taken | str]) -> _Taken:
    """The log by one robot's columns, its longest piece; read once for all robots of the same columns.

    Raises:
        InputError: if it cannot be read so.
    """
    log_map.check(robot.n)
    naming = Naming(raw, log_map, robot)
    currents = naming.holds("current") and not naming.holds("torque")
    gains = [1.0] * robot.n if currents else None
    columns = choose(raw, log_map, robot, gains)
    key = columns, robot.coupling if currents else None
    if key not in read:
        try:
            pieces = read_recordings(raw.path, robot, gains, log_map)
            read[key] = _Taken(max(pieces, key=lambda piece: float(piece.t[-1] - piece.t[0])), currents)
        except InputError as refusal:
            read[key] = str(refusal)
    reading = read[key]
    if isinstance(reading, str):
        raise InputError(reading)
    return reading


def _residual(robot: Robot, reading: _Taken) -> float | None:
    """Relative residual of the robot's own model; None where there is too little motion."""
    try:
        return weighted(reduced(robot, reading.recording, robot.processing, reading.currents)[1]).fit.relative
    except InputError:
        return None


def _first_fault(faults: list[str]) -> str:
    """What most robots' columns meet: faults of the file come before those of the number of joints."""
    return min(faults, key=lambda fault: ("missing" in fault or "joints" in fault, -faults.count(fault)))
