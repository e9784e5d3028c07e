"""The recommended payload: values that can be used, 95 % intervals, and what the constraints cost."""

from collections.abc import Sequence

import numpy as np

from ....common.arrays import Array
from ....estimation import PayloadAnswer
from ....estimation.payload.constrained import ConstrainedPayload
from ....model import INERTIAL
from ...numbers import interval_digits, or_dash, with_interval
from ..blocks import Block, Notes, Section, Table, Text, columns
from .verdict import gain_error_notes

UNITS = dict.fromkeys(INERTIAL[:6], "kg m²") | dict.fromkeys(INERTIAL[6:9], "kg m") | {"M": "kg"}
ENDS = ("M", "com z", "ZZ at com")
"""Rows after which the ten, the centre of mass and the inertia there end."""
PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""Places of the inertia matrix's six entries."""
_MOMENTS = ("smallest", "middle", "largest")


def recommended_table(answer: PayloadAnswer) -> Table:
    """One row a number: value, 95 % interval, and what the other methods say."""
    best = answer.recommended
    others = [payload for payload in answer.constrained if payload is not best]
    intervals = _numbers(best.intervals.parameters, best.intervals.com, best.intervals.inertia_com)
    bounds = np.vstack([intervals, best.intervals.principal_moments])
    rows = []
    for k, ((name, unit), (low, high)) in enumerate(zip(_names(), bounds, strict=True)):
        digits = interval_digits(high - low)
        numbers = (_values(best)[k], low, high, *(_values(estimate)[k] for estimate in others))
        # Zero has no sign.
        rows.append((name, unit, *(or_dash(np.round(number, digits) + 0.0, f".{digits}f") for number in numbers)))
    headings = [f"method {best.method}", "95 %", "interval", *(f"method {estimate.method}" for estimate in others)]
    title = f"Recommended payload (method {best.method}) in {best.frame}"
    return Table(title, columns(("", "unit"), headings), rows, ENDS)


def recommended_notes(answer: PayloadAnswer) -> list[str]:
    """Lines below the recommended table: what the intervals hold, what the constraints cost, who disagrees."""
    best = answer.recommended
    lines = [_interval_note(best), *gain_error_notes(answer.problem.robot, best.gains), _cost_note(best)]
    lines += _conflict_notes(answer.constrained)
    for weighing in best.weighings:
        lines.append(
            f"Weighed {weighing.mass:g} ± {weighing.sigma:.2g} kg; method {best.method} alone identifies "
            f"{weighing.identified:.4g} ± {weighing.identified_sigma:.2g} kg: {abs(weighing.z):.1f} sigma apart"
            f"{', which contradict each other' if weighing.conflict else ''}."
        )
    return lines


def centre_section(answer: PayloadAnswer) -> Section:
    """Mass, centre of mass, inertia there and principal moments, with 95 % intervals."""
    best, intervals = answer.recommended, answer.recommended.intervals
    numbers = [("mass", "kg", best.mass, intervals.parameters[9])]
    numbers += [(f"centre of mass {'xyz'[k]}", "m", best.body.com[k], intervals.com[k]) for k in range(3)]
    numbers += [
        (f"inertia {'XYZ'[i]}{'XYZ'[j]}", "kg m²", best.body.inertia_com[i, j], intervals.inertia_com[i, j])
        for i, j in sorted(PAIRS, key=lambda pair: pair[0] != pair[1])
    ]
    numbers += [
        (f"{which} principal moment", "kg m²", best.principal_moments[k], intervals.principal_moments[k])
        for k, which in enumerate(_MOMENTS)
    ]
    rows = [
        (name, *with_interval(float(value), float(low), float(high)), unit)
        for name, unit, value, (low, high) in numbers
    ]
    title = f"Recommended payload (method {best.method}) in {best.frame}; inertia at the centre of mass"
    blocks: list[Block] = [
        Table(title, columns(("",), ("value", "95 % interval", "unit")), rows),
        Text("XY is the entry of the inertia matrix: minus the integral of x y dm."),
        Notes(recommended_notes(answer)),
    ]
    return Section("payload", "Payload at the centre of mass", blocks)


