"""Figures of a designed motion: how near it comes to its limits, and what it would teach."""

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from ....common.arrays import Array
from ....model import Motion
from ....trajectories import DesignProblem, Score
from ....trajectories.design.score import load_torques
from ..blocks import Drawing
from .canvas import Figure, legend, log_scale, names_below, panels

_STYLES = ("-", "--", ":", "-.")
_FEW = 4  # parameters a figure names as the least known
_TALLEST = 14.0  # inches


_MOTION = "Positions, speeds and torques of every joint between their limits, over time."
_SIGMA = "Standard deviation that identification would leave to each parameter, predicted."


def motion_figure(problem: DesignProblem, motion: Motion, title: str, words: str = _MOTION) -> Drawing:
    """Positions, speeds and torques of every joint between their limits: a row a joint, a column a quantity."""
    return Drawing("motion", words, words, lambda: _motion(problem, motion, title))


def _motion(problem: DesignProblem, motion: Motion, title: str) -> Figure:
    bounds, torques = problem.bounds, load_torques(problem, motion)
    columns: list[tuple[str, dict[str, Array], Array, Array]] = [
        ("position", {"position": motion.q}, bounds.low, bounds.high),
        ("speed", {"speed": motion.qd}, -bounds.speed, bounds.speed),
    ]
    if torques:
        columns.append(("torque", torques, -bounds.torque, bounds.torque))
    n = motion.n
    size, edges = (3.4 * len(columns), min(1.25 * n + 1.0, _TALLEST)), (0.65, 0.1, 0.6, 0.75)
    figure, axes = panels(size, n, len(columns), edges, (0.5, 0.15), sharex=True)
    for k, (name, curves, low, high) in enumerate(columns):
        for j in range(n):
            axis = axes[j, k]
            _between(axis, motion.t, {label: values[:, j] for label, values in curves.items()}, low[j], high[j])
            axis.set_ylabel(f"joint {j + 1}" if k == 0 else "", fontsize=9)
        axes[0, k].set_title(f"{name} [{_unit(problem, name)}]", fontsize=10)
        axes[-1, k].set_xlabel("time [s]")
    legend(figure, axes[0], "lower center", fontsize=9)
    figure.suptitle(title)
    return figure


def sigma_figure(
    score: Score, title: str, reference: Mapping[str, float] | None = None, labels: Mapping[str, str] | None = None
) -> Drawing:
    """Predicted standard deviation of every parameter: relative where a reference value is known, else in SI units.

    Args:
        reference: values that standard deviations are relative to.
        labels: how to call parameters ("ZZ1R"), by their names.
    """
    draw = partial(_sigma, score, title, reference or {}, labels or {})
    return Drawing("predicted_sigma", _SIGMA, _SIGMA, draw)


def _sigma(score: Score, title: str, reference: Mapping[str, float], labels: Mapping[str, str]) -> Figure:
    relative = score.relative_sigma(dict(reference))
    parts = [
        ("relative to its value [%]", {name: 100.0 * value for name, value in relative.items()}),
        ("in SI units", {name: value for name, value in score.learnt.sigma.items() if name not in relative}),
    ]
    parts = [(unit, values) for unit, values in parts if values]
    widest = max(len(values) for _, values in parts)
    longest = 0.07 * max(len(labels.get(name, name)) for _, values in parts for name in values)
    size = max(0.17 * widest + 1.2, 6.0), 2.8 * len(parts) + 0.5
    figure, axes = panels(size, len(parts), 1, (0.9, 0.1, 0.4, 0.2 + longest), (0.0, 0.3 + longest))
    for axis, (unit, values) in zip(axes[:, 0], parts, strict=True):
        _bars(axis, {labels.get(name, name): value for name, value in values.items()})
        axis.set_ylabel(f"predicted sigma\n{unit}", fontsize=9)
    figure.suptitle(title)
    return figure


def _between(axis: Any, t: Array, curves: Mapping[str, Array], low: float, high: float) -> None:
    """Curves, and the limits as lines with hatching beyond."""
    for k, (label, values) in enumerate(curves.items()):
        axis.plot(t, values, _STYLES[k % len(_STYLES)], color="black", linewidth=0.9, label=label)
    if np.isfinite([low, high]).all():
        for k, limit in enumerate((low, high)):
            axis.axhline(limit, color="C3", linestyle=(0, (6, 2)), linewidth=1.1, label="limit" if k == 0 else None)
        room = 0.12 * (high - low)
        for edge, beyond in ((low, low - room), (high, high + room)):
            axis.axhspan(*sorted((edge, beyond)), facecolor="none", edgecolor="C3", hatch="////", linewidth=0.0)
        axis.set_ylim(low - room, high + room)
    axis.tick_params(labelsize=8)
    axis.grid(visible=True, alpha=0.3)


def _bars(axis: Any, values: Mapping[str, float]) -> None:
    """Bars on a logarithmic scale; the least known are named with their number."""
    heights = np.array(list(values.values()))
    place = np.arange(len(heights))
    axis.bar(place, heights, color="0.75", edgecolor="black", linewidth=0.6)
    axis.set_ylim(0.5 * heights.min(), 6.0 * heights.max())
    log_scale(axis)
    for k in np.argsort(-heights, kind="stable")[:_FEW]:
        axis.annotate(
            f"{heights[k]:.2g}", (place[k], heights[k]), ha="center", va="bottom", fontsize=7, rotation=90
        )
    names_below(axis, list(values), 7)
    axis.set_xlim(-0.8, len(heights) - 0.2)
    axis.grid(visible=True, axis="y", alpha=0.3)


def _unit(problem: DesignProblem, name: str) -> str:
    turning = {joint.revolute for joint in problem.robot.joints}
    units = {
        "position": {True: "rad", False: "m"},
        "speed": {True: "rad/s", False: "m/s"},
        "torque": {True: "N·m", False: "N"},
    }[name]
    return " or ".join(units[kind] for kind in sorted(turning, reverse=True))
