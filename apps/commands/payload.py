"""``dynident payload``: a payload from recordings with and without it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from ... import estimation, model
from ...common.errors import InputError
from ...common.progress import Progress
from .. import report, results
from .. import view as views
from . import answered
from .options import (
    EquationOptions,
    EssentialOptions,
    FramedRobotOptions,
    FrictionOptions,
    GainOptions,
    KnowledgeOptions,
    PairOptions,
    Setup,
    ViewOptions,
    option,
)
from .progress import status
from .values import method, share


@dataclass(frozen=True)
class _Payload(FrictionOptions):
    """Recordings, and by which methods they are answered."""

    unloaded: tuple[str, ...] = option(
        reads="without payload",
        action="append",
        default=[],
        metavar="LOG",
        help="recording without payload; repeatable: several are recordings of one robot",
    )
    loaded: tuple[str, ...] = option(
        reads="with payload",
        action="append",
        required=True,
        metavar="LOG",
        help="recording with payload; repeatable: several are of one payload; method 3 pairs them in order",
    )
    validate: tuple[str, ...] = option(
        reads="held out",
        action="append",
        default=[],
        metavar="LOG",
        help="another one without payload, held out; repeatable",
    )
    robot_parameters: str | None = option(
        reads="robot's parameters", metavar="JSON", help="the --json of 'dynident identify' (method 1)"
    )
    method: str = option(
        type=method,
        choices=("all", "1", "2", "3", "4"),
        default="all",
        metavar="NAME",
        help="known-robot (1), change (2), difference (3), global (4) or all (default); see docs/theory.md",
    )
    free_friction: bool = option(action="store_true", help="method 1: estimate friction anew under load")

    scale_sigma: float | None = option(
        type=share,
        metavar="SHARE",
        help="methods 1 and 4: by how much the scale of the loaded torques may differ from that without payload, "
        "1 sigma (default: not at all)",
    )

    @property
    def methods(self) -> tuple[int, ...] | None:
        """Numbers of the methods asked for, or None for all."""
        return None if self.method == "all" else (int(self.method),)

    def check(self, essential: bool) -> None:
        """Refuse options that the methods asked for cannot use."""
        check_compared(self.unloaded, self.robot_parameters)
        if self.free_friction and self.method not in ("1", "all"):
            raise InputError("--free-friction belongs to method 1, which is not among the methods asked for")
        if not self.robot_parameters and self.method not in ("4", "all"):
            self.refuse("friction_change", "belongs to method 4 and to --robot-parameters: neither is asked for")
        if self.method in ("2", "3"):
            self.refuse("scale_sigma", "belongs to methods 1 and 4: neither is asked for")
        if essential and self.method not in ("4", "all"):
            raise InputError("--essential belongs to method 4, which is not asked for")


def run(
    arm: FramedRobotOptions,
    request: _Payload,
    knowledge: KnowledgeOptions,
    drives: GainOptions,
    essential: EssentialOptions,
    processing: PairOptions,
    files: EquationOptions,
    view: ViewOptions,
) -> int:
    """Run it."""
    view.check_view()
    request.check(essential.essential is not None)
    constraints = knowledge.constraints()
    stored = results.read_stored_robot(request.robot_parameters) if request.robot_parameters else None
    setup = processing.setup(arm.load(), stored)
    unloaded, loaded, held_out = (
        setup.read(paths) for paths in (request.unloaded, request.loaded, request.validate)
    )
    gain_errors = drives.errors(setup, loaded, unloaded, stored)
    with status("reading") as progress:
        problem = _problem(request, setup, loaded, unloaded, stored, progress)
        progress("estimating")
        answer = _answer(problem, request, setup, held_out, constraints, gain_errors, essential.essential)

    def page() -> report.Page:
        others = len(loaded) + len(held_out) - len(answer.predictions)
        provenance = files.provenance(setup.in_words(), request, arm, processing)
        return report.payload_page(answer.result, provenance, answer.predictions, others)

    files.show(report.payload_screen(answer.result, files.document))
    files.write_json(lambda: answer.result)
    files.write_page(page)
    files.write_equations(lambda: estimation.payload_system(problem, loaded, unloaded, setup.processing))
    view.write_view(lambda: views.view_of_answer(setup.robot, loaded[0], answer.result))
    return answered(answer.verdict.level)


def _answer(
    problem: estimation.PayloadProblem,
    request: _Payload,
    setup: Setup,
    held_out: Sequence[model.Recording],
    constraints: Sequence[estimation.Constraint],
    gains: estimation.Gains | None,
    essential: estimation.StopRule | None,
) -> estimation.PayloadAnswer:
    """The payload by the methods asked for."""
    with constraints_solved():
        return estimation.answer_payload(
            problem,
            request.methods,
            request.free_friction,
            held_out,
            setup.processing,
            constraints=constraints,
            gains=gains,
            essential=essential,
        )


def _problem(
    request: _Payload,
    setup: Setup,
    loaded: Sequence[model.Recording],
    unloaded: Sequence[model.Recording],
    stored: estimation.RobotResult | None,
    progress: Progress,
) -> estimation.PayloadProblem:
    """Equations of the recordings, with the robot of an earlier run where one is given."""
    return estimation.payload_problem(
        setup.robot,
        loaded,
        unloaded,
        stored.estimate if stored else None,
        setup.processing,
        progress,
        robust=True,
        friction_change=request.change,
        scale_sigma=request.scale_sigma or 0.0,
    )


def check_compared(unloaded: Sequence[str], robot_parameters: str | None) -> None:
    """Refuse recordings with a payload that nothing stands beside."""
    if not unloaded and not robot_parameters:
        raise InputError("give --unloaded recordings or --robot-parameters: without either nothing can be compared")


@contextmanager
def constraints_solved() -> Iterator[None]:
    """Constraints that leave no body are the user's to mend.

    Raises:
        InputError: where the solver finds none.
    """
    try:
        yield
    except estimation.SolverError as error:
        raise InputError(str(error)) from None
