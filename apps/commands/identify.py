"""``dynident identify``, ``rollout``, ``gains``: the robot's parameters and its drive gains from recordings."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from cyclopts import Group, Parameter

from ... import estimation
from ...common.errors import InputError
from ...common.schema import read_toml
from .. import logs, results
from ..report.sections.robot import gains_report, robot_report, rollout_report
from ..rollout import HORIZONS, Predict, mujoco_arm, roll_out_all
from . import values
from .entry import SETTING, note, status
from .options import EquationsFile, PageOptions, RecordingOptions
from .values import HeldOutFiles, Reads, different, number, numbers, where, with_sigma, word

_seconds = where(
    numbers,
    lambda times: min(times) > 0.0 and different(times),
    "a list of different times in seconds such as 0.1,0.5,1",
)
_TWO = word(partial(numbers, count=2), "LOW HIGH", 2)
_POSSIBLE = Parameter(group=Group("a robot that can exist", "Beside the free estimate."))


class _Identify(PageOptions, RecordingOptions):
    rules: ClassVar = {
        "rollout": ("validate",),  # it predicts recordings that were not fitted
        "prior_mass": {"constrained": ("prior", None)},
        "prior_budget": {"constrained": ("prior", None)},
        "total_mass": {"constrained": ("base", "prior", None)},
    }

    data: values.DataFiles
    """Recording without payload; repeatable."""
    validate: HeldOutFiles = ()
    """Recording that is kept out of the fit to test it; repeatable."""
    essential: Annotated[values.Essential | None, SETTING] = None
    """Eliminate parameters until the error's standard deviation has grown by this ratio (default: 1.02), or until
    all relative standard deviations are within a percentage such as 10%."""
    friction: values.FrictionTerms | None = None
    """auto (default): Coulomb and viscous, and what else the recordings show; paper: Coulomb and viscous only; or a
    list of FS, FV, FL, FR, FB@SPEED, FA, for all joints or for one (FL2)."""
    rollout: bool = False
    """Also predict the motion of the --validate recordings, as 'dynident rollout' does."""
    constrained: Annotated[Literal["none", "base", "prior"] | None, _POSSIBLE] = None
    """base: base parameters of the nearest physical robot; prior: all standard parameters, using a prior for those
    that no data determine (default: prior if the robot's file or --prior-mass gives a mass, else base)."""
    prior_mass: Annotated[float | None, word(number, "KG"), _POSSIBLE] = None
    """Mass of the moving links: the prior is cylinders of this mass instead of the robot's file."""
    prior_budget: Annotated[float | None, word(number, "CHI2"), SETTING] = None
    """Increase of chi2 that the prior may cost (default: 1)."""
    total_mass: Annotated[tuple[float, ...] | None, _TWO, _POSSIBLE] = None
    """Least and largest mass of all links together [kg]."""
    npz: EquationsFile | None = None

    def __call__(self) -> bool:
        setup = self.setup()
        recordings, held_out = setup.read(self.data), setup.read(self.validate)
        with status("reading") as progress:
            settings = self.settings(setup, progress, unloaded=recordings)
            result = estimation.identify(setup.robot, recordings, settings, held_out)
            possible = self.possible(result)
            parameters = possible.values if possible is not None else result.estimate.values
            rollouts = roll_out_all(result.robot, parameters, held_out, settings) if self.rollout else ()
        told = estimation.robot_result(result, possible, rollouts)
        self.give(robot_report(told, self.document), lambda: told, setup.in_words())
        if self.npz:
            results.write_npz(self.npz, estimation.identification_system(result))
        return result.verdict.level != "do_not_use"

    def possible(self, result: estimation.Identification) -> estimation.PossibleRobot | None:
        """The robot that can exist, as asked for."""
        if self.constrained == "none":
            return None
        robot, base, estimate = result.robot, result.base, result.estimate
        mass = estimation.MassBounds(*self.total_mass) if self.total_mass else None
        budget = estimation.BUDGET if self.prior_budget is None else self.prior_budget
        prior = None  # of the links, where one that can exist is known
        told = (self.constrained, self.prior_mass, self.prior_budget) != (None, None, None)
        if not told and not estimation.has_prior(robot):
            note(
                "single links are left open, for their mass is not known: --prior-mass KG (of the moving links) "
                "gives links that can exist, as simulators need them"
            )
        elif self.constrained != "base":
            try:
                prior = estimation.robot_prior(robot, self.prior_mass)
            except InputError as error:  # links of CAD often cannot exist
                if self.constrained is not None or self.prior_mass is not None:
                    raise
                self.refuse("prior_budget", f"needs a prior: {error}")
                note(f"single links are left open: {error}, or --prior-mass KG (of the moving links)")
        try:
            if prior is None:
                return estimation.solve_constrained_base(robot, base, estimate, mass)
            return estimation.solve_constrained_prior(robot, base, estimate, prior, budget, mass)
        except estimation.SolverError as error:
            if self.total_mass is not None:
                least, most = self.total_mass
                bounds = f"--total-mass: links of {least:g} to {most:g} kg in all leave no robot near the data"
                raise InputError(f"{bounds}: give wider bounds, or omit them ({error})") from error
            if self.constrained == "prior":
                raise InputError(f"{error}; --constrained none leaves it out") from error
            note(
                f"no robot that can exist is given, and so no export: {error}; where the data contradict every "
                "robot, chi2 falls for ever as links grow: --total-mass 0 KG (KG: at most the whole arm's mass) "
                "bounds them; a longer recording that moves every joint is better"
            )
            return None


class _Rollout(PageOptions, RecordingOptions, without=("equation_rate", "gain_sigma")):
    robot_parameters: values.RobotParametersFile
    """The --json of 'dynident identify'."""
    data: HeldOutFiles
    """Recording without payload that was not fitted; repeatable."""
    against: tuple[Annotated[str, Reads("other model"), Parameter(metavar="F.xml")], ...] = ()
    """Another model of the arm, MJCF or URDF, moved by MuJoCo; repeatable."""
    horizons: Annotated[tuple[float, ...], word(_seconds, "S1,S2,..")] = HORIZONS
    """Times after the start [s] (default: 0.1,0.5,1,2)."""

    def __call__(self) -> None:
        from ..report.documents import RolloutsDocument  # loads what designs need

        setup = self.setup()
        assert setup.stored is not None
        recordings = setup.read(self.data)
        models: dict[str, Predict] = {}
        for path in self.against:
            if (name := Path(path).name) in models:
                raise InputError(f"{path}: two models are called {name}: rename a file")
            models[name] = mujoco_arm(path, setup.robot)
        with status("reading") as progress:
            settings, parameters = self.settings(setup, progress), setup.stored.possible_values
            rollouts = roll_out_all(setup.robot, parameters, recordings, settings, self.horizons, models)
        shown = rollout_report(rollouts, setup.robot.title or setup.robot.name)
        self.give(shown, lambda: RolloutsDocument(setup.robot.name, rollouts), setup.in_words())


class _Gains(PageOptions, RecordingOptions, without=("drive_gains", "gain_sigma")):
    unloaded: values.DataFiles
    """Recording of currents without the payload; repeatable."""
    loaded: values.LoadedFiles
    """Recording of currents with the payload; repeatable."""
    mass: Annotated[tuple[tuple[float, ...], float | None] | None, word(with_sigma, "KG[,KG..][+-KG]")] = None
    """Mass of the payload, +- its standard deviation (default: 0); with several weights, one per --loaded."""
    payload: values.PayloadFile | None = None
    """File with mass, com and inertia_com, as far as known, instead of --mass."""
    friction: Annotated[values.FrictionTerms | None, SETTING] = None
    """Friction model: paper, or a list as for 'dynident identify' (default: as in the robot's file)."""
    mounting: Annotated[tuple[int, ...], word(values.whole_numbers, "N1,N2,..")] = ()
    """One number per --loaded; equal numbers share a centre of mass (default: all the same)."""

    def __call__(self) -> bool:
        if isinstance(self.friction, estimation.Candidates):
            raise InputError("friction: gains are found with terms that are given: paper, or a list")
        load = self.known()
        setup = self.setup()
        robot = setup.robot
        plain = replace(robot, drives=replace(robot.drives, coupling=None))  # each motor's own current
        amperes = replace(setup, robot=plain, gains=(1.0,) * robot.n)
        for path in logs.grouped((*self.unloaded, *self.loaded)):
            naming = logs.named(path, plain, setup.log_map)
            if not naming.holds("current"):
                currents = naming.columns("current")
                raise InputError(
                    f"{path}: has no motor currents ({currents[0]} .. {currents[-1]}), and torques need no gains: "
                    "record currents, or map your column names in a --log-map"
                )
        unloaded, loaded = amperes.read(self.unloaded), amperes.read(self.loaded)
        with status("reading") as progress:
            settings = self.settings(setup, progress, friction=self.friction or robot.drives.friction)
            problem = estimation.gain_problem(robot, unloaded, loaded, load, self.mounting, settings)
            progress("estimating")
            gains = estimation.answer_gains(problem)
        self.give(gains_report(gains, self.document), lambda: gains, setup.in_words())
        return gains.judged.level != "do_not_use"

    def known(self) -> estimation.KnownLoad | list[estimation.KnownLoad]:
        """The known payload, the same in all mountings or one for each."""
        if (self.payload is None) == (self.mass is None):
            raise InputError("the known payload is missing: give either --mass or --payload")
        if self.payload is not None:
            return read_toml(self.payload, estimation.KnownLoad)
        assert self.mass is not None
        weights, sigma = self.mass[0], self.mass[1] or 0.0
        if len(weights) == 1:
            return estimation.known_mass(weights[0], sigma)
        if len(weights) != len(self.loaded):
            count = f"--mass holds {len(weights)} numbers for {len(self.loaded)} --loaded recordings"
            raise InputError(f"{count}: give one mass, or one for each of them, in their order")
        masses: dict[int, float] = {}
        for mounting, mass in zip(self.mounting or (1,) * len(weights), weights, strict=False):
            if masses.setdefault(mounting, mass) != mass:
                both = f"mounting {mounting} has masses of {masses[mounting]:g} and {mass:g} kg"
                raise InputError(f"{both}: give each weight a number of its own (--mounting)")
        return [estimation.known_mass(mass, sigma) for mass in masses.values()]
