"""The essential-parameter path with its words."""

from collections.abc import Mapping

from ...estimation.fit import Elimination
from ..essential_plot import essential_figure
from .canvas import Drawing


def essential_drawing(elimination: Elimination, title: str, labels: Mapping[str, str] | None = None) -> Drawing:
    """Error and largest relative sigma during elimination; arguments as ``essential_figure``."""
    kept, all_ = len(elimination.essential), len(elimination.path.order)
    text = (
        f"{kept} of {all_} parameters are essential: {elimination.rule.description}. With them the error's "
        f"standard deviation is {elimination.sigma_ratio:.4f} times that with all; the largest relative standard "
        f"deviation is {100.0 * elimination.largest_relative_sigma:.3g} %."
    )
    caption = (
        "Parameters are eliminated from left to right, each time the one with the largest relative standard "
        "deviation. Filled marks are steps that were taken."
    )
    return Drawing("essential_path", essential_figure(elimination, title, labels), caption, text)
