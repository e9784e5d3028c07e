"""How long work tells what it is doing."""

from collections.abc import Callable

Progress = Callable[[str], None]
"""Called with a line about what is being worked on."""


def silent(_: str) -> None:
    """Tell nothing."""
