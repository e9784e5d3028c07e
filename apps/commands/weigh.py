"""``dynident weigh`` and ``verify``: a payload from a short motion, and its effect in the controller."""

from __future__ import annotations

from typing import Annotated, ClassVar

from cyclopts import Parameter

from ... import estimation
from ...common.errors import InputError
from .. import report
from .. import view as views
from ..logs.following import following_change, read_following
from . import ANSWERED, DO_NOT_USE, answered
from .entry import command
from .options import (
    ArmOptions,
    GainOptions,
    KnowledgeOptions,
    LogOptions,
    PageOptions,
    PairOptions,
    RobotOptions,
    ViewedPageOptions,
)
from .payload import ComparedOptions, constraints_solved
from .progress import status
from .values import LOG, Joints, Reads


class _Weigh(ComparedOptions):
    """Recordings of the short motion, and what it is compared with."""

    needs: ClassVar = {"friction_change": ("robot_parameters",)}  # a difference of torques frees friction

    moving: Joints | None = None
    """Joints that move; seen by default."""
    inertia: Annotated[str | None, Parameter(metavar="box:AxBxC|cylinder:DxL")] = None
    """Assume this body's inertia if none is measured [mm]."""


@command
def run(
    *,
    arm: RobotOptions,
    request: _Weigh,
    knowledge: KnowledgeOptions,
    drives: GainOptions,
    processing: PairOptions,
    files: ViewedPageOptions,
) -> int:
    """Run it."""
    constraints = knowledge.constraints()
    stand_in = estimation.StandIn.parse(request.inertia) if request.inertia is not None else None
    stored = request.stored()
    setup = processing.setup(arm.load(), stored)
    robot = setup.robot
    loaded, unloaded = setup.read(request.loaded), setup.read(request.unloaded)
    gains = drives.errors(setup, loaded, unloaded, stored)
    with status("reading") as progress, constraints_solved():
        settings = estimation.Settings(
            setup.processing, friction_change=request.change, joints=request.moving, gains=gains, progress=progress
        )
        known = stored.estimate if stored else None
        answer: estimation.PayloadAnswer = estimation.weigh(
            robot, loaded, unloaded, known, constraints, settings
        ).working
        if stand_in is not None:
            answer = answer.assuming(stand_in)

    spare = "--inertia is not needed: the inertia was measured well enough."
    measured = stand_in is not None and answer.stand_in is None
    shown = report.payload_report(answer.result, files.document, [spare] if measured else [])
    files.show(shown)
    files.write_json(lambda: answer.result)
    if files.plots and not shown.drawings():
        raise InputError("plots: no joints see the mass, there is nothing to draw")
    files.write_page(shown, setup.in_words())
    files.write_view(lambda: views.view_of_answer(robot, loaded[0], answer.result))
    return answered(answer.verdict.level)


@command
def run_verify(
    *,
    arm: ArmOptions,
    before: Annotated[str, Reads("before"), LOG],
    after: Annotated[str, Reads("after"), LOG],
    logs: LogOptions,
    files: PageOptions,
) -> int:
    """Run ``verify``.

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
