"""``dynident weigh``: a payload from a short motion of a few joints near a pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from ... import estimation, model
from ...common.errors import InputError
from ...common.progress import Progress
from .. import report, results
from .. import view as views
from . import answered
from .options import (
    FrictionOptions,
    GainOptions,
    KnowledgeOptions,
    PageOptions,
    PairOptions,
    RobotOptions,
    Setup,
    ViewOptions,
    option,
)
from .payload import check_compared, constraints_solved
from .progress import status
from .values import joint_list


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
        default=[],
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


def run(
    arm: RobotOptions,
    request: _Weigh,
    knowledge: KnowledgeOptions,
    drives: GainOptions,
    processing: PairOptions,
    files: PageOptions,
    view: ViewOptions,
) -> int:
    """Run it."""
    _check_request(request)
    view.check_view()
    constraints = knowledge.constraints()
    stand_in = estimation.StandIn.parse(request.inertia) if request.inertia is not None else None
    stored = results.read_stored_robot(request.robot_parameters) if request.robot_parameters else None
    setup = processing.setup(arm.load(), stored)
    loaded, unloaded = setup.read(request.loaded), setup.read(request.unloaded)
    gains = drives.errors(setup, loaded, unloaded, stored)
    with status("reading") as progress:
        problem, others = _problems(request, setup, loaded, unloaded, stored, progress)
        progress("estimating")
        with constraints_solved():
            answer = estimation.answer_payload(
                problem, constraints=constraints, gains=gains, stand_in=stand_in, others=others
            )

    def page() -> report.Page:
        made = report.payload_page(answer.result, files.provenance(setup.in_words(), request, arm, processing))
        if files.plots and not made.drawings():
            raise InputError("--plots: no joints see the mass, there is nothing to draw")
        return made

    measured = stand_in is not None and answer.stand_in is None
    files.show(report.payload_screen(answer.result, files.document, measured))
    files.write_json(lambda: answer.result)
    files.write_page(page)
    view.write_view(lambda: views.view_of_answer(setup.robot, loaded[0], answer.result))
    return answered(answer.verdict.level)


def _check_request(request: _Weigh) -> None:
    """Refuse a line without recordings, or with options that belong together and are not."""
    if not request.loaded:
        raise InputError("give --loaded recordings")
    check_compared(request.unloaded, request.robot_parameters)
    if not request.robot_parameters:
        request.refuse("friction_change", "belongs to --robot-parameters: a difference of torques frees friction")


def _problems(
    request: _Weigh,
    setup: Setup,
    loaded: Sequence[model.Recording],
    unloaded: Sequence[model.Recording],
    stored: estimation.RobotResult | None,
    progress: Progress,
) -> tuple[estimation.PayloadProblem, list[estimation.PayloadProblem]]:
    """What is answered, and what it is compared with: torque differences first, the robot's parameters beside."""
    robot, processing, problems = setup.robot, setup.processing, []
    if unloaded:
        problems.append(
            estimation.difference_weighing(robot, loaded, unloaded, processing, request.moving, progress)
        )
    if stored is not None:
        problems.append(
            estimation.known_robot_weighing(
                robot, loaded, stored.estimate, processing, request.moving, progress, request.change
            )
        )
    return problems[0], problems[1:]
