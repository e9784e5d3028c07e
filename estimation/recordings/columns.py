"""Which columns of a log are used, by standard names, patterns or joint names; near misses are errors."""

import difflib
import math
import re
from collections.abc import Sequence
from typing import NamedTuple

from ...common.errors import InputError
from ...model import Robot
from .mapping import REFERENCES, LogMap
from .pose_columns import standard_pose
from .table import RawLog

_STANDARD = {"position": "q", "velocity": "qd", "torque": "tau", "current": "i"}
_BY_NAME = {
    "position": ("{joint}.position", "{joint}_position", "{joint}_pos", "q_{joint}", "position_{joint}"),
    "velocity": ("{joint}.velocity", "{joint}_velocity", "{joint}_vel", "qd_{joint}", "velocity_{joint}"),
    "torque": ("{joint}.effort", "{joint}_effort", "{joint}_torque", "tau_{joint}", "effort_{joint}"),
    "current": ("{joint}.current", "{joint}_current", "i_{joint}", "current_{joint}"),
}
_ALIASES = {
    "time": "t", "timestamp": "t", "position": "q", "pos": "q", "velocity": "qd", "vel": "qd", "speed": "qd",
    "dq": "qd", "qdot": "qd", "torque": "tau", "tq": "tau", "current": "i", "cur": "i",
}  # fmt: skip


class Columns(NamedTuple):
    """Names of the columns that are used, and what to tell the user about the choice.

    ``time`` is empty where the log has a rate instead; ``velocity`` where it has none; ``load`` are torques or,
    with ``kind`` "current", currents.
    """

    time: str
    position: tuple[str, ...]
    velocity: tuple[str, ...]
    load: tuple[str, ...]
    kind: str
    notes: tuple[str, ...]

    @property
    def wanted(self) -> tuple[str, ...]:
        """All of them."""
        return (*((self.time,) if self.time else ()), *self.position, *self.velocity, *self.load)


def choose(raw: RawLog, log_map: LogMap, robot: Robot, gains: Sequence[float] | None) -> Columns:
    """Choose columns.

    Raises:
        InputError: names what is missing, doubtful or there twice.
    """
    path, n = raw.path, robot.n
    twice = sorted({name for name in raw.names if raw.names.count(name) > 1})
    if twice:
        raise InputError(f"{path}: column {twice[0]!r} stands in the header twice: rename one")
    joints = _joints(raw, log_map, robot)
    names = {kind: _names(raw, log_map, kind, n, joints) for kind in _STANDARD}
    there = {kind: bool(set(columns) & set(raw.names)) for kind, columns in names.items()}
    kind, notes = _load(raw, log_map, n, gains, names, there)
    velocity = names["velocity"] if there["velocity"] or log_map.told("velocity") else ()
    chosen = Columns(log_map.time, names["position"], velocity, names[kind], kind, ())
    if not joints and not any(log_map.told(each) for each in _STANDARD):
        _check_near_misses(raw, robot, n)
    check_missing(raw, chosen.wanted)
    pose = log_map.pose or standard_pose(raw.names)
    ignored = [name for name in raw.names if name not in (*chosen.wanted, *(pose.all if pose else ()))]
    if ignored:
        notes.append(f"{path.name}: columns not used: {_listed(ignored)}")
    return chosen._replace(notes=tuple(notes))


def currents_only(raw: RawLog, log_map: LogMap, robot: Robot) -> bool:
    """Whether a log carries currents but no torques."""
    joints = _joints(raw, log_map, robot)
    torques, currents = (_names(raw, log_map, kind, robot.n, joints) for kind in ("torque", "current"))
    return bool(set(currents) & set(raw.names)) and not set(torques) & set(raw.names)


def position_columns(raw: RawLog, log_map: LogMap, robot: Robot) -> tuple[str, ...]:
    """Names that the columns of joint positions must have."""
    return _names(raw, log_map, "position", robot.n, _joints(raw, log_map, robot))


def reference_columns(raw: RawLog, log_map: LogMap, robot: Robot, kind: str) -> tuple[str, ...]:
    """Names that the columns of what the controller wanted must have; ``kind``: of ``REFERENCES``."""
    told = log_map.reference(kind).columns
    if len(told) == 1 and "{" in told[0]:
        return _expanded(told[0], robot.n, _joints(raw, log_map, robot), log_map.source)
    return told or tuple(f"{_STANDARD[REFERENCES[kind]]}ref{j}" for j in range(1, robot.n + 1))


def holds_load(raw: RawLog, log_map: LogMap, robot: Robot) -> bool:
    """Whether a log carries torques or currents."""
    joints = _joints(raw, log_map, robot)
    loads = {name for kind in ("torque", "current") for name in _names(raw, log_map, kind, robot.n, joints)}
    return bool(loads & set(raw.names))


