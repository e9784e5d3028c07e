"""Secondary programs for a Universal Robots controller: they run beside the program that moves the arm.

A program that begins with ``sec`` may not move the arm and takes no time of the running program (URScript manual,
secondary programs).
"""

from collections.abc import Iterator
from contextlib import contextmanager

from .connection import connected
from .fields import LinkError

SCRIPT_PORT = 30002
"""Port of the secondary client interface, which takes scripts."""


def program(command: str) -> str:
    """A secondary program that runs one command.

    Raises:
        ValueError: if it is anything but one call of ``set_target_payload``.
    """
    inside = command.removeprefix("set_target_payload(").removesuffix(")")
    if len(inside) != len(command) - len("set_target_payload()") or not set(inside) <= set("0123456789.,+-e[] "):
        raise ValueError(f"not a payload: {command!r}")
    return f"sec dynident_payload():\n  {command}\nend\n"


@contextmanager
def send_program(text: str, host: str, port: int = SCRIPT_PORT) -> Iterator[None]:
    """Send a program; the connection stays open within the block, for the controller reads in its own time.

    Raises:
        LinkError: if there is no connection, or it is lost while the program is sent.
    """
    hint = ": nothing was sent; switch the controller to remote control"
    connection = connected(host, port, hint, "nothing was sent")
    with connection:
        try:
            connection.sendall(text.encode("ascii"))
        except OSError as error:
            raise LinkError(f"{host}:{port}: the connection was lost: {error.strerror or error}") from None
        yield
