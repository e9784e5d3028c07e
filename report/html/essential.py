"""Essential parameters and the path that leads to them."""

from collections.abc import Mapping, Sequence

from ...estimation.fit import Elimination
from ..figures import essential_drawing
from ..robot_tables import elimination_notes
from .markup import bullets, joined, paragraph
from .page import Section


def essential_section(
    elimination: Elimination | None, warnings: Sequence[str], title: str, labels: Mapping[str, str]
) -> Section:
    """The path as a figure, the parameters by name, and what speaks against them.

    Args:
        elimination: None where nothing was eliminated.
        warnings: what speaks against the essential parameters.
        title: above the figure.
        labels: name of a parameter -> how it is called.
    """
    heading = "Essential parameters"
    if elimination is None:
        words = "Parameters are eliminated for method 4 only, robot and payload together; it was not used here."
        return Section("essential", heading, paragraph(words))
    line, *against = elimination_notes(elimination, warnings)
    kept = ", ".join(labels.get(name, name) for name in elimination.essential)
    content = joined(
        paragraph(line),
        paragraph(f"Essential: {kept}."),
        bullets([one.strip().removeprefix("- ") for one in against]),
    )
    return Section("essential", heading, content, (essential_drawing(elimination, title, labels),))
