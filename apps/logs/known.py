"""Columns that recorders write, known without a log map: one table for text, arrays, Parquet and bags alike."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

_TIME = re.compile(r"(?:t|time|timestamp|time_?stamp|stamp|__time)(?:_(s|sec|ms|msec|us|ns|nsec))?", re.IGNORECASE)
_SUFFIXES = {"sec": "s", "msec": "ms", "nsec": "ns"}


@dataclass(frozen=True)
class Known:
    """Columns that one recorder writes.

    Attributes:
        title: whose they are.
        columns: of each quantity and reference patterns, the first of which that the log has is taken: "{}" stands
            for a joint's number, "{0}" for the number less one, "{joint}" for its name, a first "*" for anything.
        time: names of the column of time, where it has none of the usual ones.
        time_unit: of that column; empty: it is found out.
        more: whether columns beyond the robot's joints are a gripper's.
    """

    title: str
    columns: Mapping[str, tuple[str, ...]]
    time: tuple[str, ...] = ()
    time_unit: str = ""
    more: bool = field(default=False)

    @property
    def by_name(self) -> bool:
        """Whether the joints' names distinguish the columns."""
        return "{joint}" in self.columns["position"][0]


PLAIN = Known(
    "plain columns",
    {
        "position": ("q{}",),
        "velocity": ("qd{}",),
        "torque": ("tau{}",),
        "current": ("i{}",),
        "position_reference": ("qref{}",),
        "torque_reference": ("tauref{}",),
    },
)
"""What a log holds that follows the documentation."""
NAMED = Known(
    "columns by joint",
    {
        "position": ("{joint}.position", "{joint}_position", "{joint}_pos", "q_{joint}", "position_{joint}"),
        "velocity": ("{joint}.velocity", "{joint}_velocity", "{joint}_vel", "qd_{joint}", "velocity_{joint}"),
        "torque": ("{joint}.effort", "{joint}_effort", "{joint}_torque", "tau_{joint}", "effort_{joint}"),
        "current": ("{joint}.current", "{joint}_current", "i_{joint}", "current_{joint}"),
    },
)
"""What a log holds whose joints have names, as in a ROS bag."""
_FROM_0 = Known(
    "columns counted from 0",
    {
        "position": ("q{0}", "q_{0}"),
        "velocity": ("qd{0}", "qd_{0}"),
        "torque": ("tau{0}", "tau_{0}"),
        "current": ("i{0}", "i_{0}"),
    },
)
_RTDE = Known(
    "Universal Robots, RTDE",
    {
        "position": ("actual_q_{0}",),
        "velocity": ("actual_qd_{0}",),
        "torque": ("actual_current_as_torque_{0}",),
        "current": ("actual_current_{0}",),
        "position_reference": ("target_q_{0}",),
        "torque_reference": ("target_moment_{0}",),
    },
)
_LIBFRANKA = Known(
    "Franka, libfranka",
    {
        "position": ("state.q[{0}]", "q[{0}]"),
        "velocity": ("state.dq[{0}]", "dq[{0}]"),
        "torque": ("state.tau_J[{0}]", "tau_J[{0}]"),
        "position_reference": ("state.q_d[{0}]", "q_d[{0}]"),
    },
    time=("time", "duration"),
    time_unit="ms",
)
_FRANKA_ARRAYS = Known(
    "Franka, arrays of its state",
    {
        "position": ("q{}",),
        "velocity": ("dq{}",),
        "torque": ("tau_J{}",),
        "position_reference": ("q_d{}",),
    },
)
_FRANKA_ROS = Known(
    "Franka, PlotJuggler",
    {
        "position": ("*franka_states/q[{0}]", "*franka_states/q.{0}"),
        "velocity": ("*franka_states/dq[{0}]", "*franka_states/dq.{0}"),
        "torque": ("*franka_states/tau_J[{0}]", "*franka_states/tau_J.{0}"),
        "position_reference": ("*franka_states/q_d[{0}]", "*franka_states/q_d.{0}"),
    },
)
_PLOTJUGGLER = Known(
    "ROS joint states, PlotJuggler",
    {
        "position": ("*joint_states/{joint}/position", "*measured_joint_state/{joint}/position"),
        "velocity": ("*joint_states/{joint}/velocity", "*measured_joint_state/{joint}/velocity"),
        "torque": ("*joint_states/{joint}/effort", "*measured_joint_state/{joint}/effort"),
    },
)
_LEROBOT = Known(
    "LeRobot data set",
    {
        "position": ("observation.state{}", "observation.position{}"),
        "velocity": ("observation.velocity{}", "observation.joint_velocities{}"),
        "torque": ("observation.effort{}", "observation.torque{}", "observation.joint_torques{}"),
        "current": ("observation.current{}",),
    },
    more=True,
)
KNOWN = (PLAIN, _FROM_0, _RTDE, _LIBFRANKA, _FRANKA_ARRAYS, _FRANKA_ROS, _PLOTJUGGLER, _LEROBOT, NAMED)
"""Every recorder whose columns are known; of two that fit alike the first counts."""


