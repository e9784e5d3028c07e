"""Options that several commands share: declared once, read once, handed on as frozen values."""

from __future__ import annotations

import math
import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter
from msgspec import structs

from ... import estimation, model
from ...common.arrays import Array
from ...common.errors import InputError
from ...common.files import checksum, made_folder, write_text
from ...common.progress import Progress, each
from ...common.schema import json_text, write_json
from .. import logs, results, view
from ..logs.map import COMMAND_LINE
from ..numbers import placed
from ..report.blocks import Report, page_html, print_report
from ..report.figures import save_figure
from . import values
from .entry import CALL, FILES, LOGS, SETTING, Options, about, note, shown, status
from .values import Reads, numbers, texts, word

if TYPE_CHECKING:
    from ..view.moving import View

_FROM_ROBOT = "These are the errors with which the robot was identified; the drives are the same."
_INSTEAD = (
    "The robot was identified with another uncertainty of the gains; the one given now is used for both, as the "
    "drives are the same."
)
_given_or_file = values.numbers_or(".json", "K|K1,K2,..|JSON")
_ERRORS = "2%|S1,S2,..%|common=1%"


class RobotOptions(Options):
    """A robot by its name or file, and how it is mounted."""

    robot: values.RobotFile
    """An included robot ('dynident robot list'), a TOML, URDF or xacro file, or a name of robot_descriptions."""
    chain: Annotated[tuple[str | None, str | None] | None, word(values.chain, "BASE:TIP"), SETTING] = None
    """URDF: first and last link of the arm; either may be omitted (default: the root, the only end)."""
    mount: Annotated[Callable[..., Any] | None, word(values.mount, "HOW")] = None
    """floor, wall (base x axis down), ceiling, ROLL,PITCH,YAW of the base in degrees, or gravity=X,Y,Z in
    its frame [m/s^2]."""

    def load(self) -> model.Robot:
        """The robot as it is mounted, with the payload's frame and the mass that are asked for."""
        robot = model.load_robot(self.robot, *(self.chain or (None, None)))
        for angle in robot.snapped:
            note(f"{self.robot}: {angle}")
        if self.mount is not None:
            robot = self.mount(robot)
        if (tool := getattr(self, "tool_frame", None)) is not None:
            with about("--tool-frame"):
                robot = model.with_tool(robot, tool, f"tool frame at {placed(tool)} in: {robot.payload_frame}")
        if (mass := getattr(self, "arm_mass", None)) is not None:
            if not model.stand_in.missing_inertial(robot):
                raise InputError(f"--arm-mass has no effect: {robot.name} has a body for each link: omit it")
            robot = replace(robot, mass=mass, sources={**robot.sources, "mass": "given with --arm-mass"})
        return robot


def in_si(given: tuple[float, ...], robot: model.Robot) -> Array:
    """Degrees of turning joints in radians; metres of sliding ones as they are."""
    if len(given) != robot.n:
        raise InputError(f"{len(given)} numbers for the {robot.n} joints of robot {robot.name!r}: give one each")
    turning = [x for x, joint in zip(given, robot.joints, strict=True) if joint.revolute]
    if sum(x % 0.5 != 0.0 for x in turning) > 1 and max(map(abs, turning)) <= 2.0 * math.pi:
        degrees = ", ".join(f"{math.degrees(x):.3g}" if x in turning else f"{x:g}" for x in given)
        raise InputError(
            f"{', '.join(f'{x:g}' for x in given)} looks like radians: give degrees ({degrees}); if these are "
            "degrees, round them to the nearest 0.5"
        )
    return np.where([joint.revolute for joint in robot.joints], np.radians(given), given)


