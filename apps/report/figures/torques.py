"""Measured and predicted torques, residuals and their autocorrelation."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ....common.arrays import Array
from ....estimation.answers.system import TorquePrediction
from ..blocks import Drawing
from .canvas import BLUE, GREY, ORANGE, Axes, Figure, bands, legend, panels

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
    _torques(above, prediction, [j])
    above.set_ylabel(f"joint {j + 1} [N·m]")
    legend(figure, [above], "upper center", fontsize=9)
    _residuals(below, prediction, [j])
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
    figure, ((left, middle, right),) = panels(
        (10.0, 1.75 * n + 0.6), 1, 3, (0.8, 0.1, 0.6, 0.5), width_ratios=(5, 3, 2)
    )
    _torques(left, prediction, range(n))
    _residuals(middle, prediction, range(n))
    _correlations(right, prediction, range(n))
    for j in range(n):
        middle_of_row = (n - j - 0.5) / n
        left.text(
            -0.14,
            middle_of_row,
            f"joint {j + 1} [N·m]",
            rotation=90,
            va="center",
            ha="center",
            transform=left.transAxes,
        )
        share = f"{100.0 * prediction.relative_per_joint[j]:.1f} %"
        middle.text(0.99, (n - j - 0.03) / n, share, ha="right", va="top", fontsize=9, transform=middle.transAxes)
    titles, labels = ("torque", "residual", "its autocorrelation"), ("time [s]", "time [s]", "lag [s]")
    for axis, title, label in zip((left, middle, right), titles, labels, strict=True):
        axis.set_title(title, fontsize=10)
        axis.set_xlabel(label)
    legend(figure, [left], "upper center")
    return figure


def words_of(prediction: TorquePrediction) -> str:
    """Which recording it is, and whether it was used."""
    load = "with payload" if prediction.loaded else "without payload"
    used = "held out of identification" if prediction.held_out else "the data that were fitted, not held out"
    return f"{prediction.source} {load}" * (load not in prediction.source) + (
        prediction.source * (load in prediction.source) + f" ({used})"
    )


def _torques(axis: Axes, prediction: TorquePrediction, joints: Sequence[int]) -> None:
    """A row for each joint."""
    curves: list[tuple[Sequence[Array], str, dict[str, Any]]]
    curves = [(prediction.measured, "measured", {"color": GREY, "linewidth": 2.6})]
    for k, (name, predicted) in enumerate(prediction.curves.items()):
        looks: dict[str, Any] = dict(
            zip(("color", "linestyle", "linewidth"), _CURVES[k % len(_CURVES)], strict=True)
        )
        curves.append((predicted, name, looks))
    rows = bands(axis, [_range([torque[j] for torque, _, _ in curves]) for j in joints])
    for torque, label, looks in curves:
        for first, (j, row) in enumerate(zip(joints, rows, strict=True)):
            t, values = _parted(prediction, j, torque[j])
            axis.plot(t, row(values), label="" if first else label, **looks)


def _residuals(axis: Axes, prediction: TorquePrediction, joints: Sequence[int]) -> None:
    residuals = [prediction.residual(j) for j in joints]
    largest = [1.15 * float(np.abs(residual).max(initial=0.0)) or 1.0 for residual in residuals]
    for j, residual, row in zip(joints, residuals, bands(axis, [(-x, x) for x in largest]), strict=True):
        t, values = _parted(prediction, j, residual)
        axis.axhline(float(row(0.0)), color="0.4", linewidth=0.6)
        axis.plot(t, row(values), color="black", linewidth=0.8)


def _correlations(axis: Axes, prediction: TorquePrediction, joints: Sequence[int]) -> None:
    correlations = [prediction.autocorrelation(j) for j in joints]
    rows = bands(axis, [(min(-0.5, 1.1 * float(rho.min())), 1.05) for _, rho in correlations])
    for j, (lags, rho), row in zip(joints, correlations, rows, strict=True):
        axis.plot(lags, row(rho), color="black", linewidth=1.0)
        axis.axhline(float(row(0.0)), color="0.4", linewidth=0.6)
        band = 1.96 / np.sqrt(max(len(prediction.t[j]), 1))
        for level in (-band, band):
            axis.axhline(float(row(level)), color="0.4", linestyle="--", linewidth=0.8)


def _range(curves: Sequence[Array]) -> tuple[float, float]:
    """Lowest and highest value of some curves, with a little room."""
    values = np.concatenate(curves)
    values = values[np.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)
    room = 0.05 * (high - low) or 1.0
    return low - room, high + room


def _parted(prediction: TorquePrediction, j: int, values: Array) -> tuple[Array, Array]:
    """A joint's curve, of long ones every so many points, with gaps where rows are missing."""
    every = prediction.thinning(j)
    t, values = prediction.t[j][::every], values[::every]
    breaks = np.flatnonzero(np.diff(t) > _GAP * every * prediction.step) + 1
    return np.insert(t, breaks, np.nan), np.insert(values, breaks, np.nan)
