"""Reads a robot from TOML (angles in degrees, everything else in SI units) or from a URDF."""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any, TypeVar

from ...common.errors import InputError
from ..drives import Coupling, Drives, Spring
from ..pose import Pose
from ..processing import Processing
from ..regressors import standard_columns
from ..robot import Joint, Limits, Robot
from .chain import load_urdf

_ROBOTS = resources.files(str(__package__).removesuffix(".files")) / "robots"
_ROBOT = {"name", "title", "source", "payload_frame", "gravity", "lengths", "joints", "drives", "processing",
          "parameters", "flange", "base", "rated_payload_kg"}  # fmt: skip
_JOINT = {"kind", "alpha_deg", "d", "theta_deg", "r", "position_deg", "position_m", "speed_deg_s", "speed_m_s",
          "acceleration_deg_s2", "acceleration_m_s2", "torque"}  # fmt: skip
_DRIVES = {"rotor_inertia", "friction", "offsets", "coupling", "spring", "side"}
_SPRING = {"joint", "stiffness", "length", "arms", "zero_deg", "table"}
_PROCESSING = {
    "rate_hz": "rate",
    "cutoff_hz": "cutoff",
    "decimate": "decimate",
    "still_speed": "still_speed",
    "slow_fraction": "slow_fraction",
    "max_mismatch": "max_mismatch",
}


def robot_names() -> tuple[str, ...]:
    """Names of the shipped robots."""
    return tuple(sorted(entry.name[:-5] for entry in _ROBOTS.iterdir() if entry.name.endswith(".toml")))


def load_robot(name: str | Path, base: str | None = None, tip: str | None = None) -> Robot:
    """Load a shipped robot by name, or a robot from a TOML or URDF file by path.

    Args:
        name: a shipped robot's name or the path of a file; a URDF is known by its ending.
        base: URDF only: first link of the chain, where there are several.
        tip: URDF only: the flange's link, where there are several.

    Raises:
        InputError: if there is no such robot or file, or if the file cannot be used; the key is named.
    """
    text = str(name)
    if Path(name).suffix.lower() == ".urdf" and Path(name).is_file():
        return load_urdf(name, base, tip)
    if base is not None or tip is not None:
        raise InputError(f"--base and --tip choose links of a URDF file, {text!r} is none: leave them out")
    if text in robot_names():
        source = (_ROBOTS / f"{text}.toml").read_text(encoding="utf-8")
    else:
        path = Path(name)
        if not path.is_file():
            raise InputError(
                f"no robot {text!r}: give one of {', '.join(robot_names())}, or the path of a TOML or URDF file"
            )
        try:
            source = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise InputError(f"{text}: cannot be read as text ({error})") from None
    try:
        data = tomllib.loads(source)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{text}: not valid TOML: {error}") from None
    return _Reader(text).robot(data)


_LARGEST = 1e9  # no length, angle or parameter of an arm comes near

_Value = TypeVar("_Value")


