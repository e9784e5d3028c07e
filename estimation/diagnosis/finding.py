"""What speaks against something, and the verdict on numbers: the form in which every look at data answers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

Severity = Literal["error", "warning", "note"]
"""error: nothing may be used so; warning: not everything may, or numbers will be poor; note: worth knowing."""
Level = Literal["use", "mass_and_com_only", "do_not_use"]
"""Use every number; the mass and the centre of mass; none."""


class Finding(NamedTuple):
    """One thing that was found out about recordings or about numbers made from them.

    Attributes:
        severity: how bad it is.
        about: the quantity, joint or recording it speaks of; "everything" where it is all of them.
        text: one or two sentences: what, where, what to do.
        cause: whether it says where what else was found may come from.
    """

    severity: Severity
    about: str
    text: str
    cause: bool = False


@dataclass(frozen=True)
class Verdict:
    """Whether numbers may be used, and what speaks against them."""

    level: Level
    findings: tuple[Finding, ...] = ()

    @property
    def reasons(self) -> tuple[str, ...]:
        """The findings in words."""
        return tuple(finding.text for finding in self.findings)


def error(text: str, about: str = "everything") -> Finding:
    """A finding against every number."""
    return Finding("error", about, text)


def warning(text: str, about: str = "inertia") -> Finding:
    """A finding against the inertia, or some other number, only."""
    return Finding("warning", about, text)


def verdict_of(findings: Sequence[Finding], brief: bool = True) -> Verdict:
    """The level that findings leave, and those that are told.

    Args:
        findings: in the order in which they are told.
        brief: where no number may be used, leave out what speaks against single ones and is no cause; else it
            comes last.
    """
    distinct = list(dict.fromkeys(finding for finding in findings if finding.severity != "note"))
    if not any(finding.severity == "error" for finding in distinct):
        return Verdict("mass_and_com_only" if distinct else "use", tuple(distinct))
    weighty = [finding for finding in distinct if finding.severity == "error" or finding.cause]
    rest = [] if brief else [finding for finding in distinct if finding not in weighty]
    return Verdict("do_not_use", (*weighty, *rest))
