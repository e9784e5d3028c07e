"""Robots from and to files: TOML by ``robot_table``, a URDF, or a name of robot_descriptions."""

import re
from difflib import get_close_matches
from functools import cache
from importlib import resources
from pathlib import Path

from ...common.errors import InputError
from ...common.schema import TOML_BYTES, given, naming, read_text, toml_table, toml_text
from ..robot import Robot
from .described import ENDING, described
from .robot_table import RobotTable
from .urdf import load_urdf

_ROBOTS = resources.files(str(__package__).removesuffix(".files")) / "robots"


@cache
def robot_names() -> tuple[str, ...]:
    """Names of the shipped robots."""
    return tuple(sorted(entry.name[:-5] for entry in _ROBOTS.iterdir() if entry.name.endswith(".toml")))


def load_robot(name: str | Path, base: str | None = None, tip: str | None = None) -> Robot:
    """Load a shipped robot by name, or a robot from a TOML or URDF file by path.

    Args:
        name: a shipped robot's name, the path of a file (a URDF or xacro file is known by its ending), or a name of
            robot_descriptions, whose file must be in its cache.
        base: URDF only: first link of the chain, where there are several.
        tip: URDF only: the flange's link, where there are several.

    Raises:
        InputError: if there is no such robot or file, or if the file cannot be used; the key is named.
    """
    text = str(name)
    if Path(name).suffix.lower() in (".urdf", ".xacro") and Path(name).is_file():
        return load_urdf(name, base, tip)
    if re.fullmatch(rf"\w+{ENDING}", text) and not Path(name).is_file():
        return load_urdf(described(text), base, tip)
    if base is not None or tip is not None:
        raise InputError(f"the setting chain chooses links of a URDF file, {text!r} is none: leave it out")
    # Capitals, blanks and hyphens do not count: "UR 10e", "Kr6-R900".
    plain = re.sub(r"[\s_-]", "", text.lower())
    for shipped in robot_names():
        if shipped.replace("_", "") == plain:
            return _read_shipped(shipped)
    if not Path(name).is_file():
        raise InputError(_no_robot(text))
    table = toml_table(read_text(name, TOML_BYTES), RobotTable, text)
    with naming(text):
        return table.robot()


@cache
def _read_shipped(name: str) -> Robot:
    """Read a shipped robot, once a process: a search over all of them asks again and again."""
    return toml_table((_ROBOTS / f"{name}.toml").read_text(encoding="utf-8"), RobotTable, name).robot()


def _no_robot(text: str) -> str:
    """Say what is wrong with a name that is none: a missing file, or a robot that is not shipped."""
    if Path(text).is_dir():
        return f"no robot {text!r}: it is a folder; give the path of a TOML or URDF file"
    if Path(text).suffix or "/" in text or "\\" in text:
        return f"no such file: {text!r}; 'dynident robot list' shows the shipped robots"
    begins = [name for name in robot_names() if name.startswith(text.lower())]
    near = begins or get_close_matches(text.lower(), robot_names(), 3, 0.6)
    # A maker ("kuka"), or another name of the arm.
    near = near or [n for n in robot_names() if text.lower() in re.split(r"\W+", load_robot(n).title.lower())]
    hint = f"did you mean {' or '.join(map(repr, near))}? " if near else ""
    return f"no robot {text!r}: {hint}give one of {', '.join(robot_names())}, or the path of a TOML or URDF file"


def robot_toml(robot: Robot, source: str = "") -> str:
    """Write a robot's description as the text of a TOML file, as ``load_robot`` reads it.

    Args:
        robot: the robot; frames of a URDF it came from are not kept.
        source: where its numbers come from.
    """
    table = given(RobotTable.of(robot, source))
    table["joints"] = [{"alpha_deg": 0.0} | joint for joint in table["joints"]]
    return f"# {robot.title or robot.name}. Lengths in m, angles in degrees.\n{toml_text(table)}"
