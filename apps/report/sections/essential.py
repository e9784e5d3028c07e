"""Essential parameters and the path that leads to them."""

from collections.abc import Mapping, Sequence

from ....estimation.fit.essential import Elimination
from ..blocks import Block, Notes, Section, Text
from ..figures.essential import essential_figure


def elimination_notes(elimination: Elimination | None, warnings: Sequence[str], prefix: str = "") -> list[str]:
    """Lines on essential parameters; none where nothing was eliminated."""
    if elimination is None:
        return []
    line = (
        f"{prefix}{len(elimination.essential)} of {len(elimination.path.order)} parameters essential "
        f"({elimination.rule.description}): error's sigma {elimination.sigma_ratio:.4f} times, largest relative "
        f"sigma {100.0 * elimination.largest_relative_sigma:.3g} %."
    )
    return [line, *(f"  - {warning}" for warning in warnings)]


def essential_section(
    elimination: Elimination | None, warnings: Sequence[str], title: str, labels: Mapping[str, str]
) -> Section:
    """The path as a figure, the parameters by name, and what speaks against them.

    Args:
        elimination: None where nothing was eliminated.
        warnings: what speaks against the essential parameters.
        labels: name of a parameter -> how it is called.
    """
    heading = "Essential parameters"
    if elimination is None:
        words = "Parameters are eliminated for method 4 only, robot and payload together; it was not used here."
        return Section("essential", heading, [Text(words)])
    names = ", ".join(labels.get(name, name) for name in elimination.essential)
    blocks: list[Block] = [
        Text(elimination_notes(elimination, ())[0]),
        Text(f"Essential: {names}."),
        Notes(warnings),
        essential_figure(elimination, title, labels),
    ]
    return Section("essential", heading, blocks)
