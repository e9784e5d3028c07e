"""A fault of ours: one line for the user, and a file with what those need who look for it."""

from __future__ import annotations

import shlex
import sys
import tempfile
import traceback
from collections.abc import Sequence

from ...common.errors import one_line
from ...common.versions import versions
from . import INTERNAL_ERROR

_SOLVERS = ("casadi", "clarabel", "cvxpy", "numpy", "scipy")
"""Packages whose versions decide the numbers."""
_TOLD = 200
"""Letters of a fault that are shown; the file has all."""


def told(fault: Exception, words: Sequence[str]) -> int:
    """Tell of a fault in a command line; returns the exit status."""
    details = [f"dynident {shlex.join(words)}", *versions_in_words(), "", *traceback.format_exception(fault)]
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="dynident-fault-", suffix=".txt", delete=False, encoding="utf-8", errors="replace"
        ) as file:
            file.write("\n".join(details))
        where = f"with {file.name}"
    except OSError as error:
        where = f"(its details could not be written: {error.strerror})"
    message = one_line(f"{type(fault).__name__}: {fault}")
    print(f"dynident: internal error, please report {where}: {message[:_TOLD]}", file=sys.stderr)
    return INTERNAL_ERROR


def versions_in_words() -> list[str]:
    """What a report of a fault should name."""
    return [f"{name.lower()} {number}" for name, number in versions(_SOLVERS).items()]
