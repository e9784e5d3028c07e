"""An interruption while the command line is being loaded is one line, not a traceback.

Importing this file sets the guard where Python was started as ``dynident`` or ``python -m dynident``, and does
nothing elsewhere. It comes first of all: what is imported after it takes most of the time until the command begins.
"""

import atexit
import os
import signal
import sys

_INTERRUPTED = 130


def _stopped(*_: object) -> None:
    os.write(2, b"dynident: interrupted\n")
    os._exit(_INTERRUPTED)


def release() -> None:
    """Let interruptions be exceptions, from the moment at which they are caught."""
    if signal.getsignal(signal.SIGINT) is _stopped:
        signal.signal(signal.SIGINT, signal.default_int_handler)


# Python calls itself "-m" until it has found the module to run.
if os.path.basename((sys.argv or [""])[0]).removesuffix(".exe") in ("-m", "dynident"):  # noqa: PTH119
    signal.signal(signal.SIGINT, _stopped)
    # The answer was given: Python, taking itself down, would fall back to ending by the signal.
    atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)
