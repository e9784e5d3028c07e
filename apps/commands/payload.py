"""``dynident payload`` and ``weigh``: a payload from recordings."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, ClassVar

from cyclopts import Parameter

from ... import estimation
from ...common.errors import InputError
from .. import results
from .. import view as views
from ..report.sections.payload import payload_report
from . import options, values
from .entry import SETTING
from .progress import note, status
from .values import Share, number, word


class _Compared(
    options.ViewOptions,
    options.PageOptions,
    options.ProcessingOptions,
    options.GainOptions,
    options.KnowledgeOptions,
    options.RobotOptions,
):
    friction_change: Share | None = None
    """How much friction may differ under load, 1 sigma; for methods 3 and 4, and for --robot-parameters (default:
    10%; 0: not at all)."""
    unloaded: values.DataFiles = ()
    """Recording without payload; repeatable."""
    loaded: values.LoadedFiles
    """Recording with payload; repeatable for the same payload, in the order of the --unloaded ones."""
    robot_parameters: values.RobotParametersFile | None = None
    """The --json file of 'dynident identify', instead of --unloaded."""
    max_mismatch: Annotated[float | None, word(number, "RAD"), SETTING] = None
    """Largest difference of position with and without payload after alignment, rms of the worst joint (payload:
    method 3; default: 0.01)."""

    def check(self) -> None:
        """Refuse recordings with a payload that nothing stands beside."""
        super().check()
        if not self.unloaded and not self.robot_parameters:
            raise InputError(
                "give --unloaded recordings or --robot-parameters: without either nothing can be compared"
            )

    @property
    def stored(self) -> estimation.RobotResult | None:
        """The robot's parameters from a file."""
        return results.read_stored_robot(self.robot_parameters) if self.robot_parameters else None


class _Payload(_Compared, options.FramedRobotOptions):
    belongs: ClassVar = {
        "free_friction": ("method", ("1", "all")),
        "essential": ("method", ("4", "all")),
        "scale_sigma": ("method", ("1", "4", "all")),
    }

    validate: values.HeldOutFiles = ()
    """Recording without payload that is kept out of the fit to test it; repeatable."""
    method: Annotated[str, word(values.method, "NAME")] = "all"
    """known-robot (1), change (2), difference (3), global (4) or all (default); see docs/theory.md."""
    friction: values.FrictionTerms | None = None
    """Friction model, as for 'dynident identify'; --robot-parameters bring their own."""
    free_friction: Annotated[bool, SETTING] = False
    """Method 1: estimate friction under load from scratch."""
    scale_sigma: Share | None = None
    """How much the scale of the loaded torques may differ from that of the unloaded ones, 1 sigma; for methods 1
    and 4 (default: not at all)."""
    essential: Annotated[values.Essential | None, SETTING] = None
    """Method 4: eliminate parameters until the error's standard deviation has grown by this ratio (default: 1.02),
    or until all relative standard deviations are within a percentage such as 10%."""
    npz: options.EquationsFile | None = None

    def check(self) -> None:
        """Refuse options that the methods asked for cannot use."""
        super().check()
        if self.robot_parameters:
            self.refuse("friction", "belongs to recordings without payload: the stored robot has its own")
        elif self.method in ("1", "2"):
            self.refuse("friction_change", "belongs to methods 3, 4 and to --robot-parameters: none is asked for")

    def __call__(self) -> bool:
        constraints, stored = self.constraints(), self.stored
        setup = self.setup(stored)
        unloaded, loaded, held_out = map(setup.read, (self.unloaded, self.loaded, self.validate))
        gains = self.errors(setup, loaded, unloaded, stored)
        with status("reading") as progress, _constraints_solved():
            settings = setup.settings(
                progress,
                gains=gains,
                methods=None if self.method == "all" else (int(self.method),),
                friction=self.friction,
                essential=self.essential,
                friction_change=self.friction_change,
                free_friction=self.free_friction,
                scale_sigma=self.scale_sigma,
            )
            known = stored.estimate if stored else None
            problem = estimation.payload_problem(setup.robot, loaded, unloaded, known, settings)
            progress("estimating")
            if settings.methods is None and settings.scale_sigma:
                note("--scale-sigma: methods 2 and 3 have no column for the scale of loaded torques: left out")
            answer = estimation.answer_payload(problem, held_out, constraints)
        result = answer.result
        self.give(payload_report(result, self.document), lambda: result, setup.in_words())
        if self.npz:
            results.write_npz(self.npz, estimation.payload_system(problem))
        self.write_view(lambda: views.view_of_answer(setup.robot, loaded[0], result))
        return answer.verdict.level != "do_not_use"


class _Weigh(_Compared):
    needs: ClassVar = {"friction_change": ("robot_parameters",)}  # a difference of torques frees friction
    instead: ClassVar = dict.fromkeys(("robot_parameters", "moving"), "static")

    moving: values.Joints | None = None
    """Joints that move (default: found in the recordings)."""
    static: bool = False
    """Weigh at rest: the arm stands still in poses, each reached from both sides (see near --static)."""
    inertia: Annotated[str | None, Parameter(metavar="box:AxBxC|cylinder:DxL")] = None
    """Assume the inertia of this body, in mm, if none is measured."""

    def __call__(self) -> bool:
        constraints, stored = self.constraints(), self.stored
        stand_in = estimation.StandIn.parse(self.inertia) if self.inertia is not None else None
        setup = self.setup(stored)
        loaded, unloaded = setup.read(self.loaded), setup.read(self.unloaded)
        gains = self.errors(setup, loaded, unloaded, stored)
        with status("reading") as progress, _constraints_solved():
            change, known = self.friction_change, stored.estimate if stored else None
            settings = setup.settings(progress, gains=gains, joints=self.moving, friction_change=change)
            if self.static:
                result = estimation.weigh_at_rest(setup.robot, loaded, unloaded, constraints, settings)
            else:
                result = estimation.weigh(setup.robot, loaded, unloaded, known, constraints, settings)
            result = result.assuming(stand_in) if stand_in is not None else result
        spare = "--inertia is not needed: the inertia was measured well enough."
        measured = stand_in is not None and not result.assumed
        shown = payload_report(result, self.document, [spare] if measured else [])
        self.give(shown, lambda: result, setup.in_words())
        self.write_view(lambda: views.view_of_answer(setup.robot, loaded[0], result))
        return result.verdict.level != "do_not_use"


@contextmanager
def _constraints_solved() -> Iterator[None]:
    """Constraints that leave no body are the user's to mend."""
    try:
        yield
    except estimation.SolverError as error:
        raise InputError(str(error)) from None
