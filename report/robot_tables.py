"""The robot's essential and constrained parameters for a terminal."""

from collections.abc import Sequence

from rich import box
from rich.table import Table

from ..estimation import PayloadAnswer
from ..estimation.fit import Elimination
from ..estimation.possible import PossibleRobot, PriorRobot
from ..model import INERTIAL
from ..model.names import parameter_kind

_MOST_NAMED = 8


def standard_table(result: PriorRobot, title: str) -> Table:
    """Standard parameters of the robot nearest to the prior, and who decides each."""
    title = f"Standard parameters of {title}, SI units"
    table = Table("", title=title, title_justify="left", box=box.SIMPLE_HEAD, padding=0)
    for heading in ("value", "prior", "data"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("decided by", overflow="fold")
    priors = {
        f"{kind}{link}": value
        for link, body in enumerate(result.prior.bodies, start=1)
        for kind, value in body.named().items()
    }
    for name, value in result.parameters.items():
        origin = result.origins[name]
        table.add_row(
            name,
            f"{value:.4g}",
            f"{priors[name] + 0.0:.4g}" if name in priors else "",
            f"{100.0 * origin.share:.0f} %",
            origin.decided_by(),
            end_section=parameter_kind(name) == INERTIAL[-1],
        )
    return table


def combined_notes(answer: PayloadAnswer, warnings: Sequence[str]) -> list[str]:
    """Lines on the essential parameters of robot and payload together, where method 4 was used."""
    if answer.elimination is None:
        return []
    return elimination_notes(answer.elimination, warnings, "Method 4: ")


def elimination_notes(elimination: Elimination, warnings: Sequence[str], what: str = "") -> list[str]:
    """Lines on essential parameters."""
    line = (
        f"{what}{len(elimination.essential)} of {len(elimination.path.order)} parameters essential "
        f"({elimination.rule.description}): error's sigma {elimination.sigma_ratio:.4f} times, largest relative "
        f"sigma {100.0 * elimination.largest_relative_sigma:.3g} %."
    )
    return [line, *(f"  - {warning}" for warning in warnings)]


def constrained_notes(result: PossibleRobot) -> list[str]:
    """Lines on the robot that can exist."""
    p_value = f"p {result.p_value:.2g} for {len(result.free.names)} parameters"
    lines = [
        f"Constrained: the nearest robot that can exist; chi2 rises by {result.chi2_rise:.3g} ({p_value}); "
        f"smallest eigenvalue of a link {min(result.min_eigenvalues):.2g}; {result.status}."
    ]
    if isinstance(result, PriorRobot):
        lines.append(
            f"Prior: {result.prior.source}; chi2 {result.chi2_rise - result.nearest.chi2_rise:.3g} above the "
            f"constrained minimum of {result.nearest.chi2_rise:.3g}. What the prior decides is not identified."
        )
    if result.active:
        named = [f"{active.description} ({active.multiplier:.2g})" for active in result.active[:_MOST_NAMED]]
        more = len(result.active) - len(named)
        lines.append(f"Held back by (multiplier): {', '.join(named)}{f' and {more} more' if more else ''}.")
    alone = [text for text in result.unidentifiable if " " not in text]
    lines.append(
        f"No motion shows {', '.join(alone)}{' and ' * bool(alone)}{len(result.unidentifiable) - len(alone)} "
        "combinations of standard parameters (the JSON lists them)."
    )
    return lines
