"""Measured and predicted torques of every joint."""

from collections.abc import Sequence

from ....estimation.answers.system import TorquePrediction
from ....estimation.fit.estimate import Fit
from ...numbers import percent
from ..blocks import Block, Drawing, Section, Table, Text, columns
from ..figures.torques import prediction_figure, words_of, worst_joint_figure


def residual_text(fit: Fit) -> str:
    """Relative residual in percent, of all joints and of each."""
    joints = " ".join(f"{100.0 * value:.1f}" for value in fit.relative_per_joint)
    return f"{100.0 * fit.relative:.2f} % (joints {joints} %)"


def worst_joint(predictions: Sequence[TorquePrediction]) -> Drawing | None:
    """The figure of the first page: held out before fitted, with payload before without."""
    shown = min(predictions, key=lambda each: (not each.held_out, not each.loaded), default=None)
    return worst_joint_figure(shown) if shown else None


def torques_section(predictions: Sequence[TorquePrediction], others: int = 0) -> Section:
    """Residuals of every recording as a table, and a figure of each.

    Args:
        predictions: recordings to draw.
        others: number of recordings that were used and are not drawn.
    """
    joints = range(1, len(predictions[0].t) + 1) if predictions else ()
    rows = [
        (words_of(prediction), *(percent(float(share)) for share in prediction.relative_per_joint))
        for prediction in predictions
    ]
    words = (
        "Residual: measured less predicted torque. A residual that repeats or lasts, seen in the autocorrelation, "
        "is an error of the model; white noise would stay within the dashed lines."
    )
    if not any(prediction.held_out for prediction in predictions):
        words += (
            " No recording was held out (--validate): these are the data that were fitted, and look better than "
            "others would."
        )
    if others:
        words += f" {others} more recordings were used and are not drawn."
    headings = columns(("norm of the residual over norm of the torque",), [f"joint {j}" for j in joints])
    drawings = [prediction_figure(each, f"torques_{k}") for k, each in enumerate(predictions, 1)]
    blocks: list[Block] = [Text(words), Table("Relative residual", headings, rows), *drawings]
    return Section("torques", "Measured and predicted torques", blocks)
