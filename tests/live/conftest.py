"""Controllers that are played."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest
from dynident.tests.live.played import Played, playing

Play = Callable[..., Played]


@pytest.fixture
def play() -> Iterator[Play]:
    """Starts players, and ends them."""
    with ExitStack() as players:

        def start(**options: Any) -> Played:
            return players.enter_context(playing(**options))

        yield start
