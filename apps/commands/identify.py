"""``dynident identify``: the robot's own parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from ... import estimation, model
from ...common.errors import InputError
from .. import report, rollout
from . import answered
from .options import (
    EquationOptions,
    EssentialOptions,
    GainOptions,
    Options,
    ProcessingOptions,
    RobotOptions,
    option,
)
from .progress import note, status
from .values import number

if TYPE_CHECKING:
    from ...estimation.possible.prior import RobotPrior
_POSSIBLE = "a robot that can exist"
_GAUGES = {"prior_mass": ("prior",), "prior_budget": ("prior",), "total_mass": ("base", "prior")}
"""Options, and with which choices of ``--constrained`` they count."""
_CLOSE = (
    "where the data contradict every robot, chi2 falls for ever as links grow: --total-mass 0 KG (KG: at most the "
    "whole arm's mass) bounds them; a longer recording that moves every joint is better"
)
"""What to do where no finite robot is nearest."""


@dataclass(frozen=True)
class _Identify(Options):
    """Recordings, and which robot that can exist is asked for beside the free estimate."""

    ABOUT: ClassVar[Mapping[str, str]] = {_POSSIBLE: "beside the free estimate"}

    data: tuple[str, ...] = option(
        reads="without payload",
        action="append",
        required=True,
        metavar="LOG",
        help="recording without payload; repeatable: several are recordings of one identification",
    )
    validate: tuple[str, ...] = option(
        reads="held out", action="append", default=[], metavar="LOG", help="another one, held out; repeatable"
    )
    constrained: str | None = option(
        group=_POSSIBLE,
        choices=("none", "base", "prior"),
        help="base parameters of the nearest robot that can exist, or all standard parameters, those that no data "
        "show by a prior (default: prior where the robot's file or --prior-mass gives a mass, else base)",
    )
    prior_mass: float | None = option(
        group=_POSSIBLE,
        type=number,
        metavar="KG",
        help="of the moving links; prior: cylinders of this mass instead of the robot's file",
    )
    prior_budget: float | None = option(
        group=_POSSIBLE, type=number, metavar="CHI2", help="what the prior may cost in chi2 (default: 1)"
    )
    total_mass: tuple[float, float] | None = option(
        group=_POSSIBLE, nargs=2, type=number, metavar=("LOW", "HIGH"), help="of all links [kg]"
    )

    rollout: bool = option(
        action="store_true", help="also predict the motion of the recordings held out, as 'dynident rollout' does"
    )

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
        mass, prior = estimation.MassBounds(*self.total_mass) if self.total_mass else None, self._prior(robot)
        budget = estimation.BUDGET if self.prior_budget is None else self.prior_budget
        try:
            if prior is None:
                return estimation.solve_constrained_base(robot, base, estimate, mass)
            return estimation.solve_constrained_prior(robot, base, estimate, prior, budget, mass)
        except estimation.SolverError as error:
            if self.constrained == "prior" or self.total_mass is not None:
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


def run(
    arm: RobotOptions,
    request: _Identify,
    essential: EssentialOptions,
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
        result = estimation.identify(
            setup.robot, recordings, setup.processing, held_out, progress, True, essential.essential, gains
        )
        possible = request.possible(result)
        if request.rollout:
            values = possible.values if possible is not None else result.estimate.values
            rollouts = rollout.roll_out_all(result.robot, values, held_out, setup.processing, progress=progress)
    told = estimation.robot_result(result, possible, tuple(map(report.documents.rollout_document, rollouts)))
    files.show(report.robot_screen(told, rollouts, files.document))
    files.write_json(lambda: told)

    def page() -> report.Page:
        provenance = files.provenance(setup.in_words(), request, arm, processing)
        others = len(held_out or recordings) - len(result.predictions)
        return report.robot_page(told, provenance, others, rollouts)

    files.write_page(page)
    files.write_equations(lambda: estimation.identification_system(result, recordings, setup.processing))
    return answered(result.verdict.level)
