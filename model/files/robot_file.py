"""Robots from and to files: TOML by ``robot_table``, or a URDF."""

from importlib import resources
from pathlib import Path

from ...common.errors import InputError
from ...common.schema import TOML_BYTES, given, naming, read_text, toml_table
from ...common.toml import toml_text
from ..robot import Robot
from .chain import load_urdf
from .robot_table import RobotTable

_ROBOTS = resources.files(str(__package__).removesuffix(".files")) / "robots"


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
    elif Path(name).is_file():
        source = read_text(name, TOML_BYTES)
    else:
        raise InputError(
            f"no robot {text!r}: give one of {', '.join(robot_names())}, or the path of a TOML or URDF file"
        )
    table = toml_table(source, RobotTable, text)
    with naming(text):
        return table.robot()


def robot_toml(robot: Robot, source: str = "") -> str:
    """A robot's description as the text of a TOML file, as ``load_robot`` reads it.

    Args:
        robot: the robot; frames of a URDF it came from are not kept.
        source: where its numbers come from.
    """
    table = given(RobotTable.of(robot, source))
    table["joints"] = [{"alpha_deg": 0.0} | joint for joint in table["joints"]]
    return f"# {robot.title or robot.name}. Lengths in m, angles in degrees.\n{toml_text(table)}"
