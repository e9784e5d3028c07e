"""Packets of the RTDE protocol, version 2: big-endian, a size and a type before each payload.

Source: the maker's guide "Real-Time Data Exchange (RTDE)", protocol version 2.
"""

import struct
from typing import NamedTuple

from ...common.errors import InputError

VERSION = 2
HEADER = struct.Struct(">HB")
"""Size of the packet with this header, and its type."""
REQUEST_VERSION, CONTROLLER_VERSION, MESSAGE = ord("V"), ord("v"), ord("M")
OUTPUTS, START, PAUSE, DATA = ord("O"), ord("S"), ord("P"), ord("U")
KINDS = frozenset((REQUEST_VERSION, CONTROLLER_VERSION, MESSAGE, OUTPUTS, START, PAUSE, DATA))
FORMATS = {
    "BOOL": "?",
    "UINT8": "B",
    "UINT32": "I",
    "UINT64": "Q",
    "INT32": "i",
    "DOUBLE": "d",
    "VECTOR3D": "3d",
    "VECTOR6D": "6d",
    "VECTOR6INT32": "6i",
    "VECTOR6UINT32": "6I",
}
"""Types of the protocol as ``struct`` writes them."""
NOT_FOUND = "NOT_FOUND"
"""Stands in the place of the type of a field that the controller does not have."""


class Packet(NamedTuple):
    """One packet: its type and what stands behind its header."""

    kind: int
    payload: bytes


def packed(kind: int, payload: bytes = b"") -> bytes:
    """A packet as it is sent."""
    return HEADER.pack(HEADER.size + len(payload), kind) + payload


def split(buffer: bytearray) -> list[Packet]:
    """Whole packets at the front of a buffer, which are taken from it; none if there is only a part of one.

    Raises:
        InputError: if the bytes are no packets of this protocol.
    """
    packets: list[Packet] = []
    start = 0
    while len(buffer) - start >= HEADER.size:
        size, kind = HEADER.unpack_from(buffer, start)
        if size < HEADER.size or kind not in KINDS:
            if packets:
                break  # these first; the next call finds what is wrong at the front
            raise InputError("what arrives is not RTDE: is this the right port?")
        if len(buffer) - start < size:
            break
        packets.append(Packet(kind, bytes(buffer[start + HEADER.size : start + size])))
        start += size
    del buffer[:start]
    return packets


def message(payload: bytes) -> str:
    """The text of a controller's message: length, text, length, source, level."""
    length = payload[0] if payload else 0
    return payload[1 : 1 + length].decode("utf-8", errors="replace")
