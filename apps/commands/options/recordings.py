"""Options of logs and of their processing, and what they come to: a setup that recordings are read with."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar, Literal

from .... import estimation, model
from ....common.errors import InputError
from ....common.progress import each
from ... import logs, results
from ...logs.map import LogMap, read_log_map
from ..progress import note, status
from ..values import fraction, gains_list, gains_or_file, number, positive, texts
from .reading import Options, about, option

_PROCESSING = "processing"


@dataclass(frozen=True, eq=False)
class Setup:
    """What recordings are read and identified with.

    Attributes:
        robot: with the structure that is asked for.
        gains: torque per current [N·m/A], if currents are read.
        identified: how sure they are, if ``dynident gains`` found them.
        told: notes that were printed already.
    """

    robot: model.Robot
    processing: model.Processing
    gains: tuple[float, ...] | None
    identified: estimation.Gains | None
    log_map: LogMap
    told: set[str] = field(default_factory=set)

    def read(self, paths: Sequence[str]) -> list[model.Recording]:
        """Read recordings, one with gaps as its pieces; what a file says of how it was read is told once."""
        with status("reading") as progress:
            recordings = [
                piece
                for path in each(paths, lambda path: f"reading {path}", progress)
                for piece in self.pieces(path)
            ]
        for recording in recordings:
            for text in recording.notes:
                about = text.split(": ", 1)[1]
                if about not in self.told:
                    self.told.add(about)
                    note(text)
        return recordings

    def pieces(self, path: str) -> tuple[model.Recording, ...]:
        """A recording, split where rows are missing."""
        return logs.read_recordings(path, self.robot, self.gains, self.log_map, self.processing)

    def in_words(self) -> dict[str, str]:
        """Robot and processing for the report."""
        robot, processing = self.robot, self.processing
        rate = f"{processing.rate:g} Hz" if processing.rate else "the recording's own"
        cutoff = f"{processing.cutoff:g} Hz" if processing.cutoff else "none"
        grid_rate = processing.equation_rate
        gains = ", ".join(f"{gain:g}" for gain in self.gains) if self.gains else "torques were read"
        words = {
            "robot": f"{robot.title or robot.name} ({robot.name})",
            "sampling rate": rate,
            "low-pass (Butterworth, 4th order, zero phase)": cutoff,
            "decimation": str(processing.decimate) if grid_rate is None else f"to {grid_rate:g} Hz",
            "slow rows left out below": _slow(processing),
            "drive gains [N·m/A]": gains,
            "offset of each joint": "identified" if robot.drives.offsets else "none",
        }
        if robot.coupling is not None:
            words["Coulomb friction of coupled drives"] = robot.coupling.coulomb
        if robot.spring is not None:
            words["spring"] = f"known torque on joint {robot.spring.joint}"
        return words


@dataclass(frozen=True)
class LogOptions(Options):
    """How logs are read."""

    GROUP: ClassVar[str] = "logs"
    ABOUT: ClassVar[str] = "CSV, TSV, NPZ, MAT, Parquet, ROS 2 bags; see docs/logs.md"

    log_map: str | None = option(reads="log map", metavar="TOML", help="columns, units, side and signs of the logs")
    joints: tuple[str, ...] = option(type=texts, default=(), metavar="A,B,..", help="joints by name, base to tip")
    units: tuple[str, ...] = option(type=texts, default=(), metavar="q=deg,..", help="units of q, qd, tau, i, t")
    signs: tuple[float, ...] = option(
        type=gains_list, default=(), metavar="1,-1,..", help="turn the sense of joints"
    )
    topic: str = option(default="", metavar="NAME", help="ROS 2 bag: which joint states")
    drive_gains: tuple[float, ...] | str | None = option(
        reads="drive gains",
        type=gains_or_file,
        metavar="K|K1,K2,..|JSON",
        help="torque per current [N·m/A], or the --json of 'dynident gains'",
    )

    def how(self) -> LogMap:
        """The map of ``--log-map`` with what the other options change."""
        log_map = read_log_map(self.log_map) if self.log_map else LogMap(source="command line")
        return logs.with_flags(log_map, self.joints, self.units, self.signs, self.topic)

    def gains(self, robot: model.Robot) -> tuple[tuple[float, ...] | None, estimation.Gains | None]:
        """Torque per current, and what a file of gains says besides."""
        if not isinstance(self.drive_gains, str):
            gains = self.drive_gains
            return gains and (gains * robot.n if len(gains) == 1 else gains), None
        stored = results.read_stored_gains(self.drive_gains)
        stored.check(robot, self.drive_gains)
        return stored.values, stored


@dataclass(frozen=True)
class ProcessingOptions(LogOptions):
    """How logs are read, settings of filtering and of the model's structure."""

    rate: float | None = option(group=_PROCESSING, type=number, metavar="HZ", help="resample to this even rate")
    cutoff: float | None = option(
        group=_PROCESSING, type=number, metavar="HZ", help="low-pass on positions and speeds"
    )
    equation_rate: float | None = option(
        group=_PROCESSING, type=number, metavar="HZ", help="decimate Y and W alike, to about this rate"
    )
    decimate: int | None = option(
        group=_PROCESSING, type=positive, metavar="N", help="the same by a whole factor (until the next version)"
    )
    offsets: bool | None = option(
        group=_PROCESSING, action=argparse.BooleanOptionalAction, help="a constant torque per joint"
    )
    coulomb: Literal["sum", "paper"] | None = option(
        group=_PROCESSING, choices=("sum", "paper"), help="Coulomb friction of coupled drives"
    )

    def setup(self, robot: model.Robot, stored: results.StoredRobot | None = None) -> Setup:
        """The robot with the model structure and processing that the command line asks for.

        Args:
            stored: its parameters from a file, whose structure it takes.
        """
        gains, identified = self.gains(robot)
        if stored:
            robot = stored.applied_to(robot)
            stored.check_gains(gains)
        with about("--coulomb"):
            robot = robot if self.coulomb is None else robot.with_coulomb(self.coulomb)
        robot = robot if self.offsets is None else robot.with_offsets(self.offsets)
        if stored and robot.fingerprint != stored.fingerprint:
            raise InputError("--offsets and --coulomb must be those the stored parameters were identified with")
        settings = self._settings()
        with about(*(f"--{name.replace('_', '-')}" for name in settings if self.has(name))):
            processing = replace(robot.processing, **settings)
        return Setup(robot, processing, gains, identified, self.how())

    def _settings(self) -> dict[str, Any]:
        """Settings of processing that were given; options are called as they are."""
        settings = {entry.name for entry in fields(model.Processing)}
        if self.has("equation_rate") and self.has("decimate"):
            raise InputError("--equation-rate and --decimate say the same: give one of them")
        # What is given takes the place of either in the robot's file.
        either = {"decimate": 1, "equation_rate": None}
        rates = either if self.has("equation_rate") or self.has("decimate") else {}
        return rates | {entry.name: getattr(self, entry.name) for entry in fields(self)
                if entry.name in settings and self.has(entry.name)}  # fmt: skip


