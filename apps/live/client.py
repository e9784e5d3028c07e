"""A client of the RTDE protocol: asks for fields, then reads samples in a thread of its own."""

import socket
import struct
import threading
import time
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from types import TracebackType
from typing import Self

from .connection import PATIENCE, connected
from .fields import FIELDS, LinkError, Recipe, Samples, chosen
from .packets import (
    CONTROLLER_VERSION,
    DATA,
    MESSAGE,
    OUTPUTS,
    REQUEST_VERSION,
    START,
    VERSION,
    Packet,
    message,
    packed,
    split,
)

PORT = 30004
"""Port of RTDE."""
_WHOLE = 4.8
"""s: by then all is agreed on, or it is told what is wrong."""
_SILENCE = 2.0
"""s: samples that stay away longer do not come any more."""
_CHUNK = 65536
_CB_SERIES = 5
"""Major versions below are of controllers that send 125 times a second."""


class Client:
    """A connection to a controller; close it, or use it in a ``with``.

    Attributes:
        host: in words, for messages.
        version: of the controller's software: major, minor, bugfix, build.
        messages: what the controller said.
    """

    def __init__(self, host: str, port: int = PORT) -> None:
        """Connect and agree on the protocol.

        Raises:
            LinkError: if the name is not resolved or nothing answers within 2.5 s each, or what answers does not
                speak version 2 within 2.5 s more; within 5 s in all.
        """
        self.host = f"{host}:{port}"
        self.messages: deque[str] = deque(maxlen=20)
        self._buffer = bytearray()
        self._waiting: deque[Packet] = deque()
        latest = time.monotonic() + _WHOLE
        self._socket = connected(host, port, ": is RTDE enabled there?", "is the robot on, is the address right?")
        self._deadline = min(time.monotonic() + PATIENCE, latest)
        try:
            self._agree()
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        """Use it until the end of the block."""
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        """Close it."""
        self.close()

    def close(self) -> None:
        """End the connection."""
        self._socket.close()

    @property
    def fastest(self) -> float:
        """Samples a second that a controller of this version can send [Hz]."""
        return 500.0 if self.version[0] >= _CB_SERIES else 125.0

    def stream(self, fields: Sequence[str] = FIELDS, rate: float | None = None) -> "Stream":
        """Start the samples: of all fields that the controller has.

        Args:
            fields: what is asked for.
            rate: samples a second [Hz]; the fastest by default.

        Raises:
            LinkError: if the controller refuses, or a field that is needed is absent.
        """
        rate = rate or self.fastest
        recipe = self._recipe(tuple(fields), rate)
        if self._ask(START, b"")[:1] != b"\x01":
            raise LinkError(f"{self.host}: the controller does not start its samples")
        self._socket.settimeout(_SILENCE)
        return Stream(self, self._socket, recipe, rate, self._buffer, self._waiting)

    def _agree(self) -> None:
        if self._ask(REQUEST_VERSION, struct.pack(">H", VERSION))[:1] != b"\x01":
            raise LinkError(f"{self.host}: the controller does not speak version 2 of RTDE: update its software")
        answer = self._ask(CONTROLLER_VERSION, b"")
        if len(answer) != 16:
            raise LinkError(f"{self.host}: the controller does not tell its version")
        self.version: tuple[int, ...] = struct.unpack(">4I", answer)

    def _recipe(self, fields: tuple[str, ...], rate: float) -> Recipe:
        """The recipe of those of the fields that are there: an absent one makes a recipe unusable."""
        while True:
            answer = self._ask(OUTPUTS, struct.pack(">d", rate) + ",".join(fields).encode())
            types = answer[1:].decode("ascii", errors="replace").split(",")
            if len(types) != len(fields):
                raise LinkError(f"{self.host}: {len(types)} types for {len(fields)} fields: this is not RTDE")
            try:
                there = chosen(fields, types)
            except LinkError as fault:
                raise LinkError(f"{self.host}: {fault}") from None
            if there == fields:
                return Recipe(answer[0], fields, tuple(types))
            fields = there

    def _ask(self, kind: int, payload: bytes) -> bytes:
        """Send a packet and wait for its answer; messages in between are kept."""
        try:
            self._socket.settimeout(max(self._deadline - time.monotonic(), 0.01))
            self._socket.sendall(packed(kind, payload))
            while True:
                while self._waiting:
                    packet = self._waiting.popleft()
                    if packet.kind == kind:
                        return packet.payload
                    if packet.kind == MESSAGE:
                        self.messages.append(message(packet.payload))
                self._read()
        except TimeoutError:
            raise LinkError(f"{self.host}: connected, but no answer within {PATIENCE:g} s") from None
        except OSError as error:
            raise LinkError(f"{self.host}: the connection was lost: {error.strerror or error}") from None

    def _read(self) -> None:
        left = self._deadline - time.monotonic()
        if left <= 0.0:
            raise TimeoutError
        self._socket.settimeout(left)
        received = self._socket.recv(_CHUNK)
        if not received:
            raise LinkError(f"{self.host}: the controller closed the connection")
        self._buffer += received
        try:
            while packets := split(self._buffer):
                self._waiting.extend(packets)
        except ValueError as error:
            raise LinkError(f"{self.host}: {error}") from None


