"""A verdict in words, and why."""

from collections.abc import Sequence
from typing import NamedTuple

from ....estimation import PayloadAnswer, Verdict
from ....estimation.answers.prediction import TorquePrediction
from ..blocks import Banner, Block, Notes, Text
from .gain_errors import scales_in_words


class VerdictWords(NamedTuple):
    """One level in words: below the tables of an answer and of a weighing, as a sentence, and quantity by quantity.

    ``each``: what to do with mass, centre of mass and inertia.
    """

    payload: str
    weighing: str
    sentence: str
    each: tuple[str, str, str]


MEND = "Next: mend what the reasons name, record again, and look at the logs by 'dynident check'."
"""What to do with an answer that is not to be used."""
_VAGUE = "not measured well enough"
VERDICTS = {
    "use": VerdictWords(
        "use",
        "use mass, centre of mass and inertia",
        "Mass, centre of mass and inertia can be used.",
        ("use", "use", "use"),
    ),
    "mass_and_com_only": VerdictWords(
        "use mass and centre of mass only",
        "use mass and centre of mass",
        f"Mass and centre of mass can be used; the inertia was {_VAGUE}.",
        ("use", "use", _VAGUE),
    ),
    "identified_only": VerdictWords(
        "use the gains that are identified",
        "use the gains that are identified",
        "The gains that are identified can be used; keep the maker's elsewhere.",
        ("use", "use", "use"),
    ),
    "do_not_use": VerdictWords(
        "do not use", "do not use", "Do not use these numbers.", ("do not use", "do not use", "do not use")
    ),
}
"""Each level in words."""


def verdict_banner(verdict: Verdict) -> Banner:
    """A payload's verdict as a sentence."""
    return Banner(verdict.level, VERDICTS[verdict.level].sentence)


def verdict_lines(words: str, verdict: Verdict) -> list[str]:
    """The verdict for a terminal, with its reasons, and what else is worth knowing."""
    return [f"Verdict: {words}.", *reason_lines(verdict), *(f"Note: {text}." for text in verdict.notes)]


def reason_lines(verdict: Verdict) -> list[str]:
    """Reasons of a verdict as items of a list."""
    return [f"  - {reason}" for reason in verdict.reasons]


def reason_blocks(verdict: Verdict) -> list[Block]:
    """Why the verdict is what it is."""
    reasons: Block = Text("No check found anything against the numbers.")
    if verdict.reasons:
        reasons = Notes([f"{_capital(reason)}." for reason in verdict.reasons])
    known = [Notes([f"Note: {text}." for text in verdict.notes])] if verdict.notes else []
    return [Text("Reasons for the verdict", "heading"), reasons, *known]


def improvements(answer: PayloadAnswer, predictions: Sequence[TorquePrediction]) -> Block:
    """What would make the answer better or better known."""
    best, scales, lines = answer.recommended, scales_in_words(answer.problem.robot), list[str]()
    robust = best.free.estimate.robust
    if not best.weighings:
        lines.append(f"Weigh the payload and give --mass KG+-KG: the weighing checks the {scales}.")
    if best.gains is None:
        lines.append(
            f"Say how well the {scales} are known (--gain-sigma 2%): no residual shows their errors, and the "
            "intervals leave them out."
        )
    if not any(prediction.held_out for prediction in predictions):
        lines.append("Keep one recording without payload out of identification (--validate).")
    if best.free.without_robust:
        lines.append(f"Record longer: intervals rest on white noise, because {best.free.without_robust}.")
    elif robust is not None and robust.warning:
        lines.append(f"{_capital(robust.warning)}.")
    lines += [f"Method {method} could not be used: {reason}." for method, reason in answer.left_out.items()]
    return Notes(lines) if lines else Text("Nothing stands out.")


def _capital(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}"
