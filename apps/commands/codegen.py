"""``dynident codegen``: a function of the robot as C."""

from __future__ import annotations

from dataclasses import dataclass

from ... import model
from ...common.errors import printable
from . import ANSWERED
from .options import Options, RobotOptions, option
from .progress import quiet


@dataclass(frozen=True)
class _Code(Options):
    """Which function, and where its files go."""

    function: str = option(required=True, metavar="NAME", help="such as base_regressor")
    out: str = option(writes="folder", required=True, metavar="DIR", help="folder of the files, made if missing")


def run(robot: RobotOptions, code: _Code) -> int:
    """Run it."""
    for path in model.generate_code(robot.load(), code.function, code.out):
        if not quiet():
            print(printable(str(path)))
    return ANSWERED