@dataclass(frozen=True, eq=False)
class Setup:
    """Robot, processing and drive gains that recordings are read and identified with."""

    robot: model.Robot  # with the structure that is asked for
    processing: model.Processing
    gains: tuple[float, ...] | None  # torque per current [N·m/A], if currents are read
    identified: estimation.Gains | None  # how sure they are, if ``dynident gains`` or --gain-sigma tells
    log_map: logs.LogMap
    stored: estimation.RobotResult | None = None  # an earlier identification, if its parameters count
    told: set[str] = field(default_factory=set)  # notes that were printed already

    def read(self, paths: Sequence[str | tuple[str, ...]]) -> list[model.Recording]:
        """Read recordings, one with gaps as its pieces; what a file says of how it was read is told once."""
        with status("reading") as progress:
            recordings = [
                piece
                for path in each(logs.grouped(paths), lambda path: f"reading {path}", progress)
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
        speeds = ", ".join(f"{speed:g}" for speed in np.atleast_1d(processing.slow_speed))
        slow = f"{100.0 * processing.slow_fraction:g} % of a joint's largest speed"
        slow += f", and {speeds} rad/s or m/s" * bool(np.any(processing.slow_speed))
        cutoff = f"{processing.cutoff:g} Hz" if processing.cutoff else "none"
        words = {
            "robot": f"{robot.title or robot.name} ({robot.name})",
            "sampling rate": f"{processing.rate:g} Hz" if processing.rate else "the recording's own",
            "low-pass (Butterworth, 4th order, zero phase)": cutoff,
            "decimation": str(processing.decimate) if grid_rate is None else f"to {grid_rate:g} Hz",
            "slow rows left out below": slow,
            "drive gains [N·m/A]": ", ".join(f"{gain:g}" for gain in self.gains or ()) or "torques were read",
            "offset of each joint": "identified" if robot.drives.offsets else "none",
        }
        if robot.coupling is not None:
            words["Coulomb friction of coupled drives"] = robot.coupling.coulomb
        if robot.spring is not None:
            words["spring"] = f"known torque on joint {robot.spring.joint}"
        return words


class RecordingOptions(RobotOptions, group=LOGS):
    """A robot and its logs, their filtering and decimation, the structure of the model, and the drive gains."""

    log_map: values.LogMapFile | None = None
    """File that maps the columns, units, side and signs of your logs."""
    joints: Annotated[tuple[str, ...], word(texts, "A,B,..")] = ()
    """Names of the joints in the logs, base to tip."""
    units: Annotated[tuple[str, ...], word(texts, "q=deg,..")] = ()
    """Units of the columns q, qd, tau, i, t."""
    signs: Annotated[tuple[float, ...], word(numbers, "1,-1,.."), SETTING] = ()
    """Signs of the joints: -1 reverses positions, speeds, torques and currents of one."""
    topic: Annotated[str, Parameter(metavar="NAME"), SETTING] = ""
    """Topic of a ROS 2 bag."""
    drive_gains: Annotated[tuple[float, ...] | str | None, Reads("drive gains"), _given_or_file] = None
    """Torque per current [N·m/A], or the --json file of 'dynident gains'."""
    rate: Annotated[values.Hertz | None, SETTING] = None
    """Even rate to which recordings are resampled."""
    cutoff: values.Hertz | None = None
    """Cut-off frequency of the low-pass filter on positions and speeds."""
    equation_rate: Annotated[values.Hertz | None, SETTING] = None
    """Approximate rate to which the equations are decimated."""
    offsets: Annotated[bool | None, Parameter(metavar="true|false"), SETTING] = None
    """Whether each joint has a constant torque offset (default: as in the robot's file)."""
    coulomb: Annotated[Literal["sum", "paper"] | None, Parameter(metavar="sum|paper"), SETTING] = None
    """Coulomb friction of coupled drives: by the sum of the speeds, or as printed in the paper."""
    gain_sigma: Annotated[tuple[tuple[float, ...], float] | None, word(values.gain_errors, _ERRORS)] = None
    """Error of each joint's drive gain, 1 sigma, and one common to all joints: 2%,common=1% (default: what the
    recordings state, else 2 %, or 1 % for torque sensors behind the gears; 0: exact)."""

    def how(self) -> logs.LogMap:
        """The map of ``--log-map`` with what the other options change."""
        log_map = logs.read_log_map(self.log_map) if self.log_map else logs.LogMap(source=COMMAND_LINE)
        return logs.with_flags(log_map, self.joints, self.units, self.signs, self.topic)

    def setup(self) -> Setup:
        """The robot with structure and processing as asked for; stored parameters bring theirs."""
        path = getattr(self, "robot_parameters", None)
        stored = results.read_stored_robot(path) if path else None
        robot, gains = self.load(), self.drive_gains
        identified: estimation.Gains | None = None
        if isinstance(gains, str):  # a file, which says how sure they are besides
            found = results.read_stored_gains(gains)
            count = len(found.drive_gains.values)
            if found.robot != robot.name or count != robot.n:
                raise InputError(
                    f"{gains}: gains of {found.robot!r} with {count} joints do not belong to {robot.name!r} with "
                    f"{robot.n}: identify gains for it"
                )
            gains, identified = tuple(found.drive_gains.values.tolist()), found.errors
        elif gains and len(gains) == 1:
            gains = gains * robot.n
        if self.gain_sigma is not None:
            per_joint, common = self.gain_sigma
            identified = structs.replace(identified or estimation.Gains(), per_joint=per_joint, common=common)
        if identified is not None:
            with about("--gain-sigma"):
                identified.covariance(robot.n)
        if stored:
            robot = stored.applied_to(robot)
            stored.check_gains(gains)
        with about("coulomb"):
            robot = robot if self.coulomb is None else robot.with_coulomb(self.coulomb)
        robot = robot if self.offsets is None else robot.with_offsets(self.offsets)
        if stored and robot.fingerprint != stored.fingerprint:
            raise InputError("offsets and coulomb must be those the stored parameters were identified with")
        names = [entry.name for entry in fields(model.Processing)]
        changed = {name: value for name in names if (value := getattr(self, name, None)) is not None}
        if "equation_rate" in changed:  # takes the place of either in the robot's file
            changed["decimate"] = 1
        with about(*(shown(name) for name in changed if name != "decimate")):
            processing = replace(robot.processing, **changed)
        return Setup(robot, processing, gains, identified, self.how(), stored)

    def settings(
        self,
        setup: Setup,
        progress: Progress,
        loaded: Sequence[model.Recording] = (),
        unloaded: Sequence[model.Recording] = (),
        **asked: Any,
    ) -> estimation.Settings:
        """Settings by the names of options, or as ``asked``; where one is None the default counts."""
        # What is said now goes before what was said then: the drives are the same, and so is their error.
        now, then = setup.identified, setup.stored.gains if setup.stored else None
        if (gains := now or then) is not None:
            # The same gains, even if they are told by numbers now.
            source = then if then is not None and not any(gains.recordings.values()) else gains
            same = then is None or now is None or now.says_as(then, setup.robot.n)
            note = _FROM_ROBOT if now is None else "" if same else _INSTEAD
            notes = (*source.reused(loaded, unloaded), *filter(None, [note]))
            gains = structs.replace(gains, recordings=source.recordings, mass=source.mass, notes=notes)
        names = ("essential", "friction", "friction_change", "free_friction", "scale_sigma")
        asked = {name: getattr(self, name, None) for name in names} | {"gains": gains} | asked
        given = {name: value for name, value in asked.items() if value is not None}
        return estimation.Settings(setup.processing, progress=progress, **given)


class PageOptions(Options, group=FILES):
    """The result as JSON, and as an HTML report with its figures."""

    json: values.Stream | None = None
    """Write the result as JSON; - writes it to standard output instead of the screen."""
    details: bool = False
    """Also print everything the answer is based on."""
    report: Annotated[str | None, values.Named("file"), Parameter(metavar="F.html")] = None
    """Write a report as one HTML file, and F.run.toml, with which --config repeats the run."""
    plots: Annotated[values.NewFolder | None, SETTING] = None
    """Folder for the report's figures as PNG, SVG and PDF; made if missing."""

    @property
    def document(self) -> str | None:
        """The file that the JSON is written to."""
        return None if self.json == "-" else self.json

    def show(self, shown: Report) -> None:
        """Print the screen, or all of it; beside standard output where that takes the JSON."""
        if not self.quiet:
            print_report(shown, self.details, sys.stderr if self.json == "-" else None)

    def give(self, shown: Report, document: Callable[[], Any], settings_text: Mapping[str, str]) -> None:
        """Print the screen; write the document, which is made only then, page and figures, as far as asked for."""
        self.show(shown)
        if self.json == "-":
            sys.stdout.write(json_text(document()).decode())
        elif self.json:
            write_json(self.json, document())
        if self.report:
            call = CALL.get()
            read = [
                (mark.role, path) for _, mark, path in call.files if mark.kind == "input" and Path(path).is_file()
            ]
            files = [(role, path, checksum(path)) for role, path in read if role != "options"]
            line = shlex.join(["dynident", *call.words])
            write_text(self.report, page_html(shown, line, files, settings_text))
            if (beside := call.settings(self.report)) is not None:
                write_text(*beside)
        if self.plots:
            if not (drawings := list(shown.drawings())):
                raise InputError("plots: there is nothing to draw")
            folder = made_folder(self.plots)
            for drawing, ending in product(drawings, ("png", "svg", "pdf")):
                save_figure(drawing.figure, folder / f"{drawing.name}.{ending}")


_EQUATIONS = Parameter(group=FILES, help="Write W, Y, weights and triangular factors for your own solver.")
EquationsFile = Annotated[values.NewFile, _EQUATIONS]


class ViewOptions(Options, group=FILES):
    """The arm in three dimensions."""

    view: Annotated[values.Stream | None, Parameter(metavar="F.html")] = None
    """Write a 3-D animation as one HTML file; - opens it in the browser."""

    def check(self) -> None:
        """Refuse a view that could not be made, before any work is done."""
        super().check()
        if self.view:
            view.require_viewer()

    def write_view(self, made: Callable[[], View]) -> None:
        """Write or open the view; it is made only if it was asked for."""
        if self.view:
            with status("drawing the view"):
                scene = made()
                notes = list(scene.notes)
                if self.view == "-":
                    notes.append(f"the view is open in the browser: {view.open_view(scene)}")
                else:
                    write_text(self.view, view.html_of(scene))
            for text in notes:
                note(text)
