"""``dynident verify``: whether the controller does better with the payload that was entered."""

from __future__ import annotations

from typing import Annotated

from .. import report
from ..logs.following import following_change, read_following
from . import ANSWERED, DO_NOT_USE
from .entry import command
from .options import ArmOptions, LogOptions, PageOptions
from .values import LOG, Reads


@command
def run(
    *,
    arm: ArmOptions,
    before: Annotated[str, Reads("before"), LOG],
    after: Annotated[str, Reads("after"), LOG],
    logs: LogOptions,
    files: PageOptions,
) -> int:
    """Run it.

    Args:
        before: Before the new number: one motion, with columns qref1.. (commanded positions) or tauref1.. (torque
            predicted, N·m), or what --log-map names.
        after: That motion again, with the new number.
    """
    robot, how = arm.load(), logs.how()
    gains, _ = logs.gains(robot)
    old, new = (read_following(path, robot, gains, how) for path in (before, after))
    change = following_change(old, new, robot.processing.still_speed)
    shown = report.following_report(change, robot)
    files.give(shown, lambda: change, {})
    return DO_NOT_USE if change.tells and change.total.clear == "rose" else ANSWERED
