"""The methods side by side."""

from collections.abc import Sequence

import numpy as np

from ....common.arrays import Array
from ....estimation import PayloadAnswer
from ....estimation.payload.constrained import ConstrainedPayload
from ..blocks import Drawing
from .canvas import BLUE, Axes, Figure, legend, mark_interval, panels, plain

_FREE = 0.22  # the free estimate stands this much below the constrained one


def methods_figure(answer: PayloadAnswer) -> Drawing:
    """Mass and centre of mass by every method, with 95 % intervals, and the free estimates."""
    payloads = answer.constrained
    masses = ", ".join(f"method {payload.method} {payload.mass:.4g} kg" for payload in payloads)
    caption = (
        "Filled: payload that can exist, with its 95 % interval. Open: least squares alone, which may be a body "
        f"that cannot exist. The band is the recommended interval (method {answer.recommended.method})."
    )
    text = f"{caption} Masses: {masses}."
    return Drawing("methods", caption, text, lambda: _drawn(payloads, answer.recommended))


def _drawn(payloads: Sequence[ConstrainedPayload], best: ConstrainedPayload) -> Figure:
    size, edges = (9.0, 0.42 * len(payloads) + 1.35), (0.85, 0.1, 0.3, 0.6)
    figure, (axes,) = panels(size, 1, 4, edges, (0.25, 0.0), sharey=True)
    scales = (1.0, 1e3, 1e3, 1e3)
    titles = ("mass [kg]", "centre of mass x [mm]", "centre of mass y [mm]", "centre of mass z [mm]")
    for k, (axis, title, scale) in enumerate(zip(axes, titles, scales, strict=True)):
        _panel(axis, payloads, best, k, scale)
        axis.set_title(title, fontsize=10)
    axes[0].set_yticks(range(len(payloads)), [f"method {payload.method}" for payload in payloads])
    axes[0].set_ylim(len(payloads) - 0.4, -0.6)
    legend(figure, [axes[0]], "lower center")
    return figure


def _panel(
    axis: Axes, payloads: Sequence[ConstrainedPayload], best: ConstrainedPayload, k: int, scale: float
) -> None:
    mark_interval(axis, *(scale * _intervals(best)[k]))
    for row, payload in enumerate(payloads):
        value, (low, high) = scale * _values(payload)[k], scale * _intervals(payload)[k]
        filled, open_ = ("with constraints, 95 %", "least squares alone") if row == 0 else (None, None)
        if np.isfinite([low, high]).all():
            axis.plot([low, high], [row, row], color=BLUE, linewidth=2.0)
        axis.plot(value, row, "o", color=BLUE, markersize=6, label=filled)
        free = scale * np.append(payload.free.mass, payload.free.body.com)[k]
        axis.plot(free, row + _FREE, "D", color="black", fillstyle="none", markersize=5, label=open_)
    plain(axis)
    axis.locator_params(axis="x", nbins=4)


def _values(payload: ConstrainedPayload) -> Array:
    return np.append(payload.mass, payload.body.com)


def _intervals(payload: ConstrainedPayload) -> Array:
    return np.vstack([payload.intervals.parameters[9:], payload.intervals.com])
