"""A connection that is there, or refused, within a known time: also where a name does not resolve."""

import socket
import threading
import time
from typing import Any

from .fields import LinkError

PATIENCE = 2.5
"""s: by then a name must be resolved, and then a host must have answered."""
_WHOLE = 4.5
"""s: for both together."""


def connected(host: str, port: int, hint: str, silent: str) -> socket.socket:
    """A socket to a host.

    The system looks a name up for as long as it likes (30 s where the name server is silent): a thread asks it.

    Args:
        host: name or address.
        port: of the host.
        hint: said behind why there is no connection.
        silent: said behind that nothing answers.

    Raises:
        LinkError: if the name does not resolve, or nothing answers, within 2.5 s each.
    """
    address, deadline = f"{host}:{port}", time.monotonic() + _WHOLE
    try:
        places = _resolved(host, port)
        if places is None:
            raise LinkError(f"{address}: the name {host} was not resolved within {PATIENCE:g} s: give the address")
        return _opened(places, deadline)
    except TimeoutError:
        raise LinkError(f"{address}: no answer within {PATIENCE:g} s: {silent}") from None
    except (OSError, UnicodeError) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise LinkError(f"{address}: no connection: {why}{hint}") from None


def _resolved(host: str, port: int) -> list[Any] | None:
    """What the system knows under a name; None if it does not say in time."""
    answer: list[list[Any]] = []
    faults: list[Exception] = []

    def ask() -> None:
        try:
            answer.append(socket.getaddrinfo(host, port, type=socket.SOCK_STREAM))
        except (OSError, UnicodeError) as error:
            faults.append(error)

    thread = threading.Thread(target=ask, name="resolver", daemon=True)
    thread.start()
    thread.join(PATIENCE)
    if faults:
        raise faults[0]
    return answer[0] if answer else None


def _opened(places: list[Any], deadline: float) -> socket.socket:
    """A socket to the first place that answers, of several as ``socket.create_connection`` does it.

    Raises:
        OSError: the last place's fault.
    """
    fault: OSError = TimeoutError()
    for family, kind, protocol, _, place in places:
        left = min(PATIENCE, deadline - time.monotonic())
        if left <= 0.0:
            break
        connection = socket.socket(family, kind, protocol)
        try:
            connection.settimeout(left)
            connection.connect(place)
        except OSError as error:
            connection.close()
            fault = error
        except BaseException:
            connection.close()
            raise
        else:
            return connection
    raise fault
