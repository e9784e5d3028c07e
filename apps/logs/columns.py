"""Columns of a log, and which are used: of recorders that are known, standard names, patterns, names of joints.

One table serves text, arrays, Parquet and bags alike; near misses of its names are errors.
"""

import difflib
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, product
from pathlib import Path

import numpy as np

from ...common import Array, InputError
from ...model import Robot
from .map import LONGEST_NAME, QUANTITIES, LogMap, ToolColumns, listed

_TIME = re.compile(r"(?:t|time|timestamp|time_?stamp|stamp|__time)(?:_(s|sec|ms|msec|us|ns|nsec))?", re.IGNORECASE)
_SUFFIXES = {"sec": "s", "msec": "ms", "nsec": "ns"}
_HUGE = 1e30  # a time in nanoseconds is 2e18
_ALIASES = {
    "time": "t", "timestamp": "t", "position": "q", "pos": "q", "velocity": "qd", "vel": "qd", "speed": "qd",
    "dq": "qd", "qdot": "qd", "torque": "tau", "tq": "tau", "current": "i", "cur": "i",
}  # fmt: skip


@dataclass(eq=False)
class RawLog:
    """A log that is open for reading, its numbers as they stand there."""

    path: Path  # file or folder
    names: tuple[str, ...]  # of all its columns
    read: Callable[[Sequence[str]], Array]  # gives all rows of the columns that are asked for, in that order
    place: Callable[[int], str] = lambda row: f"row {row + 1}"  # tells where a row stands; rows count from 0
    joints: tuple[str, ...] = ()  # names, where the format has them
    units: Mapping[str, str] = field(default_factory=dict)  # of columns, where the file names them
    notes: list[str] = field(default_factory=list)  # on how it was read; after its rows were read, on these too
    gain_sigma: float | None = None  # relative error of its torques' scale, where the file tells it

    def __post_init__(self) -> None:
        if longest := next((name for name in self.names if len(name) > LONGEST_NAME), ""):
            where = f"{self.path}: the column name that begins {longest[:20]!r} has {len(longest)} characters"
            raise InputError(f"{where}: is the first line a header? give short names")

    def whole(self, columns: Sequence[str]) -> Array:
        """All rows of the columns, rows x ``len(columns)``; refused where one is no time, place or torque."""
        values = np.ascontiguousarray(self.read(columns))
        if not (good := np.abs(values) < _HUGE).all():
            row, column = np.argwhere(~good)[0]
            bad = values[row, column]
            fault = f"{bad} is {'too large a number' if np.isfinite(bad) else 'not a finite number'}"
            where = f"{self.path}: {self.place(int(row))}, column {columns[column]!r}"
            raise InputError(f"{where}: {fault}: correct or remove the row")
        return values


@dataclass(frozen=True)
class Known:
    """Columns that one recorder writes, and what a log holds of them.

    Of each quantity and reference the first pattern that the log has is taken: "{}" stands for a joint's number,
    "{0}" for the number less one, "{joint}" for its name, a first "*" for anything.
    """

    title: str  # whose they are
    forms: str  # of columns, in which "@" stands for any of a quantity's names
    names: Mapping[str, str]  # of each quantity and reference
    time: tuple[str, ...] = ()  # names of the column of time, where it has none of the usual ones
    time_unit: str = ""  # of that column; empty: it is found out
    more: bool = False  # columns beyond the robot's joints are a gripper's
    prefixes: tuple[str, ...] = ()  # what the "*" of a log's positions stands for, several for several arms alike
    joints: tuple[str, ...] = ()  # names in the log's order, none where columns are numbered
    size: int = 0  # joints that have a position in the log

    @cached_property
    def columns(self) -> dict[str, tuple[str, ...]]:
        """Patterns of each quantity's and reference's columns."""
        each = {kind: product(names.split(), self.forms.split()) for kind, names in self.names.items()}
        return {kind: tuple(form.replace("@", name) for name, form in pairs) for kind, pairs in each.items()}

    def expanded(self, pattern: str, joints: Sequence[str], n: int) -> tuple[str, ...]:
        """Names of the columns of n joints."""
        pattern = pattern.replace("*", self.prefixes[0] if self.prefixes else "", 1)
        named = (pattern.replace("{joint}", joints[j] if joints else "") for j in range(n))
        return tuple(name.replace("{}", str(j + 1)).replace("{0}", str(j)) for j, name in enumerate(named))


