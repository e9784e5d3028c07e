"""Figures of recordings: signals over time, and torques beside predicted ones."""

from collections.abc import Mapping, Sequence
from itertools import cycle
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ....common.arrays import Array
from ....estimation.answers.system import TorquePrediction
from ....estimation.fit.covariance import NORMAL95
from ....model import Recording
from ..blocks import Drawing
from .canvas import BLUE, GREY, ORANGE, Axes, Figure, bands, legend, panels

_STRETCHES = 2000  # of a long signal that are drawn
_LINES = ("-", "--", ":", "-.")
_TALLEST = 14.0  # inches
_GAP = 2.5  # steps: a longer one is drawn as a gap
_CURVES = ((BLUE, "--", 1.3), (ORANGE, ":", 1.3), ("black", "-.", 1.0))


Column: TypeAlias = tuple[str, Mapping[str, Array], Array]
"""Heading, curves (N, n) by name, and limits (2, n), nan or infinite where there is none."""


def over_time(title: str, t: Array, columns: Sequence[Column]) -> Figure:
    """A row a joint, a column a quantity, between hatched limits."""
    n = columns[0][2].shape[1]
    size, edges = (10.2, min(1.25 * n + 1.0, _TALLEST)), (0.65, 0.1, 0.6, 0.75)
    figure, axes = panels(size, n, len(columns), edges, (0.5, 0.15), sharex=True)
    for k, (heading, curves, limits) in enumerate(columns):
        for j, (axis, (low, high)) in enumerate(zip(axes[:, k], limits.T, strict=True)):
            for line, (label, values) in zip(cycle(_LINES), curves.items(), strict=False):
                axis.plot(*_extremes(t, values[:, j]), line, color="black", linewidth=0.9, label=label)
            if np.isfinite([low, high]).all():
                room, hatched = 0.12 * (high - low), {"facecolor": "none", "hatch": "////", "linewidth": 0.0}
                for limit, beyond, label in ((low, low - room, "limit"), (high, high + room, "")):
                    axis.axhline(limit, color="C3", linestyle=(0, (6, 2)), linewidth=1.1, label=label)
                    axis.axhspan(*sorted((limit, beyond)), edgecolor="C3", **hatched)
                axis.set_ylim(low - room, high + room)
            axis.tick_params(labelsize=8)
            axis.grid(visible=True, alpha=0.3)
            axis.set_ylabel(f"joint {j + 1}" if k == 0 else "", fontsize=9)
        axes[0, k].set_title(heading, fontsize=10)
        axes[-1, k].set_xlabel("time [s]")
    legend(figure, axes[0], "lower center", fontsize=9)
    figure.suptitle(title)
    return figure


def signals_figure(recording: Recording, unit: str, name: str) -> Drawing:
    """Positions and torques of every joint over time; ``unit`` of the torques, "N·m" or "A"."""
    title, unlimited = Path(recording.source).name, np.full((2, recording.q.shape[1]), np.nan)
    loads = "currents" if unit == "A" else "torques"
    signals = (("positions [rad or m]", recording.q), (f"{loads} [{unit}]", recording.torque))
    columns = [(heading, {"": values}, unlimited) for heading, values in signals]
    caption = f"Positions and {loads} of {title} as they were understood, joint side."
    return Drawing(name, caption, lambda: over_time(title, recording.t, columns))


