"""``dynident fleet simulate``: a fleet that never was, with the truth beside, for tests and benchmarks."""

from __future__ import annotations

import argparse
import hashlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np

from ... import estimation, model, trajectories
from ...common.arrays import Array
from ...common.errors import InputError
from ...common.files import csv_table, made_folder, write_bytes, write_text
from .. import fleet, report
from ..fleet.simulated import Scenario, TrueArm, TrueNight, damaged, simulated_arms
from . import ANSWERED
from .options import Options, option, print_lines
from .progress import bar
from .simulate import rate, root_mean_square
from .values import checked, fraction, number, positive, share, whole

_USUAL = Scenario()
_GONE = {"cut": "cut short (simulated)", "clock": "its clock runs back (simulated)"}


def _day(text: str) -> date:
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is no date such as 2026-01-31") from None


def _part(text: str) -> float:
    """A percentage from 0 to 100."""
    value = fraction(text)
    return checked(value, 0.0 <= value <= 1.0, text, "a percentage from 0 to 100%")


def _change(text: str) -> float:
    """A percentage above -100."""
    value = fraction(text)
    return checked(value, -1.0 < value < 100.0, text, "a percentage above -100%")


def _load(text: str) -> float:
    """A mass of at least 0 [kg]."""
    value = number(text)
    return checked(value, 0.0 <= value < 1e4, text, "a mass of at least 0 kg")


def _drawn(field: str, how: Callable[[str], Any], metavar: str, help: str, unit: str = "") -> Any:
    """An option of the scenario, with the scenario's own default."""
    value = getattr(_USUAL, field)
    figure = f"{100.0 * value:g}%%" if metavar == "SHARE" else f"{value}{unit}"
    return option(type=how, default=value, metavar=metavar, help=f"{help} (default: {figure})")


@dataclass(frozen=True)
class _Simulate(Options):
    """Robots, what happens to them, and where it goes."""

    robots: tuple[str, ...] = option(
        "robots",
        reads="robot",
        nargs="+",
        metavar="ROBOT",
        help="types: names or TOML files; see 'dynident robot list'",
    )
    out: str = option(writes="folder", required=True, metavar="DIR", help="a folder for each type, and truth.json")
    equations: bool = option(
        action="store_true", help="a store of reduced equations for each type, drawn, instead of recordings"
    )
    arms: int = _drawn("arms", positive, "N", "arms of each type")
    days: int = _drawn("days", positive, "N", "a recording each")
    first: date = _drawn("first", _day, "DATE", "first day")
    coulomb: float = _drawn("coulomb", _part, "SHARE", "scatter of Coulomb friction from day to day")
    viscous: float = _drawn("viscous", _part, "SHARE", "scatter of viscous friction from day to day")
    memory: float = _drawn("memory", share, "PHI", "of that scatter: 0 for days that know nothing of each other")
    per_kelvin: float = _drawn("per_kelvin", _part, "SHARE", "by which friction falls with each kelvin")
    apart: float = _drawn("apart", _part, "SHARE", "by which arms of one type differ")
    worn: int = _drawn("worn", whole, "N", "arms of each type whose Coulomb friction changes on one axis")
    wear: float = _drawn("wear", _change, "SHARE", "by which it changes")
    laden: int = _drawn("laden", whole, "N", "arms of each type with a payload that the controller is not told")
    load: float = _drawn("load", _load, "KG", "its mass", " kg")
    replaced: int = _drawn("replaced", whole, "N", "arms of each type replaced by another of the same name")
    missing: float = _drawn("missing", _part, "SHARE", "of the logs that are not there")
    damaged: float = _drawn("damaged", _part, "SHARE", "of the logs that are cut short or whose clock runs back")
    noise: float = option(
        type=share, default=0.05, metavar="SHARE", help="of each joint's torque, as white noise (default: 0.05)"
    )
    points: int = option(
        type=positive, default=16, metavar="N", help="random points of the motion that all run (default: 16)"
    )
    rate: float = option(type=rate, default=250.0, metavar="HZ", help="of the recordings (default: 250)")
    seed: int = _drawn("seed", whole, "N", "of all that is drawn")

    def scenario(self) -> Scenario:
        """What the fleet goes through."""
        return Scenario(**{name: getattr(self, name) for name in Scenario.__dataclass_fields__})


def run(request: _Simulate) -> int:
    """Run it."""
    scenario = request.scenario()
    types = [model.with_stand_in(model.load_robot(name)) for name in request.robots]
    _check_names([robot.name for robot in types])
    known = [(robot, simulated_arms(robot, scenario)) for robot in types]
    players = [_Player.of(robot, request) for robot in types]
    root, lines = Path(made_folder(request.out)), list[str]()
    for player, (robot, arms) in zip(players, known, strict=True):
        folder = Path(made_folder(root / robot.name))
        with bar(f"simulating {robot.name}") as progress:
            (player.write_store if request.equations else player.write_logs)(folder, arms, progress)
        _write_tables(folder, arms, request.equations)
        contents = "a store of equations" if request.equations else "recordings and robots.csv"
        lines.append(f"{folder}: {len(arms)} arms, {scenario.days} days each: {contents}; truth.csv")
    write_bytes(root / "truth.json", report.documents.json_text(report.documents.truth_document(scenario, known)))
    print_lines(*lines, f"{root / 'truth.json'}: what is true of them")
    return ANSWERED


