"""``dynident weigh``: a payload from a short motion of a few joints near a pose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from .. import estimation, fleet, model, report
from ..common.errors import InputError
from ..common.files import checksum
from . import ANSWERED, DO_NOT_USE
from .options import (
    FrictionOptions,
    GainOptions,
    KnowledgeOptions,
    PageOptions,
    PairOptions,
    PassportOptions,
    RobotOptions,
    Setup,
    ViewOptions,
    add_command,
    logs_of,
    option,
    recipe_of,
)
from .values import joint_list

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
from .progress import status


@dataclass(frozen=True)
class _Weigh(FrictionOptions):
    """Recordings of the short motion, and what it is compared with."""

    WITHOUT: ClassVar[frozenset[str]] = frozenset({"scale_sigma"})

    unloaded: tuple[str, ...] = option(
        reads="without payload",
        action="append",
        default=[],
        metavar="LOG",
        help="the same motion without the payload: one for all of --loaded, or one for each",
    )
    loaded: tuple[str, ...] = option(
        reads="with payload",
        action="append",
        required=True,
        metavar="LOG",
        help="the motion with the payload; give it again for repeated recordings, in the order they were made",
    )
    robot_parameters: str | None = option(
        reads="robot's parameters", metavar="JSON", help="the --json of 'dynident identify', instead"
    )
    moving: tuple[int, ...] | None = option(
        type=joint_list, metavar="J1,J2,..", help="joints that move; seen by default"
    )
    inertia: str | None = option(
        metavar="box:AxBxC|cylinder:DxL", help="assume this body's inertia if none is measured [mm]"
    )


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    parts = (RobotOptions, _Weigh, KnowledgeOptions, GainOptions, PairOptions, PageOptions, ViewOptions)
    add_command(commands, "weigh", run, *parts, PassportOptions)


def run(
    arm: RobotOptions,
    asked: _Weigh,
    knowledge: KnowledgeOptions,
    drives: GainOptions,
    processing: PairOptions,
    files: PageOptions,
    view: ViewOptions,
    passport: PassportOptions,
) -> int:
    """Run it."""
    view.check_view()
    if not asked.unloaded and not asked.robot_parameters:
        raise InputError("give --unloaded recordings or --robot-parameters: without either nothing can be compared")
    if not asked.robot_parameters:
        asked.refuse("friction_change", "belongs to --robot-parameters: a difference of torques frees friction")
    constraints = knowledge.constraints()
    stand_in = estimation.StandIn.parse(asked.inertia) if asked.inertia is not None else None
    stored = estimation.files.read_stored_robot(asked.robot_parameters) if asked.robot_parameters else None
    setup = processing.setup(arm.load(), stored)
    loaded, unloaded = setup.read(asked.loaded), setup.read(asked.unloaded)
    gains = drives.errors(setup, loaded, unloaded, stored, compared=bool(unloaded))
    with status("reading") as progress:
        problem, others = _problems(asked, setup, loaded, unloaded, stored, progress)
        progress("estimating")
        try:
            answer = estimation.answer_payload(
                problem, constraints=constraints, gains=gains, stand_in=stand_in, others=others
            )
        except estimation.SolverError as error:
            raise InputError(str(error)) from None
    measured = stand_in is not None and answer.stand_in is None
    files.show(report.payload_screen(answer, files.document, measured))
    document = report.documents.payload_document(answer, setup.processing, setup.gains)
    files.write_json(lambda: document)

    def page() -> report.Page:
        made = report.weigh_page(answer, document, files.provenance(setup.in_words(), asked, arm, processing))
        if files.plots and not made.drawings():
            raise InputError("--plots: no joints see the mass, there is nothing to draw")
        return made

    files.write_page(page)
    view.write_view(lambda: report.view.view_of_answer(setup.robot, loaded[0], answer))
    recipe = recipe_of(
        "weigh",
        setup,
        gains,
        friction_change=asked.change if stored else 0.0,
        constraints=tuple(constraints),
        stand_in=stand_in,
        moving=asked.moving,
        parameters=checksum(asked.robot_parameters) if asked.robot_parameters else "",
    )
    passport.write(lambda: fleet.payload_passport(answer, others, recipe, logs_of(asked)))
    return DO_NOT_USE if answer.verdict.level == "do_not_use" else ANSWERED


def _problems(
    asked: _Weigh,
    setup: Setup,
    loaded: Sequence[model.Recording],
    unloaded: Sequence[model.Recording],
    stored: estimation.files.StoredRobot | None,
    progress: Callable[[str], None],
) -> tuple[estimation.PayloadProblem, list[estimation.PayloadProblem]]:
    """What is answered, and what it is compared with: torque differences first, the robot's parameters beside."""
    robot, processing, problems = setup.robot, setup.processing, []
    if unloaded:
        problems.append(
            estimation.payload.difference_weighing(robot, loaded, unloaded, processing, asked.moving, progress)
        )
    if stored is not None:
        problems.append(
            estimation.payload.known_robot_weighing(
                robot, loaded, stored.estimate, processing, asked.moving, progress, asked.change
            )
        )
    return problems[0], problems[1:]
