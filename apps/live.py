"""A Universal Robots controller over the network: samples by the protocol RTDE, recordings of them, and payloads.

Packets of RTDE, version 2, are big-endian, a size and a type before each payload. Source: the maker's guide
"Real-Time Data Exchange (RTDE)", protocol version 2.
"""

import gzip
import math
import socket
import struct
import threading
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from queue import Empty, Queue
from typing import Any

import numpy as np

from ..common import Array, InputError
from ..common.files import write_bytes
from ..common.schema import naming
from .extras import parquet_bytes

PORT, SCRIPT_PORT = 30004, 30002  # ports of RTDE, and of the secondary client interface, which takes scripts
TIME, POSITION, SPEED, CURRENT = "timestamp", "actual_q", "actual_qd", "actual_current"
MASS, CENTRE, INERTIA, SAFETY = "payload", "payload_cog", "payload_inertia", "safety_mode"
FIELDS = (
    TIME, POSITION, SPEED, CURRENT, "target_moment", "actual_current_as_torque", "joint_temperatures",
    "actual_TCP_pose", MASS, CENTRE, INERTIA, "robot_mode", SAFETY,
)  # fmt: skip
"""Fields that a recording asks for, under the protocol's names: the log's columns are called after them."""
_TYPES = dict.fromkeys(FIELDS, "VECTOR6D") | {
    TIME: "DOUBLE", MASS: "DOUBLE", CENTRE: "VECTOR3D", "robot_mode": "INT32", SAFETY: "INT32",
}  # fmt: skip
"""Their types by the maker's guide."""
NEEDED = (TIME, POSITION, SPEED, CURRENT)  # fields without which a recording says nothing
Samples = np.ndarray[tuple[int], np.dtype[Any]]  # consecutive samples, with the fields by name

_REQUEST_VERSION, _CONTROLLER_VERSION, _MESSAGE, _OUTPUTS, _START, _PAUSE, _DATA = _KINDS = b"VvMOSPU"
_HEADER = struct.Struct(">HB")  # size of the packet with this header, and its type
_FORMATS = {
    "BOOL": "?", "UINT8": "u1", "UINT32": ">u4", "UINT64": ">u8", "INT32": ">i4", "DOUBLE": ">f8",
    "VECTOR3D": "(3,)>f8", "VECTOR6D": "(6,)>f8", "VECTOR6INT32": "(6,)>i4", "VECTOR6UINT32": "(6,)>u4",
}  # fmt: skip
"""Types of the protocol as NumPy writes them."""
_CB_SERIES = 5  # major versions below are of controllers that send 125 times a second
_PATIENCE = 2.5  # s: by then a name must be resolved, and then a host must have answered
_AGREED = 4.8  # s: by then all is agreed on, or it is told what is wrong
_SILENCE = 2.0  # s: samples that stay away longer do not come any more
_CHUNK = 65536
_STILL = 2.0  # s: time that stands still for so many samples, or twice as long by ours, is no clock
_TICK = 1e-4  # s: steps of the clock that differ by less are one
_MOVED = 0.17  # rad: a joint that has gone farther counts as moved
_STOPS = {
    3: "protective stop", 4: "recovery", 5: "safeguard stop", 6: "emergency stop of the system",
    7: "emergency stop of the robot", 8: "violation", 9: "fault",
}  # fmt: skip
"""Safety modes in which the arm does not move as it was told (the maker's guide, safety_mode)."""
SUFFIXES = (".csv", ".csv.gz", ".parquet")  # formats that a recording can be written in, by the file's name


