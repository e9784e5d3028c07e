"""Controllers that are played, each in a process of its own."""

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest


class Played:
    """A player's process: its ports, and what it tells."""

    def __init__(self, **options: Any) -> None:
        command = [sys.executable, "-S", str(Path(__file__).with_name("player.py")), json.dumps(options)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.port, self.script_port = self.next()["ports"]
        self.host = str(options.get("host", "127.0.0.1"))

    def next(self) -> dict[str, Any]:
        """The next thing it tells; waits for it."""
        assert self._process.stdout is not None
        event: dict[str, Any] = json.loads(self._process.stdout.readline())
        return event

    def events(self) -> list[dict[str, Any]]:
        """All that it has told; ends it."""
        out, _ = self._process.communicate(timeout=10)
        return [json.loads(line) for line in out.splitlines()]

    def close(self) -> None:
        if self._process.poll() is None:
            self._process.communicate(timeout=10)

    @property
    def address(self) -> list[str]:
        """Options that lead to it."""
        return ["--host", self.host, "--port", str(self.port)]


@contextmanager
def playing(**options: Any) -> Iterator[Played]:
    """A player within a block."""
    player = Played(**options)
    try:
        yield player
    finally:
        player.close()


Play = Callable[..., Played]


@pytest.fixture
def play() -> Iterator[Play]:
    """Starts players, and ends them."""
    with ExitStack() as players:

        def start(**options: Any) -> Played:
            return players.enter_context(playing(**options))

        yield start
