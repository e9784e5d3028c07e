"""The choice of cases that ``make test`` runs; ``make test-all`` runs all of them."""

from collections.abc import Callable, Iterable
from typing import Any

import pytest


def cases(values: Iterable[Any], short: Callable[[Any], bool]) -> list[Any]:
    """All cases; those that are not ``short`` are marked long."""
    return [value if short(value) else pytest.param(value, marks=pytest.mark.long) for value in values]


def every(step: int, values: Iterable[Any]) -> list[Any]:
    """All cases; all but every ``step``-th are marked long."""
    listed = list(values)
    return cases(listed, lambda value: listed.index(value) % step == 0)
