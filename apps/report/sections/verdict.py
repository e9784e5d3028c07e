"""A verdict in words, why it is given, and what errors of the drive gains add."""

from typing import NamedTuple

import numpy as np

from ....common.schema import present
from ....estimation import Gains
from ....estimation.results.parts import ProcessingDocument, VerdictDocument
from ..blocks import Block, Notes, Text


class VerdictWords(NamedTuple):
    """One level in words: after "Verdict:", and as a sentence."""

    words: str
    sentence: str


MEND = "Next: mend what the reasons name, record again, and look at the logs by 'dynident check'."
"""It follows an answer that is not to be used."""
VERDICTS = {
    "use": VerdictWords("use mass, centre of mass and inertia", "Mass, centre of mass and inertia can be used."),
    "mass_and_com_only": VerdictWords(
        "use mass and centre of mass",
        "Mass and centre of mass can be used; the inertia was not measured well enough.",
    ),
    "identified_only": VerdictWords(
        "use the gains that are identified",
        "The gains that are identified can be used; keep the maker's elsewhere.",
    ),
    "do_not_use": VerdictWords("do not use", "Do not use these numbers."),
}
"""Each level in words."""


def reason_lines(verdict: VerdictDocument) -> list[str]:
    """Reasons of a verdict as items of a list."""
    return [f"  - {reason}" for reason in verdict.reasons]


def verdict_notes(verdict: VerdictDocument) -> list[str]:
    """List the notes of a verdict."""
    return [f"Note: {text}." for text in present(verdict.notes) or ()]


def reason_blocks(verdict: VerdictDocument) -> list[Block]:
    """Give the reasons for the verdict as a list."""
    reasons: Block = Text("No check found anything against the numbers.")
    if verdict.reasons:
        reasons = Notes([f"{reason[:1].upper()}{reason[1:]}." for reason in verdict.reasons])
    return [Text("Reasons for the verdict", "heading"), reasons]


def gain_error_notes(processing: ProcessingDocument, gains: Gains | None) -> list[str]:
    """Lines on the errors of the drive gains that intervals allow for, and on the gains themselves."""
    # Torque sensors on the link side have scales, motors have gains.
    scales = "scales of the torque sensors" if processing.torque_side == "link" else "drive gains"
    each = "motor" if processing.coulomb else "joint"
    if gains is None or not (gains.identified or any((*gains.per_joint, gains.common))):
        return [f"{scales.capitalize()} are taken as exact: no residual shows their errors."]
    if gains.identified:
        sigmas = np.sqrt(np.diag(gains.covariance(len(gains.identified))))
        percents = ", ".join(f"{100.0 * sigma:.2g}" for sigma in sigmas)
        line = f"Intervals include errors of the drive gains as they were identified: {percents} % per {each}."
    else:
        percents = ", ".join(f"{100.0 * sigma:g}" for sigma in gains.per_joint)
        common = f" and {100.0 * gains.common:g} % common to all joints" if gains.common else ""
        source = ", as is usual: nothing is said of them (--gain-sigma)" if gains.assumed else ""
        line = f"Intervals include errors of the {scales}: {percents} % per {each}{common}{source}."
    return [line, *gains.notes]
