"""The recommended payload as a table: values that can be used, 95 % intervals, the other methods beside them."""

from collections.abc import Sequence

import numpy as np
from rich.table import Table

from ..common.arrays import Array
from ..estimation import PayloadAnswer
from ..estimation.payload import ConstrainedPayload
from ..model import INERTIAL
from .gains import gain_error_notes
from .numbers import interval_digits
from .tables import UNITS, empty_table

_PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
_MOMENTS = ("smallest", "middle", "largest")


def recommended_table(answer: PayloadAnswer) -> Table:
    """One row a number: value, 95 % interval, and what the other methods say."""
    best = answer.recommended
    others = [payload for payload in answer.constrained if payload is not best]
    title = f"Recommended payload (method {best.method}) in {best.frame}"
    headings = [f"method {best.method}", "95 %", "interval", *(f"method {other.method}" for other in others)]
    table = empty_table(title, ("", "unit"), headings)
    intervals = _rows(best.intervals.parameters, best.intervals.com, best.intervals.inertia_com)
    rows = zip(_names(), _values(best), np.vstack([intervals, best.intervals.principal_moments]), strict=True)
    apart = list(zip(*(_values(other) for other in others), strict=True)) or [()] * len(_names())
    for ((name, unit), value, (low, high)), beside in zip(rows, apart, strict=True):
        digits = interval_digits(high - low)
        cells = [
            f"{round(number, digits) + 0.0:.{digits}f}" if np.isfinite(number) else "-"
            for number in (value, low, high, *beside)
        ]
        table.add_row(name, unit, *cells, end_section=name in ("M", "com z", "ZZ at com"))
    return table


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


def _interval_note(payload: ConstrainedPayload) -> str:
    robust = payload.free.estimate.robust
    if np.isnan(payload.intervals.parameters).any():
        return "No intervals: constraints contradict the data, so that none would hold."
    if robust is None:
        return (
            "95 % intervals by the formula (17)-(19) alone, for white torque noise: on real robots they are too "
            "short by a factor of about 1.5 to 4."
        )
    return f"95 % intervals by the block jackknife ({robust.blocks} blocks), over bodies that hold all constraints."


def _cost_note(payload: ConstrainedPayload) -> str:
    result = payload.result
    if not result.active:
        return "No constraint is active: the free estimate can exist as it is."
    held = "; ".join(active.description for active in result.active)
    return f"Active: {held}. Their price: chi2 rises by {result.chi2_rise:.3g} (p {payload.p_value:.2g})."


def _conflict_notes(payloads: Sequence[ConstrainedPayload]) -> list[str]:
    """One line for each constraint that any method contradicts."""
    found = [(payload.method, one) for payload in payloads for one in payload.conflicts]
    lines = []
    for text in dict.fromkeys(one.constraint.description for _, one in found):
        own = [(method, one.p_value) for method, one in found if one.constraint.description == text]
        methods = ", ".join(str(method) for method, _ in own)
        lines.append(f"Contradicted by method {methods}: {text} (p {max(p for _, p in own):.1g}).")
    return lines


def _names() -> list[tuple[str, str]]:
    ten = [(kind, UNITS[kind]) for kind in INERTIAL]
    com = [(f"com {axis}", "m") for axis in "xyz"]
    inertia = [(f"{'XYZ'[i]}{'XYZ'[j]} at com", "kg m²") for i, j in _PAIRS]
    return [*ten, *com, *inertia, *((f"{which} moment", "kg m²") for which in _MOMENTS)]


def _values(payload: ConstrainedPayload) -> Array:
    body = payload.body
    return np.concatenate([_rows(body.vector, body.com, body.inertia_com), payload.principal_moments])


def _rows(ten: Array, com: Array, inertia: Array) -> Array:
    return np.concatenate([ten, com, [inertia[pair] for pair in _PAIRS]])
