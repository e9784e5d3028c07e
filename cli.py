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
from contextvars import copy_context
from types import FrameType

from .apps.commands import BAD_INPUT, BROKEN_PIPE, INTERNAL_ERROR, INTERRUPTED
from .common.errors import InputError, one_line

_TOLD = 200  # letters of a fault that are shown; the file has all


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
    # Imports make many objects, all of which stay: to look for waste among them takes a tenth of a command's time.
    gc.set_threshold(50_000, 20, 10)
    for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[variable] = "1"  # small matrices: more threads wait for each other, and sums round otherwise
    for name in ("stdout", "stderr"):
        if (stream := getattr(sys, name)) is None:  # closed by whoever started the command
            setattr(sys, name, io.StringIO())
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without Greek letters
    try:
        with warnings.catch_warnings():
            # A warning is a line for the user, not for a programmer.
            warnings.showwarning = lambda message, *_, **__: print(
                f"dynident: note: {one_line(str(message))}", file=sys.stderr
            )
            from .apps.commands.entry import run  # which costs nothing until it is needed

            status = copy_context().run(run, words)
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
    except (KeyboardInterrupt, Exception) as fault:  # the one place that catches everything
        # An interruption that compiled code took arrives as another exception; else a fault of ours is no answer.
        if pressed or isinstance(fault, KeyboardInterrupt):
            print("dynident: interrupted", file=sys.stderr, flush=True)
            if pressed:  # Python's own steps cannot end a process whose compiled code was left on the way
                atexit.register(os._exit, INTERRUPTED)
                with suppress(OSError):
                    sys.stdout.flush()
            return INTERRUPTED
        import shlex
        import tempfile
        import traceback

        from .common.versions import versions

        numbers = (f"{name.lower()} {number}" for name, number in versions().items())
        details = [f"dynident {shlex.join(words)}", *numbers, "", *traceback.format_exception(fault)]
        try:
            handle, path = tempfile.mkstemp(".txt", "dynident-fault-")
            with os.fdopen(handle, "w", encoding="utf-8", errors="replace") as file:
                file.write("\n".join(details))
            where = f"with {path}"
        except OSError as error:
            where = f"(its details could not be written: {error.strerror})"
        message = one_line(f"{type(fault).__name__}: {fault}")[:_TOLD]
        print(f"dynident: internal error, please report {where}: {message}", file=sys.stderr)
        return INTERNAL_ERROR
