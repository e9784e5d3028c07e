"""``dynident payload``: a payload from recordings with and without it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from ... import estimation
from ...common.errors import InputError
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
    PageOptions,
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
        settings = estimation.Settings(
            setup.processing,
            essential=essential.essential,
            friction_change=request.change,
            free_friction=request.free_friction,
            scale_sigma=request.scale_sigma or 0.0,
            progress=progress,
        )
        known = stored.estimate if stored else None
        problem = estimation.payload_problem(setup.robot, loaded, unloaded, known, settings)
        progress("estimating")
        with constraints_solved():
            answer = estimation.answer_payload(problem, request.methods, held_out, constraints, gain_errors)

    def page(document: results.StoredPayload) -> report.Page:
        provenance = files.provenance(setup.in_words(), request, arm, processing)
        return _page(answer, document, provenance, len(loaded) + len(held_out))

    show_payload(answer, setup, files, page)
    files.write_equations(lambda: estimation.payload_system(problem, loaded, unloaded, setup.processing))
    view.write_view(lambda: views.view_of_answer(setup.robot, loaded[0], answer))
    return answered(answer.verdict.level)


def _page(
    answer: estimation.PayloadAnswer, document: results.StoredPayload, provenance: report.Provenance, recorded: int
) -> report.Page:
    """The report; ``recorded``: how many recordings there are, of which not all are drawn."""
    others = recorded - len(answer.predictions)
    return report.payload_page(answer, document, provenance, answer.predictions, others)


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


def show_payload(
    answer: estimation.PayloadAnswer,
    setup: Setup,
    files: PageOptions,
    page: Callable[[results.StoredPayload], report.Page],
    measured: bool = False,
) -> None:
    """Print the answer, write its document and its page.

    Args:
        page: makes the report of the document; called only where it is asked for.
        measured: whether an inertia that was to be assumed is measured.
    """
    files.show(report.payload_screen(answer, files.document, measured))
    document = report.documents.payload_document(answer, setup.processing, setup.gains)
    files.write_json(lambda: document)
    files.write_page(lambda: page(document))