class Client(AbstractContextManager["Client"]):
    """A connection to a controller, to be used in a ``with``."""

    version: tuple[int, ...]  # of the controller's software: major, minor, bugfix, build
    layout: np.dtype[Any]  # fields of a sample, once it was started
    rate: float  # samples a second that were asked for [Hz], once it was started

    def __init__(self, host: str, port: int = PORT) -> None:
        """Connect and agree on the protocol, or tell within 5 s why not."""
        self.host = f"{host}:{port}"
        self._buffer, self._number, self._fault, self._last = bytearray(), 0, "", 0.0
        latest = time.monotonic() + _AGREED
        self._socket = _connected(host, port, ": is RTDE enabled there?", "is the robot on, is the address right?")
        self._deadline = min(time.monotonic() + _PATIENCE, latest)
        try:
            with naming(self.host):
                if self._ask(_REQUEST_VERSION, struct.pack(">H", 2))[:1] != b"\x01":
                    raise ValueError("the controller does not speak version 2 of RTDE: update its software")
                if len(answer := self._ask(_CONTROLLER_VERSION)) != 16:
                    raise ValueError("the controller does not tell its version")
            self.version = struct.unpack(">4I", answer)
        except BaseException:
            self._socket.close()
            raise

    def __exit__(self, *_: object) -> None:
        """Close it."""
        self._socket.close()

    def start(self, fields: Sequence[str] = FIELDS, rate: float | None = None) -> None:
        """Start the samples of all fields that the controller has, ``rate`` [Hz] a second, the fastest by default.

        A controller that refuses, or has not a field that is needed, is an ``InputError``.
        """
        self.rate = rate or (500.0 if self.version[0] >= _CB_SERIES else 125.0)
        kinds, asked = dict.fromkeys(fields, ""), tuple[str, ...]()
        with naming(self.host):
            while asked != tuple(kinds):  # an absent field makes a recipe unusable
                asked = tuple(kinds)
                answer = self._ask(_OUTPUTS, struct.pack(">d", self.rate) + ",".join(asked).encode())
                types = answer[1:].decode("ascii", errors="replace").split(",")
                if len(types) != len(asked):
                    raise ValueError(f"{len(types)} types for {len(asked)} fields: this is not RTDE")
                kinds = {field: kind for field, kind in zip(asked, types, strict=True) if kind != "NOT_FOUND"}
                if absent := [field for field in asked if field in NEEDED and field not in kinds]:
                    raise ValueError(f"the controller has no {', '.join(absent)}: nothing can be recorded from it")
                for field, kind in kinds.items():
                    if kind not in _FORMATS:
                        raise ValueError(f"{field} comes as {kind!r}, which is no type of RTDE")
                    if kind != (usual := _TYPES.get(field, kind)):
                        raise ValueError(f"{field} comes as {kind} in the place of {usual}: is it RTDE?")
            self._number = answer[0]
            self.layout = np.dtype([(field, _FORMATS[kind]) for field, kind in kinds.items()])
            if self._ask(_START)[:1] != b"\x01":
                raise ValueError("the controller does not start its samples")
        self._last = time.monotonic()

    def take(self, wait: float = 0.1) -> Samples:
        """Samples that have come since the last call, or come within ``wait`` [s]; the system keeps them.

        When there are none left, an ``InputError`` tells why no more come.
        """
        until, samples = time.monotonic() + wait, list[bytes]()
        try:
            while not self._fault:
                kind, payload = self._packet(until)
                if kind == _DATA:
                    if len(payload) != self.layout.itemsize + 1 or payload[0] != self._number:
                        raise InputError("a sample is not of the size or the recipe that was agreed on")
                    samples.append(payload[1:])
        except TimeoutError:
            pass
        except (OSError, ValueError) as error:
            self._fault = getattr(error, "strerror", None) or str(error)
        if samples:
            self._last = time.monotonic()
        elif self._fault or time.monotonic() - self._last > _SILENCE:
            raise InputError(f"{self.host}: {self._fault or f'no sample for {_SILENCE:g} s'}")
        return np.frombuffer(b"".join(samples), self.layout)

    def _ask(self, kind: int, payload: bytes = b"") -> bytes:
        try:
            self._socket.settimeout(max(self._deadline - time.monotonic(), 0.01))
            self._socket.sendall(_HEADER.pack(_HEADER.size + len(payload), kind) + payload)
            while (packet := self._packet(self._deadline))[0] != kind:
                pass
        except TimeoutError:
            raise ValueError(f"connected, but no answer within {_PATIENCE:g} s") from None
        except OSError as error:
            raise ValueError(f"the connection was lost: {error.strerror or error}") from None
        return packet[1]

    def _packet(self, until: float) -> tuple[int, bytes]:
        """Wait for the next packet until a time, its type and its payload; those before a wrong one count."""
        while True:
            if len(self._buffer) >= _HEADER.size:
                size, kind = _HEADER.unpack_from(self._buffer)
                if size < _HEADER.size or kind not in _KINDS:
                    raise InputError("what arrives is not RTDE: is this the right port?")
                if len(self._buffer) >= size:
                    payload = bytes(self._buffer[_HEADER.size : size])
                    del self._buffer[:size]
                    return kind, payload
            if (seconds := until - time.monotonic()) <= 0.0:
                raise TimeoutError
            self._socket.settimeout(seconds)
            received = self._socket.recv(_CHUNK)
            if not received:
                raise InputError("the controller closed the connection")
            self._buffer += received


