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
from .known import NAMED, PLAIN, Known, Recognised, recognised, time_column, time_unit
from .map import LogMap
from .quantity import QUANTITIES, REFERENCES, standard_pose
from .table import RawLog, listed, repeated

_ALIASES = {
    "time": "t", "timestamp": "t", "position": "q", "pos": "q", "velocity": "qd", "vel": "qd", "speed": "qd",
    "dq": "qd", "qdot": "qd", "torque": "tau", "tq": "tau", "current": "i", "cur": "i",
}  # fmt: skip


class Columns(NamedTuple):
    """Names of the columns that are used, and what to tell the user about the choice.

    ``time`` is empty where the log has a rate instead, ``time_unit`` where it is to be found out;
    ``velocity`` where it has none; ``load`` are torques or, with ``kind`` "current", currents.
    """

    time: str
    time_unit: str
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

    @cached_property
    def layout(self) -> Recognised | None:
        """The recorder whose columns these are, where it is known."""
        return recognised(self.raw.names)

    @property
    def known(self) -> Known:
        """The table of columns that counts: the recorder's, or that of plain logs."""
        if self.raw.joints or (self.log_map.joints and not (self.layout and self.layout.known.by_name)):
            return NAMED
        return self.layout.known if self.layout else PLAIN

    def columns(self, kind: str) -> tuple[str, ...]:
        """Names that the columns of a quantity or reference must have, one for each joint."""
        named = listed(
            (self.log_map.reference(kind) if kind in REFERENCES else self.log_map.quantity(kind)).columns
        )
        if len(named) == 1 and "{" in named[0]:
            return self._expanded(named[0])
        if named:
            return named
        known = self.known
        patterns = known.columns.get(kind) or PLAIN.columns[kind]
        candidates = [self._expanded(pattern) for pattern in patterns]
        return next((names for names in candidates if set(names) & set(self.raw.names)), candidates[0])

    @property
    def time(self) -> str:
        """The column of time; empty where the log has a rate instead."""
        if self.log_map.time.rate is not None:
            return ""
        return self.log_map.time.column or time_column(self.raw.names, self.known)

    @property
    def time_unit(self) -> str:
        """The unit of time by the log map or the column's name; empty where the times themselves must show it."""
        return self.log_map.time.unit or self.raw.units.get(self.time, "") or time_unit(self.time, self.known)

    def holds(self, kind: str) -> bool:
        """Whether the log has some of these columns."""
        return bool(set(self.columns(kind)) & set(self.raw.names))

    @cached_property
    def joints(self) -> tuple[str, ...]:
        """Joint names in the robot's order; a log's own order (often alphabetical) proves nothing.

        Raises:
            InputError: if the log names joints whose order is not known.
        """
        names = self.raw.joints or (self.layout.joints if self.layout else ())
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
        joints = self.joints if "{joint}" in pattern else ()
        if "{joint}" in pattern and not joints:
            raise InputError(
                f"{self.log_map.source}: columns {pattern!r}: name the joints by joints = [...] or --joints"
            )
        layout = self.layout or Recognised(PLAIN, (), (), 0)
        if "*" in pattern and len(layout.prefixes) > 1:
            raise InputError(
                f"{self.raw.path}: holds several arms or topics ({', '.join(layout.prefixes)}): name one's columns "
                "in a log map"
            )
        return layout.expanded(pattern, joints, self.robot.n)


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
        if name.endswith(own[0]) and all(f"{prefix}{ending}" in names for ending in own):
            yield tuple(f"{prefix}{ending}" for ending in own)


def choose(raw: RawLog, log_map: LogMap, robot: Robot, gains: Sequence[float] | None) -> Columns:
    """Choose columns.

    Raises:
        InputError: names what is missing, doubtful or there twice.
    """
    naming = Naming(raw, log_map, robot)
    kind, notes = _load(naming, gains)
    speeds = naming.holds("velocity") or log_map.velocity.columns
    velocity = naming.columns("velocity") if speeds else ()
    chosen = Columns(
        naming.time, naming.time_unit, naming.columns("position"), velocity, naming.columns(kind), kind, ()
    )
    if not any(log_map.quantity(kind).columns for kind in QUANTITIES):
        notes = [*_check_layout(naming), *notes]
    if twice := repeated([name for name in raw.names if name in chosen.all]):
        raise InputError(f"{raw.path}: column {twice!r} stands in the header twice: rename one")
    check_missing(raw, chosen.all)
    return chosen._replace(notes=(*notes, *_ignored(raw, log_map, chosen)))


