"""What speaks against something, and the verdict on numbers: the form in which every look at data answers."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import filterfalse
from typing import Literal, NamedTuple

Severity = Literal["error", "warning", "note"]
"""error: nothing may be used so; warning: not everything may, or numbers will be poor; note: worth knowing."""
Level = Literal["use", "mass_and_com_only", "identified_only", "do_not_use"]
"""Use every number; of a payload mass and centre of mass; of drive gains those that are identified; none."""
_FOUNDATION = ("mass", "everything")
_OUTDONE = 1.5
"""A way to take all recordings that leaves so many times the squared residual of the best cause is none."""


class Finding(NamedTuple):
    """One thing that was found out about recordings or about numbers made from them.

    Attributes:
        about: the quantity, joint or recording it speaks of; "everything" where it is all of them.
        text: one or two sentences: what, where, what to do.
        cause: whether it says where what else was found may come from.
        explains: of a cause, the share of the squared residual that it takes off.
    """

    severity: Severity
    about: str
    text: str
    cause: bool = False
    explains: float = 0.0


@dataclass(frozen=True)
class Verdict:
    """Whether numbers may be used, what speaks against them, and what else is worth knowing."""

    level: Level
    findings: tuple[Finding, ...] = ()

    @property
    def reasons(self) -> tuple[str, ...]:
        """What speaks against the numbers, in words."""
        return tuple(finding.text for finding in self.findings if finding.severity != "note")

    @property
    def notes(self) -> tuple[str, ...]:
        """What is worth knowing, in words."""
        return tuple(finding.text for finding in self.findings if finding.severity == "note")


def error(text: str, about: str = "everything") -> Finding:
    """A finding against every number."""
    return Finding("error", about, text)


def note(text: str, about: str = "everything") -> Finding:
    """A finding that is worth knowing."""
    return Finding("note", about, text)


def warning(text: str, about: str = "inertia") -> Finding:
    """A finding against the inertia, or some other number, only."""
    return Finding("warning", about, text)


def verdict_of(findings: Sequence[Finding], brief: bool = True, partly: Level = "mass_and_com_only") -> Verdict:
    """The level that findings leave, and those that are reported: what explains most first, notes last.

    The mass is what every number rests on: whatever speaks against it, or against everything, leaves nothing.

    Args:
        findings: in the order in which they are reported, behind what explains them.
        brief: where no number may be used, leave out what speaks against single ones and is no cause; else it
            comes last.
        partly: the level where only single numbers are spoken against.
    """
    distinct_findings = dict.fromkeys(findings)
    notes = list(filter(_is_note, distinct_findings))
    distinct = _best_explained(list(filterfalse(_is_note, distinct_findings)))
    if not any(map(_against_all, distinct)):
        return Verdict(partly if distinct else "use", (*distinct, *notes))
    weighty = [finding for finding in distinct if _against_all(finding) or finding.cause]
    rest = [] if brief else [finding for finding in distinct if finding not in weighty]
    weighty.sort(key=_place)
    return Verdict("do_not_use", (*weighty, *rest, *notes))


def _best_explained(findings: list[Finding]) -> list[Finding]:
    """Without ways to take all recordings that a cause outdoes: a turned joint may look like another robot."""
    left = min((1.0 - finding.explains for finding in findings if _explains(finding)), default=1.0)
    return [
        finding
        for finding in findings
        if not (finding.cause and finding.about == "everything" and 1.0 - finding.explains > _OUTDONE * left)
    ]


def _is_note(finding: Finding) -> bool:
    return finding.severity == "note"


def _place(finding: Finding) -> tuple[float, bool]:
    """Causes first, the best before others, and of equal ones that of all recordings before that of one."""
    if not _explains(finding):
        return 2.0, False
    return 1.0 - round(finding.explains, 2), finding.about != "everything"


def _explains(finding: Finding) -> bool:
    """Whether it names where most of what else was found comes from: a screen shows the first reasons only."""
    return finding.cause and finding.severity == "error"


def _against_all(finding: Finding) -> bool:
    return finding.severity == "error" or (finding.severity == "warning" and finding.about in _FOUNDATION)
