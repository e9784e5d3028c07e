"""Figures over time: signals, motions between their limits, torques beside predicted ones."""

from collections.abc import Callable, Mapping
from functools import partial
from itertools import cycle
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ....common.arrays import Array
from ....estimation.answers.system import TorquePrediction
from ....estimation.fit.covariance import NORMAL95
from ....model import Recording
from ..blocks import Drawing
from .canvas import BLUE, GREY, ORANGE, Axes, Figure, legend, panels, plain

_STRETCHES = 2000  # of a long signal that are drawn
_TALLEST = 14.0  # inches
_GAP = 2.5  # steps: a longer one is drawn as a gap
_CURVES = ((BLUE, "--", 1.3), (ORANGE, ":", 1.3), ("black", "-.", 1.0))
LAG = "autocorrelation"
_Draw: TypeAlias = Callable[[Axes, int], None]
"""Draws a joint, counted from 0, into its panel."""


def by_joint(n: int, columns: Mapping[str, _Draw], title: str = "", **options: Any) -> Figure:
    """A row a joint, a column a quantity."""
    size = (10.2, min(1.25 * n + 1.0, _TALLEST))
    figure, axes = panels(size, n, len(columns), sharex="col", **options)
    for column, (heading, draw) in zip(axes.T, columns.items(), strict=True):
        for j, axis in enumerate(column):
            draw(axis, j)
            axis.tick_params(labelsize=8)
            plain(axis)
        column[0].set_title(heading, fontsize=9)
        column[-1].set_xlabel("lag [s]" if heading == LAG else "time [s]")
    for j, axis in enumerate(axes[:, 0], 1):
        axis.set_ylabel(f"joint {j}", fontsize=9)
    legend(figure, axes[0])
    figure.suptitle(title)
    return figure


def signals_figure(recording: Recording, unit: str, name: str) -> Drawing:
    """Positions and torques of every joint over time; ``unit`` of the torques, "N·m" or "A"."""
    title, n, loads = Path(recording.source).name, recording.q.shape[1], "currents" if unit == "A" else "torques"
    none = np.full(n, np.nan)
    columns = {
        "positions [rad or m]": partial(signals, recording.t, {"": recording.q}, none, none),
        f"{loads} [{unit}]": partial(signals, recording.t, {"": recording.torque}, none, none),
    }
    caption = f"Positions and {loads} of {title} as they were understood, joint side."
    return Drawing(name, caption, lambda: by_joint(n, columns, title))


def signals(t: Array, curves: Mapping[str, Array], low: Array, high: Array, axis: Axes, j: int) -> None:
    """Curves (N, n) by name, between hatched limits where these are finite."""
    for line, (label, values) in zip(cycle(("-", "--", ":", "-.")), curves.items(), strict=False):
        axis.plot(*_extremes(t, values[:, j]), line, color="black", linewidth=0.9, label=label)
    if not np.isfinite([low[j], high[j]]).all():
        return
    hatched: dict[str, Any] = {"facecolor": "none", "hatch": "////", "linewidth": 0.0}
    room = 0.12 * (high[j] - low[j])
    for limit, beyond, label in ((low[j], low[j] - room, "limit"), (high[j], high[j] + room, "")):
        axis.axhline(limit, color="C3", linestyle=(0, (6, 2)), linewidth=1.1, label=label)
        axis.axhspan(*sorted((limit, beyond)), edgecolor="C3", **hatched)
    axis.set_ylim(low[j] - room, high[j] + room)


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
    """The joint that the model explains worst: torques above, residual below."""
    j = int(np.argmax(np.nan_to_num(prediction.relative_per_joint, nan=-1.0)))

    def draw() -> Figure:
        figure, ((above,), (below,)) = panels((5.8, 3.2), 2, sharex=True, height_ratios=(2, 1))
        _torques(prediction, above, j)
        _residual(prediction, below, j)
        plain(above)
        plain(below)
        above.set_ylabel(f"joint {j + 1} [N·m]")
        legend(figure, [above])
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

    def residual(axis: Axes, j: int) -> None:
        _residual(prediction, axis, j)
        axis.annotate(f"{percents[j]} %", (0.99, 0.95), xycoords="axes fraction", ha="right", va="top", fontsize=8)

    def autocorrelation(axis: Axes, j: int) -> None:
        axis.plot(*prediction.autocorrelation(j), color="black", linewidth=1.0)
        axis.axhline(0.0, color="0.4", linewidth=0.6)
        for level in (-NORMAL95, NORMAL95):
            band = level / np.sqrt(max(len(prediction.t[j]), 1))
            axis.axhline(band, color="0.4", linestyle="--", linewidth=0.8)

    columns: dict[str, _Draw] = {
        "torque [N·m]": partial(_torques, prediction),
        "residual [N·m]": residual,
        LAG: autocorrelation,
    }
    text = f"{caption} Relative residuals of the joints in percent: {', '.join(percents)}."
    return Drawing(name, caption, lambda: by_joint(n, columns, width_ratios=(5, 3, 2)), text)


def words_of(prediction: TorquePrediction) -> str:
    """Name the recording, and say whether it was used."""
    load = "with payload" if prediction.loaded else "without payload"
    used = "held out of identification" if prediction.held_out else "the data that were fitted, not held out"
    source = prediction.source if load in prediction.source else f"{prediction.source} {load}"
    return f"{source} ({used})"


def _torques(prediction: TorquePrediction, axis: Axes, j: int) -> None:
    curves: list[tuple[Any, Any]] = list(zip(prediction.curves.items(), cycle(_CURVES), strict=False))
    for (label, torques), (colour, line, width) in [(("measured", prediction.measured), (GREY, "-", 2.6)), *curves]:
        axis.plot(*_parted(prediction, j, torques[j]), line, label=label, color=colour, linewidth=width)


def _residual(prediction: TorquePrediction, axis: Axes, j: int) -> None:
    values = prediction.residual(j)
    largest = 1.15 * float(np.abs(values).max(initial=0.0)) or 1.0
    axis.set_ylim(-largest, largest)
    axis.axhline(0.0, color="0.4", linewidth=0.6)
    axis.plot(*_parted(prediction, j, values), color="black", linewidth=0.8)


def _parted(prediction: TorquePrediction, j: int, values: Array) -> tuple[Array, Array]:
    """A joint's curve, of long ones every so many points, with gaps where rows are missing."""
    every = prediction.thinning(j)
    t, values = prediction.t[j][::every], values[::every]
    breaks = np.flatnonzero(np.diff(t) > _GAP * every * prediction.step) + 1
    return np.insert(t, breaks, np.nan), np.insert(values, breaks, np.nan)
