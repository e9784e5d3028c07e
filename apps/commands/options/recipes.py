"""How a command makes its numbers from logs, as a store of a fleet remembers it."""

from __future__ import annotations

from dataclasses import replace

from .... import estimation
from ....common.schema import given, json_text
from ... import fleet
from .recordings import Setup


def recipe_of(setup: Setup, gains: estimation.Gains | None) -> fleet.Recipe:
    """How a command makes its numbers."""
    how = {key: entry for key, entry in given(setup.log_map).items() if key != "title"}
    sure = replace(gains, notes=()) if gains is not None else None  # notes speak of single recordings
    words = json_text(how).decode() if how else ""
    return fleet.Recipe(setup.processing, setup.gains, sure, words)
