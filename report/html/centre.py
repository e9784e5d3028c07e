"""The payload at its centre of mass, in the axes of its frame."""

from ...estimation import PayloadAnswer
from ..constrained import recommended_notes
from ..numbers import with_interval
from .markup import bullets, joined, paragraph, table
from .page import Section

_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
_MOMENTS = ("smallest", "middle", "largest")


def centre_section(answer: PayloadAnswer) -> Section:
    """Mass, centre of mass, inertia there and principal moments, with 95 % intervals."""
    best, intervals = answer.recommended, answer.recommended.intervals
    found = [("mass", "kg", best.mass, intervals.parameters[9])]
    found += [(f"centre of mass {'xyz'[k]}", "m", best.body.com[k], intervals.com[k]) for k in range(3)]
    found += [
        (f"inertia {'XYZ'[i]}{'XYZ'[j]}", "kg m²", best.body.inertia_com[i, j], intervals.inertia_com[i, j])
        for i, j in _PAIRS
    ]
    found += [
        (f"{_MOMENTS[k]} principal moment", "kg m²", best.principal_moments[k], intervals.principal_moments[k])
        for k in range(3)
    ]
    rows = []
    for name, unit, value, (low, high) in found:
        told, interval = with_interval(float(value), float(low), float(high))
        rows.append((name, told, interval, unit))
    title = f"Recommended payload (method {best.method}) in {best.frame}; inertia at the centre of mass"
    content = joined(
        table(title, ("", "value", "95 % interval", "unit"), rows),
        paragraph("XY is the entry of the inertia matrix: minus the integral of x y dm."),
        bullets(recommended_notes(answer)),
    )
    return Section("payload", "Payload at the centre of mass", content)
