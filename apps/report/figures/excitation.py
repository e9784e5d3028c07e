"""How well each parameter was excited."""

from collections.abc import Mapping, Sequence

import numpy as np

from ....common.arrays import Array
from ....estimation.fit.least_squares import Excitation
from ..blocks import Drawing
from .canvas import BLUE, Axes, Figure, legend, log_scale, names_below, panels, plain

_GOOD = 10.0  # ten times the noise: 10 % relative sigma
_LEAST, _MOST = 1e-2, 1e9
_PER_ROW = 40


def excitation_figure(excitation: Excitation, labels: Mapping[str, str] | None = None) -> Drawing:
    """Each parameter's torque over the noise, whole and without what the others can imitate.

    Args:
        excitation: of every parameter.
        labels: name of a parameter -> how the figure calls it.
    """
    names = [(labels or {}).get(name, name) for name in excitation.names]
    weak = [name for name, value in zip(names, excitation.independent, strict=True) if value < _GOOD]
    caption = (
        "Norm of each parameter's torque over all equations, in units of the noise: whole (dash) and without what "
        "other parameters can imitate (dot). One over the dot is the relative standard deviation by (20), (21)."
    )
    known = f"Relative sigma above 10 %: {', '.join(weak)}." if weak else "All relative sigmas are below 10 %."
    return Drawing("excitation", caption, f"{caption} {known}", lambda: _drawn(excitation, names))


def _drawn(excitation: Excitation, names: Sequence[str]) -> Figure:
    rows = -(-len(names) // _PER_ROW)
    size = -(-len(names) // rows)
    longest = 0.075 * max(map(len, names))
    edges, gaps = (0.8, 0.1, 0.35, 0.2 + longest), (0.0, 0.3 + longest)
    figure, axes = panels((9.5, 2.3 * rows + 0.5), rows, 1, edges, gaps, sharey=True)
    for row, axis in enumerate(axes[:, 0]):
        part = slice(size * row, size * (row + 1))
        _row(axis, names[part], excitation.signal[part], excitation.independent[part], size)
    log_scale(axes[0, 0])
    legend(figure, [axes[0, 0]], "upper center")
    return figure


def _row(axis: Axes, names: Sequence[str], signal: Array, independent: Array, size: int) -> None:
    x = np.arange(len(names))
    whole, own = np.clip(signal, _LEAST, _MOST), np.clip(independent, _LEAST, _MOST)
    axis.vlines(x, own, whole, color="0.6", linewidth=1.0)
    axis.plot(x, whole, "_", color="black", markersize=8, label="its torque")
    axis.plot(x, own, "o", color=BLUE, markersize=4, label="the part no other parameter can imitate")
    axis.axhline(_GOOD, color="black", linestyle="--", linewidth=0.9)
    axis.annotate("relative sigma 10 %", (1.0, _GOOD), xycoords=("axes fraction", "data"), xytext=(0, 3),
                  textcoords="offset points", ha="right", fontsize=8)  # fmt: skip
    axis.set_xlim(-0.8, size - 0.2)
    axis.set_ylabel("torque over noise")
    plain(axis)
    names_below(axis, names, 8)