_SHORT = {"position": "q", "velocity": "qd", "torque": "tau", "current": "i"}
_FRANKA = {"position": "q", "velocity": "dq", "torque": "tau_J", "position_reference": "q_d"}
_RTDE = {
    "position": "actual_q", "velocity": "actual_qd", "torque": "actual_current_as_torque",
    "current": "actual_current", "position_reference": "target_q", "torque_reference": "target_moment",
}  # fmt: skip
_LEROBOT = {
    "position": "state position", "velocity": "velocity joint_velocities",
    "torque": "effort torque joint_torques", "current": "current",
}  # fmt: skip
PLAIN = Known("plain columns", "@{}", {**_SHORT, "position_reference": "qref", "torque_reference": "tauref"})
"""Columns of a log that follows the documentation."""
NAMED = Known(
    "columns by joint",
    "@",
    {
        "position": "{joint}.position {joint}_position {joint}_pos q_{joint} position_{joint}",
        "velocity": "{joint}.velocity {joint}_velocity {joint}_vel qd_{joint} velocity_{joint}",
        "torque": "{joint}.effort {joint}.torque {joint}_effort {joint}_torque tau_{joint} effort_{joint}",
        "current": "{joint}.current {joint}_current i_{joint} current_{joint}",
    },
)
"""Columns of a log whose joints have names, as in a ROS bag."""
KNOWN = (
    PLAIN,
    Known("columns counted from 0", "@{0} @_{0}", _SHORT),
    Known("Universal Robots, RTDE", "@_{0}", _RTDE),
    Known("Franka, libfranka", "state.@[{0}] @[{0}]", _FRANKA, time=("time", "duration"), time_unit="ms"),
    Known("Franka, arrays of its state", "@{}", _FRANKA),
    Known("Franka, PlotJuggler", "*franka_states/@[{0}] *franka_states/@.{0}", _FRANKA),
    Known(
        "ROS joint states, PlotJuggler",
        "*joint_states/{joint}/@ *measured_joint_state/{joint}/@",
        {"position": "position", "velocity": "velocity", "torque": "effort"},
    ),
    Known("LeRobot data set", "observation.@{}", _LEROBOT, more=True),
    NAMED,
)
"""Every recorder whose columns are known; of two that fit alike the first counts."""


def recognised(names: Sequence[str]) -> Known:
    """The recorder most of whose quantities a log has; plain columns where no positions are known."""
    best, most, there, number = PLAIN, 0, set(names), r"(?P<joint>\d+)"
    marks = {r"\*": "(?P<prefix>.*)", r"\{joint\}": "(?P<joint>[^/]+)", r"\{0\}": number, r"\{\}": number}
    for known in KNOWN:
        for pattern in known.columns["position"]:
            text, named, first = re.escape(pattern), "{joint}" in pattern, 0 if "{0}" in pattern else 1
            for mark, group in marks.items():
                text = text.replace(mark, group)
            arms: dict[str, list[str]] = {"": []}
            for match in filter(None, (re.fullmatch(text, name) for name in names)):
                arms.setdefault(match.groupdict().get("prefix") or "", []).append(match["joint"])
            joints = max(arms.values(), key=len)
            size = next(k for k in range(len(joints) + 1) if str(first + k) not in joints)
            size = len(joints) if named else size
            # A single name is none of a joint; numbers that begin before the first joint's are others.
            if size <= named or (not named and str(first - 1) in joints):
                continue
            prefixes = tuple(prefix for prefix, own in arms.items() if len(own) == len(joints))
            layout = replace(known, prefixes=prefixes, joints=tuple(joints) if named else (), size=size)
            kinds = sum(
                any(there >= set(layout.expanded(own, layout.joints, size)) for own in patterns)
                for patterns in known.columns.values()
            )
            best, most = (layout, kinds) if kinds > most else (best, most)
            break
    return best


def time_column(names: Sequence[str], known: Known) -> str:
    """The column of time: "t", else what the recorder calls it, else a usual name; "t" where there is none."""
    usual = (name for name in names if _TIME.fullmatch(name.strip()))
    return next((name for name in ("t", *known.time, *usual) if name in names), "t")


