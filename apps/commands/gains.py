"""``dynident gains``: torque per motor current, from recordings without and with a known payload."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

from cyclopts import Parameter

from ... import estimation
from ...common.errors import InputError
from ...common.schema import read_toml
from .. import logs
from ..report.sections.robot import gains_report
from .entry import SETTING, Options, command
from .options import PageOptions, ProcessingOptions, RobotOptions
from .progress import status
from .values import DataFiles, FrictionTerms, LoadedFiles, PayloadFile, whole_numbers, with_sigma, word

_Masses = Annotated[tuple[tuple[float, ...], float | None], word(with_sigma, "KG[,KG..][+-KG]")]


class _Known(Options):
    unloaded: DataFiles
    """Recording of currents without the payload; repeatable."""
    loaded: LoadedFiles
    """Recording of currents with the payload; repeatable."""
    mass: _Masses | None = None
    """Mass of the payload, +- its standard deviation (default: 0); with several weights, one per --loaded."""
    payload: PayloadFile | None = None
    """File with mass, com and inertia_com, as far as known, instead of --mass."""
    friction: Annotated[FrictionTerms | None, SETTING] = None
    """Friction model: paper, or a list as for 'dynident identify' (default: as in the robot's file)."""
    mounting: Annotated[tuple[int, ...], word(whole_numbers, "N1,N2,..")] = ()
    """One number per --loaded; equal numbers share a centre of mass (default: all the same)."""

    def load(self) -> estimation.KnownLoad | list[estimation.KnownLoad]:
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


class _Processing(ProcessingOptions):
    """Processing without the gains that are asked for."""

    drive_gains: Annotated[None, Parameter(parse=False)] = None


@command
def run(*, arm: RobotOptions, known: _Known, processing: _Processing, files: PageOptions) -> bool:
    """Run it."""
    if isinstance(known.friction, estimation.Candidates):
        raise InputError("friction: gains are found with terms that are given: paper, or a list")
    load = known.load()
    setup = processing.setup(arm.load())
    robot = setup.robot
    plain = replace(robot, drives=replace(robot.drives, coupling=None))  # each motor's own current
    amperes = replace(setup, robot=plain, gains=(1.0,) * robot.n)
    for path in logs.grouped((*known.unloaded, *known.loaded)):
        naming = logs.named(path, plain, setup.log_map)
        if not naming.holds("current"):
            currents = naming.columns("current")
            raise InputError(
                f"{path}: has no motor currents ({currents[0]} .. {currents[-1]}), and torques need no gains: "
                "record currents, or map your column names in a --log-map"
            )
    unloaded, loaded = amperes.read(known.unloaded), amperes.read(known.loaded)
    with status("reading") as progress:
        settings = setup.settings(progress, friction=known.friction or robot.drives.friction)
        problem = estimation.gain_problem(robot, unloaded, loaded, load, known.mounting, settings)
        progress("estimating")
        gains = estimation.answer_gains(problem)
    shown = gains_report(gains, files.document)
    files.give(shown, lambda: gains, setup.in_words())
    return gains.judged.level != "do_not_use"
