"""``dynident gains``: torque per motor current, from recordings without and with a known payload."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

from .. import estimation, report
from . import ANSWERED, DO_NOT_USE
from .options import Options, ProcessingOptions, ResultOptions, RobotOptions, add_command, option
from .progress import status


@dataclass(frozen=True)
class _Known(Options):
    """Recordings, and the payload that is known."""

    unloaded: tuple[str, ...] = option(
        reads="without payload",
        action="append",
        required=True,
        metavar="LOG",
        help="currents without payload; repeatable",
    )
    loaded: tuple[str, ...] = option(
        reads="with payload", action="append", required=True, metavar="LOG", help="currents with it; repeatable"
    )
    mass: float | None = option(either="load!", type=float, metavar="KG", help="the payload's mass")
    payload: str | None = option(
        either="load!", reads="payload", metavar="TOML", help="mass, com, inertia_com as far as they are known"
    )
    mass_sigma: float | None = option(type=float, metavar="KG", help="its standard deviation (default: 0)")

    def load(self) -> estimation.gains.KnownLoad:
        """What is known of the payload."""
        if self.payload:
            self.refuse("mass_sigma", "belongs to --mass; in a payload's file it is the key mass_sigma")
            return estimation.gains.read_known_load(self.payload)
        assert self.mass is not None
        return estimation.gains.known_mass(self.mass, self.mass_sigma or 0.0)


class _Processing(ProcessingOptions):
    """Processing without the gains that are asked for."""

    WITHOUT: ClassVar[frozenset[str]] = frozenset({"drive_gains"})


def add_parser(commands: Any) -> None:
    """Arguments of the command."""
    add_command(commands, "gains", run, RobotOptions, _Known, _Processing, ResultOptions)


def run(arm: RobotOptions, known: _Known, processing: _Processing, files: ResultOptions) -> int:
    """Run it."""
    load = known.load()
    setup = processing.setup(arm.load())
    robot = setup.robot
    plain = replace(robot, drives=replace(robot.drives, coupling=None))  # each motor's own current
    amperes = replace(setup, robot=plain, gains=(1.0,) * robot.n)
    unloaded, loaded = amperes.read(known.unloaded), amperes.read(known.loaded)
    with status("reading") as progress:
        problem = estimation.gains.gain_problem(robot, unloaded, loaded, setup.processing, progress, load)
        progress("estimating")
        gains = estimation.identify_gains(problem, load)
    report.print_blocks(report.gains_screen(gains))
    files.write_json(lambda: report.documents.gains_document(gains, setup.processing))
    return ANSWERED if any(gains.identified) else DO_NOT_USE
