"""``dynident codegen``: a function of the robot as C."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from ... import model
from ...common.errors import printable
from . import ANSWERED
from .entry import command
from .options import RobotOptions
from .progress import quiet
from .values import NewFolder


@command
def run(*, robot: RobotOptions, function: Annotated[str, Parameter(metavar="NAME")], out: NewFolder) -> int:
    """Run it.

    Args:
        function: Such as base_regressor.
        out: Folder of the files, made if missing.
    """
    for path in model.generate_code(robot.load(), function, out):
        if not quiet():
            print(printable(str(path)))
    return ANSWERED
