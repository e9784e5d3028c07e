"""Which of the shipped robots a log can be of, where nobody says it."""

from pathlib import Path
from typing import NamedTuple

from ...common.errors import InputError
from ...estimation.fit.least_squares import weighted
from ...model import Recording, Robot, load_robot, robot_names
from .columns import Naming, choose
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
    taken: dict[object, Recording | str] = {}  # read once for all robots of the same columns
    fitting, others, faults = list[RobotFit](), list[tuple[str, str]](), list[str]()
    for robot in map(load_robot, robot_names()):
        try:
            log_map.check(robot.n)
            naming = Naming(raw, log_map, robot)
            currents = naming.holds("current") and not naming.holds("torque")
            gains = [1.0] * robot.n if currents else None
            key = choose(raw, log_map, robot, gains), robot.coupling if currents else None
            if key not in taken:
                taken[key] = _longest(raw, robot, gains, log_map)
            recording = taken[key]
            if isinstance(recording, str):
                raise InputError(recording)
        except InputError as refusal:
            faults.append(str(refusal))
            continue
        wrong = mistakes(robot, recording, currents)
        if wrong:
            others.append((robot.name, wrong[0]))
            continue
        try:
            left = weighted(reduced(robot, recording, robot.processing, currents)[1]).fit.relative
        except InputError:  # too little motion
            left = None
        fitting.append(RobotFit(robot.name, left))
    fitting.sort(key=lambda fit: (fit.residual is None, fit.residual or 0.0))
    fault = ""
    if not fitting and others:
        fault = f"{path}: {others[0][1]}"
    elif (
        not fitting
    ):  # what most robots' columns meet; faults of the file come before those of the number of joints
        fault = min(faults, key=lambda text: ("missing" in text or "joints" in text, -faults.count(text)))
    return RobotFits(raw.names, tuple(fitting), tuple(others), fault)


def _longest(raw: RawLog, robot: Robot, gains: list[float] | None, log_map: LogMap) -> Recording | str:
    """The longest piece of the log by one robot's columns, or why it cannot be read so."""
    try:
        pieces = read_recordings(raw.path, robot, gains, log_map)
    except InputError as refusal:
        return str(refusal)
    return max(pieces, key=lambda piece: float(piece.t[-1] - piece.t[0]))
