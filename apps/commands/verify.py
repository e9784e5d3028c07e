"""``dynident verify``: whether the controller does better with the payload that was entered."""

from __future__ import annotations

from typing import Annotated

from .. import report
from ..logs.following import following_change, read_following
from . import ANSWERED, DO_NOT_USE
from .entry import command, options
from .options import ArmOptions, LogOptions, Options, PageOptions
from .values import LOG, Reads


@options()
class _Pair(Options):
    """One motion before and after the payload was entered."""

    before: Annotated[str, Reads("before"), LOG]
    """Before the new number: one motion, with columns qref1.. (commanded positions) or tauref1.. (torque predicted,
    N·m), or what --log-map names."""
    after: Annotated[str, Reads("after"), LOG]
    """That motion again, with the new number."""


@command
def run(*, arm: ArmOptions, pair: _Pair, logs: LogOptions, files: PageOptions) -> int:
    """Run it."""
    robot, how = arm.load(), logs.how()
    gains, _ = logs.gains(robot)
    before, after = (read_following(path, robot, gains, how) for path in (pair.before, pair.after))
    change = following_change(before, after, robot.processing.still_speed)
    shown = report.following_report(change, robot)
    files.show(shown)
    files.write_json(lambda: change)
    files.write_page(shown, {})
    return DO_NOT_USE if change.tells and change.total.clear == "rose" else ANSWERED
