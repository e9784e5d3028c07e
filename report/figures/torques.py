"""Measured and predicted torques, residuals and their autocorrelation."""

import numpy as np

from ...common.arrays import Array
from ...estimation.answers import TorquePrediction
from ..blocks import Drawing
from .canvas import BLUE, GREY, ORANGE, Axes, Figure, legend, panels, plain

_GAP = 2.5  # steps: a longer one is drawn as a gap
_CURVES = ((BLUE, "--", 1.3), (ORANGE, ":", 1.3), ("black", "-.", 1.0))


def worst_joint_figure(prediction: TorquePrediction) -> Drawing:
    """The joint that the model explains worst: torques above, residual below on the same scale."""
    j = prediction.worst
    share = prediction.relative_per_joint[j]
    caption = (
        f"Joint {j + 1}, the one that the model explains worst: residual {100.0 * share:.1f} % of its torque, on "
        f"{words_of(prediction)}. Pauses and slow rows are left out."
    )
    return Drawing("worst_joint", caption, caption, lambda: _one_joint(prediction, j))


def _one_joint(prediction: TorquePrediction, j: int) -> Figure:
    figure, axes = panels((5.8, 3.2), 2, edges=(0.8, 0.1, 0.3, 0.5), sharex=True, height_ratios=(2, 1))
    above, below = axes[:, 0]
    _torques(above, prediction, j)
    above.set_ylabel(f"joint {j + 1} [N·m]")
    legend(figure, [above], "upper center", fontsize=9)
    _residual(below, prediction, j)
    below.set_ylabel("residual")
    below.set_xlabel("time [s]")
    return figure


def prediction_figure(prediction: TorquePrediction, name: str) -> Drawing:
    """Torques, residual and its autocorrelation of every joint, a row each; ``name``: of the drawing."""
    joints = ", ".join(f"{100.0 * share:.1f}" for share in prediction.relative_per_joint)
    caption = (
        f"Every joint on {words_of(prediction)}: torque, residual, and the residual's autocorrelation; the dashed "
        "lines hold 95 % of it if the noise were white."
    )
    text = f"{caption} Relative residuals of the joints in percent: {joints}."
    return Drawing(name, caption, text, lambda: _every_joint(prediction))


def _every_joint(prediction: TorquePrediction) -> Figure:
    n = len(prediction.t)
    edges = (0.8, 0.1, 0.6, 0.5)
    figure, axes = panels((10.0, 1.75 * n + 0.6), n, 3, edges, sharex="col", width_ratios=(5, 3, 2))
    for j, (left, middle, right) in enumerate(axes):
        _torques(left, prediction, j)
        left.set_ylabel(f"joint {j + 1} [N·m]")
        _residual(middle, prediction, j)
        _correlation(right, prediction, j)
        middle.annotate(
            f"{100.0 * prediction.relative_per_joint[j]:.1f} %",
            (0.99, 0.97),
            xycoords="axes fraction",
            ha="right",
            va="top",
            fontsize=9,
        )
    for axis, title in zip(axes[0], ("torque", "residual", "its autocorrelation"), strict=True):
        axis.set_title(title, fontsize=10)
    for axis, label in zip(axes[-1], ("time [s]", "time [s]", "lag [s]"), strict=True):
        axis.set_xlabel(label)
    legend(figure, [axes[0][0]], "upper center")
    return figure


def words_of(prediction: TorquePrediction) -> str:
    """Which recording it is, and whether it was used."""
    load = "with payload" if prediction.loaded else "without payload"
    used = "held out of identification" if prediction.held_out else "the data that were fitted, not held out"
    return f"{prediction.source} {load}" * (load not in prediction.source) + (
        prediction.source * (load in prediction.source) + f" ({used})"
    )


def _torques(axis: Axes, prediction: TorquePrediction, j: int) -> None:
    axis.plot(*_parted(prediction, j, prediction.measured[j]), color=GREY, linewidth=2.6, label="measured")
    for k, curve in enumerate(prediction.curves):
        color, style, width = _CURVES[k % len(_CURVES)]
        line = _parted(prediction, j, curve.torque[j])
        axis.plot(*line, color=color, linestyle=style, linewidth=width, label=curve.label)
    axis.locator_params(axis="y", nbins=5)
    plain(axis)


def _residual(axis: Axes, prediction: TorquePrediction, j: int) -> None:
    residual = prediction.residual(j)
    axis.axhline(0.0, color="0.4", linewidth=0.6)
    axis.plot(*_parted(prediction, j, residual), color="black", linewidth=0.8)
    largest = 1.15 * float(np.abs(residual).max(initial=0.0))
    if largest > 0.0:
        axis.set_ylim(-largest, largest)
    axis.locator_params(axis="y", nbins=5)
    plain(axis)


def _correlation(axis: Axes, prediction: TorquePrediction, j: int) -> None:
    lags, rho = prediction.autocorrelation(j)
    axis.plot(lags, rho, color="black", linewidth=1.0)
    axis.axhline(0.0, color="0.4", linewidth=0.6)
    band = 1.96 / np.sqrt(max(len(prediction.t[j]), 1))
    for level in (-band, band):
        axis.axhline(level, color="0.4", linestyle="--", linewidth=0.8)
    axis.set_ylim(min(-0.5, 1.1 * float(rho.min())), 1.05)
    axis.locator_params(nbins=4)
    plain(axis)


def _parted(prediction: TorquePrediction, j: int, values: Array) -> tuple[Array, Array]:
    """A joint's curve, of long ones every so many points, with gaps where rows are missing."""
    every = prediction.thinning(j)
    t, values = prediction.t[j][::every], values[::every]
    breaks = np.flatnonzero(np.diff(t) > _GAP * every * prediction.step) + 1
    return np.insert(t, breaks, np.nan), np.insert(values, breaks, np.nan)
