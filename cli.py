"""The command line: finds the command, runs it, and turns its errors into one line."""

from __future__ import annotations

import atexit
import gc
import io
import os
import signal
import sys
import warnings
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from types import FrameType
from typing import Any

from .apps.commands import BAD_INPUT, BROKEN_PIPE, INTERRUPTED
from .common.errors import InputError, one_line


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns its status: 0 answered, 1 do not use, 2 the input cannot be used, 3 our fault."""
    words, pressed = tuple(sys.argv[1:] if argv is None else argv), list[int]()

    def interrupt(number: int, frame: FrameType | None) -> None:
        pressed.append(number)
        signal.default_int_handler(number, frame)

    with suppress(ValueError):  # another thread than the first, which alone is interrupted
        if signal.getsignal(signal.SIGINT) == signal.default_int_handler:
            signal.signal(signal.SIGINT, interrupt)
            atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)  # what is answered stays answered
    try:
        status = _run(words)
        sys.stdout.flush()
        return status
    except BrokenPipeError:  # whoever reads has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE
    except (InputError, OSError) as error:
        text = str(error)
        if isinstance(error, OSError):
            text = f"{error.filename or 'input or output'}: {error.strerror or error}"
        with suppress(OSError):  # a full disk takes the line, not the status
            print(f"dynident: error: {one_line(text)}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        return _interrupted(bool(pressed))
    except Exception as fault:  # the one place that catches everything: a fault of ours is no answer
        if pressed:  # compiled code took the interruption, and gave back nothing
            return _interrupted(True)
        return int(_commands("progress").report_fault(fault, words))


def _run(words: tuple[str, ...]) -> int:
    """Find the command and call it."""
    # Imports make many objects, all of which stay: to look for waste among them takes a tenth of a command's time.
    gc.set_threshold(50_000, 20, 10)
    for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[variable] = "1"  # small matrices: more threads wait for each other, and sums round otherwise
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by whoever started the command
            setattr(sys, name, io.StringIO())
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without Greek letters
    with warnings.catch_warnings():
        # A warning is a line for the user, not for a programmer.
        warnings.showwarning = lambda message, *_, **__: print(
            f"dynident: note: {one_line(str(message))}", file=sys.stderr
        )
        return int(_commands("entry").run(words))


def _commands(name: str) -> Any:
    """A module of the commands, which costs nothing until it is needed."""
    return import_module(f".apps.commands.{name}", __package__)


def _interrupted(pressed: bool) -> int:
    """Say so; Python's own steps cannot end a process whose compiled code was left on the way."""
    print("dynident: interrupted", file=sys.stderr, flush=True)
    if pressed:
        atexit.register(os._exit, INTERRUPTED)
        with suppress(OSError):
            sys.stdout.flush()
    return INTERRUPTED
