"""Whether the payload can exist, and what it costs to demand that."""

from ...estimation import PayloadAnswer
from ...estimation.payload import ConstrainedPayload
from .markup import joined, paragraph, table
from .page import Section


def consistency_section(answer: PayloadAnswer) -> Section:
    """Smallest eigenvalue of the pseudo-inertia by every method, free and constrained, and the price."""
    rows = [_row(payload) for payload in answer.constrained]
    names = ("", "free can exist", "smallest eigenvalue, free", "constrained", "chi2 rises by", "p", "constraints")
    words = (
        "A body can exist if the 4 x 4 pseudo-inertia has no negative eigenvalue; positive moments alone are not "
        "enough. A small p says that the data contradict the constraints."
    )
    held = "; ".join(constraint.description for constraint in answer.recommended.result.constraints)
    content = joined(
        paragraph(words), table("Physical consistency", names, rows), paragraph(f"Constraints: {held}.")
    )
    return Section("consistency", "Physical consistency", content)


def _row(payload: ConstrainedPayload) -> tuple[str, ...]:
    free = payload.free.body
    return (
        f"method {payload.method}",
        "yes" if free.physically_consistent else "no",
        f"{free.min_pseudo_inertia_eigenvalue:.2g}",
        f"{payload.result.min_pseudo_inertia_eigenvalue:.2g}",
        f"{payload.result.chi2_rise:.3g}",
        f"{payload.p_value:.2g}",
        "contradict the data" if payload.conflict else "hold",
    )