@dataclass(frozen=True)
class Naming:
    """Names of the columns of one log, by its map, its own joint names, or the standard."""

    raw: RawLog
    log_map: LogMap
    robot: Robot

    @cached_property
    def known(self) -> Known:
        """The table of columns that counts: the recorder's, or that of plain logs."""
        known = recognised(self.raw.names)
        if self.raw.joints or (self.log_map.joints and not known.joints):
            return replace(NAMED, prefixes=known.prefixes, joints=known.joints)
        return known

    def columns(self, kind: str) -> tuple[str, ...]:
        """Names that the columns of a quantity or reference must have, one for each joint."""
        named = listed(self.log_map.quantity(kind).columns)
        if named and (len(named) > 1 or "{" not in named[0]):
            return named
        prefixes, candidates = self.known.prefixes, []
        for pattern in named or self.known.columns.get(kind) or PLAIN.columns[kind]:
            joints = self.joints if "{joint}" in pattern else ()
            if "{joint}" in pattern and not joints:
                raise InputError(f"{self.log_map.source}: {pattern!r}: name the joints: joints = [...], --joints")
            if "*" in pattern and len(prefixes) > 1:
                several = f"has several arms or topics ({', '.join(prefixes)})"
                raise InputError(f"{self.raw.path}: {several}: name one's columns in a log map")
            candidates.append(self.known.expanded(pattern, joints, self.robot.n))
        return next((names for names in candidates if set(names) & set(self.raw.names)), candidates[0])

    @property
    def pose(self) -> ToolColumns | None:
        """Columns of the tool's pose by the map, else x, y, z [m], perhaps with qx, qy, qz, qw; None without."""
        place, turn, there = ("x", "y", "z"), ("qx", "qy", "qz", "qw"), set(self.raw.names)
        turned = ToolColumns(place, "m", turn, "quaternion") if there >= set(turn) else ToolColumns(place)
        return self.log_map.pose or (turned if there >= set(place) else None)

    @cached_property
    def time(self) -> tuple[str, str]:
        """The column of time, empty where the log has a rate, and its unit, empty where the times must show it.

        The unit is the map's, else the file's, the one in the column's name, or the recorder's.
        """
        own = self.log_map.time
        column = "" if own.rate is not None else own.column or time_column(self.raw.names, self.known)
        match = _TIME.fullmatch(column.strip())
        by_name = _SUFFIXES.get(match[1].lower(), match[1].lower()) if match and match[1] else ""
        by_recorder = self.known.time_unit if column in self.known.time else ""
        return column, own.unit or self.raw.units.get(column, "") or by_name or by_recorder

    def holds(self, kind: str) -> bool:
        """True where the log has some of these columns; those that are said to hold currents are no torques."""
        others = set(listed(self.log_map.current.columns)) if kind == "torque" else set[str]()
        return not (set(self.columns(kind)) - others).isdisjoint(self.raw.names)

    @property
    def holds_currents_only(self) -> bool:
        """True where the log carries currents but no torques."""
        return self.holds("current") and not self.holds("torque")

    @cached_property
    def joints(self) -> tuple[str, ...]:
        """Joint names in the robot's order; a log's own order (often alphabetical) proves nothing."""
        names = self.raw.joints or self.known.joints
        if self.log_map.joints or not names:
            return listed(self.log_map.joints)
        known = (*self.robot.joint_names, *((self.robot.links.joints,) if self.robot.links else ()))
        orders = {
            tuple(f"{prefix}{ending}" for ending in own)
            for own in known
            for prefix in (name.removesuffix(own[0]) for name in names if name.endswith(own[0]))
            if all(f"{prefix}{ending}" in names for ending in own)
        }
        if len(orders) == 1:
            return orders.pop()
        # Else the numbers that the names end in, where those are 1 to n or 0 to n - 1, give the order.
        n, numbers = self.robot.n, {int(match[1]): name for name in names if (match := re.search(r"(\d+)$", name))}
        if len(names) == n and sorted(numbers) in (list(range(n)), list(range(1, n + 1))):
            return tuple(numbers[k] for k in sorted(numbers))
        advice = f"give the {n} of the robot from base to tip by --joints"
        raise InputError(f"{self.raw.path}: names joints {', '.join(names)}: {advice}")