def _extremes(t: Array, values: Array) -> tuple[Array, Array]:
    """Smallest and largest value of each of some thousand stretches, in the order of time."""
    size = len(t) // _STRETCHES
    if size < 4:
        return t, values
    parts = values[: len(t) // size * size].reshape(-1, size)
    within = np.sort(np.stack([parts.argmin(axis=1), parts.argmax(axis=1)], axis=1), axis=1)
    chosen = (within + size * np.arange(len(parts))[:, None]).ravel()
    return t[chosen], values[chosen]


def worst_joint_figure(prediction: TorquePrediction) -> Drawing:
    """The joint that the model explains worst: torques above, residual below on the same scale."""
    j = int(np.argmax(np.nan_to_num(prediction.relative_per_joint, nan=-1.0)))

    def draw() -> Figure:
        figure, axes = panels((5.8, 3.2), 2, edges=(0.8, 0.1, 0.3, 0.5), sharex=True, height_ratios=(2, 1))
        above, below = axes[:, 0]
        _torques(above, prediction, [j])
        _residuals(below, prediction, [j])
        above.set_ylabel(f"joint {j + 1} [N·m]")
        legend(figure, [above], "upper center", fontsize=9)
        below.set(xlabel="time [s]", ylabel="residual")
        return figure

    caption = (
        f"Joint {j + 1}, the one that the model explains worst: residual "
        f"{100.0 * prediction.relative_per_joint[j]:.1f} % of its torque, on {words_of(prediction)}. Pauses and "
        "slow rows are left out."
    )
    return Drawing("worst_joint", caption, draw)


def prediction_figure(prediction: TorquePrediction, name: str) -> Drawing:
    """Torques, residual and its autocorrelation of every joint, a row each."""
    n, percents = len(prediction.t), [f"{100.0 * ratio:.1f}" for ratio in prediction.relative_per_joint]
    caption = (
        f"Every joint on {words_of(prediction)}: torque, residual, and the residual's autocorrelation; the dashed "
        "lines hold 95 % of it if the noise were white."
    )

    def draw() -> Figure:
        size, edges = (10.0, 1.75 * n + 0.6), (0.8, 0.1, 0.6, 0.5)
        figure, ((left, middle, right),) = panels(size, 1, 3, edges, width_ratios=(5, 3, 2))
        _torques(left, prediction, range(n))
        _residuals(middle, prediction, range(n))
        correlations = [prediction.autocorrelation(j) for j in range(n)]
        rows = bands(right, [(min(-0.5, 1.1 * float(rho.min())), 1.05) for _, rho in correlations])
        upright: dict[str, Any] = {"rotation": 90, "va": "center", "ha": "center", "transform": left.transAxes}
        corner: dict[str, Any] = {"ha": "right", "va": "top", "fontsize": 9, "transform": middle.transAxes}
        for j, ((lags, rho), row) in enumerate(zip(correlations, rows, strict=True)):
            right.plot(lags, row(rho), color="black", linewidth=1.0)
            right.axhline(float(row(0.0)), color="0.4", linewidth=0.6)
            for level in (-NORMAL95, NORMAL95):
                band = float(row(level / np.sqrt(max(len(prediction.t[j]), 1))))
                right.axhline(band, color="0.4", linestyle="--", linewidth=0.8)
            left.text(-0.14, (n - j - 0.5) / n, f"joint {j + 1} [N·m]", **upright)
            middle.text(0.99, (n - j - 0.03) / n, f"{percents[j]} %", **corner)
        for axis, title in ((left, "torque"), (middle, "residual"), (right, "its autocorrelation")):
            axis.set_title(title, fontsize=10)
            axis.set_xlabel("lag [s]" if axis is right else "time [s]")
        legend(figure, [left], "upper center")
        return figure

    text = f"{caption} Relative residuals of the joints in percent: {', '.join(percents)}."
    return Drawing(name, caption, draw, text)


def words_of(prediction: TorquePrediction) -> str:
    """Name the recording, and say whether it was used."""
    load = "with payload" if prediction.loaded else "without payload"
    used = "held out of identification" if prediction.held_out else "the data that were fitted, not held out"
    source = prediction.source if load in prediction.source else f"{prediction.source} {load}"
    return f"{source} ({used})"


def _torques(axis: Axes, prediction: TorquePrediction, joints: Sequence[int]) -> None:
    predicted = zip(prediction.curves.items(), cycle(_CURVES), strict=False)
    curves = [("measured", prediction.measured, (GREY, "-", 2.6)), *((*own, look) for own, look in predicted)]
    ranges = []
    for j in joints:
        values = np.concatenate([torques[j] for _, torques, _ in curves])
        values = values[np.isfinite(values)]
        low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)
        room = 0.05 * (high - low) or 1.0
        ranges.append((low - room, high + room))
    rows = bands(axis, ranges)
    for label, torques, (colour, line, width) in curves:
        for first, (j, row) in enumerate(zip(joints, rows, strict=True)):
            t, values = _parted(prediction, j, torques[j])
            own = "" if first else label
            axis.plot(t, row(values), label=own, color=colour, linestyle=line, linewidth=width)


def _residuals(axis: Axes, prediction: TorquePrediction, joints: Sequence[int]) -> None:
    residuals = [prediction.residual(j) for j in joints]
    largest = [1.15 * float(np.abs(residual).max(initial=0.0)) or 1.0 for residual in residuals]
    for j, residual, row in zip(joints, residuals, bands(axis, [(-x, x) for x in largest]), strict=True):
        t, values = _parted(prediction, j, residual)
        axis.axhline(float(row(0.0)), color="0.4", linewidth=0.6)
        axis.plot(t, row(values), color="black", linewidth=0.8)


def _parted(prediction: TorquePrediction, j: int, values: Array) -> tuple[Array, Array]:
    """A joint's curve, of long ones every so many points, with gaps where rows are missing."""
    every = prediction.thinning(j)
    t, values = prediction.t[j][::every], values[::every]
    breaks = np.flatnonzero(np.diff(t) > _GAP * every * prediction.step) + 1
    return np.insert(t, breaks, np.nan), np.insert(values, breaks, np.nan)
