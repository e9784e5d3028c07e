"""Options of a controller on the network."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ... import live
from ..values import port_number
from .reading import Options, option


@dataclass(frozen=True)
class HostOptions(Options):
    """The controller that is listened to."""

    GROUP: ClassVar[str] = "controller"

    host: str | None = option(metavar="H", help="name or address of the controller")
    port: int | None = option(type=port_number, metavar="N", help="its port of RTDE (default: 30004)")

    def client(self) -> live.Client:
        """A connection to it."""
        return live.Client(self.host or "", self.port or live.PORT)