class Recognised(NamedTuple):
    """The columns of a log that were recognised.

    ``prefixes``: what the "*" of the positions stands for, several where the log holds several arms alike;
    ``joints``: names in the log's order, none where columns are numbered; ``size``: joints that have a position.
    """

    known: Known
    prefixes: tuple[str, ...]
    joints: tuple[str, ...]
    size: int

    def expanded(self, pattern: str, joints: Sequence[str], n: int) -> tuple[str, ...]:
        """Names of the columns of n joints."""
        prefix = self.prefixes[0] if self.prefixes else ""
        return tuple(
            pattern.replace("*", prefix, 1).replace("{joint}", joints[j] if joints else "")
            .replace("{}", str(j + 1)).replace("{0}", str(j))
            for j in range(n)
        )  # fmt: skip


def recognised(names: Sequence[str]) -> Recognised | None:
    """The recorder most of whose quantities a log has; None for a log without positions that are known."""
    best, most, there = None, 0, set(names)
    for known in KNOWN:
        layout = next(
            filter(None, (_positions(known, pattern, names) for pattern in known.columns["position"])), None
        )
        if layout is None:
            continue
        kinds = sum(
            any(there >= set(layout.expanded(pattern, layout.joints, layout.size)) for pattern in patterns)
            for patterns in known.columns.values()
        )
        if kinds > most:
            best, most = layout, kinds
    return best


def _positions(known: Known, pattern: str, names: Sequence[str]) -> Recognised | None:
    """The joints whose positions follow a pattern; None without a first one, or for a single name."""
    arms: dict[str, list[str]] = {}
    for match in filter(None, map(_compiled(pattern).fullmatch, names)):
        arms.setdefault(match.groupdict().get("prefix") or "", []).append(match["joint"])
    if not arms:
        return None
    most = max(map(len, arms.values()))
    prefixes = tuple(prefix for prefix, joints in arms.items() if len(joints) == most)
    joints = tuple(arms[prefixes[0]])
    if "{joint}" in pattern:
        return Recognised(known, prefixes, joints, most) if most > 1 else None
    count = _counted(joints, 0 if "{0}" in pattern else 1)
    return Recognised(known, prefixes, (), count) if count else None


def _counted(numbers: Sequence[str], first: int) -> int:
    """How many joints are numbered without a gap from ``first`` on; none where the numbers begin before it."""
    if str(first - 1) in numbers:
        return 0
    return next(k for k in range(len(numbers) + 1) if str(first + k) not in numbers)


def _compiled(pattern: str) -> re.Pattern[str]:
    number, text = r"(?P<joint>\d+)", re.escape(pattern)
    marks = {r"\*": "(?P<prefix>.*)", r"\{joint\}": "(?P<joint>[^/]+)", r"\{0\}": number, r"\{\}": number}
    for mark, group in marks.items():
        text = text.replace(mark, group)
    return re.compile(text)


def time_column(names: Sequence[str], known: Known | None) -> str:
    """The column of time: "t", else what the recorder calls it, else a usual name; "t" where there is none."""
    usual = (name for name in names if _TIME.fullmatch(name.strip()))
    candidates = ("t", *(known.time if known else ()), *usual)
    return next((name for name in candidates if name in names), "t")


def time_unit(name: str, known: Known | None) -> str:
    """The unit that a column of time has by its name, "t_ms", or by its recorder; empty where neither says it."""
    match = _TIME.fullmatch(name.strip())
    if match and match[1]:
        return _SUFFIXES.get(match[1].lower(), match[1].lower())
    return known.time_unit if known and name in known.time else ""
