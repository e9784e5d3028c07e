"""How well each parameter was excited."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...estimation import Excitation
from .canvas import BLUE, Drawing, new_figure, plain

_GOOD = 10.0  # ten times the noise: 10 % relative sigma
_LEAST, _MOST = 1e-2, 1e9


def excitation_figure(found: Excitation, labels: Mapping[str, str] | None = None) -> Drawing:
    """Each parameter's torque over the noise, whole and without what the others can imitate.

    Args:
        found: of every parameter.
        labels: name of a parameter -> how the figure calls it.
    """
    names = [(labels or {}).get(name, name) for name in found.names]
    figure = new_figure(max(7.0, 0.19 * len(names) + 1.2), 3.4)
    axis = figure.subplots()
    x = np.arange(len(names))
    whole, own = (np.clip(values, _LEAST, _MOST) for values in (found.signal, found.independent))
    axis.vlines(x, own, whole, color="0.6", linewidth=1.0)
    axis.plot(x, whole, "_", color="black", markersize=7, label="its torque")
    axis.plot(x, own, "o", color=BLUE, markersize=4, label="the part no other parameter can imitate")
    axis.axhline(_GOOD, color="black", linestyle="--", linewidth=0.9)
    axis.annotate("relative sigma 10 %", (1.0, _GOOD), xycoords=("axes fraction", "data"), xytext=(0, 3),
                  textcoords="offset points", ha="right", fontsize=8)  # fmt: skip
    axis.set_yscale("log")
    axis.set_xlim(-0.8, len(names) - 0.2)
    axis.set_xticks(x, names, rotation=90, fontsize=7)
    axis.set_ylabel("torque over noise")
    plain(axis)
    figure.legend(*axis.get_legend_handles_labels(), loc="outside upper center", ncols=2, frameon=False)
    weak = [name for name, value in zip(names, found.independent, strict=True) if value < _GOOD]
    caption = (
        "Norm of each parameter's torque over all equations, in units of the noise: whole (dash) and without what "
        "other parameters can imitate (dot). One over the dot is the relative standard deviation by (20), (21)."
    )
    told = f"Relative sigma above 10 %: {', '.join(weak)}." if weak else "All relative sigmas are below 10 %."
    return Drawing("excitation", figure, caption, f"{caption} {told}")