def _connected(host: str, port: int, hint: str, silent: str) -> socket.socket:
    """Open a socket, within 2.5 s for the name and 2.5 s for the host; ``hint`` and ``silent``: why there is none.

    The system may look a name up for 30 s, where the name server is silent: a thread asks it.
    """
    address, found = f"{host}:{port}", Queue[Any]()

    def resolve() -> None:
        try:
            found.put(socket.getaddrinfo(host, port, type=socket.SOCK_STREAM))
        except (OSError, UnicodeError) as error:
            found.put(error)

    threading.Thread(target=resolve, name="resolving", daemon=True).start()
    try:
        places = found.get(timeout=_PATIENCE)
        if isinstance(places, Exception):
            raise places
        return socket.create_connection((host, port), _PATIENCE / len(places))  # it tries each in its turn
    except Empty:
        fault = f"the name {host} was not resolved within {_PATIENCE:g} s: give the address"
    except TimeoutError:
        fault = f"no answer within {_PATIENCE:g} s: {silent}"
    except (OSError, UnicodeError) as error:
        fault = f"no connection: {getattr(error, 'strerror', None) or error}{hint}"
    raise InputError(f"{address}: {fault}")


class Recorder:
    """Samples of one connection, in rising time.

    The controller's time stamps count, not the arrival: what is missing between them was dropped.
    """

    def __init__(self, rate: float, length: float = math.inf) -> None:
        """Begin an empty one of ``rate`` samples a second [Hz], over after a ``length`` in its own time [s]."""
        self.rate, self.length = rate, length
        self.count = self.repeated = 0  # samples that are kept, and those that came again
        self.stops: list[tuple[float, str]] = []  # what stopped the arm, with the time since the start [s]
        self._kept: list[Samples] = []
        self._steps = Counter[int]()
        self._lowest: Array = np.full(6, np.inf)
        self._highest: Array = np.full(6, -np.inf)
        self._standing, self._first, self._last, self._stop = 0, 0.0, 0.0, ""
        self._begun = self._ran = time.monotonic()  # the latter: when the controller's time last went on

    @property
    def seconds(self) -> float:
        """Length in the controller's time [s]."""
        return self._last - self._first

    @property
    def step(self) -> float:
        """The usual time from one sample to the next [s]; that of the rate asked for while there are none."""
        return _TICK * self._steps.most_common(1)[0][0] if self._steps else 1.0 / self.rate

    @property
    def dropped(self) -> int:
        """Samples that are missing between those that are there, by their time stamps."""
        step = self.step
        return sum(count * max(round(_TICK * ticks / step) - 1, 0) for ticks, count in self._steps.items())

    @property
    def moved(self) -> list[int]:
        """Numbers of the joints that have moved so far, by 10 degrees at least."""
        return [int(j) + 1 for j in np.flatnonzero(self._highest - self._lowest > _MOVED)]

    def add(self, samples: Samples) -> Samples:
        """Keep samples, and give those that are new; a time that runs back or stands still ends it all."""
        new, safe = list[int](), SAFETY not in (samples.dtype.names or ())
        modes = [0] * len(samples) if safe else samples[SAFETY].tolist()
        try:
            for k, (now, mode) in enumerate(zip(samples[TIME].tolist(), modes, strict=True)):
                if self.seconds >= self.length:
                    break
                step, after = now - self._last, f"after {self.seconds:.1f} s"
                if not self.count:
                    self._first = now
                elif not 0.0 <= step < 1e9:
                    raise InputError(f"its time runs back {after}: was the controller restarted?")
                elif step == 0.0:
                    self.repeated, self._standing = self.repeated + 1, self._standing + 1
                    if max(self._standing * self.step, 0.5 * (time.monotonic() - self._ran)) > _STILL:
                        raise InputError(f"the controller's time stopped {after}")
                    continue
                else:
                    self._steps[max(round(step / _TICK), 1)] += 1
                self._last, self._standing, self._ran = now, 0, time.monotonic()
                if (ours := self._ran - self._begun) > 2.0 * self.length + _SILENCE:
                    fault = f"the controller's time goes on by {self.seconds:.1f} s in {ours:.0f} s"
                    raise InputError(f"{fault}: it is no clock")
                new.append(k)
                self.count += 1
                if (stop := _STOPS.get(mode, "")) not in ("", self._stop):
                    self.stops.append((self.seconds, stop))
                self._stop = stop
        finally:
            self._kept.append(kept := samples[new])
        self._lowest = np.minimum(self._lowest, kept[POSITION].min(axis=0, initial=np.inf))
        self._highest = np.maximum(self._highest, kept[POSITION].max(axis=0, initial=-np.inf))
        return kept

    def write(self, path: str | Path) -> None:
        """Write what there is in the format of the name; a field of several numbers counts its columns from 0."""
        if not self.count:
            raise InputError(f"{path}: not written: no sample came")
        samples, ending = np.concatenate(self._kept), Path(path).suffix.lower()
        columns: dict[str, Any] = {}
        for name in samples.dtype.names or ():
            values = samples[name].astype(samples[name].dtype.newbyteorder("="))
            several = {f"{name}_{k}": column for k, column in enumerate(values.T)} if values.ndim > 1 else {}
            columns |= several or {name: values}
        if ending == ".parquet":
            content = parquet_bytes(columns)
        else:
            rows = zip(*(map(repr, column.tolist()) for column in columns.values()), strict=True)
            content = "".join(f"{','.join(row)}\n" for row in [tuple(columns), *rows]).encode()
        write_bytes(path, gzip.compress(content, mtime=0) if ending == ".gz" else content)


def program(command: str) -> str:
    """A secondary program that runs one call of ``set_target_payload``; anything else is a ``ValueError``.

    A program that begins with ``sec`` runs beside the one that moves the arm, may not move it and takes none of its
    time (URScript manual, secondary programs).
    """
    inside = command.removeprefix("set_target_payload(").removesuffix(")")
    if len(inside) != len(command) - len("set_target_payload()") or not set(inside) <= set("0123456789.,+-e[] "):
        raise ValueError(f"not a payload: {command!r}")
    return f"sec dynident_payload():\n  {command}\nend\n"


@contextmanager
def send_program(text: str, host: str, port: int = SCRIPT_PORT) -> Iterator[None]:
    """Send a program; the connection stays open within the block, for the controller reads in its own time."""
    hint = ": nothing was sent; switch the controller to remote control"
    with _connected(host, port, hint, "nothing was sent") as connection:
        try:
            connection.sendall(text.encode("ascii"))
        except OSError as error:
            raise InputError(f"{host}:{port}: the connection was lost: {error.strerror or error}") from None
        yield
