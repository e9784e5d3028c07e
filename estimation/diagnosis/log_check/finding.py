"""One thing that a look at a log has shown."""

from dataclasses import dataclass
from typing import Literal

Severity = Literal["error", "warning", "note"]
"""error: the log cannot be used so; warning: numbers from it will be poor or wrong; note: worth knowing."""


@dataclass(frozen=True)
class Finding:
    """What was found, in words.

    Attributes:
        severity: how bad it is.
        words: one or two sentences: what, where, what to do.
    """

    severity: Severity
    words: str
