"""Findings on recordings or numbers, and the verdict that they add up to."""

from collections.abc import Sequence
from typing import Literal, NamedTuple, Self

from ...common.schema import Worked

Severity = Literal["error", "warning", "note"]
"""Severity: error: nothing may be used so; warning: numbers are poor or not all for use; note: worth knowing."""
Level = Literal["use", "mass_and_com_only", "identified_only", "do_not_use"]
"""Level of use: every number; of a payload mass and centre of mass; of gains those that are identified; none."""
_OUTDONE = 1.5
"""A cause that leaves so many times the squared residual of the best one is not reported: a turned joint may look
like another robot."""


class Finding(NamedTuple):
    """Fault or remark on recordings, or on numbers made from them."""

    severity: Severity
    about: str  # the quantity, joint or recording; "everything" where it is all of them
    text: str  # what, where, what to do
    cause: bool = False  # whether it says where other findings may come from
    explains: float = 0.0  # of a cause: fraction of the squared residual that it takes off

    @property
    def spoils_all(self) -> bool:
        """True if no number may be used: the mass is what every number rests on."""
        return self.severity == "error" or (self.severity == "warning" and self.about in ("mass", "everything"))


def error(text: str, about: str = "everything") -> Finding:
    """Make a finding against every number."""
    return Finding("error", about, text)


def warning(text: str, about: str = "inertia") -> Finding:
    """Make a finding against the inertia, or some other number, only."""
    return Finding("warning", about, text)


def note(text: str, about: str = "everything") -> Finding:
    """Make a finding that is worth knowing."""
    return Finding("note", about, text)


class Verdict(Worked, frozen=True, dict=True, omit_defaults=True):
    """Verdict on the use of numbers: what speaks against them, and what else is worth knowing."""

    level: Level
    reasons: tuple[str, ...]
    notes: tuple[str, ...] = ()

    @classmethod
    def made(cls, level: Level, *findings: Finding) -> Self:
        """State the level, and its findings as texts."""
        against, notes = ([f.text for f in findings if (f.severity == "note") is note] for note in (False, True))
        return cls(level, tuple(against), tuple(notes)).made_by(findings)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Findings that it was made from; none where it was read from a file."""
        return self.working or ()


def verdict_of(findings: Sequence[Finding], brief: bool = True, partly: Level = "mass_and_com_only") -> Verdict:
    """Make the verdict of findings: the level that they leave, those that explain most first, notes last.

    Args:
        findings: in the order in which they are reported, behind what explains them.
        brief: where no number may be used, leave out what spoils single ones and is no cause; else it comes last.
        partly: the level where only single numbers are spoilt.
    """

    def rank(finding: Finding) -> tuple[float, bool]:
        # Of equal causes that of all recordings comes first; what takes off too little to be a cause comes last.
        if finding not in causes:
            return 3.0 if finding.explains else 2.0, False
        return 1.0 - round(finding.explains, 2), finding.about != "everything"

    distinct = list(dict.fromkeys(findings))
    notes = [finding for finding in distinct if finding.severity == "note"]
    causes = [finding for finding in distinct if finding.cause and finding.severity == "error"]
    most = _OUTDONE * min((1.0 - finding.explains for finding in causes), default=1.0)
    against = [
        finding
        for finding in distinct
        if finding.severity != "note"
        and not (finding.cause and finding.about == "everything" and 1.0 - finding.explains > most)
    ]
    if not any(finding.spoils_all for finding in against):
        return Verdict.made(partly if against else "use", *against, *notes)
    weighty = [finding for finding in against if finding.spoils_all or finding.cause]
    rest = [] if brief else [finding for finding in against if finding not in weighty]
    return Verdict.made("do_not_use", *sorted(weighty, key=rank), *rest, *notes)