@dataclass(frozen=True)
class FilterOptions(ProcessingOptions):
    """Settings of filtering without those of decimation, for commands that build no equations of thinned rows."""

    WITHOUT: ClassVar[frozenset[str]] = frozenset({"decimate", "equation_rate"})


@dataclass(frozen=True)
class PairOptions(ProcessingOptions):
    """Settings for recordings with and without payload."""

    max_mismatch: float | None = option(
        group=_PROCESSING,
        type=number,
        metavar="RAD",
        help="largest difference of position with and without payload after alignment, rms of the worst joint "
        "(payload: method 3; default: 0.01)",
    )


@dataclass(frozen=True)
class EssentialOptions(Options):
    """When the elimination of parameters ends: one rule or the other."""

    essential_ratio: float | None = option(
        either="rule",
        type=number,
        metavar="RATIO",
        help="eliminate parameters until the error's standard deviation has grown by this (default: 1.02)",
    )
    essential_sigma: float | None = option(
        either="rule",
        type=fraction,
        metavar="PERCENT",
        help="or until all relative standard deviations are within this, such as 10%%",
    )

    def rule(self) -> estimation.StopRule | None:
        """The rule asked for; None for the default."""
        if self.essential_sigma is not None:
            return estimation.SigmaBound(self.essential_sigma)
        return estimation.SigmaRatio(self.essential_ratio) if self.essential_ratio is not None else None


def _slow(processing: model.Processing) -> str:
    """Which rows are too slow to be used."""
    share = f"{100.0 * processing.slow_fraction:g} % of a joint's largest speed"
    speeds = processing.slow_speed if isinstance(processing.slow_speed, tuple) else (processing.slow_speed,)
    return f"{share}, and {', '.join(f'{speed:g}' for speed in speeds)} rad/s or m/s" if any(speeds) else share
