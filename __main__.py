"""Where the command begins: an interruption is one line from the first instant on."""

import os
import signal

_INTERRUPTED = 130


def main() -> int:
    """Run the command line; while it is being loaded, an interruption ends the process at once."""
    signal.signal(signal.SIGINT, _stopped)
    from .cli import main as run  # loaded under the guard

    signal.signal(signal.SIGINT, signal.default_int_handler)
    return run()


def _stopped(*_: object) -> None:
    os.write(2, b"dynident: interrupted\n")
    os._exit(_INTERRUPTED)


if __name__ == "__main__":
    raise SystemExit(main())
