"""Several recordings of one payload, each alone."""

from __future__ import annotations

import numpy as np

from ...estimation.fit import student95
from ...estimation.weigh import Repeats
from .canvas import BLUE, Drawing, new_figure, plain

_NAME = 24  # letters of a recording's name


def repeats_figure(found: Repeats, mass: float, interval: tuple[float, float]) -> Drawing | None:
    """Mass by each recording in the order they were given; None where fewer than two show it.

    Args:
        found: the recordings.
        mass: by all of them [kg].
        interval: its 95 % interval [kg]; nan where there is none.
    """
    places, masses, sigmas = found.seen
    if len(places) < 2:
        return None
    figure = new_figure(7.0, 0.32 * len(found.masses) + 1.0)
    axis = figure.subplots()
    if np.isfinite(interval).all():
        axis.axvspan(*interval, facecolor="0.9", edgecolor="0.7", hatch="//", linewidth=0.0)
    axis.axvline(mass, color="black", linestyle="--", linewidth=1.0)
    half = student95(1e9) * sigmas
    axis.errorbar(masses, places, xerr=half, fmt="o", color=BLUE, linewidth=2.0, markersize=6)
    names = [f"{k}: {source[-_NAME:]}" for k, source in enumerate(found.sources, 1)]
    axis.set_yticks(range(len(names)), names)
    axis.set_ylim(len(names) - 0.5, -0.5)
    axis.set_xlabel("mass [kg]")
    plain(axis)
    caption = (
        "The mass by each recording alone, in order, with two standard deviations; the dashed line and the band "
        "are the answer by all of them."
    )
    told = "; ".join(f"recording {k + 1} {m:.4g} kg" for k, m in zip(places, masses, strict=True))
    return Drawing("repeats", figure, caption, f"{caption} {told}.")
