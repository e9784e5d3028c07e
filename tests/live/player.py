"""A controller to be played with: RTDE and the script port on loopback, in a process of its own.

    python player.py '{"rate": 500, "fault": "silent"}'

prints its two ports and the JSON of what happened, line by line, and ends when its input does. It shares no line
with the client: the protocol is written out here again.
"""

import contextlib
import itertools
import json
import math
import re
import socket
import struct
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

WIDTHS = {"DOUBLE": 1, "VECTOR3D": 3, "VECTOR6D": 6, "UINT32": 1, "INT32": 1}
TYPES = {
    "timestamp": "DOUBLE",
    "actual_q": "VECTOR6D",
    "actual_qd": "VECTOR6D",
    "actual_current": "VECTOR6D",
    "target_moment": "VECTOR6D",
    "actual_current_as_torque": "VECTOR6D",
    "joint_temperatures": "VECTOR6D",
    "actual_TCP_pose": "VECTOR6D",
    "payload": "DOUBLE",
    "payload_cog": "VECTOR3D",
    "payload_inertia": "VECTOR6D",
    "robot_mode": "INT32",
    "safety_mode": "INT32",
}
PROGRAM = re.compile(
    r"sec [a-z_]+\(\):\n  set_target_payload\(([-+.e\d]+), \[([^\]]*)\](?:, \[([^\]]*)\])?\)\nend\n"
)
"""The only thing that the script port takes."""


