"""The command line: finds the command, runs it, and turns its errors into one line."""

from __future__ import annotations

import argparse
import gc
import io
import os
import re
import sys
import warnings
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from types import ModuleType
from typing import Any, NoReturn

from .apps.commands import BAD_INPUT, BROKEN_PIPE, COMMANDS, INTERRUPTED
from .common import interruption
from .common.errors import InputError, one_line


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns its status: 0 answered, 1 do not use, 2 the input cannot be used, 3 our fault."""
    words = tuple(sys.argv[1:] if argv is None else argv)
    try:
        interruption.release()
        status = _run(words)
        sys.stdout.flush()
        return status
    except BrokenPipeError:  # whoever reads has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE
    except InputError as error:
        return _refused(str(error))
    except OSError as error:
        return _refused(f"{error.filename or 'input or output'}: {error.strerror or error}")
    except KeyboardInterrupt:
        print("dynident: interrupted", file=sys.stderr)
        exec(
            ""
        )  # Python ends by the signal, not by a status, where exec of a text was interrupted; this forgets it
        return INTERRUPTED
    except Exception as fault:  # the one place that catches everything: a fault of ours is no answer
        return int(_faults().told(fault, words))


def _run(words: tuple[str, ...]) -> int:
    """Find the command and call it."""
    _prepare()
    parser = _parser(_completed() if "_ARGCOMPLETE" in os.environ else words)
    if "_ARGCOMPLETE" in os.environ:
        _complete(parser)
    if not words:
        parser.print_help()
        return BAD_INPUT
    if any(word.startswith("--config") for word in words):
        words = import_module(".apps.commands.settings", __package__).with_settings(parser, words)
    arguments, unknown = parser.parse_known_args(words)
    if unknown:
        parser.error(
            import_module(".apps.commands.settings", __package__).unknown_option(parser, words, unknown[0])
        )
    arguments.argv, arguments.parser = words, parser
    with warnings.catch_warnings():
        warnings.showwarning = _note
        return int(arguments.run(arguments))


def _completed() -> tuple[str, ...]:
    """Words of the line that a shell asks to complete."""
    return tuple(os.environ.get("COMP_LINE", "").split()[1:])


def _complete(parser: argparse.ArgumentParser) -> None:
    """Tell the shell what fits, where argcomplete is installed; ends the process."""
    try:
        argcomplete = import_module("argcomplete")
    except ModuleNotFoundError:
        raise SystemExit(1) from None
    argcomplete.autocomplete(parser)


def _prepare() -> None:
    # Imports make many objects, all of which stay: to look for waste among them takes a tenth of a command's time.
    gc.set_threshold(50_000, 20, 10)
    for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(variable, "1")  # the matrices are small: more threads only wait for each other
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by whoever started the command
            setattr(sys, name, io.StringIO())
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without Greek letters


def _faults() -> ModuleType:
    return import_module(".apps.commands.faults", __package__)


def _refused(message: str) -> int:
    with suppress(OSError):  # a full disk takes the line, not the status
        print(f"dynident: error: {one_line(message)}", file=sys.stderr)
    return BAD_INPUT


def _note(message: Warning | str, *_: object, **__: object) -> None:
    """A warning is a line for the user, not for a programmer."""
    print(f"dynident: note: {one_line(str(message))}", file=sys.stderr)


class _Parser(argparse.ArgumentParser):
    """A wrong command line is one line too; a value may begin with a minus and a digit."""

    def __init__(self, *arguments: Any, **how: Any) -> None:
        """Take "-1,1" and "-90:90" for values, as argparse takes "-1"."""
        super().__init__(*arguments, **how)
        self._negative_number_matcher = re.compile(r"-\.?\d")

    def _get_values(self, action: argparse.Action, words: Any) -> Any:
        """Refuse "--" as an option's value, which argparse drops."""
        if action.option_strings and "--" in words:
            raise argparse.ArgumentError(action, "'--' is no value")
        return super()._get_values(action, words)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Say which choice may be meant."""
        if action.choices is not None and value not in action.choices:
            close = import_module("difflib").get_close_matches(str(value), list(map(str, action.choices)), 1)
            meant = f"did you mean {close[0]}? " if close else ""
            choices = ", ".join(map(str, action.choices))
            raise argparse.ArgumentError(action, f"there is no {value!r}: {meant}give one of {choices}")

    def error(self, message: str) -> NoReturn:
        with suppress(OSError):
            print(f"{self.prog}: error: {one_line(message)} (see {self.prog} --help)", file=sys.stderr)
        raise SystemExit(BAD_INPUT)


class _Version(argparse.Action):
    """Prints what a report of a fault should name."""

    def __call__(self, *_: object, **__: object) -> None:
        print(*_faults().versions_in_words(), sep="\n")
        raise SystemExit(0)


def _parser(words: Sequence[str]) -> argparse.ArgumentParser:
    """Names of all commands, and the arguments of the one that is called."""
    parser = _Parser(prog="dynident", description="Tells what hangs on the flange of an industrial manipulator.")
    parser.add_argument("--version", action=_Version, nargs=0, help="versions of dynident and of its solvers")
    commands = parser.add_subparsers(required=True, metavar="command", parser_class=_Parser)
    called = next((word for word in words if not word.startswith("-")), None)
    for command, summary in COMMANDS.items():
        if command == called:
            _declare(import_module(f".apps.commands.{command}", __package__), commands, command)
        else:
            commands.add_parser(command, help=summary)
    return parser


def _declare(module: ModuleType, commands: Any, command: str) -> None:
    """The arguments of a command: those that its ``run`` takes, unless it says more of itself by ``add_parser``."""
    if hasattr(module, "add_parser"):
        module.add_parser(commands)
    else:
        import_module(".apps.commands.options", __package__).add_command(commands, command, module.run)