class Stream:
    """Samples that a thread reads as they come, whatever is done with those before them.

    Attributes:
        recipe: fields that are sent.
        rate: that was asked for [Hz].
        fault: why there are no more; empty while they come.
    """

    def __init__(
        self,
        client: Client,
        connection: socket.socket,
        recipe: Recipe,
        rate: float,
        buffer: bytearray,
        waiting: deque[Packet],
    ) -> None:
        """Begin to read."""
        self.recipe, self.rate, self.fault = recipe, rate, ""
        self._client, self._socket, self._buffer = client, connection, buffer
        self._taken: deque[bytes] = deque()
        self._over = threading.Event()
        self._ended = False
        self._collect(waiting)
        self._thread = threading.Thread(target=self._run, name="rtde", daemon=True)
        self._thread.start()

    def __enter__(self) -> Self:
        """Use it until the end of the block."""
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        """End the thread and the connection."""
        self.close()

    def close(self) -> None:
        """End the thread and the connection."""
        self._ended = True
        with suppress(OSError):  # the other side was faster
            self._socket.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._client.close()

    def take(self, wait: float = 0.1) -> Samples:
        """Samples that came since the last call.

        Args:
            wait: for so long [s], unless the samples end before.

        Raises:
            LinkError: when there are none left, and why no more come.
        """
        over = self._over.wait(wait)
        packets = [self._taken.popleft() for _ in range(len(self._taken))]
        if over and not packets:
            raise LinkError(self.fault)
        return Samples(self.recipe, b"".join(packets))

    def _run(self) -> None:
        try:
            self._receive()
        except TimeoutError:
            self.fault = f"{self._client.host}: no sample for {_SILENCE:g} s"
        except (OSError, ValueError) as error:
            why = getattr(error, "strerror", None) or str(error)
            self.fault = why if why.startswith(self._client.host) else f"{self._client.host}: {why}"
        finally:
            self._over.set()

    def _receive(self) -> None:
        """Read until the connection ends; half a packet now and then does not count as a sample."""
        last = time.monotonic()
        while not self._ended:
            received = self._socket.recv(_CHUNK)
            if not received:
                raise LinkError("the controller closed the connection")
            self._buffer += received
            now = time.monotonic()
            while packets := split(self._buffer):
                last = now if self._collect(packets) else last
            if now - last > _SILENCE:
                raise TimeoutError

    def _collect(self, packets: Sequence[Packet] | deque[Packet]) -> int:
        """Keep the samples among packets; gives their number."""
        size, count = self.recipe.layout.size, 0
        for kind, payload in packets:
            if kind == DATA:
                if len(payload) != size + 1 or payload[0] != self.recipe.number:
                    raise LinkError("a sample is not of the size or the recipe that was agreed on")
                self._taken.append(payload[1:])
                count += 1
            elif kind == MESSAGE:
                self._client.messages.append(message(payload))
        return count
