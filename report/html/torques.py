"""Measured and predicted torques of every joint."""

from collections.abc import Sequence

from ...estimation.payload import TorquePrediction
from ..figures import prediction_figure
from ..figures.torques import words_of
from ..numbers import percent
from .markup import joined, paragraph, table
from .page import Section


def shown(predictions: Sequence[TorquePrediction]) -> TorquePrediction | None:
    """The one for the first page: held out before fitted, with payload before without."""
    return min(predictions, key=lambda one: (not one.held_out, not one.loaded), default=None)


def torques_section(predictions: Sequence[TorquePrediction], others: int = 0) -> Section:
    """Residuals of every recording as a table, and a figure of each.

    Args:
        predictions: recordings to draw.
        others: number of recordings that were used and are not drawn.
    """
    joints = range(1, len(predictions[0].t) + 1) if predictions else ()
    rows = [(words_of(one), *(percent(float(share)) for share in one.relative_per_joint)) for one in predictions]
    words = (
        "Residual: measured less predicted torque. A residual that repeats or lasts, seen in the autocorrelation, "
        "is an error of the model; white noise would stay within the dashed lines."
    )
    if not any(one.held_out for one in predictions):
        words += (
            " No recording was held out (--validate): these are the data that were fitted, and look better than "
            "others would."
        )
    if others:
        words += f" {others} more recordings were used and are not drawn."
    names = ("norm of the residual over norm of the torque", *(f"joint {j}" for j in joints))
    content = joined(paragraph(words), table("Relative residual", names, rows))
    drawings = tuple(prediction_figure(one, f"torques_{k}") for k, one in enumerate(predictions, 1))
    return Section("torques", "Measured and predicted torques", content, drawings)