def choose(naming: Naming, gains: Sequence[float] | None) -> tuple[dict[str, tuple[str, ...]], list[str]]:
    """Choose columns, and say what is to be told of the choice.

    Names stand by quantity: time, unless the log has a rate instead, positions, speeds where there are any, and
    last torques or currents.
    """
    raw, log_map, robot, known = naming.raw, naming.log_map, naming.robot, naming.known
    n, currents, notes, is_plain = robot.n, naming.columns("current"), list[str](), known.names is PLAIN.names
    named = f"{currents[0]}..{currents[-1]}"
    if gains is None:
        if naming.holds_currents_only:
            fault = f"has currents ({named}) but no torques: give --drive-gains, {n} numbers in N·m/A"
            by = "'dynident gains' identifies them, 'dynident check' estimates them from the weight of the links"
            raise InputError(f"{raw.path}: {fault} ({by})")
        # The controller's own prediction does not stand in the place of a measured torque.
        computed = () if is_plain or naming.holds("torque") else naming.columns("torque_reference")
        if computed and set(raw.names) >= set(computed):
            fault = f"{computed[0]} and so on are what the controller computes, not what was measured"
            raise InputError(f"{raw.path}: {fault}: record {currents[0]} and so on as well")
    else:
        if len(gains) != n:
            raise InputError(
                f"--drive-gains has {len(gains)} numbers, the robot has {n} joints: give one per joint"
            )
        wrong = [joint for joint, gain in enumerate(gains) if not math.isfinite(gain) or gain == 0.0]
        if wrong:
            fault = f"gain {wrong[0] + 1} is {gains[wrong[0]]}: give a number other than zero in N·m/A"
            raise InputError(f"--drive-gains: {fault}")
        if not naming.holds("current"):
            raise InputError(
                f"{raw.path}: --drive-gains is given, but the file has no currents {named}: omit the option"
            )
        notes += ["has torques too; currents and drive gains are used"] * naming.holds("torque")
    load = "torque" if gains is None else "current"
    speeds = naming.holds("velocity") or log_map.velocity.columns
    columns = dict[str, tuple[str, ...]]({"time": naming.time[:1]} if naming.time[0] else {})
    columns |= {kind: naming.columns(kind) for kind in ("position", *["velocity"] * bool(speeds), load)}
    by_name = not any(log_map.quantity(kind).columns for kind in QUANTITIES)
    if by_name and not is_plain:
        if known.size > n and not known.joints and not known.more:
            fault = f"holds {known.size} joints ({known.title}), but robot {robot.name!r} has {n}"
            raise InputError(f"{raw.path}: {fault}: is it the right robot?")
        notes = [f"columns of: {known.title}"] * (known.names is not NAMED.names) + notes
    # Near misses of the names of plain columns.
    plain = {"t"}.union(*(PLAIN.expanded(PLAIN.columns[kind][0], (), n) for kind in QUANTITIES))
    exact = {*plain, time_column(raw.names, PLAIN)}
    for name in raw.names if by_name and is_plain else ():
        if name in exact:
            continue
        match = re.fullmatch(r"([a-z]+?)0*(\d*)", re.sub(r"[\[(].*?[\])]|[^a-z0-9]", "", name.lower()))
        meant = _ALIASES.get(match[1], match[1]) + match[2] if match else name
        if meant in plain and (meant not in raw.names or meant == name.strip().lower()):
            raise InputError(f"{raw.path}: column {name!r} looks like {meant!r}: rename it, or give a log map")
        if re.fullmatch(r"(q|qd|tau|i)(\d+)", name):
            joints = f"robot {robot.name!r} has {n} joints"
            raise InputError(f"{raw.path}: column {name!r}, but {joints}: is it the right robot?")
    names = list(chain.from_iterable(columns.values()))
    if twice := [name for name in names if raw.names.count(name) > 1]:
        raise InputError(f"{raw.path}: column {min(twice)!r} is in the header twice: rename one")
    check_missing(raw, names)
    used = {*names, *((*pose.columns, *pose.rotation) if (pose := naming.pose) else ())}
    if ignored := [name for name in raw.names if name not in used]:
        notes = [*notes, f"columns not used: {in_a_row(ignored)}"]
    return columns, notes


def check_missing(raw: RawLog, columns: Sequence[str]) -> None:
    """Refuse a log without some columns."""
    if missing := [name for name in columns if name not in raw.names]:
        close = difflib.get_close_matches(missing[0], [name for name in raw.names if name not in columns], 1, 0.75)
        hint = f" (is it {close[0]!r}?)" if close else ""
        names = f"s {', '.join(missing)} are" if missing[1:] else f" {missing[0]} is"
        advice = "record them, map your column names in a --log-map, or give the --robot that has these joints"
        raise InputError(f"{raw.path}: column{names} missing{hint}; found {in_a_row(raw.names)}: {advice}")


def in_a_row(names: Sequence[str]) -> str:
    """Names in a row, those that are numbered on as "i1 .. i7"."""
    runs: list[list[str]] = []
    for name in names:
        stem = name.rstrip("0123456789")
        if not runs or runs[-1][-1] != f"{stem}{int(name[len(stem) :] or 0) - 1}":
            runs.append([])
        runs[-1].append(name)
    words = [f"{run[0]} .. {run[-1]}" if len(run) > 2 else ", ".join(run) for run in runs]
    return ", ".join(words) if len(words) <= 60 else f"{', '.join(words[:60])} and {len(words) - 60} more"
