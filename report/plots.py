"""Figures. matplotlib is imported here and nowhere else."""

from collections.abc import Sequence
from pathlib import Path

from ..estimation import Observation
from ..model.arrays import Array


def save_torques(
    path: str | Path, observation: Observation, curves: Sequence[tuple[str, Array]], title: str
) -> None:
    """Measured and predicted torques of every joint, one below the other, as PNG, SVG or PDF.

    Args:
        path: file; its ending chooses the format.
        observation: measured torques Y and the columns W.
        curves: (label, parameters chi of ``observation.columns``) of each prediction W chi.
        title: above the figure.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    n = len(observation.Y)
    figure = Figure(figsize=(8.0, 1.6 * n + 0.8), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(n, 1, sharex=True, squeeze=False)[:, 0]
    styles = ("-", "--", ":", "-.")
    for j, axis in enumerate(axes):
        t = observation.t[j]
        axis.plot(t, observation.Y[j], ".", color="0.6", markersize=3, label="measured")
        for k, (label, chi) in enumerate(curves):
            axis.plot(t, observation.W[j] @ chi, styles[k % 4], linewidth=1.1, label=label)
        axis.set_ylabel(f"joint {j + 1} [N·m]")
        axis.grid(visible=True, alpha=0.3)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(curves) + 1)
    axes[-1].set_xlabel("time [s]")
    figure.suptitle(title)
    # Without metadata the same result gives the same bytes.
    figure.savefig(path, dpi=130, metadata={"Software": None} if str(path).endswith(".png") else None)
