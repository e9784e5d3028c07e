"""``dynident identify``: the robot's own parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ... import estimation, model
from ...common.errors import InputError
from ...common.progress import Progress
from .. import report
from .. import rollout as rollouts
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

    ABOUT = "beside the free estimate"

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

    def gauge(self, robot: model.Robot) -> str:
        """What is asked for, or what the robot's file allows; tells where a mass is missing."""
        if self.constrained is not None:
            return self.constrained
        if self.prior_mass is not None or self.prior_budget is not None or estimation.has_prior(robot):
            return "prior"
        note(
            "single links are left open, for their mass is not known: --prior-mass KG (of the moving links) gives "
            "links that can exist, as simulators need them"
        )
        return "base"

    def possible(self, result: estimation.Identification) -> estimation.PossibleRobot | None:
        """The robot that can exist, as asked for."""
        gauge = self.gauge(result.robot)
        if gauge == "none":
            return None
        try:
            if gauge == "prior" and self.constrained is None and self.prior_mass is None:
                return self._nearest_own_prior(result)
            return self._nearest_prior(result) if gauge == "prior" else self._nearest(result)
        except estimation.SolverError as error:
            if self.constrained == "prior" or self.total_mass is not None:
                raise InputError(f"{error}; --constrained none leaves it out") from error
            note(f"no robot that can exist is given, and so no export: {error}; {_CLOSE}")
            return None

    def _nearest_own_prior(self, result: estimation.Identification) -> estimation.PossibleRobot:
        """By the robot's own file, unless its links cannot exist themselves, as links of CAD often cannot."""
        try:
            estimation.robot_prior(result.robot)
        except InputError as error:
            self.refuse("prior_budget", f"needs a prior: {error}")
            note(f"single links are left open: {error}, or --prior-mass KG (of the moving links)")
            return self._nearest(result)
        return self._nearest_prior(result)

    def _nearest(self, result: estimation.Identification) -> estimation.PossibleRobot:
        return estimation.solve_constrained_base(result.robot, result.base, result.estimate, self._mass())

    def _nearest_prior(self, result: estimation.Identification) -> estimation.PriorRobot:
        budget = estimation.BUDGET if self.prior_budget is None else self.prior_budget
        prior = estimation.robot_prior(result.robot, self.prior_mass)
        return estimation.solve_constrained_prior(
            result.robot, result.base, result.estimate, prior, budget, self._mass()
        )

    def _mass(self) -> estimation.MassBounds | None:
        return estimation.MassBounds(*self.total_mass) if self.total_mass else None

    def rollouts(
        self,
        result: estimation.Identification,
        possible: estimation.PossibleRobot | None,
        held_out: Sequence[model.Recording],
        processing: model.Processing,
        progress: Progress,
    ) -> tuple[rollouts.Rollout, ...]:
        """Predicted motion of the recordings held out, where it was asked for."""
        if not self.rollout:
            return ()
        values = possible.values if possible is not None else result.estimate.values
        return rollouts.roll_out_all(result.robot, values, held_out, processing, progress=progress)


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
    with status("reading") as progress:
        result = estimation.identify(
            setup.robot, recordings, setup.processing, held_out, progress, True, essential.essential, gains
        )
        possible = request.possible(result)
        rollouts = request.rollouts(result, possible, held_out, setup.processing, progress)
    files.show(report.robot_screen(result, possible, rollouts, files.document))
    files.write_json(
        lambda: report.documents.identification_document(result, setup.processing, setup.gains, possible, rollouts)
    )

    def page() -> report.Page:
        provenance = files.provenance(setup.in_words(), request, arm, processing)
        return _page(result, possible, rollouts, provenance, len(held_out or recordings))

    files.write_page(page)
    files.write_equations(lambda: estimation.identification_system(result, recordings, setup.processing))
    return answered(result.verdict.level)


def _page(
    result: estimation.Identification,
    possible: estimation.PossibleRobot | None,
    rollouts: Sequence[rollouts.Rollout],
    provenance: report.Provenance,
    recorded: int,
) -> report.Page:
    """The report; ``recorded``: how many recordings could be drawn."""
    return report.robot_page(
        result,
        possible,
        result.predictions,
        result.excitation,
        provenance,
        others=recorded - len(result.predictions),
        extra=[report.rollout_section(rollouts)] if rollouts else [],
    )
