"""``dynident identify``: the robot's own parameters."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Group, Parameter

from ... import estimation, model
from ...common.errors import InputError
from .. import report, rollout
from . import answered
from .entry import SETTING, command, options
from .options import EquationOptions, GainOptions, Options, ProcessingOptions, RobotOptions
from .progress import note, status
from .values import DataFile, Essential, FrictionTerms, HeldOutFile, number, word, words

if TYPE_CHECKING:
    from ...estimation.possible.prior import RobotPrior

_GAUGES = {"prior_mass": ("prior",), "prior_budget": ("prior",), "total_mass": ("base", "prior")}
"""Options, and with which choices of ``--constrained`` they count."""
_CLOSE = (
    "where the data contradict every robot, chi2 falls for ever as links grow: --total-mass 0 KG (KG: at most the "
    "whole arm's mass) bounds them; a longer recording that moves every joint is better"
)
"""Advice where no finite robot is nearest."""
_POSSIBLE = Parameter(group=Group("a robot that can exist", "Beside the free estimate."))


@options()
class _Identify(Options):
    """Recordings, and which robot that can exist is asked for beside the free estimate."""

    data: tuple[DataFile, ...]
    """Recording without payload; repeatable: several are recordings of one identification."""
    validate: tuple[HeldOutFile, ...] = ()
    """Another one, held out; repeatable."""
    essential: Annotated[Essential | None, SETTING] = None
    """Eliminate parameters until the error's standard deviation has grown by this ratio (default: 1.02), or until
    all relative standard deviations are within a percentage such as 10%."""
    friction: FrictionTerms | None = None
    """auto: load and root friction of the joints that show it (default); paper: Coulomb and viscous alone; or a
    list of FS, FV, FL, FR, FB@SPEED, FA, of all joints or of one (FL2)."""
    rollout: bool = False
    """Also predict the motion of the recordings held out, as 'dynident rollout' does."""
    constrained: Annotated[Literal["none", "base", "prior"] | None, _POSSIBLE] = None
    """Base parameters of the nearest robot that can exist, or all standard parameters, those that no data show by a
    prior (default: prior where the robot's file or --prior-mass gives a mass, else base)."""
    prior_mass: Annotated[float | None, word(number, "KG"), _POSSIBLE] = None
    """Mass of the moving links; prior: cylinders of this mass instead of the robot's file."""
    prior_budget: Annotated[float | None, word(number, "CHI2"), SETTING] = None
    """Rise of chi2 that the prior may cost (default: 1)."""
    total_mass: Annotated[tuple[float, float] | None, words(number, "LOW HIGH"), _POSSIBLE] = None
    """Bounds of the mass of all links [kg]."""

    def check(self) -> None:
        """Refuse options that would have no effect."""
        if self.rollout and not self.validate:
            raise InputError("--rollout predicts recordings that were not fitted: give some by --validate")
        for name, gauges in _GAUGES.items():
            if self.constrained not in (None, *gauges):
                self.refuse(name, f"belongs to --constrained {' or '.join(gauges)}, not {self.constrained}")

    def possible(self, result: estimation.Identification) -> estimation.PossibleRobot | None:
        """The robot that can exist, as asked for."""
        if self.constrained == "none":
            return None
        robot, base, estimate = result.robot, result.base, result.estimate
        prior = self._prior(robot)
        mass = estimation.MassBounds(*self.total_mass) if self.total_mass else None
        budget = estimation.BUDGET if self.prior_budget is None else self.prior_budget
        try:
            if prior is None:
                return estimation.solve_constrained_base(robot, base, estimate, mass)
            return estimation.solve_constrained_prior(robot, base, estimate, prior, budget, mass)
        except estimation.SolverError as error:
            if self.total_mass is not None:
                low, high = self.total_mass
                bounds = f"--total-mass: links of {low:g} to {high:g} kg in all leave no robot near the data"
                raise InputError(f"{bounds}: give wider bounds, or leave them out ({error})") from error
            if self.constrained == "prior":
                raise InputError(f"{error}; --constrained none leaves it out") from error
            note(f"no robot that can exist is given, and so no export: {error}; {_CLOSE}")
            return None

    def _prior(self, robot: model.Robot) -> RobotPrior | None:
        """The prior of the links; None where base parameters are asked for, or none is known that can exist."""
        told = (self.constrained, self.prior_mass, self.prior_budget) != (None, None, None)
        if self.constrained == "base":
            return None
        if not told and not estimation.has_prior(robot):
            note(
                "single links are left open, for their mass is not known: --prior-mass KG (of the moving links) "
                "gives links that can exist, as simulators need them"
            )
            return None
        try:
            return estimation.robot_prior(robot, self.prior_mass)
        except InputError as error:  # links of CAD often cannot exist
            if self.constrained is not None or self.prior_mass is not None:
                raise
            self.refuse("prior_budget", f"needs a prior: {error}")
            note(f"single links are left open: {error}, or --prior-mass KG (of the moving links)")
            return None


@command
def run(
    *,
    arm: RobotOptions,
    request: _Identify,
    drives: GainOptions,
    processing: ProcessingOptions,
    files: EquationOptions,
) -> int:
    """Run it."""
    setup = processing.setup(arm.load())
    request.check()
    recordings, held_out = setup.read(request.data), setup.read(request.validate)
    gains = drives.errors(setup, [], recordings)
    rollouts: tuple[rollout.Rollout, ...] = ()
    with status("reading") as progress:
        settings = estimation.Settings(setup.processing, essential=request.essential, progress=progress)
        settings = settings if request.friction is None else replace(settings, friction=request.friction)
        result = estimation.identify(setup.robot, recordings, settings, held_out, gains)
        possible = request.possible(result)
        if request.rollout:
            values = possible.values if possible is not None else result.estimate.values
            rollouts = rollout.roll_out_all(result.robot, values, held_out, settings)
    told = estimation.robot_result(result, possible, tuple(map(report.documents.rollout_document, rollouts)))
    shown = report.robot_report(told, rollouts, files.document)
    files.give(shown, lambda: told, setup.in_words())
    files.write_equations(lambda: estimation.identification_system(result))
    return answered(result.verdict.level)