class _Reader:
    """Turns the tables of one file into a robot and names the key of whatever does not fit."""

    def __init__(self, source: str) -> None:
        self._source = source

    def robot(self, data: Mapping[str, Any]) -> Robot:
        self._known(data, _ROBOT, "")
        lengths = {key: self._number(data["lengths"], key, "lengths.") for key in self._table(data, "lengths")}
        joints = data.get("joints")
        if not isinstance(joints, list) or not joints:
            raise self._error("joints", "give one [[joints]] table for each joint")
        arguments: dict[str, Any] = {
            "name": self._text(data, "name"),
            "title": self._text(data, "title", ""),
            "payload_frame": self._text(data, "payload_frame", f"frame {len(joints)} (modified DH)"),
            "joints": tuple(self._joint(joint, k + 1, lengths) for k, joint in enumerate(joints)),
            "drives": self._drives(self._table(data, "drives")),
            "processing": self._processing(self._table(data, "processing")),
            "parameters": self._parameters(self._table(data, "parameters")),
            "flange": self._pose(self._table(data, "flange"), "flange."),
            "base": self._pose(self._table(data, "base"), "base."),
        }
        if "rated_payload_kg" in data:
            arguments["rated_payload"] = self._number(data, "rated_payload_kg", "")
        if "gravity" in data:
            arguments["gravity"] = self._numbers(data, "gravity", 3, "")
        robot = self._make("", Robot, arguments)
        known = standard_columns(robot.with_offsets(True))
        for key in robot.parameters:
            if key not in known:
                raise self._error(f"parameters.{key}", "not a standard parameter of this robot")
        return robot

    def _joint(self, table: Any, number: int, lengths: Mapping[str, float]) -> Joint:
        where = f"joints[{number}]."
        if not isinstance(table, dict):
            raise self._error(where[:-1], "must be a table")
        for key in ("parent", "antecedent"):
            if key in table:
                raise self._error(where + key, "trees are not supported: give the joints of one chain, base to tip")
        self._known(table, _JOINT, where)
        kind = table.get("kind", "revolute")
        unit, scale = ("m", 1.0) if kind == "prismatic" else ("deg", math.pi / 180.0)
        for key in table:
            for name in ("position", "speed", "acceleration"):
                if key.startswith(name) and not key.startswith(f"{name}_{unit}"):
                    raise self._error(where + key, f"a {kind} joint takes {name}_{unit}...")
        limits: dict[str, Any] = {}
        for name, suffix in (("speed", "_s"), ("acceleration", "_s2")):
            key = f"{name}_{unit}{suffix}"
            if key in table:
                limits[name] = self._number(table, key, where) * scale
        if "torque" in table:
            limits["torque"] = self._number(table, "torque", where)
        if f"position_{unit}" in table:
            limits["position"] = tuple(v * scale for v in self._numbers(table, f"position_{unit}", 2, where))
        d, d_name = self._length(table, "d", lengths, where)
        r, r_name = self._length(table, "r", lengths, where)
        return self._make(
            where,
            Joint,
            {
                "kind": kind,
                "alpha": math.radians(self._number(table, "alpha_deg", where, 0.0)),
                "d": d,
                "theta": math.radians(self._number(table, "theta_deg", where, 0.0)),
                "r": r,
                "limits": self._make(where, Limits, limits),
                "names": (d_name, r_name),
            },
        )

    def _pose(self, table: Mapping[str, Any], where: str) -> Pose:
        self._known(table, {"xyz", "rpy_deg"}, where)
        xyz = self._numbers(table, "xyz", 3, where) if "xyz" in table else (0.0, 0.0, 0.0)
        rpy = self._numbers(table, "rpy_deg", 3, where) if "rpy_deg" in table else (0.0, 0.0, 0.0)
        return Pose.from_rpy(xyz, [math.radians(angle) for angle in rpy])

    def _drives(self, table: Mapping[str, Any]) -> Drives:
        self._known(table, _DRIVES, "drives.")
        side = self._text(table, "side", "motor", "drives.")
        if side not in ("motor", "link"):
            raise self._error("drives.side", "must be 'motor' or 'link'")
        if side == "link":
            for key in ("rotor_inertia", "coupling"):
                if table.get(key):
                    raise self._error(f"drives.{key}", "sensors on the link side do not see it: leave it out")
        drives = Drives.on_link_side() if side == "link" else Drives()
        arguments: dict[str, Any] = {}
        for key in ("rotor_inertia", "friction", "offsets"):
            if key in table:
                if not isinstance(table[key], bool):
                    raise self._error(f"drives.{key}", "must be true or false")
                arguments[key] = table[key]
        coupling = self._table(table, "coupling", "drives.")
        if coupling:
            where = "drives.coupling."
            self._known(coupling, {"joints", "coulomb"}, where)
            joints = self._whole(where + "joints", *self._numbers(coupling, "joints", 2, where))
            coulomb = self._text(coupling, "coulomb", "sum", where)
            arguments["coupling"] = self._make(where, Coupling, {"joints": joints, "coulomb": coulomb})
        spring = self._table(table, "spring", "drives.")
        if spring:
            arguments["spring"] = self._spring(spring, "drives.spring.")
        return replace(drives, **arguments)

    def _spring(self, table: Mapping[str, Any], where: str) -> Spring:
        self._known(table, _SPRING, where)
        (joint,) = self._whole(where + "joint", self._number(table, "joint", where))
        arguments: dict[str, Any] = {"joint": joint}
        for key in ("stiffness", "length"):
            if key in table:
                arguments[key] = self._number(table, key, where)
        if "arms" in table:
            arguments["arms"] = self._numbers(table, "arms", 2, where)
        arguments["zero"] = math.radians(self._number(table, "zero_deg", where, 0.0))
        rows = table.get("table", [])
        if not isinstance(rows, list) or not all(isinstance(row, list) and len(row) == 2 for row in rows):
            raise self._error(where + "table", "must be a list of [angle in degrees, torque in N·m]")
        pairs = [self._numbers({"table": row}, "table", 2, where) for row in rows]
        arguments["table"] = tuple((math.radians(angle), torque) for angle, torque in pairs)
        return self._make(where, Spring, arguments)

    def _processing(self, table: Mapping[str, Any]) -> Processing:
        where = "processing."
        self._known(table, set(_PROCESSING), where)
        arguments: dict[str, Any] = {_PROCESSING[key]: self._number(table, key, where) for key in table}
        if "decimate" in arguments and arguments["decimate"] == int(arguments["decimate"]):
            arguments["decimate"] = int(arguments["decimate"])
        return self._make(where, Processing, arguments)

    def _parameters(self, table: Mapping[str, Any]) -> dict[str, float]:
        return {key: self._number(table, key, "parameters.") for key in table}

    # Checks of single entries.

    def _error(self, key: str, problem: str) -> InputError:
        return InputError(f"{self._source}: key {key!r}: {problem}")

    def _known(self, table: Mapping[str, Any], known: set[str], where: str) -> None:
        for key in table:
            if key not in known:
                raise self._error(where + key, f"unknown; known here: {', '.join(sorted(known))}")

    def _table(self, table: Mapping[str, Any], key: str, where: str = "") -> Mapping[str, Any]:
        value = table.get(key, {})
        if not isinstance(value, dict):
            raise self._error(where + key, "must be a table")
        return value

    def _text(self, table: Mapping[str, Any], key: str, default: str | None = None, where: str = "") -> str:
        value = table.get(key, default)
        if not isinstance(value, str):
            raise self._error(where + key, "must be given as text")
        return value

    def _number(self, table: Mapping[str, Any], key: str, where: str, default: float | None = None) -> float:
        value = table.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < _LARGEST:
            raise self._error(where + key, f"must be a finite number, got {repr(value)[:40]}")
        return float(value)

    def _numbers(self, table: Mapping[str, Any], key: str, count: int, where: str) -> tuple[float, ...]:
        values = table.get(key)
        if not isinstance(values, list) or len(values) != count:
            raise self._error(where + key, f"must be a list of {count} numbers")
        return tuple(self._number({key: value}, key, where) for value in values)

    def _whole(self, key: str, *values: float) -> tuple[int, ...]:
        if any(value != int(value) for value in values):
            raise self._error(key, f"joint numbers must be whole numbers, got {', '.join(map(str, values))}")
        return tuple(int(value) for value in values)

    def _length(
        self, table: Mapping[str, Any], key: str, lengths: Mapping[str, float], where: str
    ) -> tuple[float, str]:
        value = table.get(key, 0.0)
        if isinstance(value, str):
            if value not in lengths:
                raise self._error(where + key, f"no length {value!r} in [lengths]")
            return lengths[value], value
        return self._number(table, key, where, 0.0), ""

    def _make(self, where: str, kind: type[_Value], arguments: Mapping[str, Any]) -> _Value:
        try:
            return kind(**arguments)
        except ValueError as error:
            raise self._error(where.rstrip(".") or "robot", str(error)) from None
