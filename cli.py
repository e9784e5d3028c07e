"""The command line: finds the command, runs it, and turns its errors into one line."""

from __future__ import annotations

import argparse
import io
import os
import sys
import warnings
from collections.abc import Sequence
from importlib import import_module
from types import ModuleType
from typing import NoReturn

from .commands import BAD_INPUT, BROKEN_PIPE, COMMANDS, INTERRUPTED, moved
from .common.errors import InputError


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns its status: 0 answered, 1 do not use, 2 the input cannot be used, 3 our fault."""
    words = tuple(sys.argv[1:] if argv is None else argv)
    if today := moved(words):
        print(f"dynident: error: this is a command of its own now: {today}", file=sys.stderr)
        return BAD_INPUT
    _prepare()
    try:
        arguments = _parser(words).parse_args(words)
        arguments.argv = words
        with warnings.catch_warnings():
            warnings.showwarning = _note
            return int(arguments.run(arguments))
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
        return int(_faults().told(fault, words))


def _prepare() -> None:
    for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(variable, "1")  # the matrices are small: more threads only wait for each other
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without Greek letters


def _faults() -> ModuleType:
    return import_module(".commands.faults", __package__)


def _refused(message: str) -> int:
    print(f"dynident: error: {' '.join(message.split())}", file=sys.stderr)
    return BAD_INPUT


def _note(message: Warning | str, *_: object, **__: object) -> None:
    """A warning is a line for the user, not for a programmer."""
    print(f"dynident: note: {' '.join(str(message).split())}", file=sys.stderr)


class _Parser(argparse.ArgumentParser):
    """A wrong command line is one line too."""

    def error(self, message: str) -> NoReturn:
        print(f"{self.prog}: error: {message} (see {self.prog} --help)", file=sys.stderr)
        raise SystemExit(BAD_INPUT)


class _Version(argparse.Action):
    """Prints what a report of a fault should name."""

    def __call__(self, *_: object, **__: object) -> None:
        print(*_faults().versions(), sep="\n")
        raise SystemExit(0)


def _parser(words: Sequence[str]) -> argparse.ArgumentParser:
    """Names of all commands, and the arguments of the one that is called."""
    parser = _Parser(prog="dynident", description="Tells what hangs on the flange of an industrial manipulator.")
    parser.add_argument("--version", action=_Version, nargs=0, help="versions of dynident and of its solvers")
    commands = parser.add_subparsers(required=True, metavar="command", parser_class=_Parser)
    called = next((word for word in words if not word.startswith("-")), None)
    for command, what in COMMANDS.items():
        if command == called:
            import_module(f".commands.{command}", __package__).add_parser(commands)
        else:
            commands.add_parser(command, help=what)
    return parser
