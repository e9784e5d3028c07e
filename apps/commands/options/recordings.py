"""Options of logs and of their processing, and what they come to: a setup that recordings are read with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Annotated, Literal

from cyclopts import Parameter

from .... import estimation, model
from ....common.errors import InputError
from ....common.progress import each
from ... import logs, results
from ..entry import LOGS, SETTING, Options, about
from ..progress import note, status
from ..values import Hertz, LogMapFile, Reads, gains_or_file, number, numbers, texts, word

_Texts = Annotated[tuple[str, ...], word(texts, "A,B,..")]
_Units = Annotated[tuple[str, ...], word(texts, "q=deg,..")]
_Signs = Annotated[tuple[float, ...], word(numbers, "1,-1,..")]
_Gains = Annotated[tuple[float, ...] | str, Reads("drive gains"), word(gains_or_file, "K|K1,K2,..|JSON")]


@dataclass(frozen=True, eq=False)
class Setup:
    """Robot, processing and drive gains that recordings are read and identified with.

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
    log_map: logs.LogMap
    told: set[str] = field(default_factory=set)

    def read(self, paths: Sequence[str]) -> list[model.Recording]:
        """Read recordings, one with gaps as its pieces; what a file says of how it was read is told once."""
        with status("reading") as progress:
            recordings = [
                piece
                for path in each(paths, lambda path: f"reading {path}", progress)
                for piece in logs.read_recordings(path, self.robot, self.gains, self.log_map, self.processing)
            ]
        for text in (text for recording in recordings for text in recording.notes):
            about = text.split(": ", 1)[1]
            if about not in self.told:
                self.told.add(about)
                note(text)
        return recordings

    def in_words(self) -> dict[str, str]:
        """Robot and processing for the report."""
        robot, processing, grid_rate = self.robot, self.processing, self.processing.equation_rate
        speeds = processing.slow_speed if isinstance(processing.slow_speed, tuple) else (processing.slow_speed,)
        slow = f"{100.0 * processing.slow_fraction:g} % of a joint's largest speed"
        if any(speeds):
            slow += f", and {', '.join(f'{speed:g}' for speed in speeds)} rad/s or m/s"
        cutoff = f"{processing.cutoff:g} Hz" if processing.cutoff else "none"
        gains = ", ".join(f"{gain:g}" for gain in self.gains or ())
        words = {
            "robot": f"{robot.title or robot.name} ({robot.name})",
            "sampling rate": f"{processing.rate:g} Hz" if processing.rate else "the recording's own",
            "low-pass (Butterworth, 4th order, zero phase)": cutoff,
            "decimation": str(processing.decimate) if grid_rate is None else f"to {grid_rate:g} Hz",
            "slow rows left out below": slow,
            "drive gains [N·m/A]": gains or "torques were read",
            "offset of each joint": "identified" if robot.drives.offsets else "none",
        }
        if robot.coupling is not None:
            words["Coulomb friction of coupled drives"] = robot.coupling.coulomb
        if robot.spring is not None:
            words["spring"] = f"known torque on joint {robot.spring.joint}"
        return words


class LogOptions(Options, group=LOGS):
    """Columns, units and drive gains of logs."""

    log_map: LogMapFile | None = None
    """Columns, units, side and signs of the logs, topic of a ROS 2 bag."""
    joints: _Texts = ()
    """Joints by name, base to tip."""
    units: _Units = ()
    """Units of q, qd, tau, i, t."""
    signs: Annotated[_Signs, SETTING] = ()
    """Senses of the joints: -1 turns positions, speeds, torques and currents of one."""
    topic: Annotated[str, Parameter(metavar="NAME"), SETTING] = ""
    """Topic of a ROS 2 bag."""
    drive_gains: _Gains | None = None
    """Torque per current [N·m/A], or the --json of 'dynident gains'."""

    def how(self) -> logs.LogMap:
        """The map of ``--log-map`` with what the other options change."""
        log_map = logs.read_log_map(self.log_map) if self.log_map else logs.LogMap(source="command line")
        return logs.with_flags(log_map, self.joints, self.units, self.signs, self.topic)

    def gains(self, robot: model.Robot) -> tuple[tuple[float, ...] | None, estimation.Gains | None]:
        """Torque per current, and what a file of gains says besides."""
        if not isinstance(self.drive_gains, str):
            gains = self.drive_gains
            return gains and (gains * robot.n if len(gains) == 1 else gains), None
        stored = results.read_stored_gains(self.drive_gains)
        stored.check(robot, self.drive_gains)
        return stored.values, stored


class FilterOptions(LogOptions):
    """Logs, their filtering, and the structure of the model."""

    rate: Annotated[Hertz | None, SETTING] = None
    """Even rate that recordings are filtered down to."""
    cutoff: Hertz | None = None
    """Low-pass on positions and speeds."""
    offsets: Annotated[bool | None, Parameter(metavar="true|false"), SETTING] = None
    """A constant torque for each joint, or none (default: as the robot's file)."""
    coulomb: Annotated[Literal["sum", "paper"] | None, Parameter(metavar="sum|paper"), SETTING] = None
    """Coulomb friction of coupled drives."""

    def setup(self, robot: model.Robot, stored: estimation.RobotResult | None = None) -> Setup:
        """The robot with the model structure and processing that the command line asks for.

        Args:
            stored: its parameters from a file, whose structure it takes.
        """
        gains, identified = self.gains(robot)
        if stored:
            robot = stored.applied_to(robot)
            stored.check_gains(gains)
        with about("coulomb"):
            robot = robot if self.coulomb is None else robot.with_coulomb(self.coulomb)
        robot = robot if self.offsets is None else robot.with_offsets(self.offsets)
        if stored and robot.fingerprint != stored.fingerprint:
            raise InputError("offsets and coulomb must be those the stored parameters were identified with")
        names = {entry.name for entry in fields(model.Processing)} & {entry.name for entry in fields(self)}
        settings = {name: getattr(self, name) for name in names if getattr(self, name) is not None}
        named = [self.shown(name) for name in sorted(settings)]
        if "equation_rate" in settings:  # takes the place of either in the robot's file
            settings["decimate"] = 1
        with about(*named):
            processing = replace(robot.processing, **settings)
        return Setup(robot, processing, gains, identified, self.how())


class ProcessingOptions(FilterOptions):
    """Settings of filtering and of decimation, for commands that build equations of fewer rows."""

    equation_rate: Annotated[Hertz | None, SETTING] = None
    """Rate that the equations are decimated to, about."""


class PairOptions(ProcessingOptions):
    """Settings for recordings with and without payload."""

    max_mismatch: Annotated[float | None, word(number, "RAD"), SETTING] = None
    """Largest difference of position with and without payload after alignment, rms of the worst joint (payload:
    method 3; default: 0.01)."""
