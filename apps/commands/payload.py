"""``dynident payload``: a payload from recordings with and without it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Annotated

from ... import estimation
from ...common.errors import InputError
from .. import report, results
from .. import view as views
from . import answered
from .entry import FILES, SETTING, command, options
from .options import (
    EquationOptions,
    FramedRobotOptions,
    GainOptions,
    KnowledgeOptions,
    Options,
    PairOptions,
    ViewOptions,
)
from .progress import note, status
from .values import (
    DataFile,
    Essential,
    FrictionTerms,
    HeldOutFile,
    LoadedFile,
    RobotParametersFile,
    Share,
    method,
    word,
)


@options()
class ComparedOptions(Options):
    """Recordings with a payload, and what they are compared with."""

    friction_change: Share | None = None
    """Methods 3, 4 and --robot-parameters: by how much friction under load may differ from the robot's own, 1
    sigma, 0 for not at all (default: 10%)."""
    unloaded: tuple[DataFile, ...] = ()
    """Recording without payload; repeatable: several are recordings of one robot."""
    loaded: tuple[LoadedFile, ...]
    """Recording with payload; repeatable, in the order they were made: several are of one payload, paired with
    those without it in this order (weigh, method 3)."""
    robot_parameters: RobotParametersFile | None = None
    """The --json of 'dynident identify' (method 1; weigh: instead of --unloaded)."""

    @property
    def change(self) -> float:
        """The change of friction that was given, or the default."""
        return estimation.FRICTION_CHANGE if self.friction_change is None else self.friction_change

    def check(self) -> None:
        """Refuse recordings with a payload that nothing stands beside."""
        if not self.unloaded and not self.robot_parameters:
            raise InputError(
                "give --unloaded recordings or --robot-parameters: without either nothing can be compared"
            )

    def stored(self) -> estimation.RobotResult | None:
        """The robot's parameters from a file."""
        return results.read_stored_robot(self.robot_parameters) if self.robot_parameters else None


@options()
class _Payload(ComparedOptions):
    """Recordings, and by which methods they are answered."""

    validate: tuple[HeldOutFile, ...] = ()
    """Another one without payload, held out; repeatable."""
    method: Annotated[str, word(method, "NAME")] = "all"
    """known-robot (1), change (2), difference (3), global (4) or all (default); see docs/theory.md."""
    friction: FrictionTerms | None = None
    """The robot's friction, as of 'dynident identify'; with --robot-parameters theirs."""
    free_friction: Annotated[bool, SETTING] = False
    """Method 1: estimate friction anew under load."""
    scale_sigma: Share | None = None
    """Methods 1 and 4: by how much the scale of the loaded torques may differ from that without payload, 1 sigma
    (default: not at all)."""
    essential: Annotated[Essential | None, SETTING] = None
    """Method 4: eliminate parameters until the error's standard deviation has grown by this ratio (default: 1.02),
    or until all relative standard deviations are within a percentage such as 10%."""

    def check(self) -> None:
        """Refuse options that the methods asked for cannot use."""
        super().check()
        if self.robot_parameters:
            self.refuse("friction", "belongs to recordings without payload: the stored robot has its own")
        if self.method not in ("1", "all"):
            self.refuse("free_friction", "belongs to method 1, which is not among the methods asked for")
        if self.method not in ("4", "all"):
            self.refuse("essential", "belongs to method 4, which is not asked for")
        if self.method in ("1", "2") and not self.robot_parameters:
            self.refuse(
                "friction_change", "belongs to methods 3 and 4 and to --robot-parameters: none is asked for"
            )
        if self.method in ("2", "3"):
            self.refuse("scale_sigma", "belongs to methods 1 and 4: neither is asked for")


@options(FILES)
class _Files(EquationOptions, ViewOptions):
    """The result in all forms."""


@command
def run(
    *,
    arm: FramedRobotOptions,
    request: _Payload,
    knowledge: KnowledgeOptions,
    drives: GainOptions,
    processing: PairOptions,
    files: _Files,
) -> int:
    """Run it."""
    files.check_view()
    request.check()
    constraints = knowledge.constraints()
    stored = request.stored()
    setup = processing.setup(arm.load(), stored)
    unloaded, loaded, held_out = (
        setup.read(paths) for paths in (request.unloaded, request.loaded, request.validate)
    )
    gains = drives.errors(setup, loaded, unloaded, stored)
    with status("reading") as progress, constraints_solved():
        settings = estimation.Settings(
            setup.processing,
            essential=request.essential,
            friction_change=request.change,
            free_friction=request.free_friction,
            scale_sigma=request.scale_sigma or 0.0,
            progress=progress,
        )
        settings = settings if request.friction is None else replace(settings, friction=request.friction)
        known = stored.estimate if stored else None
        problem = estimation.payload_problem(setup.robot, loaded, unloaded, known, settings)
        progress("estimating")
        methods = None if request.method == "all" else (int(request.method),)
        if methods is None and settings.scale_sigma:
            note(
                "--scale-sigma: methods 2 and 3 have no column for the scale of the loaded torques and are left out"
            )
        answer = estimation.answer_payload(problem, methods, held_out, constraints, gains)

    shown = report.payload_report(answer.result, files.document)
    files.give(shown, lambda: answer.result, setup.in_words())
    files.write_equations(lambda: estimation.payload_system(problem))
    files.write_view(lambda: views.view_of_answer(setup.robot, loaded[0], answer.result))
    return answered(answer.verdict.level)


@contextmanager
def constraints_solved() -> Iterator[None]:
    """Constraints that leave no body are the user's to mend."""
    try:
        yield
    except estimation.SolverError as error:
        raise InputError(str(error)) from None