def _joints(raw: RawLog, log_map: LogMap, robot: Robot) -> tuple[str, ...]:
    """Joint names in the robot's order; a log's own order (often alphabetical) proves nothing."""
    if log_map.joints or not raw.joints:
        return log_map.joints
    ends = {name: re.search(r"(\d+)$", name) for name in raw.joints}
    numbers = {int(match[1]): name for name, match in ends.items() if match}
    if sorted(numbers) == list(range(1, robot.n + 1)) and len(raw.joints) == robot.n:
        return tuple(numbers[k] for k in sorted(numbers))
    raise InputError(
        f"{raw.path}: names joints {', '.join(raw.joints)}: give the {robot.n} of the robot from base to tip by "
        "--joints"
    )


def _names(raw: RawLog, log_map: LogMap, kind: str, n: int, joints: Sequence[str]) -> tuple[str, ...]:
    """The names that columns of one quantity must have."""
    told = log_map.quantity(kind).columns
    if len(told) == 1 and "{" in told[0]:
        return _expanded(told[0], n, joints, log_map.source)
    if told:
        return told
    if not joints:
        return tuple(f"{_STANDARD[kind]}{j}" for j in range(1, n + 1))
    candidates = [_expanded(pattern, n, joints, log_map.source) for pattern in _BY_NAME[kind]]
    return next((names for names in candidates if set(names) & set(raw.names)), candidates[0])


def _expanded(pattern: str, n: int, joints: Sequence[str], source: str) -> tuple[str, ...]:
    if "{joint}" in pattern and not joints:
        raise InputError(f"{source}: columns {pattern!r}: name the joints by joints = [...] or --joints")
    return tuple(
        pattern.replace("{joint}", joints[j] if joints else "").replace("{}", str(j + 1)).replace("{0}", str(j))
        for j in range(n)
    )


def _load(
    raw: RawLog,
    log_map: LogMap,
    n: int,
    gains: Sequence[float] | None,
    names: dict[str, tuple[str, ...]],
    there: dict[str, bool],
) -> tuple[str, list[str]]:
    """Whether torques or currents are used, and what to tell the user about the choice."""
    if gains is None:
        if not there["torque"] and there["current"]:
            raise InputError(
                f"{raw.path}: carries currents ({names['current'][0]}..{names['current'][-1]}) but no torques: "
                f"give --drive-gains, {n} numbers in N·m/A"
            )
        return "torque", []
    if len(gains) != n:
        raise InputError(f"--drive-gains has {len(gains)} numbers, the robot has {n} joints: give one per joint")
    for joint, gain in enumerate(gains, 1):
        if not math.isfinite(gain) or gain == 0.0:
            raise InputError(f"--drive-gains: gain {joint} is {gain}: give a number other than zero in N·m/A")
    if not there["current"]:
        raise InputError(
            f"{raw.path}: --drive-gains given, but the file has no currents "
            f"{names['current'][0]}..{names['current'][-1]}: leave them out"
        )
    both = set(names["torque"]) <= set(raw.names)
    return "current", [f"{raw.path.name}: has torques too; currents and drive gains are used"] * both


def _check_near_misses(raw: RawLog, robot: Robot, n: int) -> None:
    known = {"t"} | {f"{prefix}{j}" for prefix in _STANDARD.values() for j in range(1, n + 1)}
    for name in raw.names:
        if name in known:
            continue
        meant = _meant(name)
        if meant in known and (meant not in raw.names or meant == name.strip().lower()):
            raise InputError(f"{raw.path}: column {name!r} looks like {meant!r}: rename it, or give a log map")
        if re.fullmatch(r"(q|qd|tau|i)(\d+)", name):
            raise InputError(
                f"{raw.path}: column {name!r}, but robot {robot.name!r} has {n} joints: is it the right robot?"
            )


def _meant(name: str) -> str:
    """The known name that a header entry most likely stands for, or the entry itself."""
    plain = re.sub(r"[\[(].*?[\])]|[^a-z0-9]", "", name.lower())
    match = re.fullmatch(r"([a-z]+?)0*(\d*)", plain)
    if not match:
        return name
    return _ALIASES.get(match[1], match[1]) + match[2]


def check_missing(raw: RawLog, wanted: Sequence[str]) -> None:
    """Refuse a log without some columns.

    Raises:
        InputError: names them.
    """
    missing = [name for name in wanted if name not in raw.names]
    if not missing:
        return
    close = difflib.get_close_matches(missing[0], raw.names, 1, 0.75)
    hint = f" (is it {close[0]!r}?)" if close else ""
    raise InputError(f"{raw.path}: column {', '.join(missing)} missing{hint}; found {_listed(raw.names)}")


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) <= 60 else f"{', '.join(names[:60])} and {len(names) - 60} more"