def _ignored(raw: RawLog, log_map: LogMap, chosen: Columns) -> Iterator[str]:
    """What to tell of columns that are neither chosen nor a pose's."""
    pose = log_map.pose or standard_pose(raw.names)
    used = (*chosen.all, *(pose.all if pose else ()))
    if ignored := [name for name in raw.names if name not in used]:
        yield f"columns not used: {_listed(ignored)}"


def _check_layout(naming: Naming) -> list[str]:
    """What to tell the user about columns that were recognised.

    Raises:
        InputError: if they are of another number of joints, or near-misses of plain columns.
    """
    raw, robot, layout, known = naming.raw, naming.robot, naming.layout, naming.known
    if known is PLAIN:
        _check_near_misses(raw, robot)
    if layout is None or layout.known is not known or known in (PLAIN, NAMED):
        return []
    if layout.size > robot.n and not known.by_name and not known.more:
        raise InputError(
            f"{raw.path}: holds {layout.size} joints ({known.title}), but robot {robot.name!r} has {robot.n}: is "
            "it the right robot?"
        )
    return [f"columns of: {known.title}"]


def _load(naming: Naming, gains: Sequence[float] | None) -> tuple[str, list[str]]:
    """Whether torques or currents are used, and what to tell the user about the choice."""
    raw, n = naming.raw, naming.robot.n
    torques, currents = naming.columns("torque"), naming.columns("current")
    if gains is None:
        if not naming.holds("torque") and not naming.holds("current"):
            _check_computed(naming)
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
    return "current", ["has torques too; currents and drive gains are used"] * both


def _check_computed(naming: Naming) -> None:
    """Refuse the controller's own prediction in the place of a measured torque.

    Raises:
        InputError: if the log has nothing else.
    """
    computed = naming.columns("torque_reference") if naming.known is not PLAIN else ()
    if computed and set(computed) <= set(naming.raw.names):
        raise InputError(
            f"{naming.raw.path}: {computed[0]} and so on are what the controller computes, not what was measured: "
            f"record {naming.columns('current')[0]} and so on as well"
        )


def _check_near_misses(raw: RawLog, robot: Robot) -> None:
    patterns = [PLAIN.columns[kind][0] for kind in QUANTITIES]
    known = {"t"} | {pattern.replace("{}", str(j)) for pattern in patterns for j in range(1, robot.n + 1)}
    time = time_column(raw.names, PLAIN)
    for name in raw.names:
        if name in known or name == time:
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


def check_missing(raw: RawLog, columns: Sequence[str]) -> None:
    """Refuse a log without some columns."""
    missing = [name for name in columns if name not in raw.names]
    if not missing:
        return
    free = [name for name in raw.names if name not in columns]
    close = difflib.get_close_matches(missing[0], free, 1, 0.75)
    hint = f" (is it {close[0]!r}?)" if close else ""
    raise InputError(
        f"{raw.path}: column {', '.join(missing)} missing{hint}; found {_listed(raw.names)}: log "
        "them, or name yours in a --log-map"
    )


def _listed(names: Sequence[str]) -> str:
    """Names in a row, those that are numbered on as "i1 .. i7"."""
    words, k = list[str](), 0
    while k < len(names):
        stem, first = _numbered(names[k])
        count = 1
        while k + count < len(names) and _numbered(names[k + count]) == (stem, first + count):
            count += 1
        words += [f"{names[k]} .. {names[k + count - 1]}"] if count > 2 else names[k : k + count]
        k += count
    return ", ".join(words) if len(words) <= 60 else f"{', '.join(words[:60])} and {len(words) - 60} more"


def _numbered(name: str) -> tuple[str, int]:
    """What stands before the number at a name's end, and the number; -1 where there is none."""
    stem = name.rstrip("0123456789")
    return stem, int(name[len(stem) :] or -1)
