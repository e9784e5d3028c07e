"""The methods side by side."""

from ...estimation import PayloadAnswer
from ..constrained import recommended_table
from ..figures import methods_figure
from ..tables import payload_table, sigma_notes
from .markup import bullets, joined, paragraph, printed_table
from .page import Section


def methods_section(answer: PayloadAnswer) -> Section:
    """Constrained and free estimates of every method."""
    agreement = (
        "Methods 3 and 4 on the same trajectories use the same equations: that they agree confirms nothing. "
        "Methods 1 and 2 go through the robot's own parameters."
    )
    left_out = [f"Method {method} left out: {reason}" for method, reason in answer.left_out.items()]
    after = joined(
        printed_table(recommended_table(answer)),
        printed_table(payload_table(answer.estimates)),
        bullets([*sigma_notes(answer.estimates), *left_out]),
    )
    return Section("methods", "The methods side by side", paragraph(agreement), (methods_figure(answer),), after)
