"""The command line. Hands values from room to room; every heavy import waits until it is needed."""

from __future__ import annotations

import argparse
import io
import os
import sys
import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from . import __version__

if TYPE_CHECKING:
    from .estimation.stored import StoredRobot
    from .model import Processing, Recording, Robot

ANSWERED, DO_NOT_USE, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit status (0 answered, 1 do not use, 2 the input cannot be used)."""
    arguments = _parser().parse_args(argv)
    for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(variable, "1")  # the matrices are small: more threads only wait for each other
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without Greek letters
    from .model import InputError

    try:
        _check_target(getattr(arguments, "json", None))
        with warnings.catch_warnings():
            warnings.showwarning = _note
            return int(arguments.run(arguments))
    except (InputError, OSError) as error:
        message = " ".join(str(error).split())
        print(f"dynident: error: {message}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("dynident: interrupted", file=sys.stderr)
        return INTERRUPTED


def _note(message: Warning | str, *_: object, **__: object) -> None:
    """A warning is a line for the user, not for a programmer."""
    print(f"dynident: note: {message}", file=sys.stderr)


def _check_target(path: str | None) -> None:
    """Refuse a file that cannot be written before any work is done."""
    from .model import InputError

    if path is not None and (not path or Path(path).is_dir() or not Path(path).resolve().parent.is_dir()):
        raise InputError(f"--json {path!r}: not a file in a folder that exists")


class _Parser(argparse.ArgumentParser):
    """A wrong command line is one line too."""

    def error(self, message: str) -> NoReturn:
        print(f"{self.prog}: error: {message} (see {self.prog} --help)", file=sys.stderr)
        raise SystemExit(BAD_INPUT)


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="dynident", description="Tells what hangs on the flange of an industrial manipulator.")
    parser.add_argument("--version", action="version", version=f"dynident {__version__}")
    commands = parser.add_subparsers(required=True, metavar="command", parser_class=_Parser)
    _payload_parser(commands)
    _identify_parser(commands)
    _codegen_parser(commands)
    _demo_parser(commands)
    return parser


def _payload_parser(commands: Any) -> None:
    parser = commands.add_parser("payload", help="identify a payload from recordings with and without it")
    parser.add_argument("--robot", required=True, help="rx90, tx40, ur10e, or the path of a robot TOML file")
    parser.add_argument(
        "--unloaded", action="append", default=[], metavar="CSV", help="recording without payload; repeatable"
    )
    parser.add_argument(
        "--loaded",
        action="append",
        required=True,
        metavar="CSV",
        help="recording with payload; repeatable; method 3 pairs them in order",
    )
    parser.add_argument("--robot-parameters", metavar="JSON", help="the --json of 'dynident identify' (method 1)")
    parser.add_argument("--method", choices=("1", "2", "3", "4", "all"), default="all", help="default: all")
    parser.add_argument("--free-friction", action="store_true", help="method 1: estimate friction anew under load")
    parser.add_argument(
        "--max-mismatch", type=float, metavar="RAD", help="method 3: largest difference of position"
    )
    parser.add_argument(
        "--validate", action="append", default=[], metavar="CSV", help="another one without payload"
    )
    _processing_arguments(parser)
    parser.set_defaults(run=_payload)


def _identify_parser(commands: Any) -> None:
    parser = commands.add_parser("identify", help="identify the robot's own parameters, without payload")
    parser.add_argument("--robot", required=True, help="rx90, tx40, ur10e, or the path of a robot TOML file")
    parser.add_argument("--data", action="append", required=True, metavar="CSV", help="recording without payload")
    parser.add_argument("--validate", action="append", default=[], metavar="CSV", help="another one, held out")
    _processing_arguments(parser)
    parser.set_defaults(run=_identify)


def _codegen_parser(commands: Any) -> None:
    parser = commands.add_parser("codegen", help="write a function of the robot as self-contained C")
    parser.add_argument("--robot", required=True, help="rx90, tx40, ur10e, or the path of a robot TOML file")
    parser.add_argument("--function", required=True, metavar="NAME", help="such as base_regressor")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder of the files, made if missing")
    parser.set_defaults(run=_codegen)


def _demo_parser(commands: Any) -> None:
    parser = commands.add_parser("demo", help="the paper's experiment on a simulated RX90")
    parser.add_argument("--out", default="demo", metavar="DIR", help="folder of the results (default: demo)")
    parser.add_argument("--seed", type=_whole, default=0, help="of the trajectories and the noise (default: 0)")
    parser.add_argument(
        "--trajectories", type=_positive, default=18, metavar="N", help="default: 18, as in the paper"
    )
    parser.set_defaults(run=_demo)


def _processing_arguments(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("processing", "defaults stand in the robot's file")
    group.add_argument("--drive-gains", type=_gains, metavar="K1,K2,..", help="torque per current [N·m/A]")
    group.add_argument("--rate", type=float, metavar="HZ", help="resample to this even rate")
    group.add_argument("--cutoff", type=float, metavar="HZ", help="low-pass on positions and speeds")
    group.add_argument("--decimate", type=_positive, metavar="N", help="parallel decimation of Y and W")
    group.add_argument("--offsets", action=argparse.BooleanOptionalAction, help="a constant torque per joint")
    group.add_argument("--coulomb", choices=("sum", "paper"), help="Coulomb friction of coupled drives")
    group.add_argument("--json", metavar="F", help="write the result as JSON")


def _whole(text: str) -> int:
    if not text.isdecimal() or len(text) > 9:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number of at least 0")
    return int(text)


def _positive(text: str) -> int:
    if _whole(text) == 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number of at least 1")
    return int(text)


def _gains(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of numbers separated by commas") from None


def _settings(arguments: argparse.Namespace, stored: StoredRobot | None = None) -> tuple[Robot, Processing]:
    """The robot with the model structure and processing that the command line asks for."""
    from .model import InputError, load_robot

    robot = load_robot(arguments.robot)
    if stored:
        robot = stored.applied_to(robot)
        stored.check_gains(arguments.drive_gains)
    given = {"rate": arguments.rate, "cutoff": arguments.cutoff, "decimate": arguments.decimate}
    given["max_mismatch"] = getattr(arguments, "max_mismatch", None)
    try:
        if arguments.offsets is not None:
            robot = robot.with_offsets(arguments.offsets)
        if arguments.coulomb is not None:
            robot = robot.with_coulomb(arguments.coulomb)
        if stored and robot.fingerprint != stored.fingerprint:
            raise InputError("--offsets and --coulomb must be those the stored parameters were identified with")
        changes: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
        return robot, replace(robot.processing, **changes)
    except ValueError as error:
        raise InputError(str(error)) from None


def _read(paths: Sequence[str], robot: Robot, gains: tuple[float, ...] | None, told: set[str]) -> list[Recording]:
    """Read recordings; what a file says about unused columns is told once."""
    from .estimation import read_recording

    recordings = [read_recording(path, robot, gains) for path in paths]
    for recording in recordings:
        for note in recording.notes:
            about = note.split(": ", 1)[1]
            if about not in told:
                told.add(about)
                print(f"dynident: note: {note}", file=sys.stderr)
    return recordings


def _payload(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    from .estimation import answer_payload, payload_problem
    from .estimation.stored import read_stored_robot
    from .model import InputError
    from .report.documents import payload_document, write_json
    from .report.tables import console, payload_notes, payload_table

    if not arguments.unloaded and not arguments.robot_parameters:
        raise InputError("give --unloaded recordings or --robot-parameters: without either nothing can be compared")
    if arguments.free_friction and arguments.method not in ("1", "all"):
        raise InputError("--free-friction belongs to method 1, which is not among the methods asked for")
    stored = read_stored_robot(arguments.robot_parameters) if arguments.robot_parameters else None
    robot, processing = _settings(arguments, stored)
    gains, told = arguments.drive_gains, set(robot.snapped)
    unloaded = _read(arguments.unloaded, robot, gains, told)
    loaded = _read(arguments.loaded, robot, gains, told)
    held_out = _read(arguments.validate, robot, gains, told)
    known = stored.estimate if stored else None
    with Console(stderr=True).status("reading") as status:
        # A stored robot brings the formula's covariance only: no block of its recordings can be left out.
        robust = stored is None
        problem = payload_problem(robot, loaded, unloaded, known, processing, status.update, robust)
        status.update("estimating")
        methods = None if arguments.method == "all" else (int(arguments.method),)
        answer = answer_payload(problem, methods, arguments.free_friction, held_out, processing)
    table = payload_table(answer.estimates)
    terminal = console(table)
    terminal.print(table)
    for line in payload_notes(answer):
        terminal.print(line, markup=False, highlight=False)
    if arguments.json:
        write_json(arguments.json, payload_document(answer, processing, gains))
    return DO_NOT_USE if answer.verdict.level == "do_not_use" else ANSWERED


def _identify(arguments: argparse.Namespace) -> int:
    from rich.console import Console

    from .estimation import identify
    from .estimation.verdict import fit_reasons
    from .report.tables import console, robot_notes, robot_table

    robot, processing = _settings(arguments)
    told: set[str] = set()
    recordings = _read(arguments.data, robot, arguments.drive_gains, told)
    held_out = _read(arguments.validate, robot, arguments.drive_gains, told)
    with Console(stderr=True).status("reading") as status:
        result = identify(robot, recordings, processing, held_out, progress=status.update)
    table = robot_table(result)
    terminal = console(table)
    terminal.print(table)
    for line in robot_notes(result):
        terminal.print(line, markup=False, highlight=False)
    if arguments.json:
        from .report.documents import identification_document, write_json

        write_json(arguments.json, identification_document(result, processing, arguments.drive_gains))
    return DO_NOT_USE if fit_reasons(result.estimate.fit, "the model") else ANSWERED


def _codegen(arguments: argparse.Namespace) -> int:
    from .model import generate_code, load_robot

    for path in generate_code(load_robot(arguments.robot), arguments.function, arguments.out):
        print(path)
    return ANSWERED


def _demo(arguments: argparse.Namespace) -> int:
    from .demo import run_demo

    return run_demo(Path(arguments.out), arguments.seed, arguments.trajectories)