def consistency_section(answer: PayloadAnswer) -> Section:
    """Smallest eigenvalue of the pseudo-inertia by every method, free and constrained, and the price."""
    headings = ("free can exist", "smallest eigenvalue, free", "constrained", "chi2 rises by", "p", "constraints")
    rows = [
        (
            f"method {payload.method}",
            "yes" if payload.free.body.physically_consistent else "no",
            f"{payload.free.body.min_pseudo_inertia_eigenvalue:.2g}",
            f"{payload.result.min_pseudo_inertia_eigenvalue:.2g}",
            f"{payload.result.chi2_rise:.3g}",
            f"{payload.p_value:.2g}",
            "contradict the data" if payload.conflict else "hold",
        )
        for payload in answer.constrained
    ]
    words = (
        "A body can exist if the 4 x 4 pseudo-inertia has no negative eigenvalue; positive moments alone are not "
        "enough. A small p says that the data contradict the constraints."
    )
    constraints = "; ".join(constraint.description for constraint in answer.recommended.result.constraints)
    table = Table("Physical consistency", columns(("",), headings), rows)
    return Section(
        "consistency", "Physical consistency", [Text(words), table, Text(f"Constraints: {constraints}.")]
    )


def agreement(answer: PayloadAnswer) -> list[Text]:
    """The identified mass beside the scale or CAD."""
    weighings = answer.recommended.weighings
    if not weighings:
        return [Text("No mass from a scale or from CAD was given to compare with.", "note")]
    lines = []
    for weighing in weighings:
        mass, sigma = weighing.identified, weighing.identified_sigma
        words = "they contradict each other" if weighing.conflict else "they agree"
        lines.append(
            f"Scale or CAD: {weighing.mass:g} ± {weighing.sigma:.2g} kg. Identified without it: "
            f"{with_interval(mass, mass - 2 * sigma, mass + 2 * sigma)[0]} ± {sigma:.2g} kg, "
            f"{abs(weighing.z):.1f} sigma apart: {words}."
        )
    return [Text(line) for line in lines]


def _interval_note(payload: ConstrainedPayload) -> str:
    robust = payload.free.estimate.robust
    if np.isnan(payload.intervals.parameters).any():
        return "No intervals: constraints contradict the data, so that none would hold."
    if robust is None:
        return (
            "95 % intervals by the formula (17)-(19) alone, for white torque noise: on real robots they are too "
            "short by a factor of about 1.5 to 4."
        )
    if robust.by_memory:
        return f"95 % intervals over bodies that hold all constraints: {robust.warning}."
    return f"95 % intervals by the block jackknife ({robust.blocks} blocks), over bodies that hold all constraints."


def _cost_note(payload: ConstrainedPayload) -> str:
    result = payload.result
    if not result.active:
        return "No constraint is active: the free estimate can exist as it is."
    bounds = "; ".join(active.description for active in result.active)
    return f"Active: {bounds}. Their price: chi2 rises by {result.chi2_rise:.3g} (p {payload.p_value:.2g})."


def _conflict_notes(payloads: Sequence[ConstrainedPayload]) -> list[str]:
    """One line for each constraint that any method contradicts."""
    against: dict[str, dict[int, float]] = {}
    for payload in payloads:
        for conflict in payload.conflicts:
            against.setdefault(conflict.constraint.description, {})[payload.method] = conflict.p_value
    return [
        f"Contradicted by method {', '.join(map(str, methods))}: {text} (p {max(methods.values()):.1g})."
        for text, methods in against.items()
    ]


def _names() -> list[tuple[str, str]]:
    ten = [(kind, UNITS[kind]) for kind in INERTIAL]
    com = [(f"com {axis}", "m") for axis in "xyz"]
    inertia = [(f"{'XYZ'[i]}{'XYZ'[j]} at com", "kg m²") for i, j in PAIRS]
    return [*ten, *com, *inertia, *((f"{which} moment", "kg m²") for which in _MOMENTS)]


def _values(payload: ConstrainedPayload) -> Array:
    body = payload.body
    return np.concatenate([_numbers(body.vector, body.com, body.inertia_com), payload.principal_moments])


def _numbers(ten: Array, com: Array, inertia: Array) -> Array:
    return np.concatenate([ten, com, [inertia[pair] for pair in PAIRS]])
