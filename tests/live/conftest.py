"""Controllers that are played."""

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from dynident.tests.live.played import Played, playing

Play = Callable[..., Played]


@pytest.fixture
def play() -> Iterator[Play]:
    """Starts players, and ends them."""
    with ExitStack() as players:

        def start(**asked: Any) -> Played:
            return players.enter_context(playing(**asked))

        yield start


@pytest.fixture(scope="session")
def recordings() -> Path:
    """Folder of real recordings."""
    folder = os.environ.get("DYNIDENT_DATA")
    if not folder or not Path(folder).is_dir():
        pytest.skip("real recordings: set DYNIDENT_DATA to their folder")
    return Path(folder)
