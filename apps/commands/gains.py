"""``dynident gains``: torque per motor current, from recordings without and with a known payload."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from ... import estimation
from ...common.errors import InputError
from .. import report
from . import answered
from .options import Options, PageOptions, ProcessingOptions, RobotOptions, option
from .progress import status
from .values import whole_list, with_sigma


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
    mass: tuple[tuple[float, ...], float | None] | None = option(
        either="load!",
        type=with_sigma,
        metavar="KG[,KG..][+-KG]",
        help="the payload's mass; of several weights one for each --loaded; +- their sigma (default: 0)",
    )
    payload: str | None = option(
        either="load!", reads="payload", metavar="TOML", help="mass, com, inertia_com as far as they are known"
    )
    mounting: tuple[int, ...] = option(
        type=whole_list,
        default=(),
        metavar="N1,N2,..",
        help="one number for each --loaded: equal ones share a centre of mass (default: all one)",
    )

    def load(self) -> estimation.KnownLoad | list[estimation.KnownLoad]:
        """What is known of the payload, the same in all mountings or one for each."""
        if self.payload:
            return estimation.read_known_load(self.payload)
        assert self.mass is not None
        weights, sigma = self.mass[0], self.mass[1] or 0.0
        if len(weights) == 1:
            return estimation.known_mass(weights[0], sigma)
        if len(weights) != len(self.loaded):
            raise InputError(
                f"--mass holds {len(weights)} numbers for {len(self.loaded)} --loaded recordings: give "
                "one mass, or one for each of them, in their order"
            )
        numbers = self.mounting or (1,) * len(self.loaded)
        masses: dict[int, float] = {}
        for mounting, mass in zip(numbers, weights, strict=False):
            if masses.setdefault(mounting, mass) != mass:
                raise InputError(
                    f"mounting {mounting} has masses of {masses[mounting]:g} and {mass:g} kg: give each weight a "
                    "number of its own (--mounting)"
                )
        return [estimation.known_mass(mass, sigma) for mass in masses.values()]


class _Processing(ProcessingOptions):
    """Processing without the gains that are asked for."""

    WITHOUT: ClassVar[frozenset[str]] = frozenset({"drive_gains"})


def run(arm: RobotOptions, known: _Known, processing: _Processing, files: PageOptions) -> int:
    """Run it."""
    load = known.load()
    setup = processing.setup(arm.load())
    robot = setup.robot
    plain = replace(robot, drives=replace(robot.drives, coupling=None))  # each motor's own current
    amperes = replace(setup, robot=plain, gains=(1.0,) * robot.n)
    unloaded, loaded = amperes.read(known.unloaded), amperes.read(known.loaded)
    with status("reading") as progress:
        problem = estimation.gain_problem(robot, unloaded, loaded, setup.processing, progress, load, known.mounting)
        progress("estimating")
        gains = estimation.identify_gains(problem, load)
    files.show(report.gains_screen(gains.result, files.document))
    files.write_json(lambda: gains.result)
    provenance = files.provenance
    files.write_page(lambda: report.gains_page(gains.result, provenance(setup.in_words(), known, arm, processing)))
    return answered(gains.verdict.level)
