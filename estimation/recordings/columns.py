"""Which columns of a log are used, by standard names, patterns or joint names; near misses are errors."""

import difflib
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from ...common.errors import InputError
from ...model import Robot
from .map import LogMap
from .quantity import REFERENCES, standard_pose
from .table import RawLog, listed, repeated

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
    def all(self) -> tuple[str, ...]:
        """Time, positions, speeds, torques or currents."""
        return (*((self.time,) if self.time else ()), *self.position, *self.velocity, *self.load)


@dataclass(frozen=True)
class Naming:
    """What the columns of one log are called, by its map, its own joint names, or the standard."""

    raw: RawLog
    log_map: LogMap
    robot: Robot

    def columns(self, kind: str) -> tuple[str, ...]:
        """Names that the columns of a quantity or reference must have, one for each joint."""
        reference = REFERENCES.get(kind)
        named = listed((self.log_map.reference(kind) if reference else self.log_map.quantity(kind)).columns)
        if len(named) == 1 and "{" in named[0]:
            return self._expanded(named[0])
        if named:
            return named
        if reference or not self.joints:
            prefix = f"{_STANDARD[reference]}ref" if reference else _STANDARD[kind]
            return tuple(f"{prefix}{j}" for j in range(1, self.robot.n + 1))
        candidates = [self._expanded(pattern) for pattern in _BY_NAME[kind]]
        return next((names for names in candidates if set(names) & set(self.raw.names)), candidates[0])

    def holds(self, kind: str) -> bool:
        """Whether the log has some of these columns."""
        return bool(set(self.columns(kind)) & set(self.raw.names))

    @cached_property
    def joints(self) -> tuple[str, ...]:
        """Joint names in the robot's order; a log's own order (often alphabetical) proves nothing.

        Raises:
            InputError: if the log names joints whose order cannot be told.
        """
        names = self.raw.joints
        if self.log_map.joints or not names:
            return listed(self.log_map.joints)
        known = (*self.robot.joint_names, *((self.robot.links.joints,) if self.robot.links else ()))
        orders = {ordered for own in known for ordered in _as_known(names, own)}
        ordered = orders.pop() if len(orders) == 1 else _by_number(names, self.robot.n)
        if ordered:
            return ordered
        raise InputError(
            f"{self.raw.path}: names joints {', '.join(names)}: give the {self.robot.n} of the robot from base to "
            "tip by --joints"
        )

    def _expanded(self, pattern: str) -> tuple[str, ...]:
        joints = self.joints
        if "{joint}" in pattern and not joints:
            raise InputError(
                f"{self.log_map.source}: columns {pattern!r}: name the joints by joints = [...] or --joints"
            )
        return tuple(
            pattern.replace("{joint}", joints[j] if joints else "").replace("{}", str(j + 1)).replace("{0}", str(j))
            for j in range(self.robot.n)
        )


def _by_number(names: Sequence[str], n: int) -> tuple[str, ...]:
    """The names in the order of the numbers that they end in, where those are 1 to n or 0 to n - 1; else none."""
    ends = {name: re.search(r"(\d+)$", name) for name in names}
    numbers = {int(match[1]): name for name, match in ends.items() if match}
    first = min(numbers, default=0)
    if first not in (0, 1) or sorted(numbers) != list(range(first, first + n)) or len(names) != n:
        return ()
    return tuple(numbers[k] for k in sorted(numbers))


def _as_known(names: Sequence[str], own: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """A log's joints in the order of an arm's own names, for each prefix under which it has all of them."""
    for name in names:
        prefix = name.removesuffix(own[0])
        if name.endswith(own[0]) and all(f"{prefix}{other}" in names for other in own):
            yield tuple(f"{prefix}{other}" for other in own)


def choose(raw: RawLog, log_map: LogMap, robot: Robot, gains: Sequence[float] | None) -> Columns:
    """Choose columns.

    Raises:
        InputError: names what is missing, doubtful or there twice.
    """
    if repeated(raw.names):
        raise InputError(f"{raw.path}: column {repeated(raw.names)!r} stands in the header twice: rename one")
    naming = Naming(raw, log_map, robot)
    kind, notes = _load(naming, gains)
    speeds = naming.holds("velocity") or log_map.velocity.columns
    velocity = naming.columns("velocity") if speeds else ()
    chosen = Columns(log_map.time.column, naming.columns("position"), velocity, naming.columns(kind), kind, ())
    if not naming.joints and not any(log_map.quantity(kind).columns for kind in _STANDARD):
        _check_near_misses(raw, robot)
    check_missing(raw, chosen.all)
    pose = log_map.pose or standard_pose(raw.names)
    ignored = [name for name in raw.names if name not in (*chosen.all, *(pose.all if pose else ()))]
    if ignored:
        notes.append(f"{raw.path.name}: columns not used: {_listed(ignored)}")
    return chosen._replace(notes=tuple(notes))


def _load(naming: Naming, gains: Sequence[float] | None) -> tuple[str, list[str]]:
    """Whether torques or currents are used, and what to tell the user about the choice."""
    raw, n = naming.raw, naming.robot.n
    torques, currents = naming.columns("torque"), naming.columns("current")
    if gains is None:
        if not naming.holds("torque") and naming.holds("current"):
            raise InputError(
                f"{raw.path}: carries currents ({currents[0]}..{currents[-1]}) but no torques: "
                f"give --drive-gains, {n} numbers in N·m/A"
            )
        return "torque", []
    if len(gains) != n:
        raise InputError(f"--drive-gains has {len(gains)} numbers, the robot has {n} joints: give one per joint")
    for joint, gain in enumerate(gains, 1):
        if not math.isfinite(gain) or gain == 0.0:
            raise InputError(f"--drive-gains: gain {joint} is {gain}: give a number other than zero in N·m/A")
    if not naming.holds("current"):
        raise InputError(
            f"{raw.path}: --drive-gains given, but the file has no currents "
            f"{currents[0]}..{currents[-1]}: leave them out"
        )
    both = set(torques) <= set(raw.names)
    return "current", [f"{raw.path.name}: has torques too; currents and drive gains are used"] * both


def _check_near_misses(raw: RawLog, robot: Robot) -> None:
    known = {"t"} | {f"{prefix}{j}" for prefix in _STANDARD.values() for j in range(1, robot.n + 1)}
    for name in raw.names:
        if name in known:
            continue
        meant = _meant(name)
        if meant in known and (meant not in raw.names or meant == name.strip().lower()):
            raise InputError(f"{raw.path}: column {name!r} looks like {meant!r}: rename it, or give a log map")
        if re.fullmatch(r"(q|qd|tau|i)(\d+)", name):
            joints = f"robot {robot.name!r} has {robot.n} joints"
            raise InputError(f"{raw.path}: column {name!r}, but {joints}: is it the right robot?")


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
    free = [name for name in raw.names if name not in wanted]
    close = difflib.get_close_matches(missing[0], free, 1, 0.75)
    hint = f" (is it {close[0]!r}?)" if close else ""
    raise InputError(f"{raw.path}: column {', '.join(missing)} missing{hint}; found {_listed(raw.names)}")


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) <= 60 else f"{', '.join(names[:60])} and {len(names) - 60} more"
