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
from typing import Any, NoReturn

from .apps.commands import BAD_INPUT, BROKEN_PIPE, COMMANDS, INTERRUPTED
from .common.errors import InputError, one_line


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns its status: 0 answered, 1 do not use, 2 the input cannot be used, 3 our fault."""
    words = tuple(sys.argv[1:] if argv is None else argv)
    try:
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
        return INTERRUPTED
    except Exception as fault:  # the one place that catches everything: a fault of ours is no answer
        return int(_commands("progress").report_fault(fault, words))


def _run(words: tuple[str, ...]) -> int:
    """Find the command and call it."""
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
    completing = "_ARGCOMPLETE" in os.environ
    parser = _parser(os.environ.get("COMP_LINE", "").split()[1:] if completing else words)
    if completing:  # tells the shell what fits, where argcomplete is installed, and ends the process
        try:
            import_module("argcomplete").autocomplete(parser)
        except ModuleNotFoundError:
            raise SystemExit(1) from None
    if not words:
        parser.print_help()
        return BAD_INPUT
    arguments = parser.parse_args(words)
    arguments.argv = words
    with warnings.catch_warnings():
        warnings.showwarning = _note
        return int(arguments.run(arguments))


def _commands(name: str) -> Any:
    """A module of the commands, which costs nothing until it is needed."""
    return import_module(f".apps.commands.{name}", __package__)


def _refused(message: str) -> int:
    with suppress(OSError):  # a full disk takes the line, not the status
        print(f"dynident: error: {one_line(message)}", file=sys.stderr)
    return BAD_INPUT


def _note(message: Warning | str, *_: object, **__: object) -> None:
    """A warning is a line for the user, not for a programmer."""
    print(f"dynident: note: {one_line(str(message))}", file=sys.stderr)


class Parser(argparse.ArgumentParser):
    """Parser of a command: wrong words are one line, a value may begin with a minus, options may stand in a file.

    Attributes:
        typed: values of the options as they were written, by destination; "true" of a switch.
    """

    def __init__(self, *arguments: Any, **how: Any) -> None:
        """Take "-1,1" and "-90:90" for values, as argparse takes "-1"."""
        super().__init__(*arguments, **how)
        self.typed: dict[str, list[str]] = {}
        self._negative_number_matcher = re.compile(r"-\.?\d")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Read a command line, with the options of its ``--config`` file before those that are typed."""
        if not any(action.dest == "config" for action in self._actions):  # commands stand below this one
            return super().parse_known_args(args, namespace)
        if any(word.startswith("--conf") for word in args):
            parts: list[Any] = [*self._actions, *self._mutually_exclusive_groups]
            required = [part for part in parts if part.required]
            for part in required:  # the file may hold them
                part.required = False
            self.typed = {}
            super().parse_known_args(args)
            for part in required:
                part.required = True
            if "config" in self.typed:
                args = [*_commands("options.reading").settings_words(self, self.typed), *args]
        self.typed = {}
        arguments, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(_commands("options.reading").unknown_option(self, unknown[0]))
        return arguments, unknown

    def _get_values(self, action: argparse.Action, words: Any) -> Any:
        """Remember what was written, and refuse "--" as an option's value, which argparse drops."""
        if action.option_strings and "--" in words:
            raise argparse.ArgumentError(action, "'--' is no value")
        if words or action.option_strings:
            earlier = self.typed.get(action.dest, []) if isinstance(action, argparse._AppendAction) else []
            self.typed[action.dest] = [*earlier, *(words or ["true"])]
        return super()._get_values(action, words)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Say which choice may be meant."""
        if action.choices is not None and value not in action.choices:
            close = import_module("difflib").get_close_matches(str(value), list(map(str, action.choices)), 1)
            meant = f"did you mean {close[0]}? " if close else ""
            choices = ", ".join(map(str, action.choices))
            raise argparse.ArgumentError(action, f"there is no {value!r}: {meant}give one of {choices}")

    def error(self, message: str) -> NoReturn:
        """Say what is wrong in one line."""
        with suppress(OSError):
            print(f"{self.prog}: error: {one_line(message)} (see {self.prog} --help)", file=sys.stderr)
        raise SystemExit(BAD_INPUT)


class _Version(argparse.Action):
    """Prints what a report of a fault should name."""

    def __call__(self, *_: object, **__: object) -> None:
        print(*_commands("progress").version_lines(), sep="\n")
        raise SystemExit(0)


def _parser(words: Sequence[str]) -> Parser:
    """Names of all commands, and the arguments of the one that is called."""
    parser = Parser(prog="dynident", description="Tells what hangs on the flange of an industrial manipulator.")
    parser.add_argument("--version", action=_Version, nargs=0, help="versions of dynident and of its solvers")
    commands = parser.add_subparsers(required=True, metavar="command", parser_class=Parser)
    called = next((word for word in words if not word.startswith("-")), None)
    for command, summary in COMMANDS.items():
        if command != called:
            commands.add_parser(command, help=summary)
        elif hasattr(module := _commands(command), "add_parser"):  # it says more of itself
            module.add_parser(commands)
        else:
            _commands("options").add_command(commands, command, module.run)
    return parser
