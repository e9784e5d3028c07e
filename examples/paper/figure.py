"""Errors of the payload and whether intervals hold, in many experiments."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from dynident.apps.report.figures import legend, panels, save_figure

from .repetition import Repetition

_MARKS = ("o", "s", "^", "D", "v", "P", "X", "*")
_SHOWN = ("M", "MZ", "XX", "YY", "ZZ")


def save_repetitions(path: str | Path, scenarios: Mapping[str, Mapping[str, Repetition]]) -> None:
    """Errors of the payload by every method, and coverage of the intervals: one row of panels a scenario.

    Args:
        path: file; its ending chooses the format.
        scenarios: title -> method -> its answers.
    """
    size = (9.0, 2.6 * len(scenarios) + 0.6)
    figure, rows = panels(size, len(scenarios), 2, framed=True, sharex="col", width_ratios=(3, 2))
    for (left, right), (title, methods) in zip(rows, scenarios.items(), strict=True):
        for k, (who, repetition) in enumerate(methods.items()):
            _spread(left, who, repetition, k, len(methods))
            place = np.arange(len(repetition.names)) + 0.8 * (k + 0.5) / len(methods) - 0.4
            right.plot(place, 100.0 * repetition.coverage, _MARKS[k % len(_MARKS)], color="black", markersize=4)
        left.set_title(title, loc="left", fontsize=10)
        left.axhline(0.0, color="black", linewidth=0.6)
        left.set_ylabel("error [%]")
        left.grid(visible=True, axis="y", alpha=0.3)
        right.axhline(95.0, color="black", linewidth=0.6)
        right.set_ylabel("95 % intervals hold [%]")
        right.set_ylim(min(50.0, right.get_ylim()[0]), 102.0)
        names = [name.removesuffix("_L") for name in next(iter(methods.values())).names]
        right.set_xticks(range(len(names)), names, fontsize=8)
        right.grid(visible=True, axis="y", alpha=0.3)
    legend(figure, [rows[0][0]])
    save_figure(figure, path)


def _spread(axis: Any, who: str, repetition: Repetition, k: int, count: int) -> None:
    """Every experiment's error in percent of the truth, one column of marks a parameter."""
    places = [repetition.column(f"{name}_L") for name in _SHOWN]
    error = 100.0 * repetition.error[:, places] / np.abs(repetition.truth[:, places])
    offset = 0.8 * (k + 0.5) / count - 0.4
    x = np.broadcast_to(np.arange(len(_SHOWN)) + offset, error.shape)
    mark = _MARKS[k % len(_MARKS)]
    axis.plot(x.ravel(), error.ravel(), mark, color="black", fillstyle="none", markersize=3, alpha=0.5, label=who)
    axis.set_xticks(range(len(_SHOWN)), _SHOWN)