class Player:
    """The recording that is played, and what the other side did."""

    def __init__(self, **options: Any) -> None:
        self.rate: float = options.get("rate", 125.0)
        self.pace = options.get("pace", 1.0)
        self.fault = options.get("fault", "")
        self.after: int = options.get("after", 0)
        self.cuts = list(options.get("cuts", ()))
        self.absent = set(options.get("absent", ()))
        self.major = options.get("major", 5)
        self.payload = [0.0] * 10
        self.sent = 0
        self.lock = threading.Lock()
        self.host = options.get("host", "127.0.0.1")
        self.rtde = socket.create_server((self.host, options.get("port", 0)))
        self.script = socket.create_server((self.host, options.get("script_port", 0)))
        if self.fault == "refused":
            self.rtde.close()
        if self.fault == "refuses scripts":
            self.script.close()

    def tell(self, **event: Any) -> None:
        print(json.dumps(event), flush=True)

    def serve(self, server: socket.socket, answer: Any) -> None:
        with contextlib.suppress(OSError):
            while True:
                connection, _ = server.accept()
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                threading.Thread(target=self.guarded, args=(answer, connection), daemon=True).start()

    def guarded(self, answer: Any, connection: socket.socket) -> None:
        with connection, contextlib.suppress(OSError, EOFError):
            answer(connection)

    def send(self, connection: socket.socket, data: bytes) -> None:
        """Send, unless the fault is that the line is cut or slow."""
        if self.fault == "cut":
            data = data[: max(self.after - self.sent, 0)]
        if self.fault == "slow":
            for k in range(len(data)):
                connection.sendall(data[k : k + 1])
                time.sleep(0.3)
        else:
            connection.sendall(data)
        self.sent += len(data)
        if self.fault == "cut" and self.sent >= self.after:
            raise EOFError

    def packet(self, connection: socket.socket, kind: str, payload: bytes) -> None:
        self.send(connection, struct.pack(">HB", len(payload) + 3, ord(kind)) + payload)

    def play(self, connection: socket.socket) -> None:
        """Answer one client of RTDE."""
        self.sent, self.after = 0, self.cuts.pop(0) if self.cuts else self.after
        recipe: list[str] = []
        step = 1.0 / self.rate
        if self.fault == "deaf":
            time.sleep(30.0)
        if self.fault == "another protocol":
            connection.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n")
        while True:
            size, kind = struct.unpack(">HB", read(connection, 3))
            payload = read(connection, size - 3)
            if kind == ord("V"):
                (version,) = struct.unpack(">H", payload)
                self.packet(connection, "V", bytes([version == 2 and self.fault != "version 1"]))
            elif kind == ord("v"):
                self.packet(connection, "M", b"\x05hello\x04test\x03")
                self.packet(connection, "v", struct.pack(">4I", self.major, 12, 0, 1))
            elif kind == ord("O"):
                (rate,) = struct.unpack_from(">d", payload)
                # ur_rtde ends its list with a comma, which controllers take.
                recipe = [name for name in payload[8:].decode().split(",") if name]
                unknown = self.absent | (set(recipe) - set(TYPES))
                types = ["NOT_FOUND" if name in unknown else TYPES[name] for name in recipe]
                if self.fault == "another type":
                    types = ["INT32" if kind == "DOUBLE" else kind for kind in types]
                step = 1.0 / min(rate, self.rate)
                self.tell(event="fields", fields=recipe, rate=rate)
                self.packet(connection, "O", bytes([0 if unknown & set(recipe) else 7]) + ",".join(types).encode())
            elif kind == ord("S"):
                accepted = self.fault != "not started"
                self.packet(connection, "S", bytes([accepted]))
                if accepted:
                    self.samples(connection, recipe, step)
                    return
            elif kind == ord("P"):
                self.packet(connection, "P", b"\x01")

    def samples(self, connection: socket.socket, recipe: list[str], step: float) -> None:
        """Send samples until the client goes, or the fault comes."""
        begin, k = time.monotonic(), 0
        for t, state in self.states(step):
            k += 1
            if self.fault and k > self.after > 0 and self.fault != "cut":
                if self.fault == "silent":
                    time.sleep(30.0)
                if self.fault == "closed":
                    return
                if self.fault == "garbage":
                    connection.sendall(b"\xff" * 64)
                    time.sleep(30.0)
                if self.fault == "wrong recipe":
                    self.packet(connection, "U", b"\x09" + bytes(8))
                if self.fault == "drops" and k % 10 == 0:
                    continue
            now = self.shown_time(t, k)
            values: dict[str, list[float]] = {"timestamp": [now], "safety_mode": [1.0], "robot_mode": [7.0]}
            values |= state
            with self.lock:
                values |= {
                    "payload": self.payload[:1],
                    "payload_cog": self.payload[1:4],
                    "payload_inertia": self.payload[4:],
                }
            data = b"\x07" + b"".join(packed(name, values.get(name, [0.0] * 6)) for name in recipe)
            self.packet(connection, "U", data)
            time.sleep(max(begin + k * step / self.pace - time.monotonic(), 0.0))

    def shown_time(self, t: float, k: int) -> float:
        if k > self.after > 0 and self.fault == "time stands still":
            return 1000.0 + (self.after - 1) / self.rate
        if k > self.after > 0 and self.fault in ("time runs back", "restarted"):
            return t - (0.5 if self.fault == "time runs back" else 999.0)
        return 1000.0 + t

    def states(self, step: float) -> Iterator[tuple[float, dict[str, list[float]]]]:
        """Time from 0 [s], positions, speeds and currents."""
        turns = [0.3 + 0.2 * j for j in range(6)]
        for k in itertools.count():
            sines = [math.sin(w * k * step) for w in turns]
            yield (
                k * step,
                {
                    "actual_q": sines,
                    "actual_qd": [w * math.cos(w * k * step) for w in turns],
                    "actual_current": [0.5 * sine for sine in sines],
                    "actual_current_as_torque": [6.0 * sine for sine in sines],
                    "joint_temperatures": [30.0 + j for j in range(6)],
                },
            )

    def take_program(self, connection: socket.socket) -> None:
        """Take one program that sets a payload; tell of every byte that comes."""
        connection.settimeout(0.3)
        text = b""
        with contextlib.suppress(TimeoutError):
            while part := connection.recv(4096):
                text += part
                if text.endswith(b"end\n"):
                    connection.settimeout(0.1)
        match = PROGRAM.fullmatch(text.decode("latin-1"))
        self.tell(event="script", text=text.decode("latin-1"), refused=match is None)
        if match is None or self.fault == "local mode":
            return
        numbers = [float(match[1])] + [float(x) for part in match.groups()[1:] if part for x in part.split(",")]
        numbers += [0.0] * (10 - len(numbers))
        if self.fault == "wrong payload":
            numbers[0] += 0.25
        if self.fault == "wrong inertia":
            numbers[4] += 0.25
        with self.lock:
            self.payload = numbers
        time.sleep(5.0)


def packed(name: str, values: list[float]) -> bytes:
    kind = TYPES[name]
    letter = {"UINT32": "I", "INT32": "i"}.get(kind, "d")
    return struct.pack(f">{WIDTHS[kind]}{letter}", *(map(int, values) if letter != "d" else values))


def read(connection: socket.socket, size: int) -> bytes:
    data = b""
    while len(data) < size:
        part = connection.recv(size - len(data))
        if not part:
            raise EOFError
        data += part
    return data


def main() -> None:
    player = Player(**json.loads(sys.argv[1]))
    ports = [server.getsockname()[1] if server.fileno() >= 0 else 9 for server in (player.rtde, player.script)]
    player.tell(event="ports", ports=ports)
    for server, answer in ((player.rtde, player.play), (player.script, player.take_program)):
        threading.Thread(target=player.serve, args=(server, answer), daemon=True).start()
    sys.stdin.read()  # whoever started it is gone


if __name__ == "__main__":
    main()
