"""First page: the verdict as a sentence, and each quantity with value, interval and what to do with it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...common.arrays import Array
from ...estimation import PayloadAnswer, Verdict
from ...estimation.payload import ConstrainedPayload, TorquePrediction
from ..gains import scales_in_words
from ..numbers import with_interval
from .markup import Html, bullets, joined, paragraph, tag

_SENTENCES = {
    "use": "Mass, centre of mass and inertia can be used.",
    "mass_and_com_only": "Mass and centre of mass can be used; the inertia was not measured well enough.",
    "do_not_use": "Do not use these numbers.",
}
_USE, _VAGUE, _NOT = "use", "not measured well enough", "do not use"
_TOLD = {"use": (_USE, _USE, _USE), "mass_and_com_only": (_USE, _USE, _VAGUE), "do_not_use": (_NOT, _NOT, _NOT)}
Row = tuple[str, str, str]
"""Name, value with unit, 95 % interval."""


def verdict_box(level: str, sentence: str) -> Html:
    """The verdict; its border differs in line as well as in colour."""
    return tag("div", paragraph(sentence), class_=f"verdict {level}", role="status")


def verdict_of(verdict: Verdict) -> Html:
    """A payload's verdict as a sentence."""
    return verdict_box(verdict.level, _SENTENCES[verdict.level])


def quantities_table(answer: PayloadAnswer) -> Html:
    """Mass, centre of mass and inertia: value, 95 % interval, use or not."""
    best = answer.recommended
    told = _TOLD[answer.verdict.level]
    groups = (_mass(best), _com(best), _inertia(best))
    caption = f"In {best.frame}; inertia at the centre of mass; method {best.method}"
    return grouped_table(caption, groups, told)


def grouped_table(caption: str, groups: Sequence[Sequence[Row]], told: Sequence[str]) -> Html:
    """Quantities in groups; ``told``: what to do with each."""
    bodies = [
        tag("tbody", *(_row(row, words if k == 0 else "", len(rows)) for k, row in enumerate(rows)))
        for rows, words in zip(groups, told, strict=True)
    ]
    cells = (tag("th", "", scope="col"), tag("th", "value", scope="col", class_="number"),
             tag("th", "95 % interval", scope="col", class_="number"), tag("th", "", scope="col"))  # fmt: skip
    table = tag("table", tag("caption", caption), tag("thead", tag("tr", *cells)), *bodies)
    return tag("div", table, class_="scroll quantities")


def pair(left: Html, right: Html) -> Html:
    """Side by side where there is room."""
    return tag("div", tag("div", left), tag("div", right), class_="first")


def agreement(answer: PayloadAnswer) -> Html:
    """The identified mass beside the scale or CAD."""
    weighings = answer.recommended.weighings
    if not weighings:
        return paragraph("No mass from a scale or from CAD was given to compare with.", class_="note")
    lines = []
    for one in weighings:
        words = "they contradict each other" if one.conflict else "they agree"
        identified = with_interval(one.identified, one.identified - 2 * one.identified_sigma,
                                   one.identified + 2 * one.identified_sigma)[0]  # fmt: skip
        lines.append(
            paragraph(
                f"Scale or CAD: {one.mass:g} ± {one.sigma:.2g} kg. Identified without it: {identified} ± "
                f"{one.identified_sigma:.2g} kg, {abs(one.z):.1f} sigma apart: {words}."
            )
        )
    return joined(*lines)


def reasons(verdict: Verdict) -> Html:
    """Why the verdict is what it is."""
    if not verdict.reasons:
        return paragraph("No check found anything against the numbers.")
    return bullets([f"{reason[:1].upper()}{reason[1:]}." for reason in verdict.reasons])


def improvements(answer: PayloadAnswer, predictions: Sequence[TorquePrediction]) -> Html:
    """What would make the answer better or better known."""
    best, scales, lines = answer.recommended, scales_in_words(answer.problem.robot), list[str]()
    if not best.weighings:
        lines.append(f"Weigh the payload and give --mass and --mass-sigma: the weighing checks the {scales}.")
    if best.gains is None:
        lines.append(
            f"Say how well the {scales} are known (--gain-sigma 2%): no residual shows their errors, and the "
            "intervals leave them out."
        )
    if not any(one.held_out for one in predictions):
        lines.append("Keep one recording without payload out of identification (--validate).")
    if best.free.without_robust:
        lines.append(f"Record longer: intervals rest on white noise, because {best.free.without_robust}.")
    elif best.free.estimate.robust is not None and best.free.estimate.robust.warning:
        lines.append(f"{best.free.estimate.robust.warning[:1].upper()}{best.free.estimate.robust.warning[1:]}.")
    lines += [f"Method {method} could not be used: {reason}." for method, reason in answer.left_out.items()]
    return bullets(lines) or paragraph("Nothing stands out.")


def _row(row: Row, words: str, span: int) -> Html:
    cells = [tag("th", row[0], scope="row"), tag("td", row[1], class_="number"), tag("td", row[2], class_="number")]
    if words:
        cells.append(tag("td", words, class_="words", rowspan=str(span)))
    return tag("tr", *cells)


def _mass(best: ConstrainedPayload) -> list[Row]:
    value, interval = with_interval(best.mass, *best.intervals.parameters[9])
    return [("mass", f"{value} kg", interval)]


def _com(best: ConstrainedPayload) -> list[Row]:
    values, bounds = 1e3 * best.body.com, 1e3 * best.intervals.com
    return _rows(["centre of mass x", "y", "z"], values, bounds, "mm")


def _inertia(best: ConstrainedPayload) -> list[Row]:
    values = np.diag(best.body.inertia_com)
    bounds = best.intervals.inertia_com[range(3), range(3)]
    return _rows(["inertia XX", "YY", "ZZ"], values, bounds, "kg m²")


def _rows(names: Sequence[str], values: Array, bounds: Array, unit: str) -> list[Row]:
    texts = [with_interval(float(value), *pair) for value, pair in zip(values, bounds, strict=True)]
    return [(name, f"{value} {unit}", interval) for name, (value, interval) in zip(names, texts, strict=True)]