def _check_names(names: Sequence[str]) -> None:
    """Refuse types that would share a folder, or whose names lead elsewhere."""
    if twice := {name for name in names if names.count(name) > 1}:
        raise InputError(f"robots: {twice.pop()!r} twice: give each type once")
    for name in names:
        if name != Path(name).name or name == "..":
            raise InputError(f"robots: {name!r} is no name of a folder, which each type gets: give it another name")


@dataclass(frozen=True)
class _Player:
    """Runs one motion with all arms of a type.

    ``motion``: exact; ``noise``: standard deviation of each joint's torque, shape (n,); ``seed``: of the noise.
    """

    simulator: trajectories.Simulator
    motion: model.Motion
    noise: Array
    seed: int

    @staticmethod
    def of(robot: model.Robot, request: _Simulate) -> _Player:
        """A player with a random motion of the type."""
        try:
            points = trajectories.motions.random_points(robot, request.points, request.seed)
            plan = trajectories.plan_point_to_point(robot, points)
        except ValueError as error:
            raise InputError(f"{robot.name}: {error}") from None
        noise = request.noise * root_mean_square(robot, [plan])
        return _Player(trajectories.Simulator(robot), plan.motion(request.rate), noise, request.seed)

    def recording(self, night: TrueNight, seed: Sequence[int]) -> model.Recording:
        """What a night's log holds."""
        return self.simulator.record(
            self.motion, night.payload, self.noise, [self.seed, *seed], night.day, night.parameters
        )

    def write_logs(self, folder: Path, arms: Sequence[TrueArm], progress: Callable[[float], None]) -> None:
        """A CSV for each night whose log is there."""
        for k, d, arm, night in _nights(arms, progress):
            if night.log == "missing":
                continue
            path = Path(made_folder(folder / "logs" / arm.name)) / f"{night.day}.csv"
            text = report.recordings.recording_text(self.recording(night, [k, d]))
            write_text(path, damaged(text, night.log))

    def write_store(self, folder: Path, arms: Sequence[TrueArm], progress: Callable[[float], None]) -> None:
        """A store of passports, drawn on the equations of the first night's recording.

        Raises:
            InputError: if that motion does not determine the robot's parameters.
        """
        robot = self.simulator.robot
        recipe = fleet.Recipe("identify", robot.processing)
        result = estimation.identify(robot, [self.recording(arms[0].nights[0], [0, 0])])
        log = fleet.Log("without payload", "the motion", hashlib.sha256(self.motion.q.tobytes()).hexdigest())
        passport = fleet.robot_passport(result, recipe, [log])
        store, noise = fleet.Store.made(folder / "store", robot, recipe), fleet.drawing.noise_of(passport)
        rows, refused = {}, {}
        for k, d, arm, night in _nights(arms, progress):
            name, about = f"{arm.name}/{night.day}.csv", _about(arm, night)
            if night.log in _GONE:
                refused[name] = _GONE[night.log]
            if night.log != "good":
                continue
            values = result.base.grouping @ self.simulator.parameters(night.payload, night.parameters)
            draw = np.random.default_rng([self.seed, k, d])
            drawn_passport = fleet.drawing.drawn(passport, values, noise, draw, name, about)
            key = fleet.store.key_of(drawn_passport.logs[0].sha256, about, recipe)
            store.put(key, fleet.passport_bytes(drawn_passport))
            rows[name] = fleet.store.Row(name, drawn_passport.logs[0].sha256, about, key)
        store.finish(rows, refused)


def _nights(
    arms: Sequence[TrueArm], progress: Callable[[float], None]
) -> Iterator[tuple[int, int, TrueArm, TrueNight]]:
    count, done = sum(len(arm.nights) for arm in arms), 0
    for k, arm in enumerate(arms):
        for d, night in enumerate(arm.nights):
            yield k, d, arm, night
            done += 1
            progress(done / count)


def _about(arm: TrueArm, night: TrueNight) -> dict[str, str]:
    return {"arm": arm.name, "day": night.day, "temperature": f"{night.temperature:g}", "payload": "0"}


def _write_tables(folder: Path, arms: Sequence[TrueArm], equations: bool) -> None:
    """The table for ``fleet reduce``, unless it is reduced already, and the truth of each night."""
    frictions = [name for name in arms[0].parameters if model.names.parameter_kind(name) in fleet.series.RELATIVE]
    nights = [(arm, night) for arm in arms for night in arm.nights]
    truth = [
        [
            *(arm.name, night.day, f"{night.temperature:g}", f"{night.carried:g}", night.log),
            *(f"{night.parameters[name]:.9g}" for name in frictions),
        ]
        for arm, night in nights
    ]
    if not equations:
        listed = [[f"logs/{arm.name}/{night.day}.csv", *_about(arm, night).values()] for arm, night in nights]
        write_text(folder / "robots.csv", csv_table(["file", "arm", "day", "temperature", "payload"], listed))
    write_text(folder / "truth.csv", csv_table(["arm", "day", "temperature", "carried", "log", *frictions], truth))
